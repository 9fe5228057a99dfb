//! The definitions as OMG IDL.

use column_twin::messages::idl::idl;
use column_twin::messages::{
    INTERFACES, Message as _, column_twin_msgs::HingeForces, visualization_msgs::MarkerArray,
};

#[test]
fn names_arrays_constants_and_units_are_those_of_the_definition() {
    let text = idl(&[HingeForces::INTERFACE], INTERFACES).expect("a definition");
    for expected in [
        "module column_twin_msgs { module msg {",
        "  const octet HINGE_2 = 2;",
        "struct HingeForces_ {",
        "  std_msgs::msg::dds_::Header_ header;",
        "  // Bending moment [N m].\n  sequence<double, 16> moment;",
        "  sequence<octet, 16> state;",
    ] {
        assert!(text.contains(expected), "{expected} is not in\n{text}");
    }
    let (time, header) = (text.find("struct Time_"), text.find("struct Header_"));
    assert!(time < header, "a definition precedes those that use it");
}

#[test]
fn a_type_that_several_use_is_defined_once() {
    let text = idl(
        &[MarkerArray::INTERFACE, HingeForces::INTERFACE],
        INTERFACES,
    )
    .expect("definitions");
    assert_eq!(text.matches("struct Header_ ").count(), 1);
    assert!(text.contains("  sequence<visualization_msgs::msg::dds_::Marker_> markers;"));
}
