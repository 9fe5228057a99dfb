//! `~/get_type_description`: what the types of the node look like, as every node of rclcpp and rclpy answers it.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::endpoints::{Direction, ENDPOINTS};
use crate::messages::interface::DefinitionError;
use crate::messages::service_msgs::ServiceEventInfo;
use crate::messages::type_description::TypeDescription;
use crate::messages::type_hash::TypeHash;
use crate::messages::{INTERFACES, Interface, Message, Part, find};

/// `type_description_interfaces/srv/GetTypeDescription_Request`
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct GetTypeDescriptionRequest {
    pub type_name: String,
    /// `RIHS01_...`
    pub type_hash: String,
    pub include_type_sources: bool,
}

/// `type_description_interfaces/srv/GetTypeDescription_Response`
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct GetTypeDescriptionResponse {
    pub successful: bool,
    pub failure_reason: String,
    pub type_description: TypeDescription,
    pub type_sources: Vec<TypeSource>,
    pub extra_information: Vec<KeyValue>,
}

/// `type_description_interfaces/msg/TypeSource`
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct TypeSource {
    pub type_name: String,
    /// `msg`, `srv`, or `implicit` for the parts of a service.
    pub encoding: String,
    pub raw_file_contents: String,
}

/// `type_description_interfaces/msg/KeyValue`
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct KeyValue {
    pub key: String,
    pub value: String,
}

impl ros2_client::Message for GetTypeDescriptionRequest {}
impl ros2_client::Message for GetTypeDescriptionResponse {}

/// All messages and services of this program by their type hash, described once.
static DESCRIPTIONS: LazyLock<BTreeMap<String, TypeDescription>> = LazyLock::new(|| {
    let messages = INTERFACES
        .iter()
        .map(|interface| TypeDescription::of(interface, INTERFACES));
    let services = ENDPOINTS
        .iter()
        .filter(|endpoint| endpoint.direction == Direction::Service)
        .filter_map(|endpoint| {
            let half = |half| find(&format!("{}_{half}", endpoint.type_name));
            Some(service([half("Request")?, half("Response")?]))
        });
    messages
        .chain(services)
        .map(|description| {
            let description = description.expect("the definitions are complete, which is tested");
            (TypeHash::from(&description).to_string(), description)
        })
        .collect()
});

fn service(halves: [&'static Interface; 2]) -> Result<TypeDescription, DefinitionError> {
    TypeDescription::of_service(halves, ServiceEventInfo::INTERFACE, INTERFACES)
}

/// The answer to a request. The hash decides, as in rcl: it belongs to one type only.
pub(super) fn describe(request: &GetTypeDescriptionRequest) -> GetTypeDescriptionResponse {
    let Some(description) = DESCRIPTIONS.get(&request.type_hash) else {
        return GetTypeDescriptionResponse {
            failure_reason: failure_reason(request),
            ..GetTypeDescriptionResponse::default()
        };
    };
    GetTypeDescriptionResponse {
        successful: true,
        type_sources: match request.include_type_sources {
            true => sources(description),
            false => vec![],
        },
        type_description: description.clone(),
        ..GetTypeDescriptionResponse::default()
    }
}

fn failure_reason(request: &GetTypeDescriptionRequest) -> String {
    let known = DESCRIPTIONS
        .iter()
        .find(|(_, it)| it.type_description.type_name == request.type_name);
    match known {
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
fn sources(description: &TypeDescription) -> Vec<TypeSource> {
    let types = std::iter::once(&description.type_description)
        .chain(&description.referenced_type_descriptions);
    types.map(|it| source(&it.type_name)).collect()
}

fn source(type_name: &str) -> TypeSource {
    let part_of_service = |suffix: &str| find(&format!("{type_name}{suffix}"));
    let file = match find(type_name).filter(|it| it.part() == Part::Message) {
        Some(message) => Some(("msg", message)),
        None => part_of_service("_Request").map(|request| ("srv", request)),
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

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(type_name: &str, type_hash: &str) -> GetTypeDescriptionResponse {
        describe(&GetTypeDescriptionRequest {
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
    fn every_type_of_the_program_is_described() {
        // Two types without fields or with equal ones would have one hash if the name were not part of it.
        let services = [
            "column_twin_msgs/srv/CorrectDamage",
            "column_twin_msgs/srv/ConfirmEstimate",
            "column_twin_msgs/srv/PredictImpact",
            "column_twin_msgs/srv/ResetColumn",
            "lifecycle_msgs/srv/ChangeState",
            "lifecycle_msgs/srv/GetAvailableStates",
            "lifecycle_msgs/srv/GetAvailableTransitions",
            "lifecycle_msgs/srv/GetState",
            "std_srvs/srv/Trigger",
        ];
        assert_eq!(DESCRIPTIONS.len(), INTERFACES.len() + services.len());
        for service in services {
            let mut all = DESCRIPTIONS.values();
            assert!(
                all.any(|it| it.type_description.type_name == service),
                "{service}"
            );
        }
    }

    #[test]
    fn an_unknown_hash_is_answered_with_the_reason() {
        let answer = asked("column_twin_msgs/msg/ColumnState", "RIHS01_00");
        assert!(!answer.successful && answer.type_sources.is_empty());
        let reason = &answer.failure_reason;
        assert!(
            reason.starts_with(
                "the hash of column_twin_msgs/msg/ColumnState in this node is RIHS01_"
            ),
            "{reason}"
        );
        let reason = asked("a\u{1b}/b", "").failure_reason;
        assert!(
            reason.starts_with("this node has no type with the given type_hash"),
            "{reason}"
        );
    }
}
