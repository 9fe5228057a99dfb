//! The definitions that a recording holds of its types.

use std::collections::BTreeMap;
use std::sync::Arc;

use re_ros_msg::MessageSchema;
use re_ros_msg::message_spec::{ArraySize, BuiltInType, ComplexType, MessageSpecification, Type};

use crate::error::RecordingError;
use crate::reader::RecordedTopic;

/// Maximum length of a definition \[bytes\].
const MAX_DEFINITION: usize = 4 << 20;

/// Maximum depth of types that contain each other.
const MAX_DEPTH: usize = 32;

/// Name of the byte that a message without fields has.
const NO_FIELDS: &str = "structure_needs_at_least_one_member";

/// The structure of a type.
#[derive(Debug, Clone)]
pub(crate) enum Shape {
    One(BuiltInType),
    Fields(Arc<[(Arc<str>, Shape)]>),
    Array(Box<Shape>, usize),
    /// With the bound of its length, if it has one.
    Sequence(Box<Shape>, Option<usize>),
}

impl Shape {
    /// The structure of the messages of `topic`.
    pub fn of(topic: &RecordedTopic) -> Result<Self, RecordingError> {
        let schema = parse_schema(topic)?;
        let definitions = Definitions::new(&schema);
        definitions
            .shape_of(&schema.spec, &mut BTreeMap::new(), &mut Vec::new())
            .map_err(|reason| wrong_schema(topic, reason))
    }
}

fn wrong_schema(topic: &RecordedTopic, reason: String) -> RecordingError {
    RecordingError::Schema {
        topic: topic.name.to_string(),
        type_name: topic.type_name.to_string(),
        reason,
    }
}

fn parse_schema(topic: &RecordedTopic) -> Result<MessageSchema, RecordingError> {
    let wrong = |reason: String| wrong_schema(topic, reason);
    if topic.encoding != "cdr" || topic.schema_encoding != "ros2msg" {
        let (messages, schema) = (&topic.encoding, &topic.schema_encoding);
        return Err(wrong(format!(
            "expected messages in cdr and a definition in ros2msg, found {messages:?} and {schema:?}"
        )));
    }
    if topic.schema.len() > MAX_DEFINITION {
        return Err(wrong(format!(
            "expected at most {MAX_DEFINITION} bytes, found {}",
            topic.schema.len()
        )));
    }
    let text = std::str::from_utf8(&topic.schema)
        .map_err(|_| wrong("it is not valid UTF-8".to_owned()))?;
    MessageSchema::parse(&topic.type_name, text).map_err(|error| wrong(format!("{error:#}")))
}

/// Package and name of a type, with or without `msg` between them.
fn key(name: &str) -> (&str, &str) {
    let package = name.split('/').next().unwrap_or_default();
    (package, name.rsplit('/').next().unwrap_or_default())
}

/// The definitions on which a type depends.
struct Definitions<'a>(BTreeMap<(&'a str, &'a str), &'a MessageSpecification>);

impl<'a> Definitions<'a> {
    fn new(schema: &'a MessageSchema) -> Self {
        Self(
            schema
                .dependencies
                .iter()
                .map(|it| (key(&it.name), it))
                .collect(),
        )
    }

    fn find(
        &self,
        user: &'a MessageSpecification,
        wanted: &'a ComplexType,
    ) -> Result<&'a MessageSpecification, String> {
        let (package, name) = match wanted {
            ComplexType::Absolute { package, name } => (key(package).0, name.as_str()),
            ComplexType::Relative { name } => (key(&user.name).0, name.as_str()),
        };
        let found = self.0.get(&(package, name)).copied();
        found.ok_or_else(|| format!("{} needs {package}/{name}, which is not defined", user.name))
    }

    /// Each type is visited once; `inside` are the types that contain the current one, none of which may occur again.
    fn shape_of(
        &self,
        definition: &'a MessageSpecification,
        done: &mut BTreeMap<(&'a str, &'a str), Shape>,
        inside: &mut Vec<(&'a str, &'a str)>,
    ) -> Result<Shape, String> {
        let key = key(&definition.name);
        if let Some(shape) = done.get(&key) {
            return Ok(shape.clone());
        }
        if inside.contains(&key) {
            return Err(format!("{} contains itself", definition.name));
        }
        if inside.len() >= MAX_DEPTH {
            return Err(format!(
                "expected at most {MAX_DEPTH} types inside each other, found more"
            ));
        }
        inside.push(key);
        let mut fields = Vec::with_capacity(definition.fields.len().max(1));
        for field in &definition.fields {
            let shape = self.shape(definition, &field.ty, done, inside)?;
            fields.push((Arc::from(field.name.as_str()), shape));
        }
        if fields.is_empty() {
            fields.push((Arc::from(NO_FIELDS), Shape::One(BuiltInType::UInt8)));
        }
        inside.pop();
        let shape = Shape::Fields(fields.into());
        done.insert(key, shape.clone());
        Ok(shape)
    }

    fn shape(
        &self,
        user: &'a MessageSpecification,
        kind: &'a Type,
        done: &mut BTreeMap<(&'a str, &'a str), Shape>,
        inside: &mut Vec<(&'a str, &'a str)>,
    ) -> Result<Shape, String> {
        Ok(match kind {
            Type::BuiltIn(built_in) => Shape::One(built_in.clone()),
            Type::Complex(wanted) => self.shape_of(self.find(user, wanted)?, done, inside)?,
            Type::Array { ty, size } => {
                let element = Box::new(self.shape(user, ty, done, inside)?);
                match size {
                    ArraySize::Fixed(length) => Shape::Array(element, *length),
                    ArraySize::Bounded(length) => Shape::Sequence(element, Some(*length)),
                    ArraySize::Unbounded => Shape::Sequence(element, None),
                }
            }
        })
    }
}

impl RecordedTopic {
    /// Whether the recording defines the type as `expected` does (a schema in the encoding `ros2msg`), so that a
    /// program with that definition reads the messages as they were meant.
    ///
    /// # Errors
    /// Fields, their types or constants differ; the error names the first difference.
    pub fn check_definition(&self, expected: &str) -> Result<(), RecordingError> {
        let other = |difference: String| RecordingError::OtherDefinition {
            topic: self.name.to_string(),
            type_name: self.type_name.to_string(),
            difference,
        };
        let expected = MessageSchema::parse(&self.type_name, expected)
            .map_err(|error| wrong_schema(self, format!("{error:#}")))?;
        let (expected, found) = (lines(&expected), lines(&parse_schema(self)?));
        if expected == found {
            return Ok(());
        }
        let none = || "nothing".to_owned();
        let differs = (0..)
            .find(|index| expected.get(*index) != found.get(*index))
            .unwrap_or(0);
        let line = |lines: &[String]| lines.get(differs).cloned().unwrap_or_else(none);
        Err(other(format!(
            "expected {}, found {}",
            line(&expected),
            line(&found)
        )))
    }
}

/// Constants and fields of a definition, without comments and defaults; the type itself first.
fn lines(schema: &MessageSchema) -> Vec<String> {
    let mut dependencies: Vec<_> = schema.dependencies.iter().collect();
    dependencies.sort_by_key(|it| key(&it.name));
    let mut lines = Vec::new();
    for definition in std::iter::once(&schema.spec).chain(dependencies) {
        let (package, name) = key(&definition.name);
        let constants = definition.constants.iter();
        lines.extend(constants.map(|it| {
            format!(
                "{package}/{name}: {} {} = {:?}",
                type_text(&it.ty),
                it.name,
                it.value
            )
        }));
        let fields = definition.fields.iter();
        lines.extend(
            fields.map(|it| format!("{package}/{name}: {} {}", type_text(&it.ty), it.name)),
        );
    }
    lines
}

/// A type as a definition writes it.
fn type_text(kind: &Type) -> String {
    match kind {
        Type::BuiltIn(built_in) => format!("{built_in:?}").to_lowercase(),
        Type::Complex(ComplexType::Absolute { package, name }) => {
            format!("{}/{name}", key(package).0)
        }
        Type::Complex(ComplexType::Relative { name }) => name.clone(),
        Type::Array {
            ty,
            size: ArraySize::Fixed(length),
        } => format!("{}[{length}]", type_text(ty)),
        Type::Array {
            ty,
            size: ArraySize::Bounded(length),
        } => format!("{}[<={length}]", type_text(ty)),
        Type::Array {
            ty,
            size: ArraySize::Unbounded,
        } => format!("{}[]", type_text(ty)),
    }
}
