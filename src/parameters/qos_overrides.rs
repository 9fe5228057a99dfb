//! The parameters that override the quality of service of a topic, with the names that rclcpp gives them.
//!
//! A topic has a name on the network only after remapping, so that the node looks it up; here are the notation and the values.

use std::collections::BTreeMap;

use super::parameter::Admissible::Choice;
use super::parameter::{Applies, DeclaredParameter, DefaultValue, Parameter, integer, parameters};
use super::value::{Kind, Value};

/// The policies that can be overridden, once for each end of each topic. A parameter exists only if it is given.
pub const QOS_PARAMETERS: &[Parameter] = parameters! {
    "qos_overrides.<topic>.<end>.history", "", Required(Kind::String), Choice(&["keep_last"]), Restart,
        "the node bounds every history, so that keep_all is not offered";
    "qos_overrides.<topic>.<end>.depth", "", Required(Kind::Integer), integer(1, MAX_DEPTH), Restart,
        "number of messages in the history";
    "qos_overrides.<topic>.<end>.reliability", "", Required(Kind::String), Choice(&["reliable", "best_effort"]), Restart,
        "whether lost messages are sent again";
    "qos_overrides.<topic>.<end>.durability", "", Required(Kind::String), Choice(&["volatile", "transient_local"]), Restart,
        "whether late subscribers receive the messages in the history";
};

/// Longest history: as many messages as RustDDS allows to be unacknowledged.
const MAX_DEPTH: i64 = 8192;

/// The group of all overrides.
pub(super) const QOS_GROUP: &str = "qos_overrides";

/// What is wrong with a name in the group that is no parameter.
pub(super) const EXPECTED_QOS_NAME: &str = "is not the policy of a topic; expected qos_overrides./TOPIC.publisher.POLICY or \
                                            qos_overrides./TOPIC.subscription.POLICY with the full name of the topic and the policy \
                                            history, depth, reliability or durability";

/// The end of a topic that the node has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TopicEnd {
    /// The node publishes.
    Publisher,
    /// The node subscribes.
    Subscription,
}

/// The overrides as given, by the full names of their parameters.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct QosSettings {
    pub(super) given: BTreeMap<String, GivenQos>,
}

/// The value of an override.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GivenQos {
    pub value: Value,
    /// It was given for any node (`/**`): a topic that this node does not have belongs to another one.
    pub for_any_node: bool,
}

/// One override.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QosOverride<'a> {
    /// The full name of the parameter.
    pub name: &'a str,
    /// The full name of the topic, after remapping.
    pub topic: &'a str,
    /// Which end of it.
    pub end: TopicEnd,
    /// `history`, `depth`, `reliability` or `durability`.
    pub policy: &'static str,
    /// The checked value.
    pub value: &'a Value,
    /// Whether the topic may belong to another node.
    pub for_any_node: bool,
}

impl TopicEnd {
    /// Its word in the names of parameters.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Publisher => "publisher",
            Self::Subscription => "subscription",
        }
    }
}

impl QosSettings {
    /// All overrides, in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = QosOverride<'_>> {
        self.given.iter().filter_map(|(name, given)| {
            let (topic, end, row) = parts(name)?;
            Some(QosOverride {
                name,
                topic,
                end,
                policy: policy(&QOS_PARAMETERS[row]),
                value: &given.value,
                for_any_node: given.for_any_node,
            })
        })
    }

    pub(super) fn declared(&self) -> impl Iterator<Item = DeclaredParameter<'_>> {
        self.given.keys().filter_map(|name| {
            let (.., row) = parts(name)?;
            Some(DeclaredParameter {
                name,
                row: &QOS_PARAMETERS[row],
            })
        })
    }

    pub(super) fn values(&self) -> impl Iterator<Item = Value> {
        self.given.values().map(|it| it.value.clone())
    }
}

/// The index in [`QOS_PARAMETERS`] of a parameter of this name, whatever its topic.
pub(super) fn qos_row(name: &str) -> Option<usize> {
    parts(name).map(|(.., row)| row)
}

/// The topic, its end and the index of the policy. The name of a topic contains no dots.
fn parts(name: &str) -> Option<(&str, TopicEnd, usize)> {
    let mut parts = name.strip_prefix(QOS_GROUP)?.strip_prefix('.')?.split('.');
    let (topic, end, wanted) = (parts.next()?, parts.next()?, parts.next()?);
    let end = [TopicEnd::Publisher, TopicEnd::Subscription]
        .into_iter()
        .find(|it| it.word() == end)?;
    let row = QOS_PARAMETERS.iter().position(|it| policy(it) == wanted)?;
    (parts.next().is_none() && topic.starts_with('/')).then_some((topic, end, row))
}

fn policy(row: &Parameter) -> &'static str {
    row.name.rsplit('.').next().unwrap_or(row.name)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{Parameters, parse_override};
    use super::*;

    #[test]
    fn overrides_have_the_names_of_rclcpp_in_files_and_arguments() {
        let text = "column_twin:\n  ros__parameters:\n    qos_overrides:\n      /impact_report:\n        publisher: {depth: 50}\n";
        let of_file = Parameters::from_yaml(Path::new("f.yaml"), text).expect("correct");
        let argument = parse_override("qos_overrides./impact_report.publisher.depth:=50");
        let of_argument = Parameters::load(&[], &[argument]).expect("correct");
        assert_eq!(of_file, of_argument);
        let name = "qos_overrides./impact_report.publisher.depth";
        assert_eq!(of_file.get(name), Some(Value::Integer(50)));
        assert!(of_file.declared(name).is_some_and(|it| it.row.read_only()));
        let given: Vec<_> = of_file.settings().qos_overrides.iter().collect();
        assert_eq!(given.len(), 1);
        assert_eq!(
            (given[0].topic, given[0].end, given[0].policy),
            ("/impact_report", TopicEnd::Publisher, "depth")
        );
        let read = Parameters::from_yaml(Path::new("f.yaml"), &of_file.to_yaml());
        assert_eq!(read, Ok(of_file));
        // Nothing that is not given is a parameter.
        let is_override = |name: &str| name.starts_with(QOS_GROUP);
        assert!(
            !Parameters::default()
                .all_declared()
                .any(|it| is_override(it.name))
        );
    }

    #[test]
    fn a_wrong_override_is_a_fault_that_says_what_is_expected() {
        for (argument, expected) in [
            (
                "qos_overrides./clock.subscription.depht:=1",
                "history, depth, reliability or durability",
            ),
            (
                "qos_overrides.clock.subscription.depth:=1",
                "full name of the topic",
            ),
            ("qos_overrides./clock.reader.depth:=1", "/TOPIC.publisher."),
            (
                "qos_overrides./clock.subscription.deadline:=1",
                "is not the policy of a topic",
            ),
            (
                "qos_overrides./clock.subscription.history:=keep_all",
                "keep_last",
            ),
            ("qos_overrides./clock.subscription.depth:=0", "1 to 8192"),
            (
                "qos_overrides./clock.subscription.reliability:=true",
                "best_effort",
            ),
        ] {
            let faults = Parameters::load(&[], &[parse_override(argument)]);
            let faults = faults.expect_err(argument).to_string();
            assert!(faults.contains(expected), "{argument}: {faults}");
        }
    }

    #[test]
    fn an_override_cannot_be_added_while_the_node_runs() {
        let before = Parameters::default();
        let name = "qos_overrides./impact_report.publisher.depth";
        let after = before
            .with_changes([(name, Value::Integer(5))])
            .expect("the value is right");
        let changed = after.changed_from(&before);
        assert!(changed.iter().all(|it| it.row.read_only()) && changed.len() == 1);
        // Other changes leave it as it is.
        let next = after
            .with_changes([("impact.velocity", Value::Double(3.0))])
            .expect("correct");
        assert_eq!(next.get(name), Some(Value::Integer(5)));
    }
}
