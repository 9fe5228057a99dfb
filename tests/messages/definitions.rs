//! The structs hold the fields and constants of their definitions, and the table holds every definition.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use column_twin::messages::column_twin_msgs::{
    ColumnParameters, ColumnState, CorrectDamageRequest, HingeDescription, HingeForces,
    ImpactEstimate, ImpactReport, ParameterEntry, SecondOpinion, TwinStatus,
};
use column_twin::messages::diagnostic_msgs::DiagnosticStatus;
use column_twin::messages::lifecycle_msgs::{State, Transition};
use column_twin::messages::rcl_interfaces::Log;
use column_twin::messages::service_msgs::ServiceEventInfo;
use column_twin::messages::visualization_msgs::{Marker, MarkerArray};
use column_twin::messages::{INTERFACES, Message, find, std_msgs, std_srvs};
use re_ros_msg::MessageSchema;
use re_ros_msg::message_spec::{ArraySize, BuiltInType, ComplexType, Literal, Type};
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

/// The constants of a definition, as `(name, value)`.
fn constants<M: Message>() -> Vec<(String, i64)> {
    let constants = M::INTERFACE.specification().unwrap().constants;
    let value = |literal: &Literal| match literal {
        Literal::Int(value) => *value,
        Literal::UInt(value) => i64::try_from(*value).unwrap(),
        other => panic!("no definition has a constant like {other:?} so far"),
    };
    constants
        .iter()
        .map(|constant| (constant.name.clone(), value(&constant.value)))
        .collect()
}

#[test]
fn every_constant_has_the_value_of_its_definition() {
    macro_rules! same_constants {
        ($($type:ident { $($name:ident),* $(,)? })*) => { $(
            let found = vec![$((stringify!($name).to_owned(), i64::from($type::$name))),*];
            assert_eq!(found, constants::<$type>(), stringify!($type));
        )* };
    }
    same_constants! {
        ColumnState { IDLE, APPROACH, CONTACT, FREE, REST, COLLAPSED, FAULTED, FRACTURED }
        ImpactEstimate {
            DECISION_PENDING, DECISION_ACCEPTED, DECISION_MERGED, DECISION_DECLINED, DECISION_REJECTED,
        }
        CorrectDamageRequest { DISPLACEMENT, ROTATION }
        HingeDescription { LOWER_END, UPPER_END, WHOLE_BAR }
        HingeForces { HINGE_1A, HINGE_1B, HINGE_2, HINGE_3, WEB_A, WEB_B, ELASTIC, PLASTIC, UNLOADED }
        ImpactReport {
            HINGE_1A, HINGE_1B, HINGE_2, HINGE_3, WEB_A, WEB_B, FORECAST, RESULT, PREDICTION, WITHDRAWN, NO_FORECAST,
            ELASTIC, PLASTIC, COLLAPSED, FRACTURED, OUTCOME_UNKNOWN,
            END_AT_REST, END_DURATION_REACHED, END_COLLAPSED, END_FRACTURED, END_NOT_CONVERGED,
            END_SUPERSEDED, END_RESET, END_STOPPED, END_REJECTED, END_NOT_COMPUTED, END_NOT_HIT,
            ACTION_NONE, ACTION_INSPECT, ACTION_RESTRICT, ACTION_SHORE, ACTION_EVACUATE, ACTION_UNKNOWN,
        }
        SecondOpinion { NONE, PENDING, KNOWN }
        TwinStatus {
            HINGE_1A, HINGE_1B, HINGE_2, HINGE_3, IDLE, APPROACH, CONTACT, FREE, REST, COLLAPSED, FAULTED, FRACTURED,
            REJECTED_NONE, REJECTED_OTHER_COLUMN, REJECTED_EVENT_ID_INVALID, REJECTED_EVENT_ID_REPEATED, REJECTED_STAMP_TOO_OLD, REJECTED_STAMP_TOO_FAR_AHEAD, REJECTED_STAMP_OUT_OF_ORDER, REJECTED_TOO_MANY_IMPACTS_AHEAD, REJECTED_IMPACT_OUT_OF_RANGE, REJECTED_HEIGHT_NOT_POSSIBLE, REJECTED_COLUMN_COLLAPSED, REJECTED_TWIN_FAULTED, REJECTED_COLUMN_IMPOSSIBLE, REJECTED_PARAMETERS_INVALID, REJECTED_PARAMETERS_READ_ONLY, REJECTED_COLUMN_DAMAGED, REJECTED_NO_EQUILIBRIUM, REJECTED_NOT_COMPUTED, REJECTED_QUEUE_FULL, REJECTED_NO_ANSWER, REJECTED_STOPPING, REJECTED_VEHICLE_INVALID, REJECTED_COLUMN_FRACTURED, REJECTED_APPROACH_TOO_LONG, REJECTED_SENDER_NOT_ALLOWED, REJECTED_SENDER_TOO_FAST,
            REJECTED_ESTIMATE_NOT_PENDING, REJECTED_NOT_AT_REST, REJECTED_MEASUREMENT_IMPLAUSIBLE, REJECTED_NOT_ACTIVE,
            ACTION_NONE, ACTION_INSPECT, ACTION_RESTRICT, ACTION_SHORE, ACTION_EVACUATE, ACTION_UNKNOWN,
        }
        DiagnosticStatus { OK, WARN, ERROR, STALE }
        ServiceEventInfo { REQUEST_SENT, REQUEST_RECEIVED, RESPONSE_SENT, RESPONSE_RECEIVED }
        State {
            PRIMARY_STATE_UNKNOWN, PRIMARY_STATE_UNCONFIGURED, PRIMARY_STATE_INACTIVE, PRIMARY_STATE_ACTIVE,
            PRIMARY_STATE_FINALIZED, TRANSITION_STATE_CONFIGURING, TRANSITION_STATE_CLEANINGUP, TRANSITION_STATE_SHUTTINGDOWN,
            TRANSITION_STATE_ACTIVATING, TRANSITION_STATE_DEACTIVATING, TRANSITION_STATE_ERRORPROCESSING,
        }
        Transition {
            TRANSITION_CREATE, TRANSITION_CONFIGURE, TRANSITION_CLEANUP, TRANSITION_ACTIVATE,
            TRANSITION_DEACTIVATE, TRANSITION_UNCONFIGURED_SHUTDOWN, TRANSITION_INACTIVE_SHUTDOWN, TRANSITION_ACTIVE_SHUTDOWN,
            TRANSITION_DESTROY, TRANSITION_ON_CONFIGURE_SUCCESS, TRANSITION_ON_CONFIGURE_FAILURE, TRANSITION_ON_CONFIGURE_ERROR,
            TRANSITION_ON_CLEANUP_SUCCESS, TRANSITION_ON_CLEANUP_FAILURE, TRANSITION_ON_CLEANUP_ERROR, TRANSITION_ON_ACTIVATE_SUCCESS,
            TRANSITION_ON_ACTIVATE_FAILURE, TRANSITION_ON_ACTIVATE_ERROR, TRANSITION_ON_DEACTIVATE_SUCCESS, TRANSITION_ON_DEACTIVATE_FAILURE,
            TRANSITION_ON_DEACTIVATE_ERROR, TRANSITION_ON_SHUTDOWN_SUCCESS, TRANSITION_ON_SHUTDOWN_FAILURE, TRANSITION_ON_SHUTDOWN_ERROR,
            TRANSITION_ON_ERROR_SUCCESS, TRANSITION_ON_ERROR_FAILURE, TRANSITION_ON_ERROR_ERROR, TRANSITION_CALLBACK_SUCCESS,
            TRANSITION_CALLBACK_FAILURE, TRANSITION_CALLBACK_ERROR,
        }
        Log { DEBUG, INFO, WARN, ERROR, FATAL }
        Marker {
            ARROW, CUBE, SPHERE, CYLINDER, LINE_STRIP, LINE_LIST, CUBE_LIST, SPHERE_LIST, POINTS, TEXT_VIEW_FACING,
            MESH_RESOURCE, TRIANGLE_LIST, ARROW_STRIP, ADD, MODIFY, DELETE, DELETEALL,
        }
    }
    let with_constants = INTERFACES
        .iter()
        .filter(|interface| !interface.specification().unwrap().constants.is_empty())
        .count();
    assert_eq!(with_constants, 14, "a type with constants is missing above");
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
