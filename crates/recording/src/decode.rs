//! Decodes messages of any type by the definition that the recording holds.

use std::sync::Arc;

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
            values_left: MIN_VALUES + VALUES_PER_BYTE * body.len(),
        };
        cdr.read(&self.shape)
    }
}

/// A reader of plain CDR (XCDR1).
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
            .ok_or("the message has far more values than bytes")?;
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

    /// Allocates memory for the elements that are there, not for the announced number.
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
                return Err(
                    "the message has a wstring, whose encoding differs between vendors".to_owned(),
                );
            }
        })
    }

    fn u32(&mut self) -> Result<u32, String> {
        Ok(u32::from_ne_bytes(self.array()?))
    }

    /// A string ends with a zero, which its length includes.
    fn text(&mut self) -> Result<String, String> {
        let length = usize::try_from(self.u32()?).unwrap_or(usize::MAX);
        let bytes = self.take(length)?;
        let bytes = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        let text =
            std::str::from_utf8(bytes).map_err(|_| "expected text in UTF-8, found other bytes")?;
        Ok(text.to_owned())
    }

    /// The bytes of a number in the byte order of this machine; a number is aligned to its length.
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
