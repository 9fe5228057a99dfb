//! Parameters given on the command line.

use super::fault::{Fault, Origin, Problem};
use super::given::{Assignment, Content, Given};
use super::node_name::NodeName;
use super::yaml;

/// A parameter given on the command line: `-p [node:]name:=value`.
///
/// [`Parameters::load`](super::Parameters::load) reports its faults together with all others.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    /// The node that it is addressed to, if any.
    node: Option<String>,
    name: Option<String>,
    /// What was given, or what is wrong with the argument.
    given: Result<Given, Problem>,
    /// The argument as it was typed.
    text: String,
}

/// Splits a `-p` argument `[node:]name:=value` as ROS 2 does; YAML decides on the type of the value.
#[must_use]
pub fn parse_override(argument: &str) -> Override {
    let text = format!("-p {argument}");
    let malformed = |message: &str| Override {
        node: None,
        name: None,
        given: Err(Problem::Syntax(message.to_owned())),
        text: text.clone(),
    };
    let Some((target, value)) = argument.split_once(":=") else {
        return malformed("no `:=`; write it as name:=value, such as top.load:=2.0e6");
    };
    let (node, name) = match target.rsplit_once(':') {
        Some((node, name)) => (Some(node.to_owned()), name),
        None => (None, target),
    };
    if name.is_empty() {
        return malformed("no name before `:=`; write it as name:=value");
    }
    Override {
        node,
        name: Some(name.to_owned()),
        given: given_in_text(value, Origin::CommandLine(text.clone())),
        text,
    }
}

/// The value that a text gives; YAML decides on its type.
pub(super) fn given_in_text(value: &str, place: Origin) -> Result<Given, Problem> {
    let node = yaml::parse(value)
        .map_err(|error| Problem::Syntax(format!("has a value that is {}", error.message)))?;
    let nothing = Given {
        content: Content::Nothing,
        text: None,
        place: place.clone(),
    };
    Ok(node.map_or(nothing, |node| Given::of_yaml(&node, &|_| place.clone())))
}

impl Override {
    /// The assignment to this node's parameter.
    ///
    /// # Errors
    /// A malformed argument, or one for another node.
    pub(super) fn assignment(&self, node: &NodeName) -> Result<Assignment, Box<Fault>> {
        let place = Origin::CommandLine(self.text.clone());
        let fault = |problem| {
            Box::new(Fault {
                name: self.name.clone(),
                value: None,
                place: place.clone(),
                problem,
            })
        };
        if let Some(addressee) = self
            .node
            .as_deref()
            .filter(|addressee| !is_addressed_to(node, addressee))
        {
            return Err(fault(Problem::Inconsistent(format!(
                "is addressed to the node {addressee}, but this is {node}; omit `{addressee}:`"
            ))));
        }
        Ok(Assignment {
            given: self.given.clone().map_err(fault)?,
            name: self.name.clone().unwrap_or_default(),
            name_place: place.clone(),
            for_any_node: false,
            section: 0,
        })
    }
}

/// On the command line the bare name of a node is enough.
fn is_addressed_to(node: &NodeName, addressee: &str) -> bool {
    node.is_meant_by(addressee) || addressee == node.bare()
}

#[cfg(test)]
mod tests {
    use super::super::{Parameters, Value};
    use super::*;

    fn given(argument: &str) -> Result<(String, Value), String> {
        let assignment = parse_override(argument).assignment(&NodeName::default());
        let assignment = assignment.map_err(|fault| fault.to_string())?;
        match assignment.given.content {
            Content::Scalar(value) => Ok((assignment.name, value)),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn arguments_are_split_and_typed_as_ros_does() {
        for (argument, name, value) in [
            ("top.load:=2.0e6", "top.load", Value::Double(2.0e6)),
            ("top.load:=10", "top.load", Value::Integer(10)),
            (
                "section.name:=HEB 220",
                "section.name",
                Value::from("HEB 220"),
            ),
            ("section.name:=''", "section.name", Value::from("")),
            ("use_sim_time:=true", "use_sim_time", Value::Bool(true)),
            ("column_twin:top.load:=1.5", "top.load", Value::Double(1.5)),
            ("/column_twin:top.load:=1.5", "top.load", Value::Double(1.5)),
        ] {
            assert_eq!(given(argument), Ok((name.to_owned(), value)));
        }
        for (argument, expected) in [
            (
                "top.load=3",
                "-p top.load=3: no `:=`; write it as name:=value",
            ),
            (":=3", "-p :=3: no name before `:=`"),
            (
                "top.load:=[1",
                "top.load has a value that is not valid YAML",
            ),
            (
                "lidar:top.load:=1.0",
                "is addressed to the node lidar, but this is /column_twin",
            ),
        ] {
            let fault = given(argument).expect_err(argument);
            assert!(fault.contains(expected), "{fault}");
        }
    }

    #[test]
    fn values_that_are_no_scalars_are_checked_with_the_others() {
        for (argument, expected) in [
            (
                "top.load:=",
                "-p top.load:=: top.load has no value; allowed: 0 to 1e9 N",
            ),
            (
                "top.load:=[1, 2]",
                "top.load is a list; allowed: 0 to 1e9 N",
            ),
            (
                "top.load:={a: 1}",
                "top.load is a mapping; allowed: 0 to 1e9 N",
            ),
            ("top.laod:=[1, 2]", "did you mean top.load?"),
        ] {
            let faults = Parameters::load(&[], &[parse_override(argument)]);
            let faults = faults.expect_err(argument).to_string();
            assert!(faults.contains(expected), "{faults}");
        }
    }

    #[test]
    fn an_override_is_for_a_node_in_its_namespace() {
        let node = NodeName::new("/garage", "column_twin");
        for (addressee, meant) in [
            ("column_twin", true),
            ("/garage/column_twin", true),
            ("/column_twin", false),
            ("lidar", false),
        ] {
            let assignment =
                parse_override(&format!("{addressee}:top.load:=1.5")).assignment(&node);
            assert_eq!(assignment.is_ok(), meant, "{addressee}");
        }
    }
}
