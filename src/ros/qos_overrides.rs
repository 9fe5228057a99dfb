//! The quality of service that parameters ask for in the place of the table's, topic by topic.

use std::collections::{BTreeSet, HashMap};

use crate::parameters::{
    Fault, Origin, ParameterFaults, Parameters, Problem, QosOverride, QosSettings, Settings,
    TopicEnd, Value,
};

use super::qos::{
    Direction, ENDPOINTS, IMPACT_FORECAST, IMPACT_REPORT, Qos, SENSOR_DATA, TWIN_STATUS,
};
use ros_node::names::{NameError, NameKind, Names};

/// The overrides of a node, by the full names of its topics.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct QosOverrides(HashMap<(String, TopicEnd), Changes>);

/// What is overridden of one end of a topic. The history always keeps the last messages.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Changes {
    depth: Option<usize>,
    reliable: Option<bool>,
    transient_local: Option<bool>,
}

/// Why overrides are not possible.
#[derive(Debug)]
pub(super) enum OverrideError {
    /// The names of the node are not valid.
    Name(NameError),
    /// The overrides are not.
    Parameters(ParameterFaults),
}

impl QosOverrides {
    pub fn new(given: &QosSettings) -> Self {
        let mut all = HashMap::<_, Changes>::new();
        for it in given.iter() {
            let changes = all.entry((it.topic.to_owned(), it.end)).or_default();
            changes.take(&it);
        }
        Self(all)
    }

    /// The quality of service of one end of a topic with this full name.
    pub fn apply(&self, topic: &str, end: TopicEnd, qos: &Qos) -> Qos {
        if self.0.is_empty() {
            return *qos;
        }
        let changes = self.0.get(&(topic.to_owned(), end));
        changes.map_or(*qos, |it| it.apply(qos))
    }
}

impl Changes {
    fn take(&mut self, given: &QosOverride<'_>) {
        match (given.policy, given.value) {
            ("depth", Value::Integer(depth)) => self.depth = usize::try_from(*depth).ok(),
            ("reliability", Value::String(word)) => self.reliable = Some(word == "reliable"),
            ("durability", Value::String(word)) => {
                self.transient_local = Some(word == "transient_local");
            }
            _ => {}
        }
    }

    fn apply(self, qos: &Qos) -> Qos {
        Qos {
            reliable: self.reliable.unwrap_or(qos.reliable),
            transient_local: self.transient_local.unwrap_or(qos.transient_local),
            depth: self.depth.unwrap_or(qos.depth),
            ..*qos
        }
    }
}

/// Compares the overrides of a node with the topics that a node of these names with these columns can have; returns what to warn of.
///
/// # Errors
/// A topic that the node cannot have, or policies that are of no use together.
pub(super) fn check_overrides<'a>(
    node: &Parameters,
    columns: impl IntoIterator<Item = &'a Settings>,
    names: &Names,
) -> Result<Vec<Fault>, OverrideError> {
    let given = &node.settings().qos_overrides;
    if given.iter().next().is_none() {
        return Ok(Vec::new());
    }
    let columns: Vec<_> = columns.into_iter().collect();
    let kept = kept_of_columns(columns.len(), names).map_err(OverrideError::Name)?;
    let number = columns.len();
    let known = known_topics(columns, names).map_err(OverrideError::Name)?;
    let overrides = QosOverrides::new(given);
    let (mut faults, mut warnings) = (Vec::new(), Vec::new());
    let mut told = BTreeSet::new();
    for it in given.iter() {
        let fault = |message| Fault {
            name: Some(it.name.to_owned()),
            value: None,
            place: Origin::Direct,
            problem: Problem::Inconsistent(message),
        };
        if let (TopicEnd::Publisher, "depth", Value::Integer(depth)) = (it.end, it.policy, it.value)
            && let Some(kept) = kept.get(it.topic).filter(|kept| *depth < **kept as i64)
        {
            warnings.push(fault(format!(
                "is less than the {kept} messages that the {number} columns of the fleet need together: a late or slow subscriber \
                 misses messages of some columns; give at least {kept}, or omit the depth"
            )));
        }
        let own = known.get(&(it.topic.to_owned(), it.end));
        let message = match own {
            None => no_such_topic(&it, &known),
            Some(qos) => {
                let qos = overrides.apply(it.topic, it.end, qos);
                if qos.reliable || !qos.transient_local || !told.insert((it.topic, it.end.word())) {
                    continue;
                }
                "leaves the topic best effort and transient local, and a best-effort subscriber never receives earlier messages; \
                 give the reliability reliable or the durability volatile"
                    .to_owned()
            }
        };
        let found = match own.is_none() && it.for_any_node {
            true => &mut warnings,
            false => &mut faults,
        };
        found.push(fault(message));
    }
    ParameterFaults::none_of(faults)
        .map(|()| warnings)
        .map_err(OverrideError::Parameters)
}

/// The quality of service of all topics that a node can have, whether or not this one needs them.
type KnownTopics = HashMap<(String, TopicEnd), Qos>;

fn known_topics<'a>(
    columns: impl IntoIterator<Item = &'a Settings>,
    names: &Names,
) -> Result<KnownTopics, NameError> {
    let mut known = KnownTopics::new();
    for endpoint in ENDPOINTS {
        let end = match endpoint.direction {
            Direction::Out => TopicEnd::Publisher,
            Direction::In => TopicEnd::Subscription,
            Direction::Service => continue,
        };
        let name = names.resolve(NameKind::Topic, endpoint.name)?;
        known.insert((name, end), endpoint.qos);
    }
    let sensors = columns.into_iter().flat_map(|it| it.sensors.each.values());
    for sensor in sensors.filter(|it| !it.topic.is_empty()) {
        let name = names.resolve(NameKind::Topic, &sensor.topic)?;
        known.insert((name, TopicEnd::Subscription), SENSOR_DATA);
    }
    Ok(known)
}

/// The depths of the topics that the columns of a fleet share and that late joiners read; none of a single column, which displaces
/// only its own messages.
fn kept_of_columns(columns: usize, names: &Names) -> Result<HashMap<String, usize>, NameError> {
    let shared = [IMPACT_FORECAST, IMPACT_REPORT, TWIN_STATUS].into_iter();
    let shared = shared.filter(|_| columns > 1).map(|endpoint| {
        let name = names.resolve(NameKind::Topic, endpoint.name)?;
        Ok((name, endpoint.kept_of_all(columns).qos.depth))
    });
    shared.collect()
}

fn no_such_topic(given: &QosOverride<'_>, known: &KnownTopics) -> String {
    let mut topics: Vec<_> = known
        .keys()
        .filter(|(_, end)| *end == given.end)
        .map(|(name, _)| name.as_str())
        .collect();
    topics.sort_unstable();
    format!(
        "names a topic of which this node has no {}; expected one of {}",
        given.end.word(),
        topics.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::endpoints;
    use crate::parameters::parse_override;
    use ros_node::names::{RemapRule, RemapTarget};

    fn loaded(arguments: &[&str]) -> Parameters {
        let overrides: Vec<_> = arguments.iter().map(|it| parse_override(it)).collect();
        Parameters::load(&[], &overrides).expect("the values are right")
    }

    fn checked(arguments: &[&str], rules: &[RemapRule]) -> Result<(), String> {
        let parameters = loaded(arguments);
        let names = Names::new("/garage", "column_twin", rules).expect("names");
        match check_overrides(&parameters, [parameters.settings()], &names) {
            Ok(warnings) => {
                assert!(warnings.is_empty(), "{warnings:?}");
                Ok(())
            }
            Err(OverrideError::Parameters(faults)) => Err(faults.to_string()),
            Err(OverrideError::Name(error)) => panic!("{error}"),
        }
    }

    #[test]
    fn only_the_policies_that_are_given_change() {
        let parameters = loaded(&[
            "qos_overrides./column_state.publisher.reliability:=best_effort",
            "qos_overrides./column_state.publisher.depth:=7",
        ]);
        let overrides = QosOverrides::new(&parameters.settings().qos_overrides);
        let own = endpoints::COLUMN_STATE.qos;
        let expected = Qos {
            reliable: false,
            depth: 7,
            ..own
        };
        let apply = |topic, end| overrides.apply(topic, end, &own);
        assert_eq!(apply("/column_state", TopicEnd::Publisher), expected);
        assert_eq!(apply("/column_state", TopicEnd::Subscription), own);
        assert_eq!(apply("/hinge_forces", TopicEnd::Publisher), own);
    }

    #[test]
    fn a_topic_is_named_as_it_is_on_the_network() {
        let depth = |topic: &str| format!("qos_overrides.{topic}.publisher.depth:=7");
        assert_eq!(checked(&[&depth("/garage/column_state")], &[]), Ok(()));
        assert_eq!(checked(&[&depth("/rosout")], &[]), Ok(()));
        let fault = checked(&[&depth("/column_state")], &[]).expect_err("without the namespace");
        assert!(
            fault.contains("qos_overrides./column_state.publisher.depth")
                && fault.contains("/garage/column_state, "),
            "{fault}"
        );
        let rule = RemapRule {
            node: None,
            target: RemapTarget::TopicOrService,
            from: "column_state".to_owned(),
            to: "/monitor".to_owned(),
        };
        let rules = [rule];
        assert_eq!(checked(&[&depth("/monitor")], &rules), Ok(()));
        assert!(checked(&[&depth("/garage/column_state")], &rules).is_err());
    }

    #[test]
    fn the_end_of_a_topic_must_be_one_that_the_node_has() {
        let fault = checked(
            &["qos_overrides./garage/impact_event.publisher.depth:=7"],
            &[],
        );
        let fault = fault.expect_err("the node subscribes");
        assert!(fault.contains("has no publisher"), "{fault}");
        let topic_of_a_sensor = [
            "sensors.names:=[laser]",
            "sensors.laser.quantity:=displacement",
            "sensors.laser.height:=1.0",
            "sensors.laser.topic:=/laser/samples",
            "qos_overrides./laser/samples.subscription.reliability:=reliable",
        ];
        assert_eq!(checked(&topic_of_a_sensor, &[]), Ok(()));
    }

    /// It was shortened without a word, and a late subscriber learnt of one column.
    #[test]
    fn a_history_that_is_too_short_for_the_columns_of_a_fleet_is_a_warning() {
        let names = Names::new("/garage", "column_twin", &[]).expect("names");
        let warnings = |depth: i64, columns: usize| {
            let override_ = format!("qos_overrides./garage/twin_status.publisher.depth:={depth}");
            let parameters = loaded(&[&override_]);
            let columns = std::iter::repeat_n(parameters.settings(), columns);
            let checked = check_overrides(&parameters, columns, &names);
            let warnings = checked.expect("it is possible");
            warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        let found = warnings(2, 3);
        assert!(
            found.len() == 1 && found[0].contains("give at least 3"),
            "{found:?}"
        );
        assert!(warnings(3, 3).is_empty());
        assert!(warnings(1, 1).is_empty());
    }

    #[test]
    fn a_latched_topic_cannot_become_best_effort_alone() {
        let best_effort = "qos_overrides./garage/twin_status.publisher.reliability:=best_effort";
        let volatile = "qos_overrides./garage/twin_status.publisher.durability:=volatile";
        let fault = checked(&[best_effort], &[]).expect_err("of no use");
        assert!(fault.contains("the durability volatile"), "{fault}");
        assert_eq!(checked(&[best_effort, volatile], &[]), Ok(()));
    }
}
