//! `~/get_type_description`: what the types of the node look like, as every node of rclcpp and rclpy answers it.

use std::collections::BTreeMap;

use ros_interface::interface::DefinitionError;
use ros_interface::type_description::TypeDescription;
use ros_interface::type_hash::TypeHash;
use ros_interface::{Definitions, Part, find};
use serde::{Deserialize, Serialize};

/// The type of the events of a service; every description of a service contains it.
const SERVICE_EVENT_INFO: &str = "service_msgs/msg/ServiceEventInfo";

/// `type_description_interfaces/srv/GetTypeDescription_Request`
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct GetTypeDescriptionRequest {
    /// Decides nothing, and is told in the reason for a failure.
    pub type_name: String,
    /// `RIHS01_...`
    pub type_hash: String,
    /// Whether the answer has the texts of the definitions.
    pub include_type_sources: bool,
}

/// `type_description_interfaces/srv/GetTypeDescription_Response`
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct GetTypeDescriptionResponse {
    /// Whether the type is known.
    pub successful: bool,
    /// Empty if it is.
    pub failure_reason: String,
    /// Of the type and of all that it refers to.
    pub type_description: TypeDescription,
    /// Their definitions, if they were asked for.
    pub type_sources: Vec<TypeSource>,
    /// Always empty.
    pub extra_information: Vec<KeyValue>,
}

/// `type_description_interfaces/msg/TypeSource`
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TypeSource {
    /// `std_msgs/msg/Header`
    pub type_name: String,
    /// `msg`, `srv`, or `implicit` for the parts of a service.
    pub encoding: String,
    /// The text of the file; empty for the parts of a service.
    pub raw_file_contents: String,
}

/// `type_description_interfaces/msg/KeyValue`
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct KeyValue {
    /// What it is.
    pub key: String,
    /// Its value.
    pub value: String,
}

impl ros2_client::Message for GetTypeDescriptionRequest {}
impl ros2_client::Message for GetTypeDescriptionResponse {}

/// The messages and services of a program, described once.
#[derive(Debug)]
pub struct TypeDescriptions<'a> {
    definitions: Definitions<'a>,
    by_hash: BTreeMap<String, TypeDescription>,
}

impl<'a> TypeDescriptions<'a> {
    /// The descriptions of these messages, and of the services whose requests and responses are among them.
    ///
    /// # Errors
    /// A definition is wrong, or names a type that is not among `definitions`, which need `service_msgs/msg/ServiceEventInfo` if there
    /// are services.
    pub fn new(definitions: Definitions<'a>) -> Result<Self, DefinitionError> {
        let messages = definitions
            .iter()
            .map(|interface| TypeDescription::of(interface, definitions));
        let services = definitions
            .iter()
            .filter(|it| it.part() == Part::Request)
            .filter_map(|request| {
                let response = format!("{}_Response", request.source_name());
                let response = find(&response, definitions)?;
                let event_info = find(SERVICE_EVENT_INFO, definitions)?;
                Some(TypeDescription::of_service(
                    [request, response],
                    event_info,
                    definitions,
                ))
            });
        let described = messages.chain(services).map(|description| {
            let description = description?;
            Ok((TypeHash::from(&description).to_string(), description))
        });
        Ok(Self {
            by_hash: described.collect::<Result<_, _>>()?,
            definitions,
        })
    }

    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = &TypeDescription> {
        self.by_hash.values()
    }

    /// The answer to a request. The hash decides, as in rcl: it belongs to one type only.
    #[must_use]
    pub fn answer(&self, request: &GetTypeDescriptionRequest) -> GetTypeDescriptionResponse {
        let Some(description) = self.by_hash.get(&request.type_hash) else {
            return GetTypeDescriptionResponse {
                failure_reason: self.failure_reason(request),
                ..GetTypeDescriptionResponse::default()
            };
        };
        GetTypeDescriptionResponse {
            successful: true,
            type_sources: match request.include_type_sources {
                true => self.sources(description),
                false => vec![],
            },
            type_description: description.clone(),
            ..GetTypeDescriptionResponse::default()
        }
    }

    fn failure_reason(&self, request: &GetTypeDescriptionRequest) -> String {
        let mut known = self.by_hash.iter();
        match known.find(|(_, it)| it.type_description.type_name == request.type_name) {
            Some((hash, _)) => {
                let name = &request.type_name;
                format!("the hash of {name} in this node is {hash}; expected that hash in type_hash")
            }
            None => "this node has no type with the given type_hash; expected RIHS01_ and 64 hexadecimal digits of a type that \
                     it uses"
                .to_owned(),
        }
    }

    /// The sources of a type and of all that it refers to.
    fn sources(&self, description: &TypeDescription) -> Vec<TypeSource> {
        let types = std::iter::once(&description.type_description)
            .chain(&description.referenced_type_descriptions);
        types.map(|it| self.source(&it.type_name)).collect()
    }

    fn source(&self, type_name: &str) -> TypeSource {
        let find = |name: &str| find(name, self.definitions);
        let file = match find(type_name).filter(|it| it.part() == Part::Message) {
            Some(message) => Some(("msg", message)),
            None => find(&format!("{type_name}_Request")).map(|request| ("srv", request)),
        };
        let (encoding, text) = match file {
            // rosidl omits the last end of line.
            Some((encoding, interface)) => {
                let text = interface.source_text();
                (encoding, text.strip_suffix('\n').unwrap_or(text))
            }
            // The parts of a service have no files of their own.
            None => ("implicit", ""),
        };
        TypeSource {
            type_name: type_name.to_owned(),
            encoding: encoding.to_owned(),
            raw_file_contents: text.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use ros_interface::Interface;

    use super::*;

    const DEFINITIONS: [&Interface; 5] = [
        &Interface::new(
            "builtin_interfaces",
            Part::Message,
            "Time",
            "int32 sec\nuint32 nanosec\n",
        ),
        &Interface::new(
            "std_msgs",
            Part::Message,
            "Header",
            "builtin_interfaces/Time stamp\nstring frame_id\n",
        ),
        &Interface::new(
            "service_msgs",
            Part::Message,
            "ServiceEventInfo",
            include_str!("../../../msg/deps/service_msgs/ServiceEventInfo.msg"),
        ),
        &Interface::new("std_srvs", Part::Request, "Trigger", TRIGGER),
        &Interface::new("std_srvs", Part::Response, "Trigger", TRIGGER),
    ];

    const TRIGGER: &str = "---\nbool success\nstring message\n";

    fn asked(type_name: &str, type_hash: &str) -> GetTypeDescriptionResponse {
        let descriptions = TypeDescriptions::new(&DEFINITIONS).expect("complete");
        descriptions.answer(&GetTypeDescriptionRequest {
            type_name: type_name.to_owned(),
            type_hash: type_hash.to_owned(),
            include_type_sources: true,
        })
    }

    /// The published hashes, of which the second is in share/std_srvs/srv/Trigger.json of ROS 2 Jazzy.
    #[test]
    fn messages_and_services_are_described_with_their_sources() {
        let header = "RIHS01_f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01";
        let answer = asked("std_msgs/msg/Header", header);
        assert!(answer.successful, "{answer:?}");
        let described = &answer.type_description;
        assert_eq!(described.type_description.type_name, "std_msgs/msg/Header");
        let names: Vec<_> = answer
            .type_sources
            .iter()
            .map(|it| &*it.type_name)
            .collect();
        assert_eq!(
            names,
            ["std_msgs/msg/Header", "builtin_interfaces/msg/Time"]
        );
        assert!(
            answer.type_sources[0]
                .raw_file_contents
                .ends_with("string frame_id")
        );

        let trigger = "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f";
        let answer = asked("", trigger);
        let described = &answer.type_description;
        assert_eq!(described.type_description.type_name, "std_srvs/srv/Trigger");
        let kinds: Vec<_> = answer
            .type_sources
            .iter()
            .map(|it| (&*it.type_name, &*it.encoding))
            .collect();
        assert_eq!(
            kinds,
            [
                ("std_srvs/srv/Trigger", "srv"),
                ("builtin_interfaces/msg/Time", "msg"),
                ("service_msgs/msg/ServiceEventInfo", "msg"),
                ("std_srvs/srv/Trigger_Event", "implicit"),
                ("std_srvs/srv/Trigger_Request", "implicit"),
                ("std_srvs/srv/Trigger_Response", "implicit"),
            ]
        );
    }

    #[test]
    fn an_unknown_hash_is_answered_with_the_reason() {
        let answer = asked("std_msgs/msg/Header", "RIHS01_00");
        assert!(!answer.successful && answer.type_sources.is_empty());
        let reason = &answer.failure_reason;
        assert!(
            reason.starts_with("the hash of std_msgs/msg/Header in this node is RIHS01_"),
            "{reason}"
        );
        let reason = asked("a\u{1b}/b", "").failure_reason;
        assert!(
            reason.starts_with("this node has no type with the given type_hash"),
            "{reason}"
        );
    }
}
