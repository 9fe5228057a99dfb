//! Type hashes as REP-2016 defines them (RIHS01) and as rosidl writes them to `share/<package>/msg/<Type>.json`.
//!
//! The hash is the SHA-256 of a description of the type and of all its dependencies, in JSON as Python's
//! `json.dumps` writes it. Comments, constants and default values are not part of the description.

use std::fmt;
use std::io;

use serde::Serialize;
use serde_json::ser::Formatter;
use sha2::{Digest, Sha256};

use crate::interface::{DefinitionError, Definitions, Interface};
use crate::type_description::{FieldType, IndividualTypeDescription, TypeDescription};

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
        TypeDescription::of(interface, definitions).map(|description| Self::from(&description))
    }
}

impl From<&TypeDescription> for TypeHash {
    fn from(description: &TypeDescription) -> Self {
        let referenced = &description.referenced_type_descriptions;
        let hashed = HashedDescription {
            type_description: HashedType::from(&description.type_description),
            referenced_type_descriptions: referenced.iter().map(HashedType::from).collect(),
        };
        let mut json = Vec::new();
        let mut serializer = serde_json::Serializer::with_formatter(&mut json, PythonStyle);
        hashed
            .serialize(&mut serializer)
            .expect("names and numbers are written to memory");
        Self(Sha256::digest(&json).into())
    }
}

impl fmt::Display for TypeHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("RIHS01_")?;
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// The hashed part of a description: all but the default values.
#[derive(Serialize)]
struct HashedDescription<'a> {
    type_description: HashedType<'a>,
    referenced_type_descriptions: Vec<HashedType<'a>>,
}

#[derive(Serialize)]
struct HashedType<'a> {
    type_name: &'a str,
    fields: Vec<HashedField<'a>>,
}

#[derive(Serialize)]
struct HashedField<'a> {
    name: &'a str,
    r#type: &'a FieldType,
}

impl<'a> From<&'a IndividualTypeDescription> for HashedType<'a> {
    fn from(description: &'a IndividualTypeDescription) -> Self {
        let fields = description.fields.iter().map(|field| HashedField {
            name: &field.name,
            r#type: &field.r#type,
        });
        Self {
            type_name: &description.type_name,
            fields: fields.collect(),
        }
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
