//! A node: participant, names, and endpoints created from the table.

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;

use ros2_client::qos::QosProfile;
use ros2_client::{
    Context, MessageTypeName, Name, NodeName, NodeOptions, Publisher, Server, ServiceMapping,
    ServiceTypeName, Subscription,
};
use rustdds::DomainParticipantBuilder;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::parameters::TopicEnd;

use super::duplicates::Duplicates;
use super::environment::{DiscoveryRange, Environment};
use super::live_columns::LiveColumns;
use super::matches::{Discovered, Matches};
use super::names::{NameError, NameKind, Names};
use super::qos::{self, Endpoint, Qos, package_and_type};
use super::qos_overrides::QosOverrides;
use super::raw::Raw;
use super::security::{Peers, Protection, SecurityError, protection};

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
    // Dropped in this order: the node unregisters through the context's participant.
    node: ros2_client::Node,
    context: Context,
    names: Names,
    matches: Arc<Matches>,
    protection: Arc<Protection>,
    overrides: QosOverrides,
}

impl Node {
    /// A node with these names in the environment's domain.
    ///
    /// # Errors
    /// The participant or the node cannot be created, or security is enforced and its enclave cannot be used.
    pub fn new(environment: &Environment, names: Names) -> Result<Self, NodeError> {
        let protection = protection(&environment.security, environment.domain_id)?;
        protection.announce();
        let siblings = Siblings {
            context: context(environment, &protection)?,
            matches: Arc::default(),
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
        let participant = self.context.domain_participant();
        Arc::clone(&self.matches).follow(participant, on)
    }

    /// For further nodes with the participant of this one.
    pub(super) fn siblings(&self) -> Siblings {
        Siblings {
            context: self.context.clone(),
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
        let participant = self.context.domain_participant();
        let (name, status) = self.topic(&qos::TWIN_STATUS)?;
        let duplicates = Duplicates {
            participant,
            node: self.names.fully_qualified(),
            status,
            qos: self
                .overrides
                .apply(&name, TopicEnd::Publisher, &qos::TWIN_STATUS.qos),
            columns,
        };
        let (mut on_writer, compare) = duplicates.watch();
        let follow = self.events(move |discovered| {
            if let Discovered::Writer(writer) = &discovered {
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
        let discovered = self.context.discovered_topics().into_iter();
        let names: BTreeSet<String> = discovered
            .filter(|topic| topic.type_name == dds_type)
            .map(|topic| {
                topic
                    .name
                    .strip_prefix("rt")
                    .unwrap_or(&topic.name)
                    .to_owned()
            })
            .filter(|name| name != known)
            .collect();
        names.into_iter().collect()
    }

    /// A publisher of an endpoint of the table.
    ///
    /// # Errors
    /// The name is invalid, or RustDDS cannot create the endpoint.
    pub fn publisher<M: Serialize>(
        &mut self,
        endpoint: &Endpoint,
    ) -> Result<Publisher<M>, NodeError> {
        let (name, topic) = self.topic(endpoint)?;
        let qos = self
            .overrides
            .apply(&name, TopicEnd::Publisher, &endpoint.qos);
        let publisher = self
            .node
            .create_publisher(&topic, Some(qos.profile()))
            .map_err(|error| not_created(&name, &error))?;
        self.matches.name(publisher.guid(), &name);
        Ok(publisher)
    }

    /// A publisher of encoded messages on a topic given by its full name.
    ///
    /// # Errors
    /// The name is invalid, or RustDDS cannot create the endpoint.
    pub fn raw_publisher(
        &mut self,
        full_name: &str,
        type_name: &str,
        qos: QosProfile,
    ) -> Result<Publisher<Raw>, NodeError> {
        let name = Name::parse(full_name).map_err(|error| not_created(full_name, &error))?;
        let (package, bare) = package_and_type(type_name);
        let topic = self
            .node
            .create_topic(&name, MessageTypeName::new(package, bare), &qos)
            .map_err(|error| not_created(full_name, &error))?;
        let publisher = self
            .node
            .create_publisher(&topic, Some(qos))
            .map_err(|error| not_created(full_name, &error))?;
        self.matches.name(publisher.guid(), full_name);
        Ok(publisher)
    }

    /// A subscription of an endpoint of the table.
    ///
    /// # Errors
    /// The name is invalid, or RustDDS cannot create the endpoint.
    pub fn subscription<M: DeserializeOwned + 'static>(
        &mut self,
        endpoint: &Endpoint,
    ) -> Result<Subscription<M>, NodeError> {
        let (name, topic) = self.topic(endpoint)?;
        let qos = self
            .overrides
            .apply(&name, TopicEnd::Subscription, &endpoint.qos);
        let subscription = self
            .node
            .create_subscription(&topic, Some(qos.profile()))
            .map_err(|error| not_created(&name, &error))?;
        self.matches.name(subscription.guid(), &name);
        Ok(subscription)
    }

    /// A subscription of a topic that parameters name, with this type.
    ///
    /// # Errors
    /// The name is invalid, or RustDDS cannot create the endpoint.
    pub fn subscription_of<M: DeserializeOwned + 'static>(
        &mut self,
        topic: &str,
        type_name: &str,
        qos: &Qos,
    ) -> Result<Subscription<M>, NodeError> {
        let full = self.names.resolve(NameKind::Topic, topic)?;
        let qos = self.overrides.apply(&full, TopicEnd::Subscription, qos);
        let name = Name::parse(&full).map_err(|error| not_created(&full, &error))?;
        let (package, bare) = package_and_type(type_name);
        let topic = self
            .node
            .create_topic(&name, MessageTypeName::new(package, bare), &qos.profile())
            .map_err(|error| not_created(&full, &error))?;
        let subscription = self
            .node
            .create_subscription(&topic, Some(qos.profile()))
            .map_err(|error| not_created(&full, &error))?;
        self.matches.name(subscription.guid(), &full);
        Ok(subscription)
    }

    /// A server of a service of the table.
    ///
    /// # Errors
    /// The name is invalid, or RustDDS cannot create the endpoint.
    pub fn server<Request, Response>(
        &mut self,
        endpoint: &Endpoint,
    ) -> Result<Server<Request, Response>, NodeError>
    where
        Request: ros2_client::Message + Clone + 'static,
        Response: ros2_client::Message + 'static,
    {
        let (full, name) = self.resolved(endpoint)?;
        let (package, type_name) = endpoint.package_and_type();
        self.node
            .create_server(
                // The mapping of Fast DDS; clients on Cyclone DDS, such as the bridge to Zenoh, are answered in theirs.
                ServiceMapping::Enhanced,
                &name,
                &ServiceTypeName::new(package, type_name),
                endpoint.qos.profile(),
                endpoint.qos.profile(),
            )
            .map_err(|error| not_created(&full, &error))
    }

    /// A client of a service of the table.
    ///
    /// # Errors
    /// The name is invalid, or RustDDS cannot create the endpoint.
    pub fn client<Request, Response>(
        &mut self,
        endpoint: &Endpoint,
    ) -> Result<ros2_client::Client<Request, Response>, NodeError>
    where
        Request: ros2_client::Message + Clone + 'static,
        Response: ros2_client::Message + 'static,
    {
        let (full, name) = self.resolved(endpoint)?;
        let (package, type_name) = endpoint.package_and_type();
        self.node
            .create_client(
                ServiceMapping::Enhanced,
                &name,
                &ServiceTypeName::new(package, type_name),
                endpoint.qos.profile(),
                endpoint.qos.profile(),
            )
            .map_err(|error| not_created(&full, &error))
    }

    fn topic(&self, endpoint: &Endpoint) -> Result<(String, rustdds::Topic), NodeError> {
        let (full, name) = self.resolved(endpoint)?;
        let (package, type_name) = endpoint.package_and_type();
        let topic = self
            .node
            .create_topic(
                &name,
                MessageTypeName::new(package, type_name),
                &endpoint.qos.profile(),
            )
            .map_err(|error| not_created(&full, &error))?;
        Ok((full, topic))
    }

    /// Full name after remapping, as text and as ros2-client wants it.
    fn resolved(&self, endpoint: &Endpoint) -> Result<(String, Name), NodeError> {
        let full = self.names.resolve(endpoint.kind(), endpoint.name)?;
        let name = Name::parse(&full).map_err(|error| not_created(&full, &error))?;
        Ok((full, name))
    }
}

/// Makes nodes that share a participant.
pub(super) struct Siblings {
    context: Context,
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
        let not_created = |reason: String| NodeError::Endpoint {
            what: names.fully_qualified(),
            reason,
        };
        let name = NodeName::new(names.namespace(), names.node())
            .map_err(|error| not_created(error.to_string()))?;
        // This crate has its own log messages and parameter services: those of ros2-client support neither descriptions
        // nor ranges nor sets that are valid only as a whole. A node has one publisher of `/parameter_events`.
        let options = NodeOptions::new()
            .enable_rosout(false)
            .start_parameter_services(false)
            .publish_parameter_events(false);
        let node = self
            .context
            .new_node(name, options)
            .map_err(|error| not_created(error.to_string()))?;
        Ok(Node {
            node,
            context: self.context.clone(),
            names,
            matches: Arc::clone(&self.matches),
            protection: Arc::clone(&self.protection),
            overrides: QosOverrides::default(),
        })
    }
}

fn not_created(what: &str, reason: &impl ToString) -> NodeError {
    NodeError::Endpoint {
        what: what.to_owned(),
        reason: reason.to_string(),
    }
}

/// A context with a participant in the domain and on the networks of the environment.
///
/// # Errors
/// Sockets or threads are not available.
fn context(environment: &Environment, protection: &Protection) -> Result<Context, NodeError> {
    let builder = DomainParticipantBuilder::new(environment.domain_id);
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
