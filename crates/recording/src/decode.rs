//! Decodes messages of any type by the definition that the recording holds.

use std::sync::Arc;

use re_cdr::{BigEndian, ByteOrder, CdrReader, LittleEndian};
use re_ros_msg::message_spec::BuiltInType;

use crate::definition::Shape;
use crate::error::RecordingError;
use crate::reader::{Message, RecordedTopic};
use crate::table;
use crate::value::Decoded;

/// Maximum number of values of a message per byte: a definition may contain arrays of nothing.
const VALUES_PER_BYTE: usize = 2;

/// Number of values that a message of any length may have.
const MIN_VALUES: usize = 10_000;

/// Decodes the messages of one topic.
#[derive(Debug, Clone)]
pub struct Decoder {
    topic: Arc<str>,
    type_name: Arc<str>,
    shape: Shape,
    /// Whether a table has a column for each value.
    fits: bool,
}

impl Decoder {
    /// A decoder for the messages of `topic`.
    ///
    /// # Errors
    /// The recording's definition of the type is missing, in an unknown encoding, or wrong.
    pub fn new(topic: &RecordedTopic) -> Result<Self, RecordingError> {
        let shape = Shape::of(topic)?;
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
    /// The message does not match the definition.
    pub fn decode(&self, message: &Message) -> Result<Decoded, RecordingError> {
        self.decode_bytes(&message.data)
            .map_err(|reason| RecordingError::Content {
                topic: self.topic.to_string(),
                type_name: self.type_name.to_string(),
                log_time: message.log_time,
                reason,
            })
    }

    /// Names of the columns of a table of the messages: `header.stamp.sec`, `values[0]`. A sequence is a single column, and
    /// so is a message that would have thousands of columns.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        match self.fits {
            true => table::columns(&self.shape),
            false => vec!["message".to_owned()],
        }
    }

    /// The cells of a message in the order of [`columns`](Self::columns); sequences as JSON.
    #[must_use]
    pub fn cells(&self, content: &Decoded) -> Vec<String> {
        match self.fits {
            true => table::cells(&self.shape, content),
            // Serializing plain values does not fail.
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
        let max_values = MIN_VALUES + VALUES_PER_BYTE * body.len();
        match head[..2] {
            [0, 0] => Cdr::<BigEndian>::new(body, max_values).read(&self.shape),
            [0, 1] => Cdr::<LittleEndian>::new(body, max_values).read(&self.shape),
            _ => Err(format!(
                "expected plain CDR (00 00 or 00 01), found {:02x} {:02x}",
                head[0], head[1]
            )),
        }
    }
}

/// A reader of plain CDR (XCDR1).
struct Cdr<'a, BO> {
    bytes: CdrReader<'a, BO>,
    values_left: usize,
}

impl<'a, BO: ByteOrder> Cdr<'a, BO> {
    fn new(body: &'a [u8], max_values: usize) -> Self {
        Self {
            bytes: CdrReader::new(body),
            values_left: max_values,
        }
    }

    fn read(&mut self, shape: &Shape) -> Result<Decoded, String> {
        self.values_left = self
            .values_left
            .checked_sub(1)
            .ok_or("the message has far more values than bytes")?;
        match shape {
            Shape::One(built_in) => self.read_one(built_in).map_err(|error| error.to_string()),
            Shape::Fields(fields) => {
                let mut values = Vec::with_capacity(fields.len());
                for (name, shape) in fields.iter() {
                    let value = self.read(shape);
                    let value = value.map_err(|reason| format!("{name}: {reason}"))?;
                    values.push((Arc::clone(name), value));
                }
                Ok(Decoded::Fields(values))
            }
            Shape::Array(element, length) => self.read_list(element, *length),
            Shape::Sequence(element, bound) => {
                let length = self.bytes.read_u32().map_err(|error| error.to_string())?;
                let length = usize::try_from(length).unwrap_or(usize::MAX);
                match bound {
                    Some(bound) if length > *bound => {
                        Err(format!("expected at most {bound} elements, found {length}"))
                    }
                    _ => self.read_list(element, length),
                }
            }
        }
    }

    /// Allocates memory for the elements that are there, not for the announced number.
    fn read_list(&mut self, element: &Shape, length: usize) -> Result<Decoded, String> {
        let mut values = Vec::new();
        for _ in 0..length {
            values.push(self.read(element)?);
        }
        Ok(Decoded::List(values))
    }

    fn read_one(&mut self, built_in: &BuiltInType) -> re_cdr::Result<Decoded> {
        let bytes = &mut self.bytes;
        Ok(match built_in {
            BuiltInType::Bool => Decoded::Bool(bytes.read_u8()? != 0),
            BuiltInType::Byte | BuiltInType::Char | BuiltInType::UInt8 => {
                Decoded::Unsigned(bytes.read_u8()?.into())
            }
            BuiltInType::Int8 => Decoded::Integer(bytes.read_i8()?.into()),
            BuiltInType::Int16 => Decoded::Integer(bytes.read_i16()?.into()),
            BuiltInType::UInt16 => Decoded::Unsigned(bytes.read_u16()?.into()),
            BuiltInType::Int32 => Decoded::Integer(bytes.read_i32()?.into()),
            BuiltInType::UInt32 => Decoded::Unsigned(bytes.read_u32()?.into()),
            BuiltInType::Int64 => Decoded::Integer(bytes.read_i64()?),
            BuiltInType::UInt64 => Decoded::Unsigned(bytes.read_u64()?),
            BuiltInType::Float32 => Decoded::Float32(bytes.read_f32()?),
            BuiltInType::Float64 => Decoded::Float64(bytes.read_f64()?),
            BuiltInType::String(_) => Decoded::Text(bytes.read_string()?),
            BuiltInType::WString(_) => {
                return Err(re_cdr::Error::Custom(
                    "the encoding of wstring differs between vendors".to_owned(),
                ));
            }
        })
    }
}
