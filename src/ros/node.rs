//! A node: participant, names, and endpoints created from the table.

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;

use futures::StreamExt;
use futures::future::Either;
use ros2_client::qos::QosProfile;
use ros2_client::{
    Context, MessageTypeName, Name, NodeName, NodeOptions, ServiceMapping, ServiceTypeName,
};
use rustdds::{DomainParticipantBuilder, GUID, RTPSEntity};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::parameters::TopicEnd;

use super::duplicates::{Duplicates, Listen, statuses};
use super::live_columns::LiveColumns;
use super::qos::{self, Endpoint, Qos, package_and_type};
use super::qos_overrides::QosOverrides;
use super::transport::{Publisher, Server, Subscription};
use super::zenoh::{ZenohNode, ZenohSession, check_zenoh};
use ros_node::environment::{DiscoveryRange, Environment, Transport};
use ros_node::matches::{Discovered, Matches};
use ros_node::names::{NameError, NameKind, Names};
use ros_node::raw::Raw;
use ros_node::security::{Peers, Protection, SecurityError, protection};

/// Errors of creating a node or its endpoints.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// The participant cannot be created.
    #[error(
        "cannot create a DDS participant in domain {domain_id}: {reason}; check that the domain's UDP ports are free and \
         the limit of open files is not reached (ulimit -n)"
    )]
    Participant {
        /// The domain.
        domain_id: u16,
        /// The error of RustDDS.
        reason: String,
    },
    /// A name is invalid.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The enclave is missing or cannot be used.
    #[error(transparent)]
    Security(#[from] SecurityError),
    /// The delivery of alarms cannot be started.
    #[error("the alarms cannot start: {0}")]
    Alarms(String),
    /// The metrics cannot be served.
    #[error("{0}")]
    Metrics(String),
    /// Foxglove cannot be served.
    #[error("{0}")]
    Foxglove(String),
    /// Zenoh cannot be used.
    #[error("{0}")]
    Zenoh(String),
    /// The node or an endpoint cannot be created.
    #[error("cannot create {what}: {reason}")]
    Endpoint {
        /// The endpoint, by its full name.
        what: String,
        /// The error of ros2-client.
        reason: String,
    },
    /// A thread cannot be started.
    #[error("cannot start the thread {name}: {source}")]
    Thread {
        /// Its name.
        name: &'static str,
        /// The error of the system.
        source: std::io::Error,
    },
}

/// A node without any tasks.
pub struct Node {
    link: Link,
    names: Names,
    matches: Arc<Matches>,
    protection: Arc<Protection>,
    overrides: QosOverrides,
}

/// The node on its transport.
#[allow(clippy::large_enum_variant)] // a node has one
enum Link {
    Dds {
        // Dropped in this order: the node unregisters through the context's participant.
        node: ros2_client::Node,
        context: Context,
    },
    Zenoh(ZenohNode),
}

impl Node {
    /// A node with these names in the environment's domain.
    ///
    /// # Errors
    /// The participant or the node cannot be created, or security is enforced and its enclave cannot be used.
    pub fn new(environment: &Environment, names: Names) -> Result<Self, NodeError> {
        Self::with_sender(environment, names, || {})
    }

    /// The same; the thread of DDS that sends and receives calls `start` first. Zenoh has no such thread.
    ///
    /// # Errors
    /// See [`new`](Self::new).
    pub(super) fn with_sender(
        environment: &Environment,
        names: Names,
        start: impl FnOnce() + Send + 'static,
    ) -> Result<Self, NodeError> {
        let matches = Arc::default();
        let (network, protection) = match environment.transport {
            Transport::Dds => {
                let protection = protection(&environment.security, environment.domain_id)?;
                protection.announce();
                (
                    Network::Dds(context(environment, &protection, start)?),
                    protection,
                )
            }
            Transport::Zenoh => {
                check_transport(environment)?;
                let session =
                    ZenohSession::open(environment, &matches).map_err(NodeError::Zenoh)?;
                (Network::Zenoh(session), Protection::Off)
            }
        };
        let siblings = Siblings {
            network,
            matches,
            protection: Arc::new(protection),
        };
        siblings.named(names)
    }

    /// Gives the topics that are created from now on the quality of service that the parameters ask for.
    pub(super) fn override_qos(&mut self, overrides: QosOverrides) {
        self.overrides = overrides;
    }

    /// The node's names.
    #[must_use]
    pub fn names(&self) -> &Names {
        &self.names
    }

    /// The peers of the node's endpoints, as long as [`participant_events`](Self::participant_events) runs.
    #[must_use]
    pub fn matches(&self) -> Arc<Matches> {
        Arc::clone(&self.matches)
    }

    /// How the node's participant is protected.
    #[must_use]
    pub fn protection(&self) -> Arc<Protection> {
        Arc::clone(&self.protection)
    }

    /// Which peers joined with a valid identity, and how many were rejected, as long as
    /// [`participant_events`](Self::participant_events) runs.
    #[must_use]
    pub fn security_peers(&self) -> Arc<Peers> {
        self.matches.security_peers()
    }

    /// Keeps [`matches`](Self::matches) up to date as long as it runs.
    pub fn participant_events(&self) -> impl Future<Output = ()> + use<> {
        self.events(|_| {})
    }

    /// As [`participant_events`](Self::participant_events); `on` is called with everything that is discovered.
    pub(super) fn events<F: FnMut(Discovered<'_>)>(
        &self,
        on: F,
    ) -> impl Future<Output = ()> + use<F> {
        match &self.link {
            Link::Dds { context, .. } => {
                let participant = context.domain_participant();
                Either::Left(Arc::clone(&self.matches).follow(participant, on))
            }
            Link::Zenoh(node) => Either::Right(node.events(on)),
        }
    }

    /// For further nodes with the participant of this one.
    pub(super) fn siblings(&self) -> Siblings {
        Siblings {
            network: match &self.link {
                Link::Dds { context, .. } => Network::Dds(context.clone()),
                Link::Zenoh(node) => Network::Zenoh(node.session()),
            },
            matches: Arc::clone(&self.matches),
            protection: Arc::clone(&self.protection),
        }
    }

    /// As [`events`](Self::events), for the node of these columns: also warns about other nodes with the same name and other twins of
    /// the same column.
    ///
    /// # Errors
    /// A name is invalid.
    pub(super) fn twin_events<F: FnMut(Discovered<'_>)>(
        &self,
        columns: Arc<LiveColumns>,
        mut on: F,
    ) -> Result<impl Future<Output = ()> + use<F>, NodeError> {
        let endpoint = &qos::TWIN_STATUS;
        let status = self.resolved(endpoint)?;
        let end = TopicEnd::Publisher;
        let qos = self.overrides.apply(&status, end, &endpoint.qos);
        let (own, listen): (GUID, Listen) = match &self.link {
            Link::Dds { node, context } => {
                let participant = context.domain_participant();
                let topic = topic(node, &status, endpoint.type_name, &qos.profile())?;
                let listen = move || statuses(&participant, &topic, &qos);
                (context.domain_participant().guid(), Box::new(listen))
            }
            Link::Zenoh(node) => {
                let (own, node, name) = (node.guid(), node.clone(), status.clone());
                let profile = qos.profile();
                let listen = move || {
                    let heard = node.overheard(&name, endpoint.type_name, &profile)?;
                    Ok(heard.boxed())
                };
                (own, Box::new(listen))
            }
        };
        let duplicates = Duplicates {
            own,
            node: self.names.fully_qualified(),
            status,
            listen,
            columns,
        };
        let (mut on_writer, compare) = duplicates.watch();
        let follow = self.events(move |discovered| {
            if let Discovered::Writer(writer) = discovered {
                on_writer(writer);
            }
            on(discovered);
        });
        Ok(async {
            futures::join!(follow, compare);
        })
    }

    /// Full names of the topics with the type of an endpoint that others in the domain use, apart from `known`.
    #[must_use]
    pub(super) fn other_topics(&self, endpoint: &Endpoint, known: &str) -> Vec<String> {
        let (package, type_name) = endpoint.package_and_type();
        let dds_type = format!("{package}::msg::dds_::{type_name}_");
        let names: BTreeSet<String> = match &self.link {
            Link::Dds { context, .. } => {
                let discovered = context.discovered_topics().into_iter();
                let topics = discovered.filter(|topic| topic.type_name == dds_type);
                let bare =
                    |name: String| name.strip_prefix("rt").map_or(name.clone(), str::to_owned);
                topics.map(|topic| bare(topic.name)).collect()
            }
            Link::Zenoh(node) => node.topics_of(&dds_type).collect(),
        };
        names.into_iter().filter(|name| name != known).collect()
    }

    /// A publisher of an endpoint of the table.
    ///
    /// # Errors
    /// The name is invalid, or the endpoint cannot be created.
    pub fn publisher<M: Serialize>(
        &mut self,
        endpoint: &Endpoint,
    ) -> Result<Publisher<M>, NodeError> {
        let name = self.resolved(endpoint)?;
        let end = TopicEnd::Publisher;
        let qos = self.overrides.apply(&name, end, &endpoint.qos).profile();
        self.publisher_of(&name, endpoint.type_name, None, qos)
    }

    /// A publisher of encoded messages on a topic given by its full name. `hash` is the hash of the type where it is recorded.
    ///
    /// # Errors
    /// The name is invalid, or the endpoint cannot be created.
    pub fn raw_publisher(
        &mut self,
        full_name: &str,
        type_name: &str,
        hash: Option<&str>,
        qos: QosProfile,
    ) -> Result<Publisher<Raw>, NodeError> {
        self.publisher_of(full_name, type_name, hash, qos)
    }

    fn publisher_of<M: Serialize>(
        &mut self,
        full_name: &str,
        type_name: &str,
        hash: Option<&str>,
        qos: QosProfile,
    ) -> Result<Publisher<M>, NodeError> {
        let publisher = match &mut self.link {
            Link::Dds { node, .. } => {
                let topic = topic(node, full_name, type_name, &qos)?;
                let publisher = node.create_publisher(&topic, Some(qos));
                publisher.map(Publisher::Dds).map_err(|it| it.to_string())
            }
            Link::Zenoh(node) => node
                .publisher(full_name, type_name, hash, &qos)
                .map(Publisher::Zenoh),
        };
        let publisher = publisher.map_err(|error| not_created(full_name, &error))?;
        self.matches.name(publisher.guid(), full_name);
        Ok(publisher)
    }

    /// A subscription of an endpoint of the table.
    ///
    /// # Errors
    /// The name is invalid, or the endpoint cannot be created.
    pub fn subscription<M: DeserializeOwned + 'static>(
        &mut self,
        endpoint: &Endpoint,
    ) -> Result<Subscription<M>, NodeError> {
        let name = self.resolved(endpoint)?;
        self.subscribed(&name, endpoint.type_name, &endpoint.qos)
    }

    /// A subscription of a topic that parameters name, with this type.
    ///
    /// # Errors
    /// The name is invalid, or the endpoint cannot be created.
    pub fn subscription_of<M: DeserializeOwned + 'static>(
        &mut self,
        topic: &str,
        type_name: &str,
        qos: &Qos,
    ) -> Result<Subscription<M>, NodeError> {
        let full = self.names.resolve(NameKind::Topic, topic)?;
        self.subscribed(&full, type_name, qos)
    }

    fn subscribed<M: DeserializeOwned + 'static>(
        &mut self,
        full_name: &str,
        type_name: &str,
        qos: &Qos,
    ) -> Result<Subscription<M>, NodeError> {
        let end = TopicEnd::Subscription;
        let qos = self.overrides.apply(full_name, end, qos).profile();
        let subscription = match &mut self.link {
            Link::Dds { node, .. } => {
                let topic = topic(node, full_name, type_name, &qos)?;
                let subscription = node.create_subscription(&topic, Some(qos));
                let subscription = subscription.map_err(|it| it.to_string());
                subscription.map(Subscription::Dds)
            }
            Link::Zenoh(node) => node
                .subscription(full_name, type_name, &qos)
                .map(Subscription::Zenoh),
        };
        let subscription = subscription.map_err(|error| not_created(full_name, &error))?;
        self.matches.name(subscription.guid(), full_name);
        Ok(subscription)
    }

    /// A server of a service of the table.
    ///
    /// # Errors
    /// The name is invalid, or the endpoint cannot be created.
    pub fn server<Request, Response>(
        &mut self,
        endpoint: &Endpoint,
    ) -> Result<Server<Request, Response>, NodeError>
    where
        Request: ros2_client::Message + Clone + 'static,
        Response: ros2_client::Message + 'static,
    {
        let full = self.resolved(endpoint)?;
        let qos = endpoint.qos.profile();
        let server = match &mut self.link {
            Link::Dds { node, .. } => node
                .create_server(
                    // The mapping of Fast DDS; clients on Cyclone DDS, such as the bridge to Zenoh, are answered in theirs.
                    ServiceMapping::Enhanced,
                    &parsed(&full)?,
                    &service_type(endpoint),
                    qos.clone(),
                    qos,
                )
                .map(Server::Dds)
                .map_err(|it| it.to_string()),
            Link::Zenoh(node) => node
                .server(&full, endpoint.type_name, &qos)
                .map(Server::Zenoh),
        };
        server.map_err(|error| not_created(&full, &error))
    }

    /// A client of a service of the table, over DDS.
    ///
    /// # Errors
    /// The name is invalid, or the endpoint cannot be created.
    pub fn client<Request, Response>(
        &mut self,
        endpoint: &Endpoint,
    ) -> Result<ros2_client::Client<Request, Response>, NodeError>
    where
        Request: ros2_client::Message + Clone + 'static,
        Response: ros2_client::Message + 'static,
    {
        let full = self.resolved(endpoint)?;
        let Link::Dds { node, .. } = &mut self.link else {
            return Err(not_created(
                &full,
                &"clients of services exist over DDS only",
            ));
        };
        node.create_client(
            ServiceMapping::Enhanced,
            &parsed(&full)?,
            &service_type(endpoint),
            endpoint.qos.profile(),
            endpoint.qos.profile(),
        )
        .map_err(|error| not_created(&full, &error))
    }

    /// Full name after remapping.
    fn resolved(&self, endpoint: &Endpoint) -> Result<String, NodeError> {
        Ok(self.names.resolve(endpoint.kind(), endpoint.name)?)
    }
}

/// A full name as ros2-client wants it.
fn parsed(full_name: &str) -> Result<Name, NodeError> {
    Name::parse(full_name).map_err(|error| not_created(full_name, &error))
}

fn service_type(endpoint: &Endpoint) -> ServiceTypeName {
    let (package, type_name) = endpoint.package_and_type();
    ServiceTypeName::new(package, type_name)
}

/// A topic of DDS.
fn topic(
    node: &ros2_client::Node,
    full_name: &str,
    type_name: &str,
    qos: &QosProfile,
) -> Result<rustdds::Topic, NodeError> {
    let (package, bare) = package_and_type(type_name);
    let type_name = MessageTypeName::new(package, bare);
    node.create_topic(&parsed(full_name)?, type_name, qos)
        .map_err(|error| not_created(full_name, &error))
}

/// Checks whether this program can use the transport that the environment asks for, without using it.
///
/// # Errors
/// The program was built without it, its configuration cannot be read, or security is asked for that does not protect it.
pub fn check_transport(environment: &Environment) -> Result<(), NodeError> {
    match (environment.transport, environment.security.is_enabled) {
        (Transport::Dds, _) => Ok(()),
        (Transport::Zenoh, false) => check_zenoh(environment).map_err(NodeError::Zenoh),
        // Running unprotected would hide it.
        (Transport::Zenoh, true) => Err(NodeError::Zenoh(
            "ROS_SECURITY_ENABLE asks for DDS security, which does not protect Zenoh; unset it, and configure TLS and access control in \
             the file of ZENOH_SESSION_CONFIG_URI, or use --transport dds"
                .to_owned(),
        )),
    }
}

/// What the nodes of a process share of their transport.
enum Network {
    Dds(Context),
    Zenoh(ZenohSession),
}

/// Makes nodes that share a participant.
pub(super) struct Siblings {
    network: Network,
    matches: Arc<Matches>,
    protection: Arc<Protection>,
}

impl Siblings {
    /// A node with this name in this namespace.
    ///
    /// # Errors
    /// A name is invalid, or the node cannot be created.
    pub fn node(&self, namespace: &str, name: &str) -> Result<Node, NodeError> {
        self.named(Names::new(namespace, name, &[])?)
    }

    fn named(&self, names: Names) -> Result<Node, NodeError> {
        let link = match &self.network {
            Network::Dds(context) => node_of(context, &names).map(|node| Link::Dds {
                node,
                context: context.clone(),
            }),
            Network::Zenoh(session) => session.node(&names).map(Link::Zenoh),
        };
        Ok(Node {
            link: link.map_err(|reason| not_created(&names.fully_qualified(), &reason))?,
            names,
            matches: Arc::clone(&self.matches),
            protection: Arc::clone(&self.protection),
            overrides: QosOverrides::default(),
        })
    }
}

/// A node of DDS.
fn node_of(context: &Context, names: &Names) -> Result<ros2_client::Node, String> {
    let name = NodeName::new(names.namespace(), names.node()).map_err(|error| error.to_string())?;
    // This crate has its own log messages and parameter services: those of ros2-client support neither descriptions
    // nor ranges nor sets that are valid only as a whole. A node has one publisher of `/parameter_events`.
    let options = NodeOptions::new()
        .enable_rosout(false)
        .start_parameter_services(false)
        .publish_parameter_events(false);
    let node = context.new_node(name, options);
    node.map_err(|error| error.to_string())
}

fn not_created(what: &str, reason: &impl ToString) -> NodeError {
    NodeError::Endpoint {
        what: what.to_owned(),
        reason: reason.to_string(),
    }
}

/// A context with a participant in the domain and on the networks of the environment; its thread that sends and receives calls `start`
/// first.
///
/// # Errors
/// Sockets or threads are not available.
fn context(
    environment: &Environment,
    protection: &Protection,
    start: impl FnOnce() + Send + 'static,
) -> Result<Context, NodeError> {
    let builder = DomainParticipantBuilder::new(environment.domain_id).on_event_loop_start(start);
    let builder = match environment.discovery_range {
        DiscoveryRange::Localhost => builder.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]),
        DiscoveryRange::Subnet => builder,
    };
    // Where the programs of ROS 2 look for the enclave of a node.
    let user_data = format!("enclave={};", environment.security.enclave);
    let builder = protected(builder.user_data(user_data), protection);
    let participant = builder.build().map_err(|error| NodeError::Participant {
        domain_id: environment.domain_id,
        reason: format!("{error:?}"),
    })?;
    Context::from_domain_participant(participant).map_err(|error| NodeError::Participant {
        domain_id: environment.domain_id,
        reason: error.to_string(),
    })
}

/// With the files of the enclave, if there is one.
fn protected(
    builder: DomainParticipantBuilder,
    protection: &Protection,
) -> DomainParticipantBuilder {
    match protection {
        #[cfg(feature = "security")]
        Protection::Enclave(enclave) => {
            // The key has no password: RustDDS ignores passwords, and the checks of the enclave reject encrypted keys.
            let files = rustdds::DomainParticipantSecurityConfigFiles::with_ros_default_names(
                &enclave.directory,
                String::new(),
            );
            builder.builtin_security(files)
        }
        _ => builder,
    }
}
