//! The layout for Foxglove names nothing that the node does not serve.

use std::collections::BTreeSet;

use column_twin::endpoints::{Direction, ENDPOINTS};
use column_twin::messages;
use re_ros_msg::message_spec::{ComplexType, Type};
use serde_json::Value;

fn layout() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/config/foxglove_layout.json");
    let text = std::fs::read_to_string(path).expect("the shipped layout");
    serde_json::from_str(&text).expect("is JSON")
}

/// The values of all members of this name, wherever they are.
fn texts<'a>(node: &'a Value, name: &str, found: &mut Vec<&'a str>) {
    match node {
        Value::Object(members) => {
            for (key, member) in members {
                match member {
                    Value::String(text) if key == name => found.push(text),
                    _ => texts(member, name, found),
                }
            }
        }
        Value::Array(elements) => elements.iter().for_each(|it| texts(it, name, found)),
        _ => {}
    }
}

/// # Errors
/// The type has no field of this path, such as `momentum.mean` or `moment[0]`.
fn follow(type_name: &str, path: &str) -> Result<(), String> {
    let mut type_name = type_name.to_owned();
    for part in path.split('.') {
        let (name, index) = part
            .split_once('[')
            .map_or((part, false), |it| (it.0, true));
        let missing = || format!("{type_name} has no {part}");
        let interface = messages::find(&type_name).ok_or_else(missing)?;
        let fields = interface
            .specification()
            .map_err(|it| it.to_string())?
            .fields;
        let field = fields.into_iter().find(|it| it.name == name);
        let found = match (field.ok_or_else(missing)?.ty, index) {
            (Type::Array { ty, .. }, true) => *ty,
            (Type::Array { .. }, false) | (_, true) => return Err(missing()),
            (single, false) => single,
        };
        type_name = match found {
            Type::Complex(ComplexType::Absolute { package, name }) => {
                format!("{package}/msg/{name}")
            }
            Type::Complex(ComplexType::Relative { name }) => {
                format!("{}/msg/{name}", interface.package())
            }
            _ => String::new(),
        };
    }
    Ok(())
}

/// The type of what the node publishes at this name.
fn type_of(topic: &str) -> &'static str {
    let endpoint = ENDPOINTS.iter().find(|it| {
        it.direction == Direction::Out
            && it.name.trim_start_matches('/') == topic.trim_start_matches('/')
    });
    endpoint
        .unwrap_or_else(|| panic!("the node does not publish {topic}"))
        .type_name
}

#[test]
fn every_topic_and_field_of_the_layout_for_foxglove_exists() {
    let layout = layout();
    let panels = &layout["configById"];
    let mut paths = Vec::new();
    for name in ["value", "path", "topicPath"] {
        texts(panels, name, &mut paths);
    }
    assert!(paths.len() > 30, "{paths:?}");
    for path in paths {
        assert!(path.starts_with('/'), "{path}");
        match path.split_once('.') {
            Some((topic, fields)) => {
                assert_eq!(follow(type_of(topic), fields), Ok(()), "{path}");
            }
            None => {
                type_of(path);
            }
        }
    }
    let mut topics = Vec::new();
    texts(panels, "topicToRender", &mut topics);
    topics.extend(
        panels["3D!column"]["topics"]
            .as_object()
            .expect("the topics of the scene")
            .keys()
            .map(String::as_str),
    );
    assert!(topics.len() >= 3, "{topics:?}");
    for topic in topics {
        type_of(topic);
    }
    // Neither does the walk find what does not exist.
    assert!(follow(type_of("/twin_status"), "no_such_field").is_err());
    assert!(follow(type_of("/hinge_forces"), "moment").is_err());
}

#[test]
fn the_service_of_the_layout_takes_its_request() {
    let layout = layout();
    let call = &layout["configById"]["CallService!predict"];
    let name = call["serviceName"].as_str().expect("a name");
    let served = name.replace("/column_twin/", "~/");
    let endpoint = ENDPOINTS
        .iter()
        .find(|it| it.direction == Direction::Service && it.name == served);
    let type_name = endpoint.expect("a service of the node").type_name;
    let request = call["requestPayload"].as_str().expect("JSON in a text");
    let request: Value = serde_json::from_str(request).expect("is JSON");
    let given: BTreeSet<_> = request
        .as_object()
        .expect("fields")
        .keys()
        .cloned()
        .collect();
    let interface = messages::find(&format!("{type_name}_Request")).expect("is known");
    let fields = interface.specification().expect("is a definition").fields;
    let fields: BTreeSet<_> = fields.into_iter().map(|it| it.name).collect();
    // Foxglove sends 0 for a field that is left out, which is no height.
    assert_eq!(given, fields);
}

#[test]
fn every_panel_of_the_layout_is_shown_and_configured() {
    let layout = layout();
    let panels = layout["configById"].as_object().expect("panels");
    let mut shown = BTreeSet::new();
    let mut look = |node: &Value| {
        let mut open = vec![node.clone()];
        while let Some(node) = open.pop() {
            match node {
                Value::String(panel) => {
                    shown.insert(panel);
                }
                Value::Object(split) => {
                    open.extend(["first", "second"].iter().map(|it| split[*it].clone()));
                }
                other => panic!("{other} is no panel"),
            }
        }
    };
    look(&layout["layout"]);
    for tab in panels["Tab!right"]["tabs"].as_array().expect("tabs") {
        look(&tab["layout"]);
    }
    let configured: BTreeSet<_> = panels.keys().cloned().collect();
    assert_eq!(shown, configured);
}
