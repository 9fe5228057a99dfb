//! Promises about the text of the repository: the documents name what exists, the core stays pure, files stay short.

use std::fs;
use std::path::{Path, PathBuf};

#[path = "tidy/english.rs"]
mod english;
#[path = "tidy/file_lists.rs"]
mod file_lists;
#[path = "tidy/glossary.rs"]
mod glossary;
#[path = "tidy/imports.rs"]
mod imports;
#[path = "tidy/reference.rs"]
mod reference;
#[path = "tidy/vocabulary.rs"]
mod vocabulary;
#[path = "tidy/walls.rs"]
mod walls;

/// Most lines of a source file, its unit tests not counted.
const MAX_FILE: usize = 700;

/// Files that are longer, and may not grow: one table is one subject.
const LONGER_FILES: [(&str, usize); 1] = [("src/parameters/table.rs", 1350)];

/// Documents whose paths must exist, besides the pages of the book.
const DOCUMENTS: [&str; 6] = [
    "crates/python/README.md",
    "crates/recording/README.md",
    "crates/printable/README.md",
    "crates/ros_node/README.md",
    "crates/sros2_keystore/README.md",
    "vendor/README.md",
];

/// Paths that documents name and that are elsewhere: in a recording, a keystore, a state directory, and a repository of others.
const ELSEWHERE: [&str; 6] = [
    "metadata.yaml",
    "fleet.lock",
    "private/",
    "enclaves/NAME/permissions.xml",
    "eurocodes/en1993/en1993_1_1.py",
    "chapter_3_materials/table_3_1.py",
];

/// The pages of the book, as `docs/SUMMARY.md` lists them, by their paths in the repository.
fn pages() -> Vec<String> {
    let summary = read("docs/SUMMARY.md");
    let links = summary
        .split("](")
        .skip(1)
        .filter_map(|it| it.split_once(')'));
    let pages: Vec<_> = links
        .map(|(link, _)| match link.strip_prefix("../") {
            Some(path) => path.to_owned(),
            None => format!("docs/{link}"),
        })
        .collect();
    assert!(pages.len() > 20, "{pages:?}");
    pages
}

/// What the core must not contain, with the reason.
const ABSENT_FROM_CORE: [(&str, &str); 35] = [
    ("std::fs", "files"),
    ("std::io", "input and output"),
    ("std::net", "network"),
    ("std::env", "environment"),
    ("std::process", "processes"),
    ("std::time", "clock"),
    ("std::thread", "threads"),
    ("std::sync", "threads"),
    (
        "std::{",
        "hides what is imported; name each module on its own line",
    ),
    ("Instant", "clock"),
    ("SystemTime", "clock"),
    ("println!", "output"),
    ("print!", "output"),
    ("eprintln!", "output"),
    ("eprint!", "output"),
    ("dbg!", "output"),
    ("tracing", "logging"),
    ("log::", "logging"),
    ("Vec<", "heap"),
    ("Vec::", "heap"),
    ("vec!", "heap"),
    ("VecDeque", "heap"),
    ("Box<", "heap"),
    ("Box::", "heap"),
    ("Rc", "heap"),
    ("Arc", "heap"),
    ("String", "heap"),
    ("format!", "heap"),
    (".to_string", "heap"),
    (".to_owned", "heap"),
    (".to_vec", "heap"),
    (".collect", "heap"),
    ("HashMap", "heap and an order that differs from run to run"),
    ("BTreeMap", "heap"),
    ("unsafe", "needs none"),
];

/// Functions of the system's math library, which chooses its code by processor and so gives different bits on different
/// processors.
const SYSTEM_MATH: [&str; 27] = [
    "powf", "powi", "sin", "cos", "tan", "sin_cos", "asin", "acos", "atan", "atan2", "sinh",
    "cosh", "tanh", "asinh", "acosh", "atanh", "exp", "exp2", "exp_m1", "ln", "ln_1p", "log",
    "log2", "log10", "cbrt", "hypot", "mul_add",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|fault| panic!("{}: {fault}", path.display()))
}

/// All files below a folder of the repository, by their paths from its root.
fn files_below(folder: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![root().join(folder)];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                if path.file_name().is_none_or(|name| name != "__pycache__") {
                    open.push(path);
                }
            } else {
                found.push(path.strip_prefix(root()).unwrap().to_path_buf());
            }
        }
    }
    found.sort();
    found
}

fn rust_files_below(folder: &str) -> Vec<PathBuf> {
    let mut files = files_below(folder);
    files.retain(|path| path.extension().is_some_and(|extension| extension == "rs"));
    assert!(!files.is_empty(), "no source file below {folder}");
    files
}

/// A document's lines outside of fenced code.
fn prose(text: &str) -> String {
    let mut fenced = false;
    text.lines()
        .filter(|line| {
            let fence = line.trim_start().starts_with("```");
            fenced ^= fence;
            !fenced && !fence
        })
        .map(|line| format!("{line}\n"))
        .collect()
}

/// Paths that prose names: in backticks or as the target of a link. Wildcards, commands, names of things in the code
/// and addresses elsewhere are not paths.
fn named_paths(prose: &str) -> Vec<String> {
    const EXTENSIONS: [&str; 13] = [
        ".rs", ".md", ".toml", ".lock", ".yaml", ".csv", ".json", ".sh", ".py", ".xml", ".txt",
        ".msg", ".srv",
    ];
    let in_backticks = prose.split('`').skip(1).step_by(2);
    let targets = prose
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split([')', '#']).next())
        .filter(|target| !target.contains("://") && !target.is_empty());
    let looks_like_path = |text: &&str| {
        let plain = !text.contains(|c: char| c.is_whitespace() || "*<>{}()=$:".contains(c));
        let first = text.split('/').next().unwrap_or_default();
        plain
            && (text.ends_with('/') && text.len() > 1
                || text.contains('/') && !first.is_empty() && root().join(first).exists()
                || EXTENSIONS.iter().any(|end| text.ends_with(end)))
    };
    in_backticks
        .filter(looks_like_path)
        .chain(targets)
        .map(str::to_owned)
        .collect()
}

/// Source text without comments and without what follows `#[cfg(test)]` at the left margin, which ends a file here.
fn code_of(source: &str) -> String {
    source
        .lines()
        .take_while(|line| *line != "#[cfg(test)]")
        .map(|line| {
            // `ws://` in a text begins no comment.
            let mut slashes = line.match_indices("//").map(|(at, _)| at);
            let comment = slashes.find(|&at| !line[..at].ends_with(':'));
            &line[..comment.unwrap_or(line.len())]
        })
        .map(|line| format!("{line}\n"))
        .collect()
}

/// Whether `code` contains `word` as a word of its own.
fn contains_word(code: &str, word: &str) -> bool {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let starts_as_name = word.starts_with(is_name);
    let ends_as_name = word.ends_with(is_name);
    code.match_indices(word).any(|(at, _)| {
        let before = code[..at].chars().next_back();
        let after = code[at + word.len()..].chars().next();
        !(starts_as_name && before.is_some_and(is_name)
            || ends_as_name && after.is_some_and(is_name))
    })
}

#[test]
fn paths_in_documents_exist() {
    let mut missing = Vec::new();
    let documents = DOCUMENTS.map(str::to_owned).into_iter().chain(pages());
    for document in documents {
        let folder = Path::new(&document).parent().unwrap_or(Path::new(""));
        for path in named_paths(&prose(&read(&document))) {
            // A link is relative to its document, a name in backticks to the repository.
            if !ELSEWHERE.contains(&path.as_str())
                && !root().join(&path).exists()
                && !root().join(folder).join(&path).exists()
            {
                missing.push(format!("{document} names {path}, which does not exist"));
            }
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

#[test]
fn the_core_has_no_io_clock_thread_log_or_heap() {
    let mut found = Vec::new();
    for path in rust_files_below("crates/mechanics/src") {
        if path.to_string_lossy().ends_with("tests.rs") {
            continue;
        }
        let code = code_of(&read(&path));
        for (word, reason) in ABSENT_FROM_CORE {
            if contains_word(&code, word) {
                found.push(format!("{}: {word} ({reason})", path.display()));
            }
        }
        for name in SYSTEM_MATH {
            let calls = [format!(".{name}("), format!("f64::{name}")];
            if calls.iter().any(|call| contains_word(&code, call)) {
                let instead = "use the crate libm or a closed form";
                found.push(format!("{}: {name} ({instead})", path.display()));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_files_of_the_core_import_one_another_without_a_circle() {
    let mut imports: Vec<(String, String)> = rust_files_below("crates/mechanics/src")
        .iter()
        .map(|path| {
            let name = path.file_stem().unwrap().display().to_string();
            (name, code_of(&read(path)))
        })
        .filter(|(name, _)| name != "lib")
        .collect();
    // Files that import none of those left are taken away; a circle remains.
    loop {
        let names: Vec<String> = imports.iter().map(|(name, _)| name.clone()).collect();
        let before = imports.len();
        imports.retain(|(name, code)| {
            names.iter().any(|other| {
                let imported = ["super::", "super::{self, "].iter();
                let mut imported = imported.map(|start| format!("{start}{other}"));
                other != name && imported.any(|word| contains_word(code, &word))
            })
        });
        if imports.len() == before {
            assert!(names.is_empty(), "a circle among {names:?}");
            return;
        }
    }
}

#[test]
fn files_are_short() {
    let mut files = rust_files_below("src");
    files.extend(rust_files_below("crates"));
    for path in files {
        let lines = read(&path)
            .lines()
            .take_while(|line| *line != "#[cfg(test)]")
            .count();
        let longest = LONGER_FILES
            .iter()
            .find(|(longer, _)| path == Path::new(longer))
            .map_or(MAX_FILE, |(_, lines)| *lines);
        assert!(
            lines <= longest,
            "{}: {lines} lines; divide it at {longest}",
            path.display()
        );
    }
}

/// The first screen: input, output, decision, how to try it, and where to read on.
#[test]
fn the_readme_is_short() {
    let bytes = read("README.md").len();
    assert!(
        bytes <= 6_000,
        "README.md has {bytes} bytes; move what is not of the first screen to docs/guide.md"
    );
}

/// The guide to the ROS 2 node once had 48 kB, half of which described its behaviour in detail.
#[test]
fn the_guide_to_the_node_is_short() {
    let bytes = read("launch_notes.md").len();
    assert!(
        bytes <= 20_000,
        "launch_notes.md has {bytes} bytes; move what is no instruction to docs/node.md or docs/recordings.md"
    );
}

#[test]
fn nothing_is_left_to_do() {
    // In two halves, or this file would find itself.
    let marks = [
        concat!("TO", "DO"),
        concat!("FIX", "ME"),
        concat!("to", "do!"),
        concat!("unimple", "mented!"),
        concat!("TO BE ", "MEASURED"),
    ];
    let mut files: Vec<PathBuf> = ["src", "crates", "tests", "docs", "config", "msg", "srv"]
        .iter()
        .flat_map(|folder| files_below(folder))
        .collect();
    files.extend(pages().into_iter().map(PathBuf::from));
    files.push(".ci/run".into());
    for path in files {
        // Pictures are no text.
        let Ok(text) = fs::read_to_string(root().join(&path)) else {
            continue;
        };
        for mark in marks {
            assert!(!contains_word(&text, mark), "{}: {mark}", path.display());
        }
    }
}

#[test]
fn ci_runs_the_test_command_of_the_readme() {
    let ci = read(".ci/run");
    let command = ci
        .lines()
        .find_map(|line| line.strip_prefix("step 'tests' "))
        .expect("a line in .ci/run that begins with: step 'tests'");
    let readme = read("README.md");
    let code: Vec<&str> = readme.split("```").skip(1).step_by(2).collect();
    assert!(
        code.iter()
            .any(|block| block.lines().any(|line| line == command)),
        "README.md does not give the command of .ci/run: {command}"
    );
}

#[test]
fn these_tests_find_what_they_look_for() {
    assert!(contains_word("let x = vec![1];", "vec!"));
    assert!(contains_word("fn f() -> Vec<f64>", "Vec<"));
    assert!(!contains_word("Matrix4 and MyVec::new()", "Vec::"));
    assert!(!contains_word("struct Arch; StringLike", "Arc"));
    assert!(!contains_word("StringLike", "String"));
    assert_eq!(code_of("a // Vec::new\nb\n#[cfg(test)]\nc"), "a \nb\n");
    let text = "See `src/lib.rs`, `nowhere.rs`, `cargo test`, `a/b`, `src/*.rs` and [it](docs/x.md), [web](https://x.y).\n```\n`fenced.rs`\n```\n";
    assert_eq!(
        named_paths(&prose(text)),
        ["src/lib.rs", "nowhere.rs", "docs/x.md"]
    );
}
