//! ROS 2 parameter files, turned into assignments.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use super::fault::{Fault, Place, Problem, SourceFile};
use super::node_name::{NodeName, with_slashes};
use super::table::Parameter;
use super::value::Value;
use super::yaml::{self, Content, Key, Location, Node};

/// Largest parameter file that is read \[bytes\].
pub const MAX_FILE_BYTES: u64 = 1 << 20;

/// The mapping of this name holds a node's parameters.
const PARAMETERS_KEY: &str = "ros__parameters";

/// One name with one value, and where it was given.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Assignment {
    pub name: String,
    /// `None` where nothing, a list or a mapping was given.
    pub value: Result<Value, NotAValue>,
    /// As it was typed.
    pub text: Option<String>,
    pub place: Place,
}

/// What stands where a value should.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NotAValue {
    Nothing,
    List,
}

/// Reads a file and collects what it assigns to this node's parameters, and all the faults of its structure.
pub(super) fn read(path: &Path, node: &NodeName) -> (Vec<Assignment>, Vec<Fault>) {
    match read_text(path) {
        Ok(text) => assignments(
            &SourceFile {
                path: path.to_owned(),
                text: Arc::from(text),
            },
            node,
        ),
        Err(message) => {
            let place = Place::File {
                path: path.to_owned(),
                position: None,
                excerpt: None,
            };
            (
                Vec::new(),
                vec![Fault {
                    name: None,
                    value: None,
                    place,
                    problem: Problem::Unreadable(message),
                }],
            )
        }
    }
}

fn read_text(path: &Path) -> Result<String, String> {
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|error| error.to_string())?;
    file.take(MAX_FILE_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| error.to_string())?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(format!(
            "larger than {MAX_FILE_BYTES} bytes, which no parameter file is"
        ));
    }
    String::from_utf8(bytes)
        .map_err(|error| format!("not UTF-8 text (byte {})", error.utf8_error().valid_up_to()))
}

/// What a file's text assigns to this node's parameters, and all the faults of its structure.
pub(super) fn assignments(file: &SourceFile, node: &NodeName) -> (Vec<Assignment>, Vec<Fault>) {
    let mut reader = Reader {
        file,
        node,
        found: Vec::new(),
        faults: Vec::new(),
        other_nodes: Vec::new(),
        meant: false,
    };
    match yaml::parse(&file.text) {
        Ok(
            None
            | Some(Node {
                content: Content::Null,
                ..
            }),
        ) => {
            reader.fault_of_file(
                "is empty",
                &Location {
                    line: 1,
                    column: 1,
                    bytes: 0..0,
                },
            );
        }
        Ok(Some(Node {
            content: Content::Mapping(entries),
            ..
        })) => {
            reader.nodes(&entries, "");
            reader.report_missing_section(&entries);
        }
        Ok(Some(root)) => reader.fault_of_file("is not a mapping", &root.at),
        Err(error) => reader.fault(None, &error.at, Problem::Syntax(error.message)),
    }
    (reader.found, reader.faults)
}

struct Reader<'a> {
    file: &'a SourceFile,
    node: &'a NodeName,
    found: Vec<Assignment>,
    faults: Vec<Fault>,
    /// Nodes of the file that this one is not.
    other_nodes: Vec<String>,
    /// Whether some part of the file is for this node.
    meant: bool,
}

impl Reader<'_> {
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
            "the file {what}; begin it with `{}:` and below, indented, `{PARAMETERS_KEY}:`",
            self.bare_name()
        );
        self.fault(None, at, Problem::Syntax(message));
    }

    /// Mappings from names of nodes and namespaces, down to `ros__parameters`.
    fn nodes(&mut self, entries: &[(Key, Node)], path: &str) {
        self.report_duplicates(entries, |_| true);
        for (key, child) in entries {
            match (&child.content, key.text == PARAMETERS_KEY) {
                (_, true) if path.is_empty() => {
                    let message = format!(
                        "needs the name of the node above it: `{}:` or `/**:`",
                        self.bare_name()
                    );
                    self.fault(Some(PARAMETERS_KEY), &key.at, Problem::Syntax(message));
                    self.meant = true; // one fault is enough
                }
                (Content::Mapping(_) | Content::Null, true) if !self.node.is_meant_by(path) => {
                    self.other_nodes.push(with_slashes(path));
                }
                (Content::Mapping(parameters), true) => {
                    self.meant = true;
                    self.section(parameters);
                }
                (Content::Null, true) => self.meant = true,
                (Content::Mapping(below), false) => {
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

    /// Something between a node's name and its `ros__parameters` that is neither.
    fn report_stray(&mut self, key: &Key) {
        let message = format!("stands outside of `{PARAMETERS_KEY}:`; move it below, indented");
        self.fault(Some(&key.text), &key.at, Problem::Syntax(message));
        self.meant = true;
    }

    fn report_missing_section(&mut self, entries: &[(Key, Node)]) {
        let Some((first, _)) = entries.first().filter(|_| !self.meant) else {
            return;
        };
        let message = if self.other_nodes.is_empty() {
            let name = self.bare_name();
            format!(
                "the file has no `{PARAMETERS_KEY}:`; write `{name}:`, below it `{PARAMETERS_KEY}:`, and below that the parameters"
            )
        } else {
            format!(
                "nothing in the file is for the node {}, only for {}; write `{}:` or `/**:`",
                self.node,
                self.other_nodes.join(", "),
                self.node
            )
        };
        self.fault(None, &first.at, Problem::Syntax(message));
    }

    fn bare_name(&self) -> String {
        self.node.bare().to_owned()
    }

    /// The parameters of this node, grouped by mappings or by dots.
    fn section(&mut self, entries: &[(Key, Node)]) {
        let mut first_lines = BTreeMap::new();
        self.group(entries, "", &mut first_lines);
    }

    fn group(
        &mut self,
        entries: &[(Key, Node)],
        prefix: &str,
        first_lines: &mut BTreeMap<String, usize>,
    ) {
        self.report_duplicates(entries, |node| matches!(node.content, Content::Mapping(_)));
        for (key, node) in entries {
            let name = if prefix.is_empty() {
                key.text.clone()
            } else {
                format!("{prefix}.{}", key.text)
            };
            if let Content::Mapping(members) = &node.content {
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

    fn assign(&mut self, name: String, key: &Key, node: &Node) {
        let (value, text) = match &node.content {
            Content::Scalar { value, text } => (Ok(value.clone()), Some(text.clone())),
            Content::List => (Err(NotAValue::List), None),
            Content::Null | Content::Mapping(_) => (Err(NotAValue::Nothing), None),
        };
        // A fault of the name is shown at the name, one of the value at the value.
        let named = Parameter::named(&name).is_some() && value.is_ok();
        let place = self.file.place(if named { &node.at } else { &key.at });
        self.found.push(Assignment {
            name,
            value,
            text,
            place,
        });
    }

    fn report_duplicates(&mut self, entries: &[(Key, Node)], counts: impl Fn(&Node) -> bool) {
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
            .map(|one| (one.name, one.text.unwrap_or_default()))
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

    /// The spellings that rcl's parser takes (rcl_yaml_param_parser, its test files).
    #[test]
    fn a_node_is_named_in_many_ways() {
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
    fn structure_faults_say_what_to_write() {
        for (text, expected) in [
            (
                "",
                "f.yaml:1:1: the file is empty; begin it with `column_twin:` and below, indented, `ros__parameters:`",
            ),
            ("42\n", "f.yaml:1:1: the file is not a mapping; begin it"),
            (
                "colum_twin:\n  ros__parameters:\n    top.load: 1.0\n",
                "nothing in the file is for the node /column_twin, only for /colum_twin; write `/column_twin:` or `/**:`",
            ),
            (
                "ros__parameters:\n  top.load: 1.0\n",
                "f.yaml:1:1: ros__parameters needs the name of the node above it: `column_twin:`",
            ),
            (
                "column_twin:\n  top.load: 1.0\n",
                "f.yaml:2:3: top.load stands outside of `ros__parameters:`; move it below",
            ),
            ("column_twin: {}\n", "the file has no `ros__parameters:`"),
            (
                "column_twin:\n  ros__parameters: 3\n",
                "f.yaml:2:20: ros__parameters must be a mapping",
            ),
            (
                "column_twin:\n  ros__parameters:\n    a: 1\n    a: 2\n",
                "f.yaml:4:5: a is given a second time, first in line 3",
            ),
            (
                "column_twin:\n  ros__parameters:\n    a.b: 1\n    a: {b: 2}\n",
                "f.yaml:4:9: a.b is given a second time, first in line 3",
            ),
            (
                "column_twin:\n  ros__parameters:\n    a: {b: 1}\n    a: {c: 2}\n",
                "f.yaml:4:5: a is given a second time, first in line 3",
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
