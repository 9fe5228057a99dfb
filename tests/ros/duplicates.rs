//! Warnings about nodes with the same name and twins of the same column.

use std::path::Path;

use super::domain::Domain;
use super::program::Program;

const SAME_NODE: &str = "another node on the network is called /column_twin;";
const SAME_COLUMN: &str = "another twin of the column \"column\" is running on the same topics";

/// Starts a node without state file and real-time scheduling.
fn started(domain: &Domain, folder: &Path, arguments: &str) -> Program {
    let quiet = "-p real_time.priority:=0 -p real_time.lock_memory:=false -p state.directory:=''";
    let arguments: Vec<_> = quiet
        .split(' ')
        .chain(arguments.split_whitespace())
        .collect();
    Program::ready(domain, folder, &arguments)
}

/// Waits for a line that may precede the one that the program is ready.
fn wait_for(program: &mut Program, text: &str) {
    while !program.seen.iter().any(|line| line.contains(text)) {
        program.wait_for("");
    }
}

fn wait_for_both(program: &mut Program) {
    wait_for(program, SAME_NODE);
    wait_for(program, SAME_COLUMN);
}

/// How often the program warned about a node with its name and about a twin of its column.
fn warnings(program: Program) -> (usize, usize) {
    let (_, _, log) = program.terminate();
    let count = |text: &str| log.iter().filter(|line| line.contains(text)).count();
    (count(SAME_NODE), count(SAME_COLUMN))
}

#[test]
fn both_of_two_equal_nodes_warn_once() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let mut programs = [(); 2].map(|()| started(&domain, folder.path(), ""));
    programs.iter_mut().for_each(wait_for_both);
    // A third one is no reason to warn again.
    let mut third = started(&domain, folder.path(), "");
    wait_for_both(&mut third);
    assert_eq!(warnings(third), (1, 1));
    assert_eq!(programs.map(warnings), [(1, 1); 2]);
}

#[test]
fn different_names_and_columns_are_no_reason_to_warn() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let start = |arguments| started(&domain, folder.path(), arguments);
    let mut first = start("");
    let other_column = start("-r __node:=second -p column_id:=other");
    let elsewhere = start("-r __ns:=/elsewhere");
    let mut same_column = start("-r __node:=third");
    for program in [&mut first, &mut same_column] {
        wait_for(program, SAME_COLUMN);
    }
    assert_eq!(warnings(other_column), (0, 0));
    assert_eq!(warnings(elsewhere), (0, 0));
    assert_eq!(warnings(same_column), (0, 1));
    assert_eq!(warnings(first), (0, 1));
}
