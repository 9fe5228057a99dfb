//! Descriptions of types as REP-2011 and REP-2016 define them: what a type hash is computed over, and what the service
//! `~/get_type_description` answers.

use re_ros_msg::message_spec::{ArraySize, BuiltInType, Literal, Type};
use serde::{Deserialize, Serialize};

use crate::interface::{DefinitionError, Definitions, Interface};

/// A type with all types that it refers to, as in `type_description_interfaces/msg/TypeDescription`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct TypeDescription {
    /// The type itself.
    pub type_description: IndividualTypeDescription,
    /// What it refers to, directly or not, by name.
    pub referenced_type_descriptions: Vec<IndividualTypeDescription>,
}

/// One type, as in `type_description_interfaces/msg/IndividualTypeDescription`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct IndividualTypeDescription {
    /// `std_msgs/msg/Header`
    pub type_name: String,
    /// Its fields in their order.
    pub fields: Vec<Field>,
}

/// One field, as in `type_description_interfaces/msg/Field`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its type.
    pub r#type: FieldType,
    /// Its default value as rosidl writes it; empty if it has none.
    pub default_value: String,
}

/// The type of a field, as in `type_description_interfaces/msg/FieldType`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct FieldType {
    /// One of the constants `FIELD_TYPE_...`.
    pub type_id: u8,
    /// Length of an array, or maximum length of a bounded sequence; otherwise 0.
    pub capacity: u64,
    /// Maximum length of a bounded string; otherwise 0.
    pub string_capacity: u64,
    /// The message type of the field, if it is one.
    pub nested_type_name: String,
}

impl TypeDescription {
    /// The description of a message, or of one half of a service.
    ///
    /// # Errors
    /// A definition is wrong, or names a type that is not among `definitions`.
    pub fn of(
        interface: &Interface,
        definitions: Definitions<'_>,
    ) -> Result<Self, DefinitionError> {
        let mut referenced = interface
            .dependencies(definitions)?
            .into_iter()
            .map(|dependency| IndividualTypeDescription::of(dependency, definitions))
            .collect::<Result<Vec<_>, _>>()?;
        referenced.sort_by(|a, b| a.type_name.cmp(&b.type_name));
        Ok(Self {
            type_description: IndividualTypeDescription::of(interface, definitions)?,
            referenced_type_descriptions: referenced,
        })
    }

    /// The description of the service whose halves these are: rosidl gives it a field for each half and one for the events of
    /// service introspection, which refer to `event_info` (`service_msgs/msg/ServiceEventInfo`).
    ///
    /// # Errors
    /// A definition is wrong, or names a type that is not among `definitions`.
    pub fn of_service(
        [request, response]: [&Interface; 2],
        event_info: &Interface,
        definitions: Definitions<'_>,
    ) -> Result<Self, DefinitionError> {
        let halves = [request.ros_name(), response.ros_name()];
        let service = request.source_name();
        let event = format!("{service}_Event");
        let field = |name: &str, type_id: u8, capacity: u64, nested: &str| Field {
            name: name.to_owned(),
            r#type: FieldType {
                type_id,
                capacity,
                string_capacity: 0,
                nested_type_name: nested.to_owned(),
            },
            default_value: String::new(),
        };
        let half_of_event = |name, half| field(name, NESTED_TYPE + BOUNDED_SEQUENCE, 1, half);
        let mut referenced = vec![IndividualTypeDescription {
            type_name: event.clone(),
            fields: vec![
                field("info", NESTED_TYPE, 0, &event_info.ros_name()),
                half_of_event("request", &halves[0]),
                half_of_event("response", &halves[1]),
            ],
        }];
        for part in [request, response, event_info] {
            let Self {
                type_description,
                referenced_type_descriptions,
            } = Self::of(part, definitions)?;
            referenced.push(type_description);
            referenced.extend(referenced_type_descriptions);
        }
        referenced.sort_by(|a, b| a.type_name.cmp(&b.type_name));
        referenced.dedup();
        Ok(Self {
            type_description: IndividualTypeDescription {
                type_name: service,
                fields: vec![
                    field("request_message", NESTED_TYPE, 0, &halves[0]),
                    field("response_message", NESTED_TYPE, 0, &halves[1]),
                    field("event_message", NESTED_TYPE, 0, &event),
                ],
            },
            referenced_type_descriptions: referenced,
        })
    }
}

impl IndividualTypeDescription {
    fn of(interface: &Interface, definitions: Definitions<'_>) -> Result<Self, DefinitionError> {
        let mut fields = interface
            .specification()?
            .fields
            .into_iter()
            .map(|field| {
                Ok(Field {
                    r#type: FieldType::of(interface, &field.ty, definitions)?,
                    name: field.name,
                    default_value: field
                        .default
                        .map_or_else(String::new, |value| default_value(&field.ty, &value)),
                })
            })
            .collect::<Result<Vec<_>, _>>()?;
        if fields.is_empty() {
            fields.push(placeholder());
        }
        Ok(Self {
            type_name: interface.ros_name(),
            fields,
        })
    }
}

/// The field that rosidl gives to a type without fields.
fn placeholder() -> Field {
    Field {
        name: "structure_needs_at_least_one_member".to_owned(),
        r#type: FieldType {
            type_id: type_id(&BuiltInType::UInt8),
            capacity: 0,
            string_capacity: 0,
            nested_type_name: String::new(),
        },
        default_value: String::new(),
    }
}

/// A default value as Python writes it: rosidl converts it to the type of the field, and then to text.
fn default_value(ty: &Type, value: &Literal) -> String {
    let is_real = matches!(
        ty,
        Type::BuiltIn(BuiltInType::Float32 | BuiltInType::Float64)
    );
    let real = |number: f64| format!("{number:?}");
    match value {
        Literal::Bool(true) => "True".to_owned(),
        Literal::Bool(false) => "False".to_owned(),
        Literal::Int(number) if is_real => real(*number as f64),
        Literal::UInt(number) if is_real => real(*number as f64),
        Literal::Int(number) => number.to_string(),
        Literal::UInt(number) => number.to_string(),
        Literal::Float(number) => real(*number),
        Literal::String(text) => text.clone(),
        Literal::Array(elements) => {
            let element = match ty {
                Type::Array { ty, .. } => ty,
                other => other,
            };
            let elements: Vec<_> = elements
                .iter()
                .map(|it| default_value(element, it))
                .collect();
            format!("[{}]", elements.join(", "))
        }
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
                    capacity: capacity as u64,
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

fn string_capacity(built_in: &BuiltInType) -> u64 {
    match built_in {
        BuiltInType::String(Some(length)) | BuiltInType::WString(Some(length)) => *length as u64,
        _ => 0,
    }
}
