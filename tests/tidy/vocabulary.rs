//! Words that version 0.2 used, and that nothing says any more: neither code, messages, parameters, JSON, Python nor documents.
//! CHANGELOG.md tells what became of them; reference data keep their words.

use std::fs;
use std::path::{Path, PathBuf};

/// A word that must not come back, as whole words or as a part of one, and the one to use.
const BANNED: [(&str, Whole, &str); 24] = [
    ("percussion", Whole::Part, "impact impulse"),
    ("virgin", Whole::Part, "undamaged"),
    ("severed", Whole::Part, "fractured"),
    ("torn", Whole::Word, "fractured"),
    ("severit", Whole::Part, "action"),
    ("PROP", Whole::Word, "SHORE"),
    ("SEVERITY", Whole::Part, "ACTION"),
    ("felt", Whole::Word, "detected"),
    ("feels", Whole::Word, "detects"),
    ("refuse", Whole::Part, "reject"),
    ("refusal", Whole::Part, "rejection"),
    ("REFUSED", Whole::Part, "REJECTED"),
    ("screening", Whole::Part, "evaluation"),
    ("SCREENING", Whole::Part, "EVALUATION"),
    ("screen_batch", Whole::Part, "evaluate_batch"),
    ("calibrate\"", Whole::Part, "correct_damage"),
    ("~/calibrate", Whole::Part, "~/correct_damage"),
    ("srv/Calibrate", Whole::Part, "srv/CorrectDamage"),
    ("foreseen", Whole::Part, "predicted"),
    ("largest displacement", Whole::Word, "peak displacement"),
    ("largest v1", Whole::Word, "peak v1"),
    ("peak of v1", Whole::Word, "peak v1"),
    ("compliant", Whole::Part, "deformable"),
    ("remaining_capacity", Whole::Part, "residual_capacity"),
];

/// Whether a word is banned where it stands alone, or also as a part of a longer one.
#[derive(Clone, Copy, PartialEq)]
enum Whole {
    Word,
    Part,
}

/// Where a banned word may stand: the code of others, definitions of ROS 2, the history, this list, and reference data.
const EXEMPT: [&str; 6] = [
    "vendor",
    "CHANGELOG.md",
    "msg/deps",
    "tests/tidy/vocabulary.rs",
    "tests/data",
    "target",
];

/// Lines that may contain one, with the reason in the line itself.
fn is_exempt_line(line: &str) -> bool {
    // Keys of reference data, strides of a grid, and errors of the operating system.
    line.contains("row_stride")
        || line.to_lowercase().contains("connection refused")
        || line.contains("Nu_virgin")
}

fn texts(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let relative = path.strip_prefix("./").unwrap_or(&path);
        let name = relative
            .file_name()
            .and_then(|it| it.to_str())
            .unwrap_or_default();
        let is_data = relative.components().any(|it| it.as_os_str() == "data");
        if name.starts_with('.') || is_data || EXEMPT.iter().any(|it| relative == Path::new(it)) {
            continue;
        }
        if path.is_dir() {
            texts(&path, found);
        } else if [
            "rs", "md", "py", "pyi", "msg", "srv", "yaml", "json", "json5", "xml", "ipynb", "js",
            "sh", "toml",
        ]
        .iter()
        .any(|it| relative.extension().is_some_and(|ending| ending == *it))
        {
            found.push(path);
        }
    }
}

fn contains(line: &str, word: &str, whole: Whole) -> bool {
    line.match_indices(word).any(|(at, _)| {
        let is_letter = |it: char| it.is_alphanumeric() || it == '_';
        let before = line[..at].chars().next_back().is_some_and(is_letter);
        let after = line[at + word.len()..]
            .chars()
            .next()
            .is_some_and(is_letter);
        whole == Whole::Part || (!before && !after)
    })
}

#[test]
fn words_of_version_0_2_do_not_come_back() {
    let mut paths = Vec::new();
    texts(Path::new("."), &mut paths);
    assert!(paths.len() > 400, "{} files", paths.len());
    let mut faults = Vec::new();
    for path in paths {
        let text = fs::read_to_string(&path).unwrap_or_default();
        for (number, line) in text
            .lines()
            .enumerate()
            .filter(|(_, line)| !is_exempt_line(line))
        {
            for (word, whole, instead) in BANNED {
                if contains(line, word, whole) {
                    let place = path.display();
                    faults.push(format!(
                        "{place}:{}: {word}; the word is {instead}",
                        number + 1
                    ));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
