//! The configurations for several sites, against the tables of the program and against one another. What runs with them is
//! tested by `tests/interop/bridge.py`.

use std::path::Path;

use column_twin::endpoints::{Direction, ENDPOINTS};
use saphyr::{LoadableYamlNode, Yaml};
use serde_json::Value as Json;

/// Endpoints that stay at their site, each for a reason that `docs/sites.md` gives.
const STAY: &[&str] = &[
    "measurements",
    "/clock",
    "joint_states",
    "markers",
    "/rosout",
    "/parameter_events",
    "~/reset",
    "~/reset_column",
    "~/get_type_description",
    "~/change_state",
    "~/get_state",
    "~/get_available_states",
    "~/get_available_transitions",
    "~/get_transition_graph",
    "~/transition_event",
];
/// Name of the node in the configurations.
const NODE: &str = "column_twin";

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A configuration of Zenoh, whose comments have lines of their own.
fn zenoh(path: &str) -> Json {
    let text: Vec<_> = read(path)
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .map(str::to_owned)
        .collect();
    serde_json::from_str(&text.join("\n")).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn texts(list: &Json) -> Vec<String> {
    let list = list.as_array().expect("a list");
    list.iter()
        .map(|it| it.as_str().unwrap().to_owned())
        .collect()
}

/// What the bridge calls an endpoint of a node in any namespace.
fn allowed_as(name: &str) -> String {
    match name.strip_prefix("~/") {
        Some(own) => format!(".*/{NODE}/{own}"),
        None if name.starts_with('/') => name.to_owned(),
        None => format!(".*/{name}"),
    }
}

/// The names of one direction in a list of a configuration are exactly those of the endpoints that pass.
fn assert_passes(path: &str, list: &str, direction: Direction) {
    let config = zenoh(path);
    let passing = ENDPOINTS
        .iter()
        .filter(|it| it.direction == direction && !STAY.contains(&it.name));
    let mut expected: Vec<_> = passing.map(|it| allowed_as(it.name)).collect();
    let mut found = texts(&config["plugins"]["ros2dds"]["allow"][list]);
    expected.sort();
    found.sort();
    assert_eq!(found, expected, "{list} of {path}");
}

#[test]
fn sites_let_all_endpoints_pass_but_those_that_stay() {
    let (site, room) = ("config/zenoh/site.json5", "config/zenoh/control_room.json5");
    for (path, list, direction) in [
        (site, "publishers", Direction::Out),
        (site, "subscribers", Direction::In),
        (site, "service_servers", Direction::Service),
        (room, "publishers", Direction::In),
        (room, "subscribers", Direction::Out),
        (room, "service_clients", Direction::Service),
    ] {
        assert_passes(path, list, direction);
    }
    // What is missing lets nothing pass; an empty list would let everything pass.
    for (path, list) in [(site, "service_clients"), (room, "service_servers")] {
        let config = zenoh(path);
        assert!(
            config["plugins"]["ros2dds"]["allow"].get(list).is_none(),
            "{list} of {path}"
        );
    }
    for name in STAY {
        assert!(
            ENDPOINTS.iter().any(|it| it.name == *name),
            "{name} is no endpoint"
        );
    }
}

#[test]
fn router_and_sites_listen_and_search_nowhere_else() {
    let [router, site, room] =
        ["router", "site", "control_room"].map(|name| zenoh(&format!("config/zenoh/{name}.json5")));
    for config in [&router, &site, &room] {
        for scouting in ["multicast", "gossip"] {
            assert_eq!(config["scouting"][scouting]["enabled"], false, "{scouting}");
        }
    }
    for bridge in [&site, &room] {
        assert_eq!(
            router["listen"]["endpoints"],
            bridge["connect"]["endpoints"]
        );
        assert_eq!(bridge["mode"], "client");
        assert!(bridge.get("listen").is_none());
    }
    assert!(
        texts(&router["listen"]["endpoints"])[0].starts_with("tcp/127.0.0.1:"),
        "nobody else can connect until the operator says so"
    );
}

/// A member of a mapping.
fn member<'a>(node: &'a Yaml<'a>, name: &str) -> &'a Yaml<'a> {
    node.as_mapping_get(name)
        .unwrap_or_else(|| panic!("expected {name} in {node:?}"))
}

fn items<'a>(node: &'a Yaml<'a>) -> &'a [Yaml<'a>] {
    node.as_sequence().expect("a list")
}

fn named<'a>(list: &'a Yaml<'a>, name: &str) -> &'a Yaml<'a> {
    let found = items(list)
        .iter()
        .find(|it| member(it, "name").as_str() == Some(name));
    found.unwrap_or_else(|| panic!("no item {name}"))
}

#[test]
fn the_stateful_set_keeps_the_damage_of_each_shard() {
    let text = read("config/kubernetes/statefulset.yaml");
    let documents = Yaml::load_from_str(&text).unwrap();
    let kinds: Vec<_> = documents
        .iter()
        .map(|it| member(it, "kind").as_str().unwrap())
        .collect();
    assert_eq!(kinds, ["Service", "StatefulSet"]);
    let spec = member(&documents[1], "spec");
    assert_eq!(
        member(spec, "serviceName").as_str(),
        member(member(&documents[0], "metadata"), "name").as_str()
    );
    let template = member(spec, "template");
    assert_eq!(
        member(member(spec, "selector"), "matchLabels"),
        member(member(template, "metadata"), "labels")
    );
    let pod = member(template, "spec");
    let shard = named(member(pod, "containers"), "shard");

    // The state is on the volume that follows the ordinal, and only one pod at a time has it.
    let claim = &items(member(spec, "volumeClaimTemplates"))[0];
    let volume = member(member(claim, "metadata"), "name").as_str().unwrap();
    let mount = named(member(shard, "volumeMounts"), volume);
    let folder = member(mount, "mountPath").as_str().unwrap();
    let arguments: Vec<_> = items(member(shard, "args"))
        .iter()
        .map(|it| it.as_str().unwrap())
        .collect();
    let directory = arguments
        .iter()
        .find_map(|it| it.strip_prefix("state.directory:="))
        .expect("a state directory");
    assert!(Path::new(directory).starts_with(folder), "{directory}");
    assert_eq!(
        items(member(member(claim, "spec"), "accessModes"))[0].as_str(),
        Some("ReadWriteOncePod")
    );
    let retention = member(spec, "persistentVolumeClaimRetentionPolicy");
    for when in ["whenDeleted", "whenScaled"] {
        assert_eq!(member(retention, when).as_str(), Some("Retain"), "{when}");
    }

    // Every container that names the ordinal gets it.
    for container in items(member(pod, "containers")) {
        let names_it = items(member(container, "args"))
            .iter()
            .any(|it| it.as_str().unwrap().contains("$(SHARD)"));
        assert!(names_it, "{container:?}");
        let ordinal = member(
            member(named(member(container, "env"), "SHARD"), "valueFrom"),
            "fieldRef",
        );
        assert_eq!(
            member(ordinal, "fieldPath").as_str(),
            Some("metadata.labels['apps.kubernetes.io/pod-index']")
        );
    }

    // It may take as long to stop as the service of systemd, and a probe ends before Kubernetes gives it up.
    let unit = read("config/column-twin@.service");
    let stop = unit
        .lines()
        .find_map(|it| it.strip_prefix("TimeoutStopSec="));
    let stop: i64 = stop.expect("a limit").parse().unwrap();
    let grace = member(pod, "terminationGracePeriodSeconds").as_integer();
    assert!(grace.unwrap() >= stop);
    for probe in ["startupProbe", "livenessProbe"] {
        let probe = member(shard, probe);
        let line = items(member(member(probe, "exec"), "command"))[2]
            .as_str()
            .unwrap();
        let limit: i64 = line.split(' ').nth(1).unwrap().parse().unwrap();
        assert!(
            line.starts_with("timeout ") && line.contains("column-twin watch"),
            "{line}"
        );
        assert!(limit < member(probe, "timeoutSeconds").as_integer().unwrap());
    }
}

/// The memory of a node holds the private keys of its enclave and of its seals.
#[test]
fn no_service_leaves_a_core_dump_with_private_keys() {
    for unit in [
        "config/column-twin@.service",
        "config/column-twin-bridge@.service",
    ] {
        assert!(read(unit).lines().any(|it| it == "LimitCORE=0"), "{unit}");
    }
}
