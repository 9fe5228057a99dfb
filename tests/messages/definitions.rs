//! The structs hold the fields of their definitions, and the table holds every definition.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use column_twin::messages::column_twin_msgs::{
    ColumnParameters, ColumnState, CorrectDamageRequest, HingeForces, ImpactEvent, ImpactReport,
    ParameterEntry, SecondOpinion, TwinStatus,
};
use column_twin::messages::diagnostic_msgs::DiagnosticStatus;
use column_twin::messages::lifecycle_msgs::{State, Transition};
use column_twin::messages::rcl_interfaces::Log;
use column_twin::messages::service_msgs::ServiceEventInfo;
use column_twin::messages::visualization_msgs::{Marker, MarkerArray};
use column_twin::messages::{INTERFACES, Message, find, geometry_msgs, std_msgs, std_srvs};
use re_ros_msg::MessageSchema;
use re_ros_msg::message_spec::{ArraySize, BuiltInType, ComplexType, Type};
use serde_reflection::{ContainerFormat, Format, Tracer, TracerConfig};

use super::{ForEachType, for_each_type};

/// The ROS package of `msg/` and `srv/`.
const PACKAGE: &str = "column_twin_msgs";

struct SameFields {
    seen: Vec<String>,
}

impl ForEachType for SameFields {
    fn visit<M: Message + PartialEq + std::fmt::Debug>(&mut self) {
        let interface = M::INTERFACE;
        let mut tracer = Tracer::new(TracerConfig::default().is_human_readable(false));
        let (format, _) = tracer.trace_simple_type::<M>().unwrap();
        let Format::TypeName(rust_name) = format else {
            panic!("{} is no struct", interface.ros_name())
        };
        assert_eq!(rust_name, interface.type_name().replace('_', ""));
        let registry = tracer.registry().unwrap();
        let ContainerFormat::Struct(found) = &registry[&rust_name] else {
            panic!("{rust_name} has no named fields")
        };

        let found: Vec<_> = found
            .iter()
            .map(|field| (field.name.clone(), field.value.clone()))
            .collect();
        let expected: Vec<_> = interface
            .specification()
            .unwrap()
            .fields
            .into_iter()
            .map(|field| (field.name, expected_format(&field.ty)))
            .collect();
        assert_eq!(found, expected, "{}", interface.ros_name());
        self.seen.push(interface.ros_name());
    }
}

/// How serde has to see a field of that type.
fn expected_format(ty: &Type) -> Format {
    match ty {
        Type::BuiltIn(BuiltInType::Bool) => Format::Bool,
        Type::BuiltIn(BuiltInType::Byte | BuiltInType::Char | BuiltInType::UInt8) => Format::U8,
        Type::BuiltIn(BuiltInType::Int32) => Format::I32,
        Type::BuiltIn(BuiltInType::UInt16) => Format::U16,
        Type::BuiltIn(BuiltInType::UInt32) => Format::U32,
        Type::BuiltIn(BuiltInType::Int64) => Format::I64,
        Type::BuiltIn(BuiltInType::UInt64) => Format::U64,
        Type::BuiltIn(BuiltInType::Float32) => Format::F32,
        Type::BuiltIn(BuiltInType::Float64) => Format::F64,
        Type::BuiltIn(BuiltInType::String(None)) => Format::Str,
        Type::BuiltIn(other) => {
            panic!("no definition uses {other:?} so far; say here how serde has to see it")
        }
        Type::Complex(ComplexType::Absolute { name, .. } | ComplexType::Relative { name }) => {
            Format::TypeName(name.clone())
        }
        Type::Array {
            ty,
            size: ArraySize::Fixed(length),
        } => Format::TupleArray {
            content: Box::new(expected_format(ty)),
            size: *length,
        },
        Type::Array { ty, .. } => Format::Seq(Box::new(expected_format(ty))),
    }
}

#[test]
fn every_struct_has_the_fields_of_its_definition_in_order() {
    let mut visitor = SameFields { seen: Vec::new() };
    for_each_type(&mut visitor);
    let all: Vec<_> = INTERFACES
        .iter()
        .map(|interface| interface.ros_name())
        .collect();
    assert_eq!(
        visitor.seen, all,
        "the list in main.rs is that of the table"
    );
}

/// As ROS 2 documents them, and as the documents of this program do.
#[test]
fn constants_have_the_values_of_their_definitions() {
    assert_eq!([Log::DEBUG, Log::WARN, Log::FATAL], [10, 30, 50]);
    assert_eq!([DiagnosticStatus::ERROR, DiagnosticStatus::STALE], [2, 3]);
    assert_eq!([Marker::SPHERE, Marker::DELETEALL], [2, 3]);
    assert_eq!(State::PRIMARY_STATE_ACTIVE, 3);
    assert_eq!(Transition::TRANSITION_ON_ERROR_FAILURE, 61);
    assert_eq!(ServiceEventInfo::RESPONSE_RECEIVED, 3);
    assert_eq!(ColumnState::FRACTURED, TwinStatus::FRACTURED);
    assert_eq!(TwinStatus::REJECTED_NOT_ACTIVE, 29);
    assert_eq!(ImpactReport::END_NOT_HIT, 10);
    assert_eq!(CorrectDamageRequest::ROTATION, 1);
}

/// NaN stands for the value of a parameter, or for one that is not known; an orientation starts as no rotation.
#[test]
fn structs_start_as_their_definitions_say() {
    let event = ImpactEvent::default();
    assert!(event.gap.is_nan() && event.direction.is_nan() && event.mass == 0.0);
    assert!(
        ColumnParameters::default()
            .entries()
            .all(|(_, it)| it.is_unchanged())
    );
    let opinion = SecondOpinion::default();
    assert!(opinion.residual_capacity[1].is_nan() && opinion.state == SecondOpinion::NONE);
    assert_eq!(
        [opinion.action, opinion.outcome],
        [ImpactReport::ACTION_UNKNOWN; 2]
    );
    assert_eq!(geometry_msgs::Quaternion::default().w, 1.0);
}

/// `HingeForces` and the others index their arrays in the order of the column itself.
#[test]
fn hinge_constants_are_the_order_of_the_column() {
    for (name, index) in [
        ("1a", HingeForces::HINGE_1A),
        ("1b", HingeForces::HINGE_1B),
        ("2", HingeForces::HINGE_2),
        ("3", HingeForces::HINGE_3),
    ] {
        assert_eq!(column_twin::column::HINGE_NAMES[usize::from(index)], name);
    }
}

/// Files below `folder`, as `package/msg/Name` or `package/srv/Name`.
fn files_below(folder: &Path, package: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        match path.extension().and_then(|extension| extension.to_str()) {
            None if stem == "deps" => {
                for dependency in fs::read_dir(&path).unwrap() {
                    let dependency = dependency.unwrap().path();
                    if dependency.is_dir() {
                        found.extend(files_below(
                            &dependency,
                            dependency.file_name().unwrap().to_str().unwrap(),
                        ));
                    }
                }
            }
            Some(extension @ ("msg" | "srv")) => {
                found.insert(format!("{package}/{extension}/{stem}"));
            }
            _ => panic!("expected definitions, found {}", path.display()),
        }
    }
    found
}

#[test]
fn table_and_cmake_name_every_definition_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let ours: BTreeSet<_> = ["msg", "srv"]
        .iter()
        .flat_map(|folder| files_below(&root.join(folder), PACKAGE))
        .collect();
    let table: BTreeSet<_> = INTERFACES
        .iter()
        .map(|interface| {
            interface
                .ros_name()
                .replace("_Request", "")
                .replace("_Response", "")
        })
        .collect();
    assert_eq!(ours, table);

    let cmake = fs::read_to_string(root.join("ros/column_twin_msgs/CMakeLists.txt")).unwrap();
    let own = format!("{PACKAGE}/");
    for file in ours.iter().filter_map(|name| name.strip_prefix(&own)) {
        let (folder, stem) = file.split_once('/').unwrap();
        assert!(
            cmake.contains(&format!("\"{folder}/{stem}.{folder}\"")),
            "CMakeLists.txt lacks {file}"
        );
    }
}

/// `colcon build` in a workspace that has a clone of this repository finds both packages: it looks for them in every folder, but
/// not below one that is a package itself, which a `package.xml` or a `CMakeLists.txt` makes it.
#[test]
fn colcon_finds_two_packages_of_this_version() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for above in [root, &root.join("ros")] {
        for file in ["package.xml", "CMakeLists.txt", "setup.py"] {
            let hides = above.join(file);
            assert!(
                !hides.exists(),
                "{} hides the packages below",
                hides.display()
            );
        }
    }
    let version = format!("<version>{}</version>", env!("CARGO_PKG_VERSION"));
    for name in ["column_twin", PACKAGE] {
        let package = root.join("ros").join(name).join("package.xml");
        let package = fs::read_to_string(package).unwrap();
        assert!(package.contains(&format!("<name>{name}</name>")), "{name}");
        assert!(package.contains(&version), "{name} is not of this version");
    }
}

#[test]
fn names_follow_ros_and_dds() {
    assert_eq!(
        ColumnState::INTERFACE.ros_name(),
        "column_twin_msgs/msg/ColumnState"
    );
    assert_eq!(
        ColumnState::INTERFACE.dds_name(),
        "column_twin_msgs::msg::dds_::ColumnState_"
    );
    assert_eq!(
        std_srvs::TriggerRequest::INTERFACE.ros_name(),
        "std_srvs/srv/Trigger_Request"
    );
    assert_eq!(
        std_srvs::TriggerRequest::INTERFACE.dds_name(),
        "std_srvs::srv::dds_::Trigger_Request_"
    );
    assert_eq!(
        find("column_twin_msgs/msg/ColumnState"),
        Some(ColumnState::INTERFACE)
    );
    assert_eq!(find("column_twin_msgs/msg/Columnstate"), None);
}

/// Without fields above `---`, the request is what rosidl makes of it and the response what stands below.
#[test]
fn service_files_are_cut_at_their_separator() {
    assert_eq!(std_srvs::TriggerRequest::INTERFACE.text(), "");
    assert!(
        std_srvs::TriggerResponse::INTERFACE
            .text()
            .starts_with("bool success")
    );
}

#[test]
fn schema_text_embeds_every_dependency_once() {
    let header = std_msgs::Header::INTERFACE;
    let time = find("builtin_interfaces/msg/Time").unwrap();
    let expected = format!(
        "{}\n{}\nMSG: builtin_interfaces/Time\n{}",
        header.text(),
        "=".repeat(80),
        time.text()
    );
    assert_eq!(header.schema_text(INTERFACES).unwrap(), expected);

    let text = MarkerArray::INTERFACE.schema_text(INTERFACES).unwrap();
    assert!(text.ends_with('\n'));
    let read = MessageSchema::parse("visualization_msgs/MarkerArray", &text).unwrap();
    let mut names: Vec<_> = read
        .dependencies
        .iter()
        .map(|dependency| dependency.name.as_str())
        .collect();
    names.sort_unstable();
    assert_eq!(
        names,
        [
            "builtin_interfaces/Duration",
            "builtin_interfaces/Time",
            "geometry_msgs/Point",
            "geometry_msgs/Pose",
            "geometry_msgs/Quaternion",
            "geometry_msgs/Vector3",
            "sensor_msgs/CompressedImage",
            "std_msgs/ColorRGBA",
            "std_msgs/Header",
            "visualization_msgs/Marker",
            "visualization_msgs/MeshFile",
            "visualization_msgs/UVCoordinate",
        ]
    );
}

/// The entries have the names of the fields, in their order, and the default leaves all parameters as they are.
#[test]
fn column_parameters_lists_every_parameter() {
    let message = ColumnParameters::default();
    let entries: Vec<_> = message.entries().collect();
    let names: Vec<_> = entries
        .iter()
        .map(|(name, _)| name.replace('.', "_"))
        .collect();
    let fields = ColumnParameters::INTERFACE.specification().unwrap().fields;
    let fields: Vec<_> = fields.iter().map(|field| field.name.as_str()).collect();
    assert_eq!(fields[..2], ["header", "column_id"]);
    assert_eq!(names, fields[2..]);
    assert!(entries.iter().all(|(_, entry)| entry.is_unchanged()));

    let message = ColumnParameters {
        top_load: f64::INFINITY,
        steel_grade: "S355".to_owned(),
        ..message
    };
    let set: Vec<_> = message
        .entries()
        .filter(|(_, entry)| !entry.is_unchanged())
        .collect();
    assert_eq!(
        set,
        [
            ("steel.grade", ParameterEntry::Text("S355")),
            ("top.load", ParameterEntry::Number(f64::INFINITY))
        ]
    );
}

/// Two kinds of numbers per vendor (2 and 4 bytes per character) make `wstring` useless between vendors, and a
/// comment without a unit makes a number useless.
#[test]
fn our_definitions_keep_the_message_rules() {
    for interface in INTERFACES
        .iter()
        .filter(|interface| interface.package() == PACKAGE)
    {
        let text = interface.text();
        let mut comment = "";
        for line in text.lines() {
            assert!(!line.contains("wstring"), "{line}");
            if let Some(words) = line.strip_prefix('#') {
                comment = words;
            } else if line.starts_with("float") || (line.starts_with("uint") && !line.contains('='))
            {
                assert!(
                    comment.contains('[') && comment.contains(']'),
                    "{}: no unit above {line}",
                    interface.ros_name()
                );
            }
        }
    }
}
