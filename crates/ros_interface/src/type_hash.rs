//! Type hashes as REP-2016 defines them (RIHS01) and as rosidl writes them to `share/<package>/msg/<Type>.json`.
//!
//! The hash is the SHA-256 of a description of the type and of all its dependencies, in JSON as Python's
//! `json.dumps` writes it. Comments, constants and default values are not part of the description.

use std::fmt;
use std::io;

use re_ros_msg::message_spec::{ArraySize, BuiltInType, Type};
use serde::Serialize;
use serde_json::ser::Formatter;
use sha2::{Digest, Sha256};

use crate::interface::{DefinitionError, Definitions, Interface};

/// The type hash of a message; displayed as `RIHS01_` and 64 hexadecimal digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TypeHash([u8; 32]);

impl TypeHash {
    /// The hash of `interface`.
    ///
    /// # Errors
    /// A definition is wrong, or names a type that is not among `definitions`.
    pub fn of(
        interface: &Interface,
        definitions: Definitions<'_>,
    ) -> Result<Self, DefinitionError> {
        let mut referenced: Vec<TypeDescription> = interface
            .dependencies(definitions)?
            .into_iter()
            .map(|dependency| TypeDescription::of(dependency, definitions))
            .collect::<Result<_, _>>()?;
        referenced.sort_by(|a, b| a.type_name.cmp(&b.type_name));
        let description = FullDescription {
            type_description: TypeDescription::of(interface, definitions)?,
            referenced_type_descriptions: referenced,
        };
        let mut json = Vec::new();
        description
            .serialize(&mut serde_json::Serializer::with_formatter(
                &mut json,
                PythonStyle,
            ))
            .map_err(|error| DefinitionError::Syntax {
                interface: interface.ros_name(),
                reason: error.to_string(),
            })?;
        Ok(Self(Sha256::digest(&json).into()))
    }
}

impl fmt::Display for TypeHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("RIHS01_")?;
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// The hashed part of `type_description_interfaces/msg/TypeDescription`.
#[derive(Serialize)]
struct FullDescription {
    type_description: TypeDescription,
    referenced_type_descriptions: Vec<TypeDescription>,
}

/// `type_description_interfaces/msg/IndividualTypeDescription`.
#[derive(Serialize)]
struct TypeDescription {
    type_name: String,
    fields: Vec<Field>,
}

/// `type_description_interfaces/msg/Field` without its default value.
#[derive(Serialize)]
struct Field {
    name: String,
    r#type: FieldType,
}

/// `type_description_interfaces/msg/FieldType`.
#[derive(Serialize)]
struct FieldType {
    type_id: u8,
    capacity: usize,
    string_capacity: usize,
    nested_type_name: String,
}

impl TypeDescription {
    fn of(interface: &Interface, definitions: Definitions<'_>) -> Result<Self, DefinitionError> {
        let fields = interface
            .specification()?
            .fields
            .into_iter()
            .map(|field| {
                Ok(Field {
                    r#type: FieldType::of(interface, &field.ty, definitions)?,
                    name: field.name,
                })
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            type_name: interface.ros_name(),
            fields,
        })
    }
}

impl FieldType {
    /// The type of a field of `interface`.
    fn of(
        interface: &Interface,
        ty: &Type,
        definitions: Definitions<'_>,
    ) -> Result<Self, DefinitionError> {
        match ty {
            Type::BuiltIn(built_in) => Ok(Self {
                type_id: type_id(built_in),
                capacity: 0,
                string_capacity: string_capacity(built_in),
                nested_type_name: String::new(),
            }),
            Type::Complex(nested) => Ok(Self {
                type_id: NESTED_TYPE,
                capacity: 0,
                string_capacity: 0,
                nested_type_name: interface.resolve(nested, definitions)?.ros_name(),
            }),
            Type::Array { ty, size } => {
                let (offset, capacity) = match *size {
                    ArraySize::Fixed(length) => (ARRAY, length),
                    ArraySize::Bounded(length) => (BOUNDED_SEQUENCE, length),
                    ArraySize::Unbounded => (UNBOUNDED_SEQUENCE, 0),
                };
                let element = Self::of(interface, ty, definitions)?;
                Ok(Self {
                    type_id: element.type_id + offset,
                    capacity,
                    ..element
                })
            }
        }
    }
}

/// Type ids of `type_description_interfaces/msg/FieldType`; the id of an array is that of its element plus an offset.
const NESTED_TYPE: u8 = 1;
const ARRAY: u8 = 48;
const BOUNDED_SEQUENCE: u8 = 96;
const UNBOUNDED_SEQUENCE: u8 = 144;

fn type_id(built_in: &BuiltInType) -> u8 {
    match built_in {
        BuiltInType::Int8 => 2,
        // rosidl treats char as uint8.
        BuiltInType::UInt8 | BuiltInType::Char => 3,
        BuiltInType::Int16 => 4,
        BuiltInType::UInt16 => 5,
        BuiltInType::Int32 => 6,
        BuiltInType::UInt32 => 7,
        BuiltInType::Int64 => 8,
        BuiltInType::UInt64 => 9,
        BuiltInType::Float32 => 10,
        BuiltInType::Float64 => 11,
        BuiltInType::Bool => 15,
        BuiltInType::Byte => 16,
        BuiltInType::String(None) => 17,
        BuiltInType::WString(None) => 18,
        BuiltInType::String(Some(_)) => 21,
        BuiltInType::WString(Some(_)) => 22,
    }
}

fn string_capacity(built_in: &BuiltInType) -> usize {
    match built_in {
        BuiltInType::String(Some(length)) | BuiltInType::WString(Some(length)) => *length,
        _ => 0,
    }
}

/// The separators of Python's `json.dumps`, over which rosidl computes the hash: a space after comma and colon.
struct PythonStyle;

impl Formatter for PythonStyle {
    fn begin_array_value<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        if first {
            Ok(())
        } else {
            writer.write_all(b", ")
        }
    }

    fn begin_object_key<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        if first {
            Ok(())
        } else {
            writer.write_all(b", ")
        }
    }

    fn begin_object_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }
}
