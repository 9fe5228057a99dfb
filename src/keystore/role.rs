//! What an enclave is for, and what its programs may therefore do.

use sros2_keystore::{Access, EnclaveName};

use crate::endpoints::{CLOCK, Direction, ENDPOINTS, Endpoint, PARAMETER_EVENTS, ROSOUT};
use ros_node::names::{NameError, Names};

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

/// What an enclave with this role may do with these twins. A node that has the name of the enclave may offer the services that
/// every node has.
///
/// # Errors
/// A name is invalid.
pub fn access(role: Role, enclave: &EnclaveName, twins: &[Names]) -> Result<Access, NameError> {
    let (namespace, node) = enclave.namespace_and_node();
    let mut access = of_every_node(&Names::new(namespace, node, &[])?)?;
    for twin in twins {
        for endpoint in ENDPOINTS {
            let name = twin.resolve(endpoint.kind(), endpoint.name)?;
            allow(&mut access, role, endpoint, name);
        }
    }
    Ok(access)
}

/// What every node of ROS 2 does: log, announce changes of its parameters, follow the time, describe itself.
fn of_every_node(node: &Names) -> Result<Access, NameError> {
    let mut access = Access::default();
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

fn allow(access: &mut Access, role: Role, endpoint: &Endpoint, name: String) {
    use Direction::{In, Out, Service};
    use Role::{Monitor, Operator, Twin};
    let names = match (role, endpoint.direction) {
        (Twin, In) | (Monitor | Operator, Out) => &mut access.subscribe,
        (Twin, Out) => &mut access.publish,
        (Twin, Service) => &mut access.reply,
        // Everyone follows the simulated time; who may set it is another matter.
        (Operator, In) if endpoint.name == CLOCK.name => return,
        (Operator, In) => &mut access.publish,
        (Operator, Service) => &mut access.request,
        (Monitor, In | Service) => return,
    };
    names.insert(name);
}

/// The services that every node of ROS 2 offers: about its parameters and about its types.
fn is_of_every_node(endpoint: &Endpoint) -> bool {
    let packages = ["rcl_interfaces", "type_description_interfaces"];
    endpoint.direction == Direction::Service && packages.contains(&endpoint.package_and_type().0)
}
