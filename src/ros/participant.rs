//! The DDS participant.

use std::net::{IpAddr, Ipv4Addr};

use ros2_client::Context;
use rustdds::DomainParticipantBuilder;

use super::environment::{DiscoveryRange, Environment};
use super::node::NodeError;

/// A context with a participant in the domain and on the networks of the environment.
///
/// # Errors
/// Sockets or threads are not available.
pub(super) fn context(environment: &Environment) -> Result<Context, NodeError> {
    let builder = DomainParticipantBuilder::new(environment.domain_id);
    let builder = match environment.discovery_range {
        DiscoveryRange::Localhost => builder.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]),
        DiscoveryRange::Subnet => builder,
    };
    let participant = builder.build().map_err(|error| NodeError::Participant {
        domain_id: environment.domain_id,
        reason: format!("{error:?}"),
    })?;
    Context::from_domain_participant(participant).map_err(|error| NodeError::Participant {
        domain_id: environment.domain_id,
        reason: error.to_string(),
    })
}
