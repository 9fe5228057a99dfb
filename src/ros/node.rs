//! A node: participant, names, and endpoints made from the table.

use std::sync::Arc;

use ros2_client::qos::QosProfile;
use ros2_client::{
    Context, MessageTypeName, Name, NodeName, NodeOptions, Publisher, Server, ServiceMapping,
    ServiceTypeName, Subscription,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::environment::Environment;
use super::matches::Matches;
use super::names::{NameError, Names};
use super::participant;
use super::qos::{Endpoint, package_and_type};
use super::raw::Raw;

/// Why there is no node, or an endpoint is missing.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// No participant.
    #[error(
        "no DDS participant in domain {domain_id}: {reason}; are the domain's UDP ports free, and are there file \
         descriptors left (ulimit -n)?"
    )]
    Participant {
        /// The domain.
        domain_id: u16,
        /// What RustDDS says.
        reason: String,
    },
    /// A name that is none.
    #[error(transparent)]
    Name(#[from] NameError),
    /// No node or no endpoint.
    #[error("{what} cannot be made: {reason}")]
    Endpoint {
        /// The endpoint, by its full name.
        what: String,
        /// What ros2-client says.
        reason: String,
    },
    /// No thread.
    #[error("the thread {name} cannot be started: {source}")]
    Thread {
        /// Its name.
        name: &'static str,
        /// What the system says.
        source: std::io::Error,
    },
}

/// A node without any tasks.
pub struct Node {
    // Dropped in this order: the node says goodbye through the context's participant.
    node: ros2_client::Node,
    context: Context,
    names: Names,
    matches: Arc<Matches>,
}

impl Node {
    /// A node of these names in the environment's domain.
    ///
    /// # Errors
    /// When there is no participant to be had.
    pub fn new(environment: &Environment, names: Names) -> Result<Self, NodeError> {
        let context = participant::context(environment)?;
        let not_made = |reason: String| NodeError::Endpoint {
            what: names.fully_qualified(),
            reason,
        };
        let name = NodeName::new(names.namespace(), names.node())
            .map_err(|error| not_made(error.to_string()))?;
        // Log messages, parameters and their services are this crate's own: ros2-client's know neither descriptions
        // nor ranges nor sets that are valid only as a whole.
        let options = NodeOptions::new()
            .enable_rosout(false)
            .start_parameter_services(false);
        let node = context
            .new_node(name, options)
            .map_err(|error| not_made(error.to_string()))?;
        Ok(Self {
            node,
            context,
            names,
            matches: Arc::default(),
        })
    }

    /// The node's names.
    #[must_use]
    pub fn names(&self) -> &Names {
        &self.names
    }

    /// What is known of peers, once [`participant_events`](Self::participant_events) runs.
    #[must_use]
    pub fn matches(&self) -> Arc<Matches> {
        Arc::clone(&self.matches)
    }

    /// Keeps [`matches`](Self::matches) up to date for as long as it runs.
    pub fn participant_events(&self) -> impl Future<Output = ()> + use<> {
        let participant = self.context.domain_participant();
        Arc::clone(&self.matches).follow(participant)
    }

    /// A publisher of an endpoint of the table.
    ///
    /// # Errors
    /// When the name is none, or RustDDS refuses.
    pub fn publisher<M: Serialize>(
        &mut self,
        endpoint: &Endpoint,
    ) -> Result<Publisher<M>, NodeError> {
        let (name, topic) = self.topic(endpoint)?;
        let publisher = self
            .node
            .create_publisher(&topic, Some(endpoint.qos.profile()))
            .map_err(|error| not_made(&name, &error))?;
        self.matches.name(publisher.guid(), &name);
        Ok(publisher)
    }

    /// A publisher of bytes, of a topic by its full name.
    ///
    /// # Errors
    /// When the name is none, or RustDDS refuses.
    pub fn raw_publisher(
        &mut self,
        full_name: &str,
        type_name: &str,
        qos: QosProfile,
    ) -> Result<Publisher<Raw>, NodeError> {
        let name = Name::parse(full_name).map_err(|error| not_made(full_name, &error))?;
        let (package, bare) = package_and_type(type_name);
        let topic = self
            .node
            .create_topic(&name, MessageTypeName::new(package, bare), &qos)
            .map_err(|error| not_made(full_name, &error))?;
        let publisher = self
            .node
            .create_publisher(&topic, Some(qos))
            .map_err(|error| not_made(full_name, &error))?;
        self.matches.name(publisher.guid(), full_name);
        Ok(publisher)
    }

    /// A subscription of an endpoint of the table.
    ///
    /// # Errors
    /// When the name is none, or RustDDS refuses.
    pub fn subscription<M: DeserializeOwned + 'static>(
        &mut self,
        endpoint: &Endpoint,
    ) -> Result<Subscription<M>, NodeError> {
        let (name, topic) = self.topic(endpoint)?;
        let subscription = self
            .node
            .create_subscription(&topic, Some(endpoint.qos.profile()))
            .map_err(|error| not_made(&name, &error))?;
        self.matches.name(subscription.guid(), &name);
        Ok(subscription)
    }

    /// A server of a service of the table.
    ///
    /// # Errors
    /// When the name is none, or RustDDS refuses.
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
                // The mapping of Fast DDS, and of Cyclone since Humble.
                ServiceMapping::Enhanced,
                &name,
                &ServiceTypeName::new(package, type_name),
                endpoint.qos.profile(),
                endpoint.qos.profile(),
            )
            .map_err(|error| not_made(&full, &error))
    }

    /// A client of a service of the table.
    ///
    /// # Errors
    /// When the name is none, or RustDDS refuses.
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
            .map_err(|error| not_made(&full, &error))
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
            .map_err(|error| not_made(&full, &error))?;
        Ok((full, topic))
    }

    /// Full name after remapping, as text and as ros2-client wants it.
    fn resolved(&self, endpoint: &Endpoint) -> Result<(String, Name), NodeError> {
        let full = self.names.resolve(endpoint.kind(), endpoint.name)?;
        let name = Name::parse(&full).map_err(|error| not_made(&full, &error))?;
        Ok((full, name))
    }
}

fn not_made(what: &str, reason: &impl ToString) -> NodeError {
    NodeError::Endpoint {
        what: what.to_owned(),
        reason: reason.to_string(),
    }
}
