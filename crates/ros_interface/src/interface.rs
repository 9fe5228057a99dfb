//! A ROS 2 type: its names, its definition, and what follows from the definition.

use re_ros_msg::MessageSchema;
use re_ros_msg::message_spec::{ComplexType, MessageSpecification, Type};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The definitions in which the types of fields are looked up.
pub type Definitions<'a> = &'a [&'static Interface];

/// The definition with this ROS name, for example `std_msgs/msg/Header`.
#[must_use]
pub fn find(ros_name: &str, definitions: Definitions<'_>) -> Option<&'static Interface> {
    definitions
        .iter()
        .copied()
        .find(|interface| interface.ros_name() == ros_name)
}

/// A struct that is sent as a ROS 2 message, or as the request or response of a service.
pub trait Message: Serialize + DeserializeOwned {
    /// The names and the definition of the type.
    const INTERFACE: &'static Interface;
}

/// Which part of its file defines a type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// A whole `.msg` file.
    Message,
    /// The part of a `.srv` file above `---`.
    Request,
    /// The part of a `.srv` file below `---`.
    Response,
}

/// One type: its package, its name and its definition.
#[derive(Debug, PartialEq, Eq)]
pub struct Interface {
    package: &'static str,
    part: Part,
    name: &'static str,
    file: &'static str,
}

/// A definition that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum DefinitionError {
    /// The text is not valid in a `.msg` file.
    #[error("definition of {interface}: {reason}")]
    Syntax {
        /// ROS name of the type.
        interface: String,
        /// The message of the parser.
        reason: String,
    },
    /// The type of a field is not among the given definitions.
    #[error(
        "definition of {interface}: expected a type with a known definition, found {found}; add the definition of {found}"
    )]
    UnknownType {
        /// ROS name of the type that has the field.
        interface: String,
        /// ROS name of the field's type.
        found: String,
    },
}

impl Interface {
    /// `name` is the name of the file without its extension, `file` the text of the file.
    #[must_use]
    pub const fn new(
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
    #[must_use]
    pub fn package(&self) -> &'static str {
        self.package
    }

    /// `std_msgs/msg/Header`, `std_srvs/srv/Trigger_Request`.
    #[must_use]
    pub fn ros_name(&self) -> String {
        format!("{}/{}/{}", self.package, self.folder(), self.type_name())
    }

    /// Name of the type in DDS: `std_msgs::msg::dds_::Header_`.
    #[must_use]
    pub fn dds_name(&self) -> String {
        format!(
            "{}::{}::dds_::{}_",
            self.package,
            self.folder(),
            self.type_name()
        )
    }

    /// Name of the type inside its package: `Header`, `Trigger_Request`.
    #[must_use]
    pub fn type_name(&self) -> String {
        match self.part {
            Part::Message => self.name.to_owned(),
            Part::Request => format!("{}_Request", self.name),
            Part::Response => format!("{}_Response", self.name),
        }
    }

    /// Which part of its file defines the type.
    #[must_use]
    pub fn part(&self) -> Part {
        self.part
    }

    /// ROS name of what the file defines: the type itself, or the service of which it is a half (`std_srvs/srv/Trigger`).
    #[must_use]
    pub fn source_name(&self) -> String {
        format!("{}/{}/{}", self.package, self.folder(), self.name)
    }

    /// The text of the whole file.
    #[must_use]
    pub fn source_text(&self) -> &'static str {
        self.file
    }

    fn folder(&self) -> &'static str {
        match self.part {
            Part::Message => "msg",
            Part::Request | Part::Response => "srv",
        }
    }

    /// The text of the definition; for a service, the request's or the response's half of the file.
    #[must_use]
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

    /// Fields and constants of the type.
    ///
    /// # Errors
    /// The text is not a ROS 2 definition.
    pub fn specification(&self) -> Result<MessageSpecification, DefinitionError> {
        MessageSchema::parse(&self.ros_name(), self.text())
            .map(|schema| schema.spec)
            .map_err(|error| DefinitionError::Syntax {
                interface: self.ros_name(),
                reason: format!("{error:#}"),
            })
    }

    /// The message types of the fields, each once, in the order of the fields.
    ///
    /// # Errors
    /// The text is not a ROS 2 definition, or names a type that is not among `definitions`.
    pub fn field_types(
        &self,
        definitions: Definitions<'_>,
    ) -> Result<Vec<&'static Interface>, DefinitionError> {
        let mut found = Vec::new();
        for field in self.specification()?.fields {
            if let Some(nested) = nested_type(&field.ty) {
                let interface = self.resolve(nested, definitions)?;
                if !found.contains(&interface) {
                    found.push(interface);
                }
            }
        }
        Ok(found)
    }

    /// All types that this one depends on, each once, depth first in the order of the fields.
    ///
    /// # Errors
    /// A text is not a ROS 2 definition, or names a type that is not among `definitions`.
    pub fn dependencies(
        &self,
        definitions: Definitions<'_>,
    ) -> Result<Vec<&'static Interface>, DefinitionError> {
        let mut found = Vec::new();
        self.collect_dependencies(definitions, &mut found)?;
        Ok(found)
    }

    fn collect_dependencies(
        &self,
        definitions: Definitions<'_>,
        found: &mut Vec<&'static Interface>,
    ) -> Result<(), DefinitionError> {
        for interface in self.field_types(definitions)? {
            // A type that was found before is not entered again; this also ends the recursion of a type that contains itself.
            if !found.contains(&interface) {
                found.push(interface);
                interface.collect_dependencies(definitions, found)?;
            }
        }
        Ok(())
    }

    /// The schema text (encoding `ros2msg`) that a recording embeds: this definition, then every dependency
    /// under a line of 80 `=` and a line with its name.
    ///
    /// # Errors
    /// As for [`dependencies`](Self::dependencies).
    pub fn schema_text(&self, definitions: Definitions<'_>) -> Result<String, DefinitionError> {
        let mut text = with_final_newline(self.text());
        for dependency in self.dependencies(definitions)? {
            text += "\n";
            text += &"=".repeat(80);
            text += &format!("\nMSG: {}/{}\n", dependency.package, dependency.name);
            text += &with_final_newline(dependency.text());
        }
        Ok(text)
    }

    /// The type of a field: named in full or, within one package, by its name alone.
    pub(super) fn resolve(
        &self,
        nested: &ComplexType,
        definitions: Definitions<'_>,
    ) -> Result<&'static Interface, DefinitionError> {
        let ros_name = match nested {
            ComplexType::Absolute { package, name } => format!("{package}/msg/{name}"),
            ComplexType::Relative { name } => format!("{}/msg/{name}", self.package),
        };
        find(&ros_name, definitions).ok_or_else(|| DefinitionError::UnknownType {
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
