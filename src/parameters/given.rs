//! What was given for a parameter, with its place, before it is checked.

use super::fault::Origin;
use super::value::Value;
use super::yaml::{Location, YamlContent, YamlNode};

/// One name with what was given for it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Assignment {
    pub name: String,
    pub given: Given,
    /// Where the name is.
    pub name_place: Origin,
    /// Given for any node (`/**`): a name that this node does not know belongs to another one.
    pub for_any_node: bool,
    /// Number of its section in its file; later sections win.
    pub section: usize,
}

/// What was given for a parameter, or as an element of a list.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Given {
    pub content: Content,
    /// A scalar as it was typed.
    pub text: Option<String>,
    pub place: Origin,
}

/// What may be written where a value is expected.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Content {
    /// Nothing, or `null`.
    Nothing,
    /// A value that is no array.
    Scalar(Value),
    /// The elements of an array.
    List(Vec<Given>),
    /// A mapping, which no parameter is.
    Mapping,
}

impl Assignment {
    /// A value that a program gives.
    pub fn direct((name, value): (impl Into<String>, Value)) -> Self {
        Self {
            name: name.into(),
            given: Given::direct(value),
            name_place: Origin::Direct,
            for_any_node: false,
            section: 0,
        }
    }
}

impl Given {
    /// A value that a program gives.
    pub fn direct(value: Value) -> Self {
        let text = value.plain();
        let content = match value {
            Value::DoubleArray(numbers) => Content::list(numbers),
            Value::StringArray(texts) => Content::list(texts),
            scalar => Content::Scalar(scalar),
        };
        Self {
            text: matches!(content, Content::Scalar(_)).then_some(text),
            content,
            place: Origin::Direct,
        }
    }

    /// A node of a YAML text; `place` converts its location.
    pub fn of_yaml(node: &YamlNode, place: &impl Fn(&Location) -> Origin) -> Self {
        let (content, text) = match &node.content {
            YamlContent::Null => (Content::Nothing, None),
            YamlContent::Scalar { value, text } => {
                (Content::Scalar(value.clone()), Some(text.clone()))
            }
            YamlContent::List(elements) => {
                let elements = elements.iter().map(|it| Self::of_yaml(it, place));
                (Content::List(elements.collect()), None)
            }
            YamlContent::Mapping(_) => (Content::Mapping, None),
        };
        Self {
            content,
            text,
            place: place(&node.at),
        }
    }
}

impl Content {
    fn list<T: Into<Value>>(elements: Vec<T>) -> Self {
        let elements = elements.into_iter().map(Into::into);
        Self::List(elements.map(Given::direct).collect())
    }
}
