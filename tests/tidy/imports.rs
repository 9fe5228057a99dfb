//! What the source files import from one another, read from their text: `use` lines and every other path in the code, each
//! followed through re-exports to the file that defines the name.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Re-exports that a path may pass through; more are a circle of re-exports.
const MAX_RE_EXPORTS: usize = 20;

/// The crates of the workspace by the names that code uses for them, and the file with which each begins.
pub const CRATES: [(&str, &str); 13] = [
    ("bounded_file", "crates/bounded_file/src/lib.rs"),
    ("column_alarm", "crates/alarm/src/lib.rs"),
    ("column_beam", "crates/beam/src/lib.rs"),
    ("column_mechanics", "crates/mechanics/src/lib.rs"),
    ("foxglove_live", "crates/foxglove/src/lib.rs"),
    ("printable", "crates/printable/src/lib.rs"),
    ("ros_interface", "crates/ros_interface/src/lib.rs"),
    ("ros_node", "crates/ros_node/src/lib.rs"),
    ("rosbag2_mcap", "crates/recording/src/lib.rs"),
    ("sros2_keystore", "crates/sros2_keystore/src/lib.rs"),
    ("column_twin", "src/lib.rs"),
    ("the_program", "src/main.rs"),
    ("column_twin_python", "crates/python/src/lib.rs"),
];

/// A module by its path, the name of its crate first.
type ModulePath = Vec<String>;

#[derive(Debug, Default)]
struct Module {
    file: PathBuf,
    children: BTreeSet<String>,
    definitions: BTreeSet<String>,
    imports: Vec<Import>,
    /// Paths in expressions, types and patterns.
    mentions: Vec<Vec<String>>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Import {
    path: Vec<String>,
    /// The name that it has here; empty for all names of the module.
    name: String,
    is_public: bool,
}

/// The modules of all crates.
#[derive(Debug, Default)]
pub struct Source {
    modules: BTreeMap<ModulePath, Module>,
}

/// One file takes a name from another one.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Arrow {
    pub from: PathBuf,
    pub to: PathBuf,
    pub name: String,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Target {
    Module(ModulePath),
    Name(ModulePath),
}

impl Source {
    /// Reads every module that the crate whose first file is `root` declares, apart from those that are compiled for tests only.
    pub fn add(&mut self, name: &str, root: &Path, read: &impl Fn(&Path) -> Option<String>) {
        let folder = root.parent().unwrap();
        self.add_file(&[name.to_owned()], root, folder, read);
    }

    fn add_file(
        &mut self,
        path: &[String],
        file: &Path,
        folder: &Path,
        read: &impl Fn(&Path) -> Option<String>,
    ) {
        let text = read(file).unwrap_or_else(|| panic!("{}: cannot be read", file.display()));
        let tokens = tokens(&text);
        let mut reader = Reader {
            tokens: &tokens,
            at: 0,
        };
        let mut declared = Vec::new();
        reader.read_module(path.to_vec(), file, self, &mut declared, false);
        for child in declared {
            let (name, mut inner) = (child.last().unwrap().clone(), folder.to_owned());
            inner.extend(&child[path.len()..child.len() - 1]);
            let beside = inner.join(format!("{name}.rs"));
            let below = inner.join(&name);
            let file = match read(&beside) {
                Some(_) => beside,
                None => below.join("mod.rs"),
            };
            self.add_file(&child, &file, &below, read);
        }
    }

    /// Where a path that stands in `scope` leads; `None`: out of the workspace, or nowhere that is known.
    fn resolve(&self, scope: &ModulePath, path: &[String], depth: usize) -> Option<Target> {
        if depth > MAX_RE_EXPORTS {
            return None;
        }
        let (first, mut rest) = path.split_first()?;
        let mut place = match first.as_str() {
            "crate" => scope[..1].to_vec(),
            "self" => scope.clone(),
            "super" => scope[..scope.len() - 1].to_vec(),
            _ => match self.lookup(scope, first, depth)? {
                Target::Module(module) => module,
                name => return Some(name),
            },
        };
        while let Some((next, after)) = rest.split_first() {
            rest = after;
            if next == "super" {
                place.pop();
                continue;
            }
            if next == "self" {
                continue;
            }
            match self.member(&place, next, depth) {
                Some(Target::Module(module)) => place = module,
                Some(name) => return Some(name),
                None => return Some(Target::Name(place)),
            }
        }
        self.modules.get(&place)?;
        Some(Target::Module(place))
    }

    /// The first word of a path: a name of the module, or a crate.
    fn lookup(&self, scope: &ModulePath, word: &str, depth: usize) -> Option<Target> {
        self.member(scope, word, depth).or_else(|| {
            let module = vec![word.to_owned()];
            self.modules
                .contains_key(&module)
                .then_some(Target::Module(module))
        })
    }

    fn member(&self, place: &ModulePath, word: &str, depth: usize) -> Option<Target> {
        let module = self.modules.get(place)?;
        if module.children.contains(word) {
            let mut child = place.clone();
            child.push(word.to_owned());
            return self
                .modules
                .contains_key(&child)
                .then_some(Target::Module(child));
        }
        if module.definitions.contains(word) {
            return Some(Target::Name(place.clone()));
        }
        let mut named = module
            .imports
            .iter()
            .filter(|it| it.name == word && it.path != [word]);
        if let Some(target) = named.find_map(|it| self.resolve(place, &it.path, depth + 1)) {
            return Some(target);
        }
        let mut all = module.imports.iter().filter(|it| it.name.is_empty());
        all.find_map(|it| match self.resolve(place, &it.path, depth + 1)? {
            Target::Module(from) if from != *place => self.member(&from, word, depth + 1),
            _ => None,
        })
    }

    fn file_of(&self, module: &ModulePath) -> &Path {
        &self.modules[module].file
    }

    /// Every arrow between two files. What a module hands on of its own folder (`pub use` in a `mod.rs`) is none: whoever takes
    /// it has the arrow to the file that defines it.
    pub fn arrows(&self) -> BTreeSet<Arrow> {
        let mut arrows = BTreeSet::new();
        for (scope, module) in &self.modules {
            let imports = module.imports.iter().map(|it| (&it.path, it.is_public));
            let mentions = module.mentions.iter().map(|path| (path, false));
            for (path, is_public) in imports.chain(mentions) {
                let Some(target) = self.resolve(scope, path, 0) else {
                    continue;
                };
                let to = match &target {
                    // A folder alone: what is taken of it is named where it is used.
                    Target::Module(to) if self.modules[to].file.ends_with("mod.rs") => continue,
                    Target::Module(to) | Target::Name(to) => to,
                };
                let is_own = to.starts_with(scope);
                let (from, to) = (module.file.clone(), self.file_of(to).to_owned());
                if from == to || from.ends_with("lib.rs") || (is_public && is_own) {
                    continue;
                }
                let name = path.join("::");
                arrows.insert(Arrow { from, to, name });
            }
        }
        arrows
    }
}

struct Reader<'a> {
    tokens: &'a [String],
    at: usize,
}

impl Reader<'_> {
    fn peek(&self, ahead: usize) -> &str {
        self.tokens.get(self.at + ahead).map_or("", String::as_str)
    }

    /// Reads the items of a module up to its closing brace, or to the end of the file.
    fn read_module(
        &mut self,
        path: ModulePath,
        file: &Path,
        source: &mut Source,
        declared: &mut Vec<ModulePath>,
        is_inline: bool,
    ) {
        let mut module = Module {
            file: file.to_owned(),
            ..Module::default()
        };
        let mut depth = 0;
        while self.at < self.tokens.len() {
            match self.peek(0) {
                "#" if matches!(self.peek(1), "[" | "!") => {
                    if self.skip_attribute() {
                        self.skip_item();
                    }
                    continue;
                }
                "mod" if self.peek(2) == ";" => {
                    let name = self.peek(1).to_owned();
                    declared.push(path.iter().cloned().chain([name.clone()]).collect());
                    module.children.insert(name);
                    self.at += 2;
                }
                "mod" if self.peek(2) == "{" => {
                    let name = self.peek(1).to_owned();
                    module.children.insert(name.clone());
                    self.at += 3;
                    let inner = path.iter().cloned().chain([name]).collect();
                    self.read_module(inner, file, source, declared, true);
                    continue;
                }
                // What a return type captures (`use<>`) is no import.
                "use" if self.peek(1) != "<" => {
                    let is_public = self.at > 0
                        && (self.tokens[self.at - 1] == "pub"
                            || self.tokens[self.at - 1] == ")"
                                && self.tokens[..self.at]
                                    .iter()
                                    .rev()
                                    .take(6)
                                    .any(|token| token == "pub"));
                    self.at += 1;
                    self.read_use(&[], is_public, &mut module.imports);
                    continue;
                }
                "struct" | "enum" | "trait" | "fn" | "const" | "static" | "type" | "union"
                    if depth == 0 =>
                {
                    module.definitions.insert(self.peek(1).to_owned());
                }
                "macro_rules" => {
                    module.definitions.insert(self.peek(2).to_owned());
                }
                "{" => depth += 1,
                "}" if depth == 0 && is_inline => {
                    self.at += 1;
                    break;
                }
                "}" => depth -= 1,
                word if is_word(word) && self.peek(1) == "::" => {
                    let follows = self.at > 0 && self.tokens[self.at - 1] == "::";
                    let mut mention = vec![word.to_owned()];
                    while self.peek(1) == "::" && is_word(self.peek(2)) {
                        self.at += 2;
                        mention.push(self.peek(0).to_owned());
                    }
                    if !follows {
                        module.mentions.push(mention);
                    }
                }
                _ => {}
            }
            self.at += 1;
        }
        source.modules.insert(path, module);
    }

    /// Steps over an attribute and says whether what follows is compiled for tests only.
    fn skip_attribute(&mut self) -> bool {
        let begin = self.at;
        while self.peek(0) != "[" {
            self.at += 1;
        }
        self.skip_group();
        let attribute = self.tokens[begin..self.at].concat();
        attribute.starts_with("#[cfg(test)") || attribute.starts_with("#[cfg(all(test,")
    }

    fn skip_item(&mut self) {
        while self.at < self.tokens.len() {
            match self.peek(0) {
                ";" => {
                    self.at += 1;
                    return;
                }
                "{" => return self.skip_group(),
                "(" | "[" => self.skip_group(),
                _ => self.at += 1,
            }
        }
    }

    /// Steps over a bracket and all that it holds.
    fn skip_group(&mut self) {
        let mut depth = 0;
        while self.at < self.tokens.len() {
            match self.peek(0) {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
            self.at += 1;
            if depth == 0 {
                return;
            }
        }
    }

    /// One tree of a `use`, which ends before `,` or `}` or after `;`.
    fn read_use(&mut self, before: &[String], is_public: bool, imports: &mut Vec<Import>) {
        let mut path = before.to_vec();
        loop {
            let token = self.peek(0).to_owned();
            self.at += 1;
            match token.as_str() {
                "::" => {}
                "*" => imports.push(Import {
                    path: path.clone(),
                    name: String::new(),
                    is_public,
                }),
                "{" => {
                    while self.peek(0) != "}" {
                        self.read_use(&path, is_public, imports);
                        if self.peek(0) == "," {
                            self.at += 1;
                        }
                    }
                    self.at += 1;
                }
                _ => path.push(token),
            }
            match self.peek(0) {
                "," | "}" | ";" | "" => break,
                "as" => {
                    let name = self.peek(1).to_owned();
                    self.at += 2;
                    imports.push(Import {
                        path,
                        name,
                        is_public,
                    });
                    self.end_of_use();
                    return;
                }
                _ => {}
            }
        }
        let ends_as_name = self.at > 0 && is_word(&self.tokens[self.at - 1]);
        if ends_as_name {
            if path.last().is_some_and(|last| last == "self") && path.len() > 1 {
                path.pop();
            }
            let name = path.last().cloned().unwrap_or_default();
            imports.push(Import {
                path,
                name,
                is_public,
            });
        }
        self.end_of_use();
    }

    fn end_of_use(&mut self) {
        if self.peek(0) == ";" {
            self.at += 1;
        }
    }
}

fn is_word(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Words and punctuation, without comments, literals and lifetimes.
fn tokens(text: &str) -> Vec<String> {
    let chars: Vec<char> = text.chars().collect();
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut tokens = Vec::new();
    let mut at = 0;
    let next = |at: usize, wanted: &str| {
        let mut letters = wanted.chars().enumerate();
        letters.all(|(offset, letter)| chars.get(at + offset) == Some(&letter))
    };
    while at < chars.len() {
        let c = chars[at];
        let raw = chars[at..]
            .iter()
            .skip(1)
            .take_while(|it| **it == '#')
            .count();
        if next(at, "//") {
            while at < chars.len() && chars[at] != '\n' {
                at += 1;
            }
        } else if next(at, "/*") {
            while at < chars.len() && !next(at, "*/") {
                at += 1;
            }
            at += 2;
        } else if c == 'r' && chars.get(at + 1 + raw) == Some(&'"') {
            let end = format!("\"{}", "#".repeat(raw));
            at += raw + 2;
            while at < chars.len() && !next(at, &end) {
                at += 1;
            }
            at += end.len();
        } else if c == '"' {
            at += 1;
            while at < chars.len() && chars[at] != '"' {
                at += if chars[at] == '\\' { 2 } else { 1 };
            }
            at += 1;
        } else if c == '\'' {
            // A character, or a lifetime.
            if chars.get(at + 1) == Some(&'\\') {
                at += 3;
                while at < chars.len() && chars[at] != '\'' {
                    at += 1;
                }
                at += 1;
            } else if chars.get(at + 2) == Some(&'\'') {
                at += 3;
            } else {
                at += 1;
                while at < chars.len() && is_name(chars[at]) {
                    at += 1;
                }
            }
        } else if is_name(c) {
            let begin = at;
            while at < chars.len() && is_name(chars[at]) {
                at += 1;
            }
            tokens.push(chars[begin..at].iter().collect());
        } else if next(at, "::") {
            tokens.push("::".to_owned());
            at += 2;
        } else {
            if !c.is_whitespace() {
                tokens.push(c.to_string());
            }
            at += 1;
        }
    }
    tokens
}

/// The groups of nodes that reach one another by arrows, each sorted; nodes on no circle are in none.
pub fn circles<Node: Clone + Ord>(arrows: &BTreeSet<(Node, Node)>) -> Vec<Vec<Node>> {
    let nodes: BTreeSet<&Node> = arrows.iter().flat_map(|(from, to)| [from, to]).collect();
    let reached = |start: &Node| {
        let mut found = BTreeSet::new();
        let mut open = vec![start];
        while let Some(node) = open.pop() {
            for (_, to) in arrows.iter().filter(|(from, _)| from == node) {
                if found.insert(to) {
                    open.push(to);
                }
            }
        }
        found
    };
    let reach: BTreeMap<&Node, BTreeSet<&Node>> =
        nodes.iter().map(|node| (*node, reached(node))).collect();
    let groups: BTreeSet<Vec<Node>> = nodes
        .iter()
        .filter(|node| reach[*node].contains(*node))
        .map(|node| {
            let mutual = reach[node].iter().filter(|it| reach[*it].contains(*node));
            mutual.map(|it| (*it).clone()).collect()
        })
        .collect();
    groups.into_iter().collect()
}

/// The arrows of these files, which exist only here.
fn arrows_of(files: &[(&str, &str)]) -> Vec<String> {
    let mut source = Source::default();
    source.add("a", Path::new("src/lib.rs"), &|path| {
        let found = files.iter().find(|(name, _)| Path::new(name) == path);
        found.map(|(_, text)| (*text).to_owned())
    });
    let shown = |path: &Path| path.strip_prefix("src").unwrap().display().to_string();
    let arrows = source.arrows().into_iter();
    arrows
        .map(|it| format!("{} {} {}", shown(&it.from), shown(&it.to), it.name))
        .collect()
}

#[test]
fn names_are_followed_through_re_exports_to_where_they_are_defined() {
    let files = [
        ("src/lib.rs", "mod low; mod high; mod middle;"),
        ("src/low.rs", "pub struct Nanos; pub const X: u8 = b'\\'';"),
        (
            "src/middle/mod.rs",
            "mod inner; pub use inner::{Thing as Renamed, other}; pub(crate) use crate::low::Nanos; pub use inner::glob::*;",
        ),
        (
            "src/middle/inner.rs",
            "pub mod glob { pub fn all() {} } pub struct Thing; pub fn other() { super::super::low::X; }",
        ),
        (
            "src/high.rs",
            "use crate::middle::{self, Renamed,}; // crate::low::X\nfn f<'a>(_: &'a str) -> impl Sized + use<'a> { middle::other(); crate::middle::Nanos::new(\"crate::low::Y\"); middle::all() }\n#[cfg(test)]\nmod tests { use crate::low::X; }",
        ),
    ];
    assert_eq!(
        arrows_of(&files),
        [
            "high.rs low.rs crate::middle::Nanos::new",
            "high.rs middle/inner.rs crate::middle::Renamed",
            "high.rs middle/inner.rs middle::all",
            "high.rs middle/inner.rs middle::other",
            "middle/inner.rs low.rs super::super::low::X",
            "middle/mod.rs low.rs crate::low::Nanos",
        ]
    );
}

#[test]
fn circles_are_found_and_chains_are_not() {
    let arrows = [("a", "b"), ("b", "c"), ("c", "b"), ("c", "d"), ("e", "e")].into();
    assert_eq!(circles(&arrows), [vec!["b", "c"], vec!["e"]]);
}
