//! Type hashes of everything that a node speaks, which rmw_zenoh has in its keys.

use crate::messages::interface::DefinitionError;
use crate::messages::service_msgs::ServiceEventInfo;
use crate::messages::type_description::TypeDescription;
use crate::messages::type_hash::TypeHash;
use crate::messages::{INTERFACES, Interface, Message, Part, find};

/// Messages in the services that every node has. Only their fields count for the hash.
static MESSAGES: [Interface; 11] = [
    message(
        "rcl_interfaces",
        "FloatingPointRange",
        "float64 from_value\nfloat64 to_value\nfloat64 step\n",
    ),
    message(
        "rcl_interfaces",
        "IntegerRange",
        "int64 from_value\nint64 to_value\nuint64 step\n",
    ),
    message(
        "rcl_interfaces",
        "ParameterDescriptor",
        "string name\nuint8 type\nstring description\nstring additional_constraints\nbool read_only\nbool dynamic_typing\n\
         FloatingPointRange[<=1] floating_point_range\nIntegerRange[<=1] integer_range\n",
    ),
    message(
        "rcl_interfaces",
        "SetParametersResult",
        "bool successful\nstring reason\n",
    ),
    message(
        "rcl_interfaces",
        "ListParametersResult",
        "string[] names\nstring[] prefixes\n",
    ),
    message(
        "type_description_interfaces",
        "FieldType",
        "uint8 type_id\nuint64 capacity\nuint64 string_capacity\nstring<=255 nested_type_name\n",
    ),
    message(
        "type_description_interfaces",
        "Field",
        "string name\nFieldType type\nstring default_value\n",
    ),
    message(
        "type_description_interfaces",
        "IndividualTypeDescription",
        "string<=255 type_name\nField[] fields\n",
    ),
    message(
        "type_description_interfaces",
        "TypeDescription",
        "IndividualTypeDescription type_description\nIndividualTypeDescription[] referenced_type_descriptions\n",
    ),
    message(
        "type_description_interfaces",
        "TypeSource",
        "string type_name\nstring encoding\nstring raw_file_contents\n",
    ),
    message(
        "type_description_interfaces",
        "KeyValue",
        "string key\nstring value\n",
    ),
];

/// The services that every node has, as request and response.
static SERVICES: [[Interface; 2]; 7] = [
    service(
        "rcl_interfaces",
        "GetParameters",
        "string[] names\n---\nParameterValue[] values\n",
    ),
    service(
        "rcl_interfaces",
        "GetParameterTypes",
        "string[] names\n---\nuint8[] types\n",
    ),
    service(
        "rcl_interfaces",
        "ListParameters",
        "string[] prefixes\nuint64 depth\n---\nListParametersResult result\n",
    ),
    service(
        "rcl_interfaces",
        "DescribeParameters",
        "string[] names\n---\nParameterDescriptor[] descriptors\n",
    ),
    service(
        "rcl_interfaces",
        "SetParameters",
        "Parameter[] parameters\n---\nSetParametersResult[] results\n",
    ),
    service(
        "rcl_interfaces",
        "SetParametersAtomically",
        "Parameter[] parameters\n---\nSetParametersResult result\n",
    ),
    service(
        "type_description_interfaces",
        "GetTypeDescription",
        "string type_name\nstring type_hash\nbool include_type_sources\n---\nbool successful\nstring failure_reason\n\
         TypeDescription type_description\nTypeSource[] type_sources\nKeyValue[] extra_information\n",
    ),
];

const fn message(package: &'static str, name: &'static str, text: &'static str) -> Interface {
    Interface::new(package, Part::Message, name, text)
}

const fn service(package: &'static str, name: &'static str, text: &'static str) -> [Interface; 2] {
    [
        Interface::new(package, Part::Request, name, text),
        Interface::new(package, Part::Response, name, text),
    ]
}

/// The hash of a message or a service by its ROS name; `None` if its definition is unknown.
pub(super) fn type_hash(type_name: &str) -> Option<TypeHash> {
    let description = match find(type_name) {
        Some(message) => TypeDescription::of(message, INTERFACES),
        None => description_of(halves(type_name)?),
    };
    Some(TypeHash::from(
        &description.expect("the definitions are complete, which is tested"),
    ))
}

/// Request and response of a service.
fn halves(service: &str) -> Option<[&'static Interface; 2]> {
    let own = |half| find(&format!("{service}_{half}"));
    if let (Some(request), Some(response)) = (own("Request"), own("Response")) {
        return Some([request, response]);
    }
    let known = SERVICES.iter();
    known
        .map(|[request, response]| [request, response])
        .find(|[request, _]| request.source_name() == service)
}

fn description_of(halves: [&Interface; 2]) -> Result<TypeDescription, DefinitionError> {
    let definitions: Vec<_> = INTERFACES.iter().copied().chain(&MESSAGES).collect();
    TypeDescription::of_service(halves, ServiceEventInfo::INTERFACE, &definitions)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros::qos::ENDPOINTS;

    #[test]
    fn every_endpoint_has_a_hash() {
        for endpoint in ENDPOINTS {
            assert!(type_hash(endpoint.type_name).is_some(), "{}", endpoint.name);
        }
        assert_eq!(type_hash("nav_msgs/msg/Odometry"), None);
    }

    /// Those of the files in `share` of ROS 2 Jazzy.
    #[test]
    fn hashes_of_the_standard_services_are_the_published_ones() {
        for (service, hash) in [
            (
                "rcl_interfaces/srv/GetParameters",
                "bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc",
            ),
            (
                "rcl_interfaces/srv/GetParameterTypes",
                "da199c878688b3e530bdfe3ca8f74cb9fa0c303101e980a9e8f260e25e1c80ca",
            ),
            (
                "rcl_interfaces/srv/SetParameters",
                "56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0",
            ),
            (
                "rcl_interfaces/srv/SetParametersAtomically",
                "0e192ef259c07fc3c07a13191d27002222e65e00ccec653ca05e856f79285fcd",
            ),
            (
                "rcl_interfaces/srv/ListParameters",
                "3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d",
            ),
            (
                "rcl_interfaces/srv/DescribeParameters",
                "845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff",
            ),
            (
                "type_description_interfaces/srv/GetTypeDescription",
                "69b9c19c1021405984cc60dbbb1edceb147a6538b411d812ba6afabeed962cd5",
            ),
            (
                "std_srvs/srv/Trigger",
                "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
            ),
        ] {
            let computed = type_hash(service).map(|it| it.to_string());
            assert_eq!(computed, Some(format!("RIHS01_{hash}")), "{service}");
        }
    }
}
