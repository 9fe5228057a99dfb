//! The permissions of the roles against the table of the node's endpoints, the documentation and the policy file.

use std::fs;
use std::path::Path;

use column_twin::endpoints::{Direction, ENDPOINTS};
use column_twin::keystore::{POLICY_ORIGIN, Role, Twins, ZenohSite, access, plan};
use column_twin::ros::{NODE_NAME, RosArguments};
use sros2_keystore::{Access, policy};

use super::made::{name, plans, twin};

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).expect(path)
}

fn access_of(role: Role) -> Access {
    let enclave = match role {
        Role::Twin => "/column_twin",
        Role::Monitor => "/monitor",
        Role::Operator => "/operator",
    };
    access(role, &name(enclave), &twin().0).expect("valid names")
}

/// The word of the documentation for what a role may do with the topics of an endpoint.
fn word(role: Role, endpoint: &column_twin::endpoints::Endpoint) -> &'static str {
    let access = access_of(role);
    let (publish, subscribe) = (access.dds_publish(), access.dds_subscribe());
    let full = match endpoint.name.strip_prefix("~/") {
        Some(private) => format!("/column_twin/{private}"),
        None => format!("/{}", endpoint.name.trim_start_matches('/')),
    };
    if endpoint.direction == Direction::Service {
        let (request, reply) = (format!("rq{full}Request"), format!("rr{full}Reply"));
        match (
            (publish.contains(&request), subscribe.contains(&reply)),
            (publish.contains(&reply), subscribe.contains(&request)),
        ) {
            ((true, true), (false, false)) => "calls",
            ((false, false), (true, true)) => "offers",
            ((false, false), (false, false)) => "–",
            other => panic!("{full}: half of a service: {other:?}"),
        }
    } else {
        let topic = format!("rt{full}");
        match (publish.contains(&topic), subscribe.contains(&topic)) {
            (true, true) => "sends, reads",
            (true, false) => "sends",
            (false, true) => "reads",
            (false, false) => "–",
        }
    }
}

/// A new endpoint is granted by the code; this test fails until somebody has looked at the row and written it down.
#[test]
fn every_endpoint_of_the_node_is_in_the_permissions_as_documented() {
    let document = read("docs/security.md");
    let mut missing = Vec::new();
    for endpoint in ENDPOINTS {
        let [twin, monitor, operator] = Role::ALL.map(|role| word(role, endpoint));
        let row = format!("| `{}` | {twin} | {monitor} | {operator} |", endpoint.name);
        if !document.contains(&row) {
            missing.push(row);
        }
        assert_ne!(twin, "–", "{}: the node needs it", endpoint.name);
    }
    assert!(
        missing.is_empty(),
        "docs/security.md lacks\n{}",
        missing.join("\n")
    );
}

/// What a monitor may publish is only what every node of ROS 2 publishes about itself, and it may call nothing.
#[test]
fn a_monitor_can_send_the_twin_nothing() {
    let monitor = access_of(Role::Monitor);
    let allowed: Vec<_> = monitor.publish.iter().map(String::as_str).collect();
    assert_eq!(allowed, ["/parameter_events", "/rosout"]);
    assert!(monitor.request.is_empty());
    for endpoint in ENDPOINTS.iter().filter(|it| it.direction == Direction::Out) {
        assert_ne!(word(Role::Monitor, endpoint), "–", "{}", endpoint.name);
    }
}

/// Who sets the simulated time decides which events are in time.
#[test]
fn an_operator_sends_everything_except_the_time() {
    for endpoint in ENDPOINTS {
        let expected = match endpoint.direction {
            Direction::In if endpoint.name == "/clock" => "reads",
            Direction::In => "sends",
            Direction::Service => "calls",
            Direction::Out => continue,
        };
        assert_eq!(
            word(Role::Operator, endpoint),
            expected,
            "{}",
            endpoint.name
        );
    }
}

#[test]
fn names_follow_namespace_node_and_remapping_as_the_node_does() {
    let line = "--ros-args -r __ns:=/garage/a1 -r impact_event:=/garage/impact_event";
    let words = line.split_whitespace().map(Into::into);
    let (_, ros) = RosArguments::split(words).expect("arguments");
    let twins = Twins::new(&[], NODE_NAME, &ros.remap_rules).expect("names");
    let plans = plan(&[], &twins).expect("enclaves");
    assert_eq!(plans[0].plan.name.as_str(), "/garage/a1/column_twin");
    let operator = access(Role::Operator, &name("/operator"), &twins.0).expect("names");
    let publish = operator.dds_publish();
    for topic in [
        "rt/garage/impact_event",
        "rt/garage/a1/column_parameters",
        "rq/garage/a1/column_twin/resetRequest",
    ] {
        assert!(publish.contains(topic), "{topic}: {publish:?}");
    }
    assert!(!publish.contains("rt/garage/a1/impact_event"));
    let subscribe = operator.dds_subscribe();
    assert!(
        subscribe.contains("rt/garage/a1/column_state") && subscribe.contains("rt/diagnostics")
    );
}

/// `column-twin keystore policy` writes it.
#[test]
fn the_policy_file_for_ros2_security_is_that_of_the_table() {
    let expected = policy(&plans(&[]), POLICY_ORIGIN);
    let path = "config/security/column_twin.policy.xml";
    assert!(
        read(path) == expected,
        "{path} is outdated; write it with: column-twin keystore policy > {path}"
    );
}

/// `column-twin keystore zenoh` writes them.
#[test]
fn the_configurations_of_zenoh_are_those_of_the_table() {
    let keystore = "/etc/column_twin/keystore";
    let site = ZenohSite {
        keystore: Path::new(keystore),
        address: "127.0.0.1:7447",
        domain_id: 0,
    };
    let planned = plan(&[], &twin()).expect("enclaves");
    let router = site.router(&name("/router"), &planned);
    let session = site.session(&name("/column_twin"));
    for (file, options, expected) in [
        ("secured_router", "", router),
        ("secured_session", " --session /column_twin", session),
    ] {
        let path = format!("config/zenoh/{file}.json5");
        assert!(
            read(&path) == expected,
            "{path} is outdated; write it with: column-twin keystore zenoh {keystore}{options} > {path}"
        );
    }
}

/// What `permissions.xsl` of SROS 2 makes of the policy is what is in our permissions; its rules are short enough to repeat here.
#[test]
fn sros_2_makes_the_same_permissions_of_the_policy() {
    let text = policy(&plans(&[]), POLICY_ORIGIN);
    for (index, role) in Role::ALL.into_iter().enumerate() {
        let enclave = text
            .split("<enclave path=")
            .nth(index + 1)
            .expect("an enclave");
        let (mut publish, mut subscribe) = (vec![], vec![]);
        let mut list = "";
        for line in enclave.lines().map(str::trim) {
            if line.starts_with("<topics ") || line.starts_with("<services ") {
                list = line;
            }
            let element = |tag: &str| {
                let inner = line.strip_prefix(&format!("<{tag}>"))?;
                inner.strip_suffix(&format!("</{tag}>"))
            };
            if let Some(topic) = element("topic") {
                match list.contains("publish=") {
                    true => publish.push(format!("rt{topic}")),
                    false => subscribe.push(format!("rt{topic}")),
                }
            }
            if let Some(service) = element("service") {
                let (request, reply) = (format!("rq{service}Request"), format!("rr{service}Reply"));
                match list.contains("reply=") {
                    true => {
                        publish.push(reply);
                        subscribe.push(request);
                    }
                    false => {
                        publish.push(request);
                        subscribe.push(reply);
                    }
                }
            }
        }
        publish.push("ros_discovery_info".to_owned());
        subscribe.push("ros_discovery_info".to_owned());
        let access = access_of(role);
        assert_eq!(access.dds_publish(), publish.into_iter().collect());
        assert_eq!(access.dds_subscribe(), subscribe.into_iter().collect());
    }
}
