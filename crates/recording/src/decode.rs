//! Takes messages apart by the definition that the recording itself holds, of whatever type they are.

use std::collections::BTreeMap;
use std::sync::Arc;

use re_ros_msg::MessageSchema;
use re_ros_msg::message_spec::{ArraySize, BuiltInType, ComplexType, MessageSpecification, Type};
use serde::{Serialize, Serializer, ser::SerializeMap};

use crate::error::RecordingError;
use crate::reader::{Message, RecordedTopic};
use crate::table;

/// Longest definition that is read \[bytes\].
const MAX_DEFINITION: usize = 4 << 20;

/// Most types inside each other.
const DEEPEST: usize = 32;

/// Values of a message beyond which it is refused, for each byte that it has: a definition may say arrays of nothing.
const VALUES_PER_BYTE: usize = 2;

/// Values that a message of any length may have.
const VALUES_AT_LEAST: usize = 10_000;

/// Name of the byte that a message without fields has.
const NO_FIELDS: &str = "structure_needs_at_least_one_member";

/// A value of a message.
#[derive(Debug, Clone, PartialEq)]
pub enum Decoded {
    /// `bool`.
    Bool(bool),
    /// A signed integer.
    Integer(i64),
    /// An unsigned integer, `byte` or `char`.
    Unsigned(u64),
    /// `float32`.
    Float32(f32),
    /// `float64`.
    Float64(f64),
    /// `string`.
    Text(String),
    /// An array or a sequence.
    List(Vec<Decoded>),
    /// A message: its fields in their order.
    Fields(Vec<(Arc<str>, Decoded)>),
}

impl Decoded {
    /// The field of that name, `header.stamp.sec`.
    #[must_use]
    pub fn field(&self, path: &str) -> Option<&Decoded> {
        path.split('.').try_fold(self, |value, name| match value {
            Self::Fields(fields) => fields
                .iter()
                .find(|(field, _)| **field == *name)
                .map(|(_, value)| value),
            _ => None,
        })
    }

    /// The number that it is, if it is one.
    #[must_use]
    pub fn as_f64(&self) -> Option<f64> {
        match self {
            Self::Float64(value) => Some(*value),
            Self::Float32(value) => Some(f64::from(*value)),
            Self::Integer(value) => Some(*value as f64),
            Self::Unsigned(value) => Some(*value as f64),
            _ => None,
        }
    }

    /// The text that it is, if it is one.
    #[must_use]
    pub fn as_text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }
}

impl Serialize for Decoded {
    /// Numbers that are not finite become the words that Python and JavaScript read: "NaN", "Infinity", "-Infinity".
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Bool(value) => serializer.serialize_bool(*value),
            Self::Integer(value) => serializer.serialize_i64(*value),
            Self::Unsigned(value) => serializer.serialize_u64(*value),
            Self::Float32(value) if value.is_finite() => serializer.serialize_f32(*value),
            Self::Float64(value) if value.is_finite() => serializer.serialize_f64(*value),
            Self::Float32(value) => serializer.serialize_str(not_finite(f64::from(*value))),
            Self::Float64(value) => serializer.serialize_str(not_finite(*value)),
            Self::Text(text) => serializer.serialize_str(text),
            Self::List(values) => serializer.collect_seq(values),
            Self::Fields(fields) => {
                let mut map = serializer.serialize_map(Some(fields.len()))?;
                for (name, value) in fields {
                    map.serialize_entry(&**name, value)?;
                }
                map.end()
            }
        }
    }
}

/// The word for a number that JSON cannot write.
pub(crate) fn not_finite(value: f64) -> &'static str {
    if value.is_nan() {
        "NaN"
    } else if value > 0.0 {
        "Infinity"
    } else {
        "-Infinity"
    }
}

/// Reads the messages of one topic.
#[derive(Debug, Clone)]
pub struct Decoder {
    topic: Arc<str>,
    type_name: Arc<str>,
    shape: Shape,
    /// Whether such messages are rows of a table.
    fits: bool,
}

/// What a type is made of.
#[derive(Debug, Clone)]
pub(crate) enum Shape {
    One(BuiltInType),
    Fields(Arc<[(Arc<str>, Shape)]>),
    Array(Box<Shape>, usize),
    Sequence(Box<Shape>),
}

impl Decoder {
    /// For the messages of `topic`.
    ///
    /// # Errors
    /// The recording's definition of its type is missing, of another language, or wrong.
    pub fn new(topic: &RecordedTopic) -> Result<Self, RecordingError> {
        let schema = parse_schema(topic)?;
        let definitions = Definitions::new(&schema);
        let mut shapes = BTreeMap::new();
        let shape = definitions
            .shape_of(&schema.spec, &mut shapes, &mut Vec::new())
            .map_err(|reason| wrong_schema(topic, reason))?;
        Ok(Self {
            topic: Arc::clone(&topic.name),
            type_name: Arc::clone(&topic.type_name),
            fits: table::fits(&shape),
            shape,
        })
    }

    /// The content of a message.
    ///
    /// # Errors
    /// It does not fit the definition.
    pub fn decode(&self, message: &Message) -> Result<Decoded, RecordingError> {
        self.decode_bytes(&message.data)
            .map_err(|reason| RecordingError::Content {
                topic: self.topic.to_string(),
                type_name: self.type_name.to_string(),
                log_time: message.log_time,
                reason,
            })
    }

    /// Names of the columns of a table of such messages: `header.stamp.sec`, `moment[0]`. A sequence is one column, and
    /// so is a message that would have thousands.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        match self.fits {
            true => table::columns(&self.shape),
            false => vec!["message".to_owned()],
        }
    }

    /// The cells of a message under these [`columns`](Self::columns); sequences in JSON.
    #[must_use]
    pub fn cells(&self, content: &Decoded) -> Vec<String> {
        match self.fits {
            true => table::cells(&self.shape, content),
            // Written by serde from plain values, which does not fail.
            false => vec![serde_json::to_string(content).unwrap_or_default()],
        }
    }

    fn decode_bytes(&self, data: &[u8]) -> Result<Decoded, String> {
        let Some((head, body)) = data.split_first_chunk::<4>() else {
            return Err(format!(
                "expected 4 bytes of encapsulation header, found {} bytes",
                data.len()
            ));
        };
        let big_endian = match head[..2] {
            [0, 0] => true,
            [0, 1] => false,
            _ => {
                return Err(format!(
                    "expected plain CDR (00 00 or 00 01), found {:02x} {:02x}",
                    head[0], head[1]
                ));
            }
        };
        let mut cdr = Cdr {
            body,
            at: 0,
            big_endian,
            values_left: VALUES_AT_LEAST + VALUES_PER_BYTE * body.len(),
        };
        cdr.read(&self.shape)
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
    let text = std::str::from_utf8(&topic.schema).map_err(|_| wrong("it is no text".to_owned()))?;
    MessageSchema::parse(&topic.type_name, text).map_err(|error| wrong(format!("{error:#}")))
}

/// Package and name of a type, whether or not `msg` stands between them.
fn key(name: &str) -> (&str, &str) {
    let package = name.split('/').next().unwrap_or_default();
    (package, name.rsplit('/').next().unwrap_or_default())
}

/// The definitions that a type is made of.
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

    /// Each type once; `inside` are the types that are being looked at, none of which may come again.
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
        if inside.len() >= DEEPEST {
            return Err(format!(
                "expected at most {DEEPEST} types inside each other, found more"
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
                    ArraySize::Bounded(_) | ArraySize::Unbounded => Shape::Sequence(element),
                }
            }
        })
    }
}

/// Reads plain CDR (XCDR1).
struct Cdr<'a> {
    body: &'a [u8],
    at: usize,
    big_endian: bool,
    values_left: usize,
}

impl Cdr<'_> {
    fn read(&mut self, shape: &Shape) -> Result<Decoded, String> {
        self.values_left = self
            .values_left
            .checked_sub(1)
            .ok_or("it has far more values than bytes")?;
        Ok(match shape {
            Shape::One(built_in) => self.read_one(built_in)?,
            Shape::Fields(fields) => {
                let mut values = Vec::with_capacity(fields.len());
                for (name, shape) in fields.iter() {
                    let value = self.read(shape).map_err(|reason| within(name, reason))?;
                    values.push((Arc::clone(name), value));
                }
                Decoded::Fields(values)
            }
            Shape::Array(element, length) => self.read_list(element, *length)?,
            Shape::Sequence(element) => {
                let length = self.u32()?;
                self.read_list(element, usize::try_from(length).unwrap_or(usize::MAX))?
            }
        })
    }

    /// Takes memory for what comes, not for what is announced.
    fn read_list(&mut self, element: &Shape, length: usize) -> Result<Decoded, String> {
        let mut values = Vec::new();
        for _ in 0..length {
            values.push(self.read(element)?);
        }
        Ok(Decoded::List(values))
    }

    fn read_one(&mut self, built_in: &BuiltInType) -> Result<Decoded, String> {
        Ok(match built_in {
            BuiltInType::Bool => Decoded::Bool(self.array::<1>()? != [0]),
            BuiltInType::Byte | BuiltInType::Char | BuiltInType::UInt8 => {
                Decoded::Unsigned(self.array::<1>()?[0].into())
            }
            BuiltInType::Int8 => Decoded::Integer(i8::from_ne_bytes(self.array()?).into()),
            BuiltInType::Int16 => Decoded::Integer(i16::from_ne_bytes(self.array()?).into()),
            BuiltInType::UInt16 => Decoded::Unsigned(u16::from_ne_bytes(self.array()?).into()),
            BuiltInType::Int32 => Decoded::Integer(i32::from_ne_bytes(self.array()?).into()),
            BuiltInType::UInt32 => Decoded::Unsigned(self.u32()?.into()),
            BuiltInType::Int64 => Decoded::Integer(i64::from_ne_bytes(self.array()?)),
            BuiltInType::UInt64 => Decoded::Unsigned(u64::from_ne_bytes(self.array()?)),
            BuiltInType::Float32 => Decoded::Float32(f32::from_ne_bytes(self.array()?)),
            BuiltInType::Float64 => Decoded::Float64(f64::from_ne_bytes(self.array()?)),
            BuiltInType::String(_) => Decoded::Text(self.text()?),
            BuiltInType::WString(_) => {
                return Err("it has a wstring, whose bytes differ from vendor to vendor".to_owned());
            }
        })
    }

    fn u32(&mut self) -> Result<u32, String> {
        Ok(u32::from_ne_bytes(self.array()?))
    }

    /// With the zero at its end, which its length counts.
    fn text(&mut self) -> Result<String, String> {
        let length = usize::try_from(self.u32()?).unwrap_or(usize::MAX);
        let bytes = self.take(length)?;
        let bytes = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        let text =
            std::str::from_utf8(bytes).map_err(|_| "expected text in UTF-8, found other bytes")?;
        Ok(text.to_owned())
    }

    /// A number, at a multiple of its length, turned into the order of this machine.
    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.at = self.at.next_multiple_of(N);
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        if self.big_endian != cfg!(target_endian = "big") {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn take(&mut self, length: usize) -> Result<&[u8], String> {
        let end = self.at.saturating_add(length);
        let taken = self.body.get(self.at..end);
        let taken = taken
            .ok_or_else(|| format!("expected at least {end} bytes, found {}", self.body.len()))?;
        self.at = end;
        Ok(taken)
    }
}

fn within(name: &str, reason: String) -> String {
    format!("{name}: {reason}")
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

/// What a definition says, without comments and defaults: fields and constants, the type itself first.
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

/// A type as it stands in a definition.
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
