//! The topics of a recording.

use std::collections::BTreeMap;

use crate::endpoints::{self, ENDPOINTS, Endpoint, NodeKind};
use crate::outgoing::Topic;
use crate::recording::{self, OfferedQos, RecordingError, TopicInfo};

/// The topics whose messages become commands.
pub(super) const INPUTS: [&Endpoint; 2] = [&endpoints::IMPACT_EVENT, &endpoints::COLUMN_PARAMETERS];

/// The endpoints of such a node that are recorded.
fn recorded(kind: NodeKind) -> Vec<&'static Endpoint> {
    let all = std::iter::once(&endpoints::JOURNAL).chain(ENDPOINTS);
    let mut recorded: Vec<_> = all.filter(|it| it.is_recorded && it.is_of(kind)).collect();
    // The log is the last one, as in all recordings.
    recorded.sort_by_key(|it| it.name == endpoints::ROSOUT.name);
    recorded
}

/// Name of the node in recordings made without a node.
const NODE: &str = "column_twin";

/// The topics of one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Topics {
    kind: NodeKind,
    endpoints: Vec<&'static Endpoint>,
    /// In the order of the endpoints.
    names: Vec<String>,
}

impl Topics {
    /// The topics of such a node with the names that `resolve` returns.
    ///
    /// # Errors
    /// The first error of `resolve`.
    pub fn resolved<E>(
        kind: NodeKind,
        resolve: impl FnMut(&Endpoint) -> Result<String, E>,
    ) -> Result<Self, E> {
        let endpoints = recorded(kind);
        let names: Result<_, E> = endpoints.iter().copied().map(resolve).collect();
        Ok(Self {
            kind,
            endpoints,
            names: names?,
        })
    }

    /// The topics of such a node that is called `/column_twin`, without remapping.
    #[must_use]
    pub fn of_default_node(kind: NodeKind) -> Self {
        let endpoints = recorded(kind);
        let names = endpoints.iter().copied().map(default_name).collect();
        Self {
            kind,
            endpoints,
            names,
        }
    }

    /// The kind of node that has them.
    pub(super) fn kind(&self) -> NodeKind {
        self.kind
    }

    /// The topics as the recorder needs them.
    ///
    /// # Errors
    /// A message definition of this program is invalid.
    pub fn declared(&self) -> Result<Vec<TopicInfo>, RecordingError> {
        let pairs = self.endpoints.iter().zip(&self.names);
        pairs
            .map(|(endpoint, name)| {
                recording::topic(name, endpoint.type_name, OfferedQos::from(&endpoint.qos))
            })
            .collect()
    }

    /// Resolved names by the names in the table of endpoints.
    #[must_use]
    pub fn by_endpoint(&self) -> BTreeMap<String, String> {
        let pairs = self.endpoints.iter().zip(&self.names);
        pairs
            .map(|(endpoint, name)| (endpoint.name.to_owned(), name.clone()))
            .collect()
    }

    /// Index of the topic of an endpoint; `None` if it is not recorded.
    #[must_use]
    pub fn index_of(&self, endpoint: &Endpoint) -> Option<usize> {
        self.endpoints
            .iter()
            .position(|it| it.name == endpoint.name)
    }
}

fn default_name(endpoint: &Endpoint) -> String {
    match endpoint.name.strip_prefix("~/") {
        Some(private) => format!("/{NODE}/{private}"),
        None => format!("/{}", endpoint.name.trim_start_matches('/')),
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
        let topics = Topics::of_default_node(NodeKind::Single);
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
    fn every_topic_but_the_clock_is_recorded() {
        use crate::endpoints::{Direction, ENDPOINTS};
        let left_out = |topics: Topics| -> Vec<_> {
            let topic = |it: &Endpoint| it.direction != Direction::Service;
            let all = ENDPOINTS.iter().copied().filter(topic);
            all.filter(|it| topics.index_of(it).is_none())
                .map(|it| it.name)
                .collect()
        };
        let of_one = left_out(Topics::of_default_node(NodeKind::Single));
        assert_eq!(
            of_one,
            [
                "row_impact_event",
                "/clock",
                "fleet_status",
                "~/transition_event"
            ]
        );
        // A row is recorded as the impacts that it is for its columns. The others show one column.
        let of_many = left_out(Topics::of_default_node(NodeKind::Fleet));
        let absent = [
            "row_impact_event",
            "joint_states",
            "markers",
            "/clock",
            "~/transition_event",
        ];
        assert!(absent.iter().all(|it| of_many.contains(it)), "{of_many:?}");
        assert_eq!(of_many.len(), absent.len(), "{of_many:?}");
    }
}
