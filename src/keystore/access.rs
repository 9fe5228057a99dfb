//! What the programs of an enclave may publish and subscribe to.

use std::collections::BTreeSet;

use crate::endpoints::{CLOCK, Direction, ENDPOINTS, Endpoint, PARAMETER_EVENTS, ROSOUT};
use crate::ros::{NameError, Names};

use super::enclave_name::EnclaveName;

/// What an enclave is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Runs the twin.
    Twin,
    /// Receives everything that the twin publishes and can send it nothing.
    Monitor,
    /// As the monitor, and may send impact events and parameters and call the services of the twin.
    Operator,
}

/// Topics and services by their full ROS names, without a name twice and in order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Access {
    /// Topics that may be published.
    pub publish: BTreeSet<String>,
    /// Topics that may be subscribed to.
    pub subscribe: BTreeSet<String>,
    /// Services that may be offered.
    pub reply: BTreeSet<String>,
    /// Services that may be called.
    pub request: BTreeSet<String>,
}

/// The topic by which the nodes of ROS 2 find one another; every participant reads and writes it.
const DISCOVERY: &str = "ros_discovery_info";

impl Role {
    /// All roles.
    pub const ALL: [Self; 3] = [Self::Twin, Self::Monitor, Self::Operator];

    /// `twin`, `monitor` or `operator`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Twin => "twin",
            Self::Monitor => "monitor",
            Self::Operator => "operator",
        }
    }

    /// The role of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.name() == name)
    }
}

impl Access {
    /// What an enclave with this role may do with these twins. A node that has the name of the enclave may offer the
    /// services that every node has.
    ///
    /// # Errors
    /// A name is invalid.
    pub fn of(role: Role, enclave: &EnclaveName, twins: &[Names]) -> Result<Self, NameError> {
        let mut access = Self::of_every_node(&enclave.node()?)?;
        for twin in twins {
            for endpoint in ENDPOINTS {
                access.allow(
                    role,
                    endpoint,
                    twin.resolve(endpoint.kind(), endpoint.name)?,
                );
            }
        }
        Ok(access)
    }

    /// What every node of ROS 2 does: log, announce changes of its parameters, follow the time, describe itself.
    fn of_every_node(node: &Names) -> Result<Self, NameError> {
        let mut access = Self::default();
        let name = |endpoint: &Endpoint| node.resolve(endpoint.kind(), endpoint.name);
        access.publish.insert(name(&ROSOUT)?);
        access.publish.insert(name(&PARAMETER_EVENTS)?);
        access.subscribe.insert(name(&PARAMETER_EVENTS)?);
        access.subscribe.insert(name(&CLOCK)?);
        for endpoint in ENDPOINTS.iter().filter(|it| is_of_every_node(it)) {
            access.reply.insert(name(endpoint)?);
        }
        Ok(access)
    }

    fn allow(&mut self, role: Role, endpoint: &Endpoint, name: String) {
        use Direction::{In, Out, Service};
        use Role::{Monitor, Operator, Twin};
        let names = match (role, endpoint.direction) {
            (Twin, In) | (Monitor | Operator, Out) => &mut self.subscribe,
            (Twin, Out) => &mut self.publish,
            (Twin, Service) => &mut self.reply,
            // Everyone follows the simulated time; who may set it is another matter.
            (Operator, In) if endpoint.name == CLOCK.name => return,
            (Operator, In) => &mut self.publish,
            (Operator, Service) => &mut self.request,
            (Monitor, In | Service) => return,
        };
        names.insert(name);
    }

    /// Names of the DDS topics that may be published: `rt` before a topic, `rq` and `rr` before the requests and replies of a
    /// service.
    #[must_use]
    pub fn dds_publish(&self) -> BTreeSet<String> {
        dds_topics(&self.publish, &self.request, &self.reply)
    }

    /// Names of the DDS topics that may be subscribed to.
    #[must_use]
    pub fn dds_subscribe(&self) -> BTreeSet<String> {
        dds_topics(&self.subscribe, &self.reply, &self.request)
    }
}

/// The services that every node of ROS 2 offers: about its parameters and about its types.
fn is_of_every_node(endpoint: &Endpoint) -> bool {
    let packages = ["rcl_interfaces", "type_description_interfaces"];
    endpoint.direction == Direction::Service && packages.contains(&endpoint.package_and_type().0)
}

fn dds_topics(
    topics: &BTreeSet<String>,
    requests: &BTreeSet<String>,
    replies: &BTreeSet<String>,
) -> BTreeSet<String> {
    let topics = topics.iter().map(|name| format!("rt{name}"));
    let requests = requests.iter().map(|name| format!("rq{name}Request"));
    let replies = replies.iter().map(|name| format!("rr{name}Reply"));
    let all = topics.chain(requests).chain(replies);
    all.chain([DISCOVERY.to_owned()]).collect()
}
