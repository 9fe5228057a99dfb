//! The lists of files at the head of each `mod.rs` and `lib.rs`, and the lists in `ARCHITECTURE.md` that follow from the code.
//! `UPDATE_DOCS=1 cargo test --test tidy` writes all of them.

use std::fs;
use std::path::{Path, PathBuf};

use super::walls::ROOMS;
use super::{files_below, read, root};

/// The line with which the list of a folder begins.
const MARK: &str = "// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):";

/// The map. Its tables stand between the marks `<!-- NAME -->` and `<!-- end of NAME -->`.
const ARCHITECTURE: &str = "ARCHITECTURE.md";

/// Whether this run writes what it would otherwise compare.
fn updates() -> bool {
    std::env::var_os("UPDATE_DOCS").is_some()
}

/// The first sentence of the documentation with which a file begins.
fn first_sentence(source: &str) -> String {
    let paragraph: Vec<&str> = source
        .lines()
        .take_while(|line| line.starts_with("//!"))
        .map(|line| line.trim_start_matches("//!").trim())
        .take_while(|line| !line.is_empty())
        .collect();
    let paragraph = paragraph.join(" ");
    let end = paragraph.find(". ").unwrap_or(paragraph.len());
    paragraph[..end].trim_end_matches('.').to_owned()
}

/// The `mod.rs` and `lib.rs` of the program and of the crates.
fn heads() -> Vec<PathBuf> {
    let mut files = files_below("src");
    files.extend(files_below("crates").into_iter().filter(|path| {
        path.components()
            .nth(2)
            .is_some_and(|it| it.as_os_str() == "src")
    }));
    files.retain(|path| path.ends_with("mod.rs") || path.ends_with("lib.rs"));
    assert!(files.len() > 30, "{files:?}");
    files
}

/// What a folder holds besides its head and tests: each file or folder with the first sentence of its documentation.
fn entries(head: &Path) -> Vec<(String, String)> {
    let folder = head.parent().expect("a file is in a folder");
    let mut found = Vec::new();
    for entry in fs::read_dir(root().join(folder)).expect("the folder of a head") {
        let name = entry.expect("an entry").file_name();
        let name = name.to_string_lossy().into_owned();
        let path = folder.join(&name);
        let (name, documented) = if root().join(&path).is_dir() {
            (format!("{name}/"), path.join("mod.rs"))
        } else if name.ends_with(".rs") && !name.ends_with("tests.rs") && path != head {
            (name, path)
        } else {
            continue;
        };
        if root().join(&documented).exists() {
            found.push((name, first_sentence(&read(&documented))));
        }
    }
    found.sort();
    found
}

/// The list of a folder as comment lines, each at most 128 characters long.
fn list(entries: &[(String, String)]) -> String {
    let mut text = format!("{MARK}\n//\n");
    for (name, sentence) in entries {
        let mut line = format!("// - {name}:");
        for word in sentence.split(' ') {
            if line.chars().count() + 1 + word.chars().count() > 128 {
                text += &line;
                text.push('\n');
                line = "//  ".to_owned();
            }
            line.push(' ');
            line += word;
        }
        text += &line;
        text.push('\n');
    }
    text
}

/// `source` with `list` in place of the list that it has, or behind its documentation.
fn with_list(source: &str, list: &str) -> String {
    let lines: Vec<&str> = source.lines().collect();
    let (from, to) = match lines.iter().position(|line| *line == MARK) {
        Some(from) => {
            let length = lines[from..]
                .iter()
                .take_while(|line| line.starts_with("//"))
                .count();
            (from, from + length)
        }
        None => {
            let documented = lines
                .iter()
                .take_while(|line| line.starts_with("//!") || line.starts_with("#!["))
                .count();
            (documented, documented)
        }
    };
    let before = lines[..from].join("\n");
    let after = lines[to..].join("\n");
    let before = before.trim_end();
    let gap = if before.is_empty() { "" } else { "\n\n" };
    format!("{before}{gap}{list}\n{}\n", after.trim())
}

#[test]
fn every_folder_begins_with_the_list_of_its_files() {
    let mut faults = Vec::new();
    for head in heads() {
        let entries = entries(&head);
        if entries.is_empty() {
            continue;
        }
        for (name, sentence) in &entries {
            if sentence.is_empty() {
                faults.push(format!(
                    "{}: {name} does not begin with a sentence that says what it holds",
                    head.display()
                ));
            }
        }
        let source = read(&head);
        let expected = with_list(&source, &list(&entries));
        if updates() {
            fs::write(root().join(&head), expected).expect("the file can be written");
        } else if source != expected {
            faults.push(format!(
                "{}: the list of its files differs from them; update it with UPDATE_DOCS=1 cargo test --test tidy",
                head.display()
            ));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The table of the rooms as Markdown.
fn rooms() -> String {
    let mut text =
        "| room | what it owns | may import | must not know |\n|---|---|---|---|\n".to_owned();
    for room in ROOMS {
        let imports = match room.may_import {
            [] => "nothing".to_owned(),
            rooms => rooms.join(", "),
        };
        text += &format!(
            "| {} | {} | {imports} | {} |\n",
            room.name, room.owns, room.must_not_know
        );
    }
    text
}

/// A way to extend the program, by an example that exists: its identifiers occur in the files that have to change.
struct Recipe {
    /// What is added.
    task: &'static str,
    /// The example.
    example: &'static str,
    /// How its names are written in the code.
    names: &'static [&'static str],
    /// What else has to be done, for a reader.
    besides: &'static str,
}

const RECIPES: [Recipe; 5] = [
    Recipe {
        task: "a parameter",
        example: "`assessment.range_front`",
        names: &["assessment.range_front", "range_front"],
        besides: "`docs/parameters.md` is generated; `src/assessment/` and `src/study/` are where this one is used",
    },
    Recipe {
        task: "a criterion",
        example: "`residual_bow_250`",
        names: &["residual_bow_250"],
        besides: "`docs/assessment.md`",
    },
    Recipe {
        task: "a quantity that sensors measure",
        example: "`axial_strain`",
        names: &["AxialStrain", "axial_strain"],
        besides: "`msg/Measurement.msg` and `docs/estimation.md` list the quantities",
    },
    Recipe {
        task: "a topic",
        example: "`joint_states`",
        names: &["JOINT_STATES", "joint_states", "JointState"],
        besides: "the definition of the message, in `msg/`, and its row in launch_notes.md",
    },
    Recipe {
        task: "a column of the history",
        example: "`base_normal_force_N`",
        names: &["BASE_NORMAL_FORCE"],
        besides: "`crates/mechanics/src/sample.rs`, where the mechanics show the quantity",
    },
];

/// The source files, without tests, that contain a name of the recipe.
fn files_with(names: &[&str]) -> Vec<String> {
    let mut files = files_below("src");
    files.extend(files_below("crates"));
    files.retain(|path| {
        let text = path.to_string_lossy();
        text.ends_with(".rs") && !text.contains("/tests/") && !text.ends_with("tests.rs")
    });
    files
        .iter()
        .filter(|path| {
            let code = super::code_of(&read(path));
            names.iter().any(|name| super::contains_word(&code, name))
        })
        .map(|path| path.display().to_string())
        .collect()
}

fn recipes() -> String {
    let mut text =
        "| add | as it is done for | in these files | and |\n|---|---|---|---|\n".to_owned();
    for recipe in &RECIPES {
        let files = files_with(recipe.names);
        assert!(!files.is_empty(), "no file contains {:?}", recipe.names);
        text += &format!(
            "| {} | {} | `{}` | {} |\n",
            recipe.task,
            recipe.example,
            files.join("`, `"),
            recipe.besides
        );
    }
    text
}

#[test]
fn the_map_shows_the_rooms_and_the_ways_to_extend_them_as_they_are() {
    let mut text = read(ARCHITECTURE);
    for (name, expected) in [("rooms", rooms()), ("recipes", recipes())] {
        let (begin, end) = (
            format!("<!-- {name} -->\n"),
            format!("<!-- end of {name} -->"),
        );
        let from = text.find(&begin).expect("the mark of the table") + begin.len();
        let to = text.find(&end).expect("the mark of its end");
        if updates() {
            text.replace_range(from..to, &expected);
        } else {
            assert!(
                text[from..to] == expected,
                "the table of {name} in {ARCHITECTURE} is not that of the code; update it with\n    UPDATE_DOCS=1 cargo test \
                 --test tidy"
            );
        }
    }
    if updates() {
        fs::write(root().join(ARCHITECTURE), text).expect("the map can be written");
    }
}

#[test]
fn the_map_is_short() {
    let lines = read(ARCHITECTURE).lines().count();
    assert!((150..=200).contains(&lines), "{lines} lines");
}
