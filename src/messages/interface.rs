//! A type on the wire: its names, its definition, and what follows from the definition.

use re_ros_msg::MessageSchema;
use re_ros_msg::message_spec::{ComplexType, MessageSpecification, Type};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::table;

/// A struct that travels as a ROS 2 message, or as one half of a service.
pub trait Message: Serialize + DeserializeOwned {
    /// Its names and its definition.
    const INTERFACE: &'static Interface;
}

/// What of its file a type is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// A whole `.msg` file.
    Message,
    /// The part of a `.srv` file above `---`.
    Request,
    /// The part of a `.srv` file below `---`.
    Response,
}

/// One type: where it is defined and what it is called.
#[derive(Debug, PartialEq, Eq)]
pub struct Interface {
    package: &'static str,
    part: Part,
    name: &'static str,
    file: &'static str,
}

/// The text of a definition is wrong. The texts are part of the program, and tests read every one of them.
#[derive(Debug, thiserror::Error)]
pub enum DefinitionError {
    /// Not what a `.msg` file may hold.
    #[error("definition of {interface}: {reason}")]
    Syntax {
        /// ROS name of the type.
        interface: String,
        /// What the parser says.
        reason: String,
    },
    /// A field of a type that is not in the table.
    #[error(
        "definition of {interface}: expected a type that src/messages/table.rs lists, found {found}; add it there"
    )]
    UnknownType {
        /// ROS name of the type that has the field.
        interface: String,
        /// ROS name of the field's type.
        found: String,
    },
}

impl Interface {
    /// `name` is that of the file without its extension, `file` the file's text.
    pub(super) const fn new(
        package: &'static str,
        part: Part,
        name: &'static str,
        file: &'static str,
    ) -> Self {
        Self {
            package,
            part,
            name,
            file,
        }
    }

    /// Name of the ROS package.
    pub fn package(&self) -> &'static str {
        self.package
    }

    /// `column_twin/msg/ColumnState`, `std_srvs/srv/Trigger_Request`.
    pub fn ros_name(&self) -> String {
        format!("{}/{}/{}", self.package, self.folder(), self.type_name())
    }

    /// Name of the type in DDS: `column_twin::msg::dds_::ColumnState_`.
    pub fn dds_name(&self) -> String {
        format!(
            "{}::{}::dds_::{}_",
            self.package,
            self.folder(),
            self.type_name()
        )
    }

    /// Name of the type inside its package: `ColumnState`, `Trigger_Request`.
    pub fn type_name(&self) -> String {
        match self.part {
            Part::Message => self.name.to_owned(),
            Part::Request => format!("{}_Request", self.name),
            Part::Response => format!("{}_Response", self.name),
        }
    }

    fn folder(&self) -> &'static str {
        match self.part {
            Part::Message => "msg",
            Part::Request | Part::Response => "srv",
        }
    }

    /// The definition as it stands in the file; of a service, its own half.
    pub fn text(&self) -> &'static str {
        const SEPARATOR: &str = "---\n";
        let (above, below) = match self.file.find("\n---\n") {
            Some(at) => (&self.file[..=at], &self.file[at + 1 + SEPARATOR.len()..]),
            None => ("", self.file.strip_prefix(SEPARATOR).unwrap_or_default()),
        };
        match self.part {
            Part::Message => self.file,
            Part::Request => above,
            Part::Response => below,
        }
    }

    /// Fields and constants of the type. A type without fields has the one that rosidl gives it,
    /// `structure_needs_at_least_one_member`.
    ///
    /// # Errors
    /// When the text is not a ROS 2 definition.
    pub fn specification(&self) -> Result<MessageSpecification, DefinitionError> {
        MessageSchema::parse(&self.ros_name(), self.text())
            .map(|schema| schema.spec)
            .map_err(|error| DefinitionError::Syntax {
                interface: self.ros_name(),
                reason: format!("{error:#}"),
            })
    }

    /// The types of the fields, each once, in the order of their fields.
    ///
    /// # Errors
    /// When the text is wrong, or names a type that is not in the table.
    pub fn field_types(&self) -> Result<Vec<&'static Interface>, DefinitionError> {
        let mut found = Vec::new();
        for field in self.specification()?.fields {
            if let Some(nested) = nested_type(&field.ty) {
                let interface = self.resolve(nested)?;
                if !found.contains(&interface) {
                    found.push(interface);
                }
            }
        }
        Ok(found)
    }

    /// All types that this one is made of, each once: a field's type, then what that is made of, then the next field's.
    ///
    /// # Errors
    /// When a text is wrong, or names a type that is not in the table.
    pub fn dependencies(&self) -> Result<Vec<&'static Interface>, DefinitionError> {
        let mut found = Vec::new();
        self.collect_dependencies(&mut found)?;
        Ok(found)
    }

    fn collect_dependencies(
        &self,
        found: &mut Vec<&'static Interface>,
    ) -> Result<(), DefinitionError> {
        for interface in self.field_types()? {
            // A type that is already there is not entered again, which also ends a type that would hold itself.
            if !found.contains(&interface) {
                found.push(interface);
                interface.collect_dependencies(found)?;
            }
        }
        Ok(())
    }

    /// The text that a recording embeds as schema of encoding `ros2msg`: this definition, then every dependency
    /// under a line of 80 `=` and a line with its name.
    ///
    /// # Errors
    /// When a text is wrong, or names a type that is not in the table.
    pub fn schema_text(&self) -> Result<String, DefinitionError> {
        let mut text = with_final_newline(self.text());
        for dependency in self.dependencies()? {
            text += "\n";
            text += &"=".repeat(80);
            text += &format!("\nMSG: {}/{}\n", dependency.package, dependency.name);
            text += &with_final_newline(dependency.text());
        }
        Ok(text)
    }

    /// The type that a field of this type names, in full or, within one package, by its name alone.
    pub(super) fn resolve(
        &self,
        nested: &ComplexType,
    ) -> Result<&'static Interface, DefinitionError> {
        let ros_name = match nested {
            ComplexType::Absolute { package, name } => format!("{package}/msg/{name}"),
            ComplexType::Relative { name } => format!("{}/msg/{name}", self.package),
        };
        table::find(&ros_name).ok_or_else(|| DefinitionError::UnknownType {
            interface: self.ros_name(),
            found: ros_name,
        })
    }
}

/// The message type of a field or of its elements, if it is one.
fn nested_type(field: &Type) -> Option<&ComplexType> {
    match field {
        Type::BuiltIn(_) => None,
        Type::Complex(nested) => Some(nested),
        Type::Array { ty, .. } => nested_type(ty),
    }
}

fn with_final_newline(text: &str) -> String {
    let mut text = text.to_owned();
    if !text.ends_with('\n') {
        text.push('\n');
    }
    text
}
