//! Reads ROS 2 parameter files.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use bounded_file::read_text_at_most;

use super::fault::{Fault, Origin, Problem, SourceFile};
use super::given::{self, Assignment, Given};
use super::node_name::NodeName;
use super::yaml::{self, Location, YamlContent, YamlKey, YamlNode};
use ros_interface::names::with_slashes;

/// Maximum size of a parameter file \[bytes\].
pub const MAX_FILE_BYTES: u64 = 1 << 20;

/// YamlKey of the mapping that holds the parameters of a node.
const PARAMETERS_KEY: &str = "ros__parameters";

/// The parameters that a file gives under one name or pattern.
pub(super) struct Section {
    /// With one slash before every part.
    pub name: String,
    /// Where the section begins.
    pub place: Origin,
    pub assignments: Vec<Assignment>,
}

/// Reads a file and returns what it assigns to this node's parameters, and all faults in its structure.
pub(super) fn read(path: &Path, node: &NodeName) -> (Vec<Assignment>, Vec<Fault>) {
    match source(path, MAX_FILE_BYTES) {
        Ok(source) => assignments(&source, node),
        Err(fault) => (Vec::new(), vec![*fault]),
    }
}

/// Reads a file with parameters of many nodes and returns all its sections in their order, and all faults in its structure;
/// `node` is named in faults.
pub(super) fn read_sections(path: &Path, node: &NodeName) -> (Vec<Section>, Vec<Fault>) {
    match source(path, MAX_FILE_BYTES) {
        Ok(source) => {
            let mut reader = FileReader::new(&source, node);
            reader.sections = Some(Vec::new());
            reader.read();
            (reader.sections.unwrap_or_default(), reader.faults)
        }
        Err(fault) => (Vec::new(), vec![*fault]),
    }
}

/// The text of a file of at most `max_bytes`.
pub(super) fn source(path: &Path, max_bytes: u64) -> Result<SourceFile, Box<Fault>> {
    let text = read_text_at_most(path, max_bytes).map_err(|error| {
        Box::new(Fault {
            name: None,
            value: None,
            place: Origin::File {
                path: path.to_owned(),
                position: None,
                excerpt: None,
            },
            problem: Problem::Unreadable(error.to_string()),
        })
    })?;
    Ok(SourceFile {
        path: path.to_owned(),
        text: Arc::from(text),
    })
}

/// Returns what the text of a file assigns to this node's parameters, and all faults in its structure.
pub(super) fn assignments(file: &SourceFile, node: &NodeName) -> (Vec<Assignment>, Vec<Fault>) {
    let mut reader = FileReader::new(file, node);
    reader.read();
    (reader.found, reader.faults)
}

struct FileReader<'a> {
    file: &'a SourceFile,
    node: &'a NodeName,
    found: Vec<Assignment>,
    faults: Vec<Fault>,
    /// Other nodes that the file has parameters for.
    other_nodes: Vec<String>,
    /// Whether some part of the file applies to this node.
    meant: bool,
    /// Whether the present section is for any node, and not for this one by name.
    for_any_node: bool,
    /// Number of the present section.
    section: usize,
    /// The sections of all nodes, if they are wanted instead of what is for this node.
    sections: Option<Vec<Section>>,
}

impl<'a> FileReader<'a> {
    fn new(file: &'a SourceFile, node: &'a NodeName) -> Self {
        Self {
            file,
            node,
            found: Vec::new(),
            faults: Vec::new(),
            other_nodes: Vec::new(),
            meant: false,
            for_any_node: false,
            section: 0,
            sections: None,
        }
    }

    fn read(&mut self) {
        match yaml::parse(&self.file.text) {
            Ok(
                None
                | Some(YamlNode {
                    content: YamlContent::Null,
                    ..
                }),
            ) => {
                self.fault_of_file(
                    "is empty",
                    &Location {
                        line: 1,
                        column: 1,
                        bytes: 0..0,
                    },
                );
            }
            Ok(Some(YamlNode {
                content: YamlContent::Mapping(entries),
                ..
            })) => {
                self.nodes(&entries, "");
                self.report_missing_section(&entries);
            }
            Ok(Some(root)) => self.fault_of_file("is not a mapping", &root.at),
            Err(error) => self.fault(None, &error.at, Problem::Syntax(error.message)),
        }
    }

    /// Keeps what was found since the section before as a section, if sections are wanted.
    fn end_section(&mut self, path: &str, at: &Location) {
        if let Some(sections) = &mut self.sections {
            sections.push(Section {
                name: with_slashes(path),
                place: self.file.place(at),
                assignments: std::mem::take(&mut self.found),
            });
        }
    }

    fn fault(&mut self, name: Option<&str>, at: &Location, problem: Problem) {
        let place = self.file.place(at);
        self.faults.push(Fault {
            name: name.map(str::to_owned),
            value: None,
            place,
            problem,
        });
    }

    fn fault_of_file(&mut self, what: &str, at: &Location) {
        let message = format!(
            "the file {what}; begin it with `{}:` and, indented below it, `{PARAMETERS_KEY}:`",
            self.bare_name()
        );
        self.fault(None, at, Problem::Syntax(message));
    }

    /// Walks mappings from names of nodes and namespaces down to `ros__parameters`.
    fn nodes(&mut self, entries: &[(YamlKey, YamlNode)], path: &str) {
        self.report_duplicates(entries, |_| true);
        for (key, child) in entries {
            match (&child.content, key.text == PARAMETERS_KEY) {
                (_, true) if path.is_empty() => {
                    let message = format!(
                        "must be below the name of a node: `{}:` or `/**:`",
                        self.bare_name()
                    );
                    self.fault(Some(PARAMETERS_KEY), &key.at, Problem::Syntax(message));
                    self.meant = true; // one fault is enough
                }
                (YamlContent::Mapping(_) | YamlContent::Null, true)
                    if self.sections.is_none() && !self.node.is_meant_by(path) =>
                {
                    self.other_nodes.push(with_slashes(path));
                }
                (YamlContent::Mapping(parameters), true) => {
                    self.meant = true;
                    self.section += 1;
                    self.for_any_node = match self.sections {
                        None => !self.node.is_named_by(path),
                        Some(_) => path.ends_with('*'),
                    };
                    self.group(parameters, "", &mut BTreeMap::new());
                    self.end_section(path, &key.at);
                }
                (YamlContent::Null, true) => {
                    self.meant = true;
                    self.end_section(path, &key.at);
                }
                (YamlContent::Mapping(below), false) => {
                    self.nodes(below, &format!("{path}/{}", key.text))
                }
                (_, true) => {
                    let problem =
                        Problem::Syntax("must be a mapping from names to values".to_owned());
                    self.fault(Some(PARAMETERS_KEY), &child.at, problem);
                }
                (_, false) => self.report_stray(key),
            }
        }
    }

    /// Reports a value between the name of a node and its `ros__parameters`.
    fn report_stray(&mut self, key: &YamlKey) {
        let message = format!("is outside `{PARAMETERS_KEY}:`; move it below, indented");
        self.fault(Some(&key.text), &key.at, Problem::Syntax(message));
        self.meant = true;
    }

    fn report_missing_section(&mut self, entries: &[(YamlKey, YamlNode)]) {
        let Some((first, _)) = entries.first().filter(|_| !self.meant) else {
            return;
        };
        let message = if self.other_nodes.is_empty() {
            let name = self.bare_name();
            format!(
                "the file has no `{PARAMETERS_KEY}:`; write `{name}:`, below it `{PARAMETERS_KEY}:`, and the parameters below that"
            )
        } else {
            format!(
                "the file has parameters for {2}, but none for the node {0}; write `{1}:` or `/**:`",
                self.node,
                self.node,
                self.other_nodes.join(", ")
            )
        };
        self.fault(None, &first.at, Problem::Syntax(message));
    }

    fn bare_name(&self) -> String {
        self.node.bare().to_owned()
    }

    /// Reads parameters of this node, grouped by mappings or by dots.
    fn group(
        &mut self,
        entries: &[(YamlKey, YamlNode)],
        prefix: &str,
        first_lines: &mut BTreeMap<String, usize>,
    ) {
        self.report_duplicates(entries, |node| {
            matches!(node.content, YamlContent::Mapping(_))
        });
        for (key, node) in entries {
            let name = if prefix.is_empty() {
                key.text.clone()
            } else {
                format!("{prefix}.{}", key.text)
            };
            if let YamlContent::Mapping(members) = &node.content {
                if members.is_empty() {
                    continue;
                }
                self.group(members, &name, first_lines);
            } else if let Some(&first_line) = first_lines.get(&name) {
                self.fault(Some(&name), &key.at, Problem::Duplicate { first_line });
            } else {
                first_lines.insert(name.clone(), key.at.line);
                self.assign(name, key, node);
            }
        }
    }

    fn assign(&mut self, name: String, key: &YamlKey, node: &YamlNode) {
        let mut given = Given::of_yaml(node, &|at| self.file.place(at));
        let name_place = self.file.place(&key.at);
        // A fault in a scalar is shown at the scalar, one in the name or in a whole list at the name.
        if !matches!(given.content, given::Content::Scalar(_)) {
            given.place = name_place.clone();
        }
        self.found.push(Assignment {
            name,
            given,
            name_place,
            for_any_node: self.for_any_node,
            section: self.section,
        });
    }

    fn report_duplicates(
        &mut self,
        entries: &[(YamlKey, YamlNode)],
        counts: impl Fn(&YamlNode) -> bool,
    ) {
        let mut first_lines = BTreeMap::new();
        for (key, _) in entries.iter().filter(|(_, node)| counts(node)) {
            match first_lines.get(key.text.as_str()) {
                Some(&first_line) => {
                    self.fault(Some(&key.text), &key.at, Problem::Duplicate { first_line })
                }
                None => {
                    first_lines.insert(key.text.as_str(), key.at.line);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_for(node: &NodeName, text: &str) -> (Vec<(String, String)>, Vec<String>) {
        let file = SourceFile {
            path: "f.yaml".into(),
            text: Arc::from(text),
        };
        let (found, faults) = assignments(&file, node);
        let found = found
            .into_iter()
            .map(|one| (one.name, one.given.text.unwrap_or_default()))
            .collect();
        (found, faults.iter().map(ToString::to_string).collect())
    }

    fn names_and_values(text: &str) -> Vec<(String, String)> {
        let (found, faults) = read_for(&NodeName::default(), text);
        assert!(faults.is_empty(), "{faults:?}");
        found
    }

    fn one(name: &str, value: &str) -> Vec<(String, String)> {
        vec![(name.to_owned(), value.to_owned())]
    }

    /// The spellings that rcl's parser accepts (test files of rcl_yaml_param_parser).
    #[test]
    fn a_node_can_be_named_in_many_ways() {
        for head in [
            "column_twin:",
            "/column_twin:",
            "/**:",
            "/*:",
            "\"/**/column_twin\":",
            "'*':",
        ] {
            let text = format!("{head}\n  ros__parameters:\n    top.load: 1.0\n");
            assert_eq!(names_and_values(&text), one("top.load", "1.0"), "{head}");
        }
        let garage = NodeName::new("/garage/a3", "column_twin");
        for head in [
            "/garage/a3/column_twin:",
            "garage/a3/column_twin:",
            "/**:",
            "/garage/**:",
            "/*/*/column_twin:",
            "/**/column_twin:",
        ] {
            let text = format!("{head}\n  ros__parameters:\n    top.load: 1.0\n");
            assert_eq!(
                read_for(&garage, &text),
                (one("top.load", "1.0"), vec![]),
                "{head}"
            );
        }
        let nested =
            "garage:\n  a3:\n    column_twin:\n      ros__parameters: {top: {load: 1.0}}\n";
        assert_eq!(read_for(&garage, nested), (one("top.load", "1.0"), vec![]));
    }

    #[test]
    fn dots_and_mappings_mean_the_same() {
        let dotted =
            names_and_values("column_twin:\n  ros__parameters:\n    a.b.c: 1\n    a.b.d: 2\n");
        let nested =
            names_and_values("column_twin:\n  ros__parameters:\n    a:\n      b: {c: 1, d: 2}\n");
        let mixed = names_and_values(
            "column_twin:\n  ros__parameters:\n    a.b:\n      c: 1\n    a: {b.d: 2}\n",
        );
        assert_eq!(dotted, nested);
        assert_eq!(dotted, mixed);
    }

    #[test]
    fn other_nodes_are_left_alone_and_a_wildcard_adds() {
        let text = "/**:\n  ros__parameters: {top.load: 1.0}\nlidar:\n  ros__parameters: {top.load: 9.0, x: [1]}\n\
                    column_twin:\n  ros__parameters: {top.load: 2.0}\n";
        let found = names_and_values(text);
        assert_eq!(
            found,
            [one("top.load", "1.0"), one("top.load", "2.0")].concat()
        );
    }

    #[test]
    fn structural_faults_name_the_remedy() {
        for (text, expected) in [
            (
                "",
                "f.yaml:1:1: the file is empty; begin it with `column_twin:` and, indented below it, `ros__parameters:`",
            ),
            ("42\n", "f.yaml:1:1: the file is not a mapping; begin it"),
            (
                "colum_twin:\n  ros__parameters:\n    top.load: 1.0\n",
                "the file has parameters for /colum_twin, but none for the node /column_twin; write `/column_twin:` or `/**:`",
            ),
            (
                "ros__parameters:\n  top.load: 1.0\n",
                "f.yaml:1:1: ros__parameters must be below the name of a node: `column_twin:`",
            ),
            (
                "column_twin:\n  top.load: 1.0\n",
                "f.yaml:2:3: top.load is outside `ros__parameters:`; move it below",
            ),
            ("column_twin: {}\n", "the file has no `ros__parameters:`"),
            (
                "column_twin:\n  ros__parameters: 3\n",
                "f.yaml:2:20: ros__parameters must be a mapping",
            ),
            (
                "column_twin:\n  ros__parameters:\n    a: 1\n    a: 2\n",
                "f.yaml:4:5: a is given a second time; the first is in line 3",
            ),
            (
                "column_twin:\n  ros__parameters:\n    a.b: 1\n    a: {b: 2}\n",
                "f.yaml:4:9: a.b is given a second time; the first is in line 3",
            ),
            (
                "column_twin:\n  ros__parameters:\n    a: {b: 1}\n    a: {c: 2}\n",
                "f.yaml:4:5: a is given a second time; the first is in line 3",
            ),
            (
                "column_twin:\n  ros__parameters: {a: 1}\ncolumn_twin:\n  ros__parameters: {b: 1}\n",
                "f.yaml:3:1: column_twin is given a second time",
            ),
        ] {
            let (_, faults) = read_for(&NodeName::default(), text);
            assert!(
                faults.iter().any(|fault| fault.contains(expected)),
                "{text}\n{faults:?}"
            );
        }
    }

    #[test]
    fn unreadable_files_are_faults() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let large = folder.path().join("large.yaml");
        std::fs::write(&large, vec![b'#'; MAX_FILE_BYTES as usize + 1]).expect("written");
        let binary = folder.path().join("binary.yaml");
        std::fs::write(&binary, b"a: \xff").expect("written");
        let cases = [
            (
                folder.path().join("missing.yaml"),
                "cannot be read: No such file",
            ),
            (folder.path().to_owned(), "cannot be read: Is a directory"),
            (large, "larger than 1048576 bytes"),
            (binary, "not UTF-8 text (byte 3)"),
        ];
        for (path, expected) in cases {
            let (found, faults) = read(&path, &NodeName::default());
            assert!(found.is_empty());
            assert!(
                faults.len() == 1 && faults[0].to_string().contains(expected),
                "{faults:?}"
            );
        }
    }
}
