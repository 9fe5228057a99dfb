//! The walls of the house: which room may import which, checked against what the source files take from one another.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::imports::{Arrow, CRATES, Source, circles};
use super::root;

/// A room: a file or folder of `src`, or a crate of the workspace.
pub struct Room {
    pub name: &'static str,
    /// The noun that belongs to it.
    pub owns: &'static str,
    /// Rooms above it in the table from which it may take names.
    pub may_import: &'static [&'static str],
    /// What must stay out of it, for a reader; the arrows that the test allows follow from `may_import` alone.
    pub must_not_know: &'static str,
}

const fn room(
    name: &'static str,
    owns: &'static str,
    may_import: &'static [&'static str],
    must_not_know: &'static str,
) -> Room {
    Room {
        name,
        owns,
        may_import,
        must_not_know,
    }
}

/// The rooms, each below those that use it.
#[rustfmt::skip]
pub const ROOMS: &[Room] = &[
    room("mechanics", "the mechanics of the column", &[], "names of parameters, files, clocks, threads"),
    room("observables", "what can be observed of a column, and where", &["mechanics"], "everything else"),
    room("beam", "the column as a fibre beam, the second opinion", &["mechanics"], "the two bars, names of parameters, files, clocks, threads"),
    room("printable", "text from outside, escaped, and bytes as digits", &[], "everything else"),
    room("ros_interface", "definitions and bytes of messages, rules of names", &[], "columns, DDS"),
    room("bounded_file", "a file that is expected to be short", &[], "what is in it"),
    room("recording crate", "recordings in MCAP", &["bounded_file"], "columns, DDS"),
    room("alarm crate", "alarms that arrive", &[], "columns, DDS"),
    room("foxglove crate", "live topics for Foxglove", &[], "columns, DDS"),
    room("sros2_keystore", "keystores and enclaves of DDS security", &["bounded_file"], "topics, nodes, columns, DDS"),
    room("ros_node", "what a node needs that knows no column", &["printable", "ros_interface", "sros2_keystore"], "topics of a program, columns"),
    room("whole_file", "a file that appears complete or not at all", &[], "what is in it"),
    room("state_home", "the state folder of the user", &[], "what is kept there"),
    room("host_header", "the host of an HTTP request", &[], "who asks"),
    room("time", "nanoseconds since the epoch", &[], "clocks"),
    room("numerics", "numerical methods", &[], "columns"),
    room("sensors", "a sensor on the column", &[], "readings, parameters"),
    room("endpoints", "topics and services", &[], "DDS, what is in a message"),
    room("parameters", "the parameters of a column", &["mechanics", "ros_interface", "printable", "bounded_file", "sensors"], "the twin, DDS, the command line"),
    room("exact_number", "numbers in JSON to the last bit", &["parameters"], "what they mean"),
    room("standing", "a column at rest with its damage", &["mechanics", "parameters"], "the twin, clocks, estimates"),
    room("assessment", "action and its criteria", &["mechanics", "observables", "parameters", "standing"], "the twin, clocks"),
    room("second_opinion", "what the fibre beam says beside the two bars", &["mechanics", "beam", "parameters", "assessment"], "the twin, clocks, files"),
    room("messages", "Rust types of the messages", &["mechanics", "ros_interface", "assessment"], "the twin, parameters, DDS"),
    room("results", "results by name", &["mechanics", "parameters", "assessment", "second_opinion"], "the twin, files"),
    room("study", "many impacts on a column", &["mechanics", "numerics", "parameters", "assessment", "second_opinion", "results"], "the twin, clocks, files"),
    room("estimation", "what readings say about an impact", &["mechanics", "beam", "printable", "time", "numerics", "sensors", "parameters", "exact_number", "standing", "assessment", "second_opinion"], "the twin, threads, DDS"),
    room("commissioning", "the check of sensors at commissioning", &["mechanics", "beam", "sensors", "estimation"], "the twin, parameters, files, clocks"),
    room("twin", "the twin of one column", &["mechanics", "beam", "printable", "bounded_file", "state_home", "time", "sensors", "parameters", "exact_number", "standing", "assessment", "second_opinion", "study", "estimation"], "threads, clocks, DDS, messages"),
    room("shape", "the geometry of a deformed column", &["mechanics", "observables", "parameters", "assessment", "twin"], "RViz, Rerun"),
    room("live", "the twin in real time", &["mechanics", "time", "parameters", "standing", "estimation", "twin"], "DDS, messages, recordings"),
    room("fleet", "a fleet without DDS", &["mechanics", "ros_interface", "printable", "time", "messages", "parameters", "twin"], "threads, DDS"),
    room("incoming", "received messages as commands", &["time", "endpoints", "messages", "parameters", "estimation", "twin"], "DDS, threads"),
    room("outgoing", "outputs of the twin as messages", &["mechanics", "observables", "ros_interface", "time", "endpoints", "messages", "parameters", "assessment", "second_opinion", "study", "estimation", "twin", "shape", "live"], "DDS, files"),
    room("recording", "recordings of this program", &["mechanics", "ros_interface", "recording crate", "state_home", "endpoints", "messages", "parameters"], "the twin, DDS"),
    room("evidence", "recording and verification of a twin", &["mechanics", "ros_interface", "recording crate", "printable", "time", "sensors", "endpoints", "messages", "parameters", "estimation", "twin", "live", "incoming", "outgoing", "recording"], "DDS, reports"),
    room("figures", "figures of one impact", &["mechanics", "observables", "beam", "whole_file", "sensors", "parameters", "assessment", "study", "estimation", "twin", "shape"], "recordings, DDS"),
    room("report", "the report for people", &["mechanics", "observables", "recording crate", "time", "sensors", "parameters", "assessment", "second_opinion", "results", "study", "estimation", "twin", "shape", "live", "recording", "evidence", "figures", "standing", "beam"], "DDS, the command line"),
    room("viewer", "the column in Rerun", &["mechanics", "observables", "beam", "printable", "state_home", "host_header", "time", "messages", "parameters", "standing", "assessment", "study", "estimation", "twin", "shape", "live", "fleet", "outgoing"], "DDS, recordings"),
    room("ros", "the ROS 2 node", &["mechanics", "ros_interface", "recording crate", "alarm crate", "foxglove crate", "sros2_keystore", "ros_node", "printable", "state_home", "host_header", "time", "sensors", "endpoints", "messages", "parameters", "estimation", "twin", "live", "fleet", "incoming", "outgoing", "recording", "evidence", "viewer"], "reports, figures"),
    room("keystore", "what the enclaves of twins may do", &["sros2_keystore", "ros_node", "endpoints"], "files, cryptography"),
    room("cli", "the commands", &["mechanics", "observables", "ros_interface", "recording crate", "sros2_keystore", "ros_node", "printable", "bounded_file", "whole_file", "sensors", "endpoints", "messages", "parameters", "assessment", "second_opinion", "study", "estimation", "commissioning", "twin", "live", "fleet", "incoming", "recording", "evidence", "figures", "report", "results", "viewer", "ros", "keystore"], "nothing is above it"),
    room("main", "the program's entry", &["cli"], "everything else"),
    room("python crate", "the Python package", &["mechanics", "observables", "parameters", "assessment", "second_opinion", "results", "study", "estimation", "beam"], "the twin, threads, DDS"),
];

/// Files that import one another in a circle, inside one room.
struct Circle {
    folder: &'static str,
    files: &'static [&'static str],
    reason: &'static str,
}

const fn circle(
    folder: &'static str,
    files: &'static [&'static str],
    reason: &'static str,
) -> Circle {
    Circle {
        folder,
        files,
        reason,
    }
}

/// Most circles that may stay for a reason of their own.
const MAX_CIRCLES: usize = 4;

/// Circles that stay, with the reason.
#[rustfmt::skip]
const CIRCLES: [Circle; 3] = [
    circle("crates/recording/src", &["predecessor.rs", "reader.rs"], "a recording names the one before it, which is found by reading the recordings in its folder"),
    circle("crates/recording/src", &["index_check.rs", "records.rs"], "the index is checked against the records while they are read, and consists of records itself"),
    circle("src/report", &["document.rs", "recorded.rs", "recording_section.rs"], "a document begins with its origin, and a recording is the origin that makes a whole document"),
];

fn source() -> Source {
    let mut source = Source::default();
    for (name, file) in CRATES {
        source.add(name, Path::new(file), &|path| {
            std::fs::read_to_string(root().join(path)).ok()
        });
    }
    source
}

fn room_of(path: &Path) -> String {
    let parts: Vec<String> = path
        .iter()
        .map(|it| it.to_string_lossy().into_owned())
        .collect();
    match (parts[0].as_str(), parts[1].as_str()) {
        ("src", room) => room.trim_end_matches(".rs").to_owned(),
        (_, name @ ("alarm" | "foxglove" | "recording" | "python")) => format!("{name} crate"),
        (_, name) => name.to_owned(),
    }
}

/// What is wrong with these arrows between rooms.
fn broken_walls(rooms: &[Room], arrows: &BTreeSet<Arrow>) -> Vec<String> {
    let mut faults = Vec::new();
    let mut used = BTreeSet::new();
    for arrow in arrows {
        let [from, to] = [&arrow.from, &arrow.to].map(|path| room_of(path));
        if from == to {
            continue;
        }
        let may = rooms
            .iter()
            .any(|it| it.name == from && it.may_import.contains(&to.as_str()));
        if !may {
            let Arrow {
                from: file, name, ..
            } = arrow;
            faults.push(format!(
                "{} takes {name} from {}: the room {from} may not import {to}; move the name to a room below both, or add \
                 the arrow to ROOMS if it belongs there",
                file.display(),
                arrow.to.display()
            ));
        }
        used.insert((from, to));
    }
    for (index, room) in rooms.iter().enumerate() {
        for other in room.may_import {
            if !rooms[..index].iter().any(|below| below.name == *other) {
                faults.push(format!(
                    "{} may import {other}, which is not above it in ROOMS",
                    room.name
                ));
            }
            if !used.contains(&(room.name.to_owned(), (*other).to_owned())) {
                faults.push(format!(
                    "{} no longer imports {other}; remove it from ROOMS",
                    room.name
                ));
            }
        }
    }
    faults
}

#[test]
fn rooms_import_only_what_their_table_allows() {
    let faults = broken_walls(ROOMS, &source().arrows());
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    for room in ROOMS {
        let texts = [room.owns, room.must_not_know];
        assert!(texts.iter().all(|text| !text.is_empty()), "{}", room.name);
    }
}

#[test]
fn every_part_of_the_source_is_a_room() {
    let mut missing = Vec::new();
    for entry in std::fs::read_dir(root().join("src")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let name = name.trim_end_matches(".rs");
        if name != "lib" && !ROOMS.iter().any(|room| room.name == name) {
            missing.push(name.to_owned());
        }
    }
    assert!(missing.is_empty(), "ROOMS does not contain {missing:?}");
}

#[test]
fn files_import_one_another_in_no_other_circles_than_those_that_are_listed() {
    let within: BTreeSet<(PathBuf, PathBuf)> = source()
        .arrows()
        .into_iter()
        .filter(|arrow| room_of(&arrow.from) == room_of(&arrow.to))
        .map(|arrow| (arrow.from, arrow.to))
        .collect();
    let found = circles(&within);
    let known: BTreeMap<BTreeSet<PathBuf>, &str> = CIRCLES
        .iter()
        .map(|it| {
            let files = it.files.iter().map(|file| Path::new(it.folder).join(file));
            (files.collect(), it.reason)
        })
        .collect();
    for circle in &found {
        let mut known = known.keys();
        assert!(
            known.any(|it| circle.iter().all(|file| it.contains(file))),
            "these files import one another in a circle, which is new or has grown: {circle:?}"
        );
    }
    for (files, reason) in &known {
        assert!(!reason.is_empty(), "{files:?}");
        assert!(
            found.iter().any(|circle| circle.iter().eq(files)),
            "this circle is gone or smaller; shorten the list: {files:?}"
        );
    }
    const { assert!(CIRCLES.len() <= MAX_CIRCLES) };
}

#[test]
fn an_arrow_upwards_breaks_a_wall() {
    let rooms = [
        room("time", "a", &[], "b"),
        room("twin", "c", &["time"], "d"),
    ];
    let arrow = |from: &str, to: &str| Arrow {
        from: from.into(),
        to: to.into(),
        name: "crate::x".to_owned(),
    };
    let down = arrow("src/twin/mod.rs", "src/time.rs");
    assert_eq!(broken_walls(&rooms, &[down.clone()].into()), [""; 0]);
    let up = arrow("src/time.rs", "src/twin/command.rs");
    let faults = broken_walls(&rooms, &[down, up].into());
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert!(faults[0].starts_with("src/time.rs takes crate::x from src/twin/command.rs"));
    assert_eq!(broken_walls(&rooms, &BTreeSet::new()).len(), 1);
}
