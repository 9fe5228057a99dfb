//! docs/glossary.md: each term once, and every name of messages, services and JSON in exactly one row.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Endings of JSON keys, which carry the unit; the longest first.
const UNITS: [&str; 8] = ["_m_s", "_n_s", "_n_m", "_rad", "_m", "_n", "_s", "_j"];

/// Fields that every message may have, and names of a table that say what they are by their place.
const WITHOUT_A_TERM: [&str; 4] = ["header", "name", "value", "report"];

/// Names that end like a key with a unit, and have none.
const WITHOUT_A_UNIT: [&str; 1] = ["gamma_m"];

/// A row: the term, and the patterns of its names.
struct Row {
    term: String,
    names: Vec<String>,
}

fn rows() -> Vec<Row> {
    let text = fs::read_to_string("docs/glossary.md").expect("the glossary");
    let rows = text.lines().filter(|line| line.starts_with("| "));
    rows.skip(1)
        .map(|line| {
            let cells: Vec<_> = line.trim_matches('|').split('|').map(str::trim).collect();
            let [term, meaning, _, names] = cells[..] else {
                panic!("{line}: expected four cells");
            };
            assert!(meaning.ends_with('.'), "{term}: the meaning is no sentence");
            Row {
                term: term.to_owned(),
                names: names
                    .split('`')
                    .skip(1)
                    .step_by(2)
                    .map(str::to_owned)
                    .collect(),
            }
        })
        .collect()
}

/// Every file with this ending in a folder.
fn files(folder: &str, ending: &str) -> Vec<String> {
    let entries = fs::read_dir(Path::new(folder)).expect("the folder");
    let paths = entries.map(|it| it.expect("an entry").path());
    paths
        .filter(|path| path.extension().is_some_and(|it| it == ending))
        .map(|path| fs::read_to_string(path).expect("a text"))
        .collect()
}

/// The names of the interface and where each is used.
fn names() -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut take = |name: &str, place: &str| {
        let unit = UNITS.iter().find(|unit| name.ends_with(**unit));
        let name = match unit.filter(|_| !WITHOUT_A_UNIT.contains(&name)) {
            Some(unit) => name.trim_end_matches(unit),
            None => name,
        };
        if !WITHOUT_A_TERM.contains(&name) {
            found.insert(name.to_owned(), place.to_owned());
        }
    };
    for kind in ["msg", "srv"] {
        for entry in fs::read_dir(kind).expect("the folder") {
            let path = entry.expect("an entry").path();
            let is_parameters = path.ends_with("ColumnParameters.msg");
            if path.extension().is_none_or(|it| it != kind) || is_parameters {
                continue;
            }
            let text = fs::read_to_string(&path).expect("a definition");
            let lines = text.lines().filter(|line| !line.starts_with('#'));
            // What has a value is a constant.
            let fields = lines.filter_map(|line| line.split_whitespace().nth(1));
            for name in fields.filter(|name| !name.contains('=')) {
                take(name, &path.display().to_string());
            }
        }
    }
    for text in files("src/results", "rs") {
        let mut is_written = false;
        for line in text.lines() {
            is_written |= line == "fields! {";
            is_written &= line != "}";
            let field = line
                .trim_start()
                .trim_start_matches("pub ")
                .split_once(": ");
            let name = field.map(|(name, _)| name).filter(|name| {
                !name.is_empty()
                    && name
                        .chars()
                        .all(|it| it.is_ascii_lowercase() || it.is_ascii_digit() || it == '_')
            });
            if let Some(name) = name
                .filter(|_| is_written && line.starts_with("    ") && !line.starts_with("     "))
            {
                take(name, "src/results");
            }
        }
    }
    let columns = fs::read_to_string("src/study/map_columns.rs").expect("the columns of a map");
    for line in columns.lines().filter(|line| line.contains(" |it| ")) {
        let name = line.trim().trim_start_matches('"').split('"').next();
        take(name.unwrap_or_default(), "src/study/map_columns.rs");
    }
    let lines: Vec<_> = columns.lines().collect();
    for pair in lines.windows(2) {
        let [first, second] = [pair[0].trim(), pair[1].trim()];
        if first.starts_with('"') && second.starts_with("ColumnKind::") {
            take(first.trim_matches(['"', ',']), "src/study/map_columns.rs");
        }
    }
    let python = "crates/python/python/column_twin/_evaluation.py";
    for line in fs::read_to_string(python)
        .expect("the Python class")
        .lines()
    {
        let field = line.strip_prefix("    ").and_then(|it| it.split_once(": "));
        if let Some((name, _)) = field.filter(|(name, _)| {
            name.chars()
                .all(|it| it.is_ascii_lowercase() || it == '_' || it.is_ascii_digit())
        }) {
            take(name, python);
        }
    }
    found
}

fn fits(pattern: &str, name: &str) -> bool {
    pattern
        .strip_suffix('*')
        .map_or(pattern == name, |start| name.starts_with(start))
}

#[test]
fn every_name_of_the_interface_has_one_term_of_the_glossary() {
    let rows = rows();
    let terms: BTreeSet<_> = rows.iter().map(|it| it.term.to_lowercase()).collect();
    assert_eq!(terms.len(), rows.len(), "a term stands twice");
    let mut faults = Vec::new();
    let names = names();
    assert!(names.len() > 150, "{} names", names.len());
    for (name, place) in &names {
        let exact: Vec<_> = rows.iter().filter(|row| row.names.contains(name)).collect();
        let found = match exact.is_empty() {
            true => rows
                .iter()
                .filter(|row| row.names.iter().any(|it| fits(it, name)))
                .collect(),
            false => exact,
        };
        if found.len() != 1 {
            let terms: Vec<_> = found.iter().map(|it| &it.term).collect();
            faults.push(format!(
                "{name} ({place}) has the terms {terms:?}; expected one"
            ));
        }
    }
    for (row, pattern) in rows
        .iter()
        .flat_map(|row| row.names.iter().map(move |it| (row, it)))
    {
        if !names.keys().any(|name| fits(pattern, name)) {
            faults.push(format!("{}: nothing is called {pattern}", row.term));
        }
    }
    assert!(
        faults.is_empty(),
        "docs/glossary.md:\n{}",
        faults.join("\n")
    );
}
