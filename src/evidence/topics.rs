//! The topics of a recording.

use std::collections::BTreeMap;

use crate::endpoints::{self, Endpoint};
use crate::outgoing::Topic;
use crate::recording::{self, OfferedQos, RecordingError, TopicInfo};

/// The endpoints that are recorded.
pub const RECORDED: [&Endpoint; 15] = [
    &endpoints::JOURNAL,
    &endpoints::IMPACT_EVENT,
    &endpoints::COLUMN_PARAMETERS,
    &endpoints::MEASUREMENTS,
    &endpoints::COLUMN_STATE,
    &endpoints::HINGE_FORCES,
    &endpoints::IMPACT_FORECAST,
    &endpoints::IMPACT_REPORT,
    &endpoints::IMPACT_ESTIMATE,
    &endpoints::TWIN_STATUS,
    &endpoints::JOINT_STATES,
    &endpoints::MARKERS,
    &endpoints::DIAGNOSTICS,
    &endpoints::PARAMETER_EVENTS,
    &endpoints::ROSOUT,
];

/// Name of the node in recordings made without a node.
const NODE: &str = "column_twin";

/// The topics of one recording, in the order of [`RECORDED`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topics {
    names: Vec<String>,
}

impl Topics {
    /// The topics with the names that `resolve` returns.
    ///
    /// # Errors
    /// The first error of `resolve`.
    pub fn resolved<E>(resolve: impl FnMut(&Endpoint) -> Result<String, E>) -> Result<Self, E> {
        let names: Result<_, E> = RECORDED.iter().copied().map(resolve).collect();
        Ok(Self { names: names? })
    }

    /// The topics of a node `/column_twin` without remapping.
    #[must_use]
    pub fn of_default_node() -> Self {
        let name = |endpoint: &&Endpoint| match endpoint.name.strip_prefix("~/") {
            Some(private) => format!("/{NODE}/{private}"),
            None => format!("/{}", endpoint.name.trim_start_matches('/')),
        };
        Self {
            names: RECORDED.iter().map(name).collect(),
        }
    }

    /// The topics as the recorder needs them.
    ///
    /// # Errors
    /// A message definition of this program is invalid.
    pub fn declared(&self) -> Result<Vec<TopicInfo>, RecordingError> {
        let pairs = RECORDED.iter().zip(&self.names);
        pairs
            .map(|(endpoint, name)| {
                recording::topic(name, endpoint.type_name, OfferedQos::from(&endpoint.qos))
            })
            .collect()
    }

    /// Resolved names by the names in the table of endpoints.
    #[must_use]
    pub fn by_endpoint(&self) -> BTreeMap<String, String> {
        let pairs = RECORDED.iter().zip(&self.names);
        pairs
            .map(|(endpoint, name)| (endpoint.name.to_owned(), name.clone()))
            .collect()
    }

    /// Index of an endpoint in [`RECORDED`]; `None` if it is not recorded.
    #[must_use]
    pub fn index_of(endpoint: &Endpoint) -> Option<usize> {
        RECORDED.iter().position(|it| it.name == endpoint.name)
    }
}

/// Whether every message of an endpoint follows from the journal: the twin's own topics, the received messages, of which the
/// journal has a digest, and the journal itself.
pub(super) fn is_recomputed(endpoint: &str) -> bool {
    let received = [endpoints::IMPACT_EVENT, endpoints::COLUMN_PARAMETERS];
    endpoint == endpoints::JOURNAL.name
        || received.iter().any(|it| it.name == endpoint)
        || Topic::ALL.iter().any(|it| it.endpoint().name == endpoint)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_have_the_names_of_a_default_node() {
        let topics = Topics::of_default_node();
        let names: Vec<_> = topics
            .declared()
            .expect("definitions")
            .into_iter()
            .map(|it| it.name)
            .collect();
        for name in ["/column_twin/journal", "/column_state", "/diagnostics"] {
            assert!(names.iter().any(|it| it == name), "{names:?}");
        }
        assert_eq!(topics.by_endpoint()["~/journal"], "/column_twin/journal");
    }

    #[test]
    fn every_topic_of_a_twin_but_the_clock_is_recorded() {
        use crate::endpoints::{Direction, ENDPOINTS};
        let left_out: Vec<_> = ENDPOINTS
            .iter()
            .filter(|it| it.direction != Direction::Service && Topics::index_of(it).is_none())
            .map(|it| it.name)
            .collect();
        // A fleet is not recorded.
        assert_eq!(left_out, ["row_impact_event", "/clock", "fleet_status"]);
    }
}
