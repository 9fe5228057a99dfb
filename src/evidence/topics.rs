//! The topics of a recording.

use std::collections::BTreeMap;

use crate::endpoints::{self, Endpoint, Qos};
use crate::recording::{self, OfferedQos, RecordingError, TopicInfo};

/// What is recorded.
pub const RECORDED: [&Endpoint; 13] = [
    &endpoints::JOURNAL,
    &endpoints::IMPACT_EVENT,
    &endpoints::COLUMN_PARAMETERS,
    &endpoints::COLUMN_STATE,
    &endpoints::HINGE_FORCES,
    &endpoints::IMPACT_FORECAST,
    &endpoints::IMPACT_REPORT,
    &endpoints::TWIN_STATUS,
    &endpoints::JOINT_STATES,
    &endpoints::MARKERS,
    &endpoints::DIAGNOSTICS,
    &endpoints::PARAMETER_EVENTS,
    &endpoints::ROSOUT,
];

/// Name of the node where there is none.
const NODE: &str = "column_twin";

/// The topics of one recording, in the order of [`RECORDED`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topics {
    names: Vec<String>,
}

impl Topics {
    /// Under the names that `resolve` gives them.
    ///
    /// # Errors
    /// Those of `resolve`.
    pub fn resolved<E>(resolve: impl FnMut(&Endpoint) -> Result<String, E>) -> Result<Self, E> {
        let names: Result<_, E> = RECORDED.iter().copied().map(resolve).collect();
        Ok(Self { names: names? })
    }

    /// Under the names of a node `/column_twin` whose names nobody has remapped.
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

    /// As the recorder needs them.
    ///
    /// # Errors
    /// A message definition of this program is wrong.
    pub fn declared(&self) -> Result<Vec<TopicInfo>, RecordingError> {
        let pairs = RECORDED.iter().zip(&self.names);
        pairs
            .map(|(endpoint, name)| {
                recording::topic(name, endpoint.type_name, offered(&endpoint.qos))
            })
            .collect()
    }

    /// Resolved names by those in the table of endpoints.
    #[must_use]
    pub fn by_endpoint(&self) -> BTreeMap<String, String> {
        let pairs = RECORDED.iter().zip(&self.names);
        pairs
            .map(|(endpoint, name)| (endpoint.name.to_owned(), name.clone()))
            .collect()
    }

    /// Place of an endpoint in [`RECORDED`]; `None` for one that is not recorded.
    #[must_use]
    pub fn index_of(endpoint: &Endpoint) -> Option<usize> {
        RECORDED.iter().position(|it| it.name == endpoint.name)
    }
}

fn offered(qos: &Qos) -> OfferedQos {
    OfferedQos {
        reliable: qos.reliable,
        transient_local: qos.transient_local,
        depth: qos.depth,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_have_their_usual_names() {
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

    /// What a node sends is recorded.
    #[test]
    fn nothing_is_forgotten() {
        use crate::endpoints::{Direction, ENDPOINTS};
        let left_out: Vec<_> = ENDPOINTS
            .iter()
            .filter(|it| it.direction != Direction::Service && Topics::index_of(it).is_none())
            .map(|it| it.name)
            .collect();
        assert_eq!(left_out, ["/clock"]);
    }
}
