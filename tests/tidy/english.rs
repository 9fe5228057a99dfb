//! The English of the documents for users: patterns that a native speaker reads twice are rare.

use super::{code_of, files_below, pages, prose, read};

/// Pages of the book that no user needs: the history, and the pages for developers.
const NOT_FOR_USERS: [&str; 4] = [
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "SECURITY.md",
];

/// Pages whose fenced text is prose: the comments of messages, the help, and docstrings.
const FENCED_PROSE: [&str; 3] = [
    "docs/messages.md",
    "docs/commands.md",
    "docs/python_reference.md",
];

/// Words that are rare, and the ones to write in their place.
struct Pattern {
    name: &'static str,
    words: &'static [&'static str],
    place: Place,
    /// Most occurrences in 1000 words of all documents together: a tenth of the number that a review once counted.
    per_thousand: f64,
    instead: &'static str,
}

/// Where the words of a pattern count.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Anywhere,
    /// At the beginning of a line, a cell or a sentence, or after a colon or semicolon.
    Beginning,
}

const PATTERNS: [Pattern; 6] = [
    Pattern {
        name: "a clause with \"what\" as a noun",
        words: &["what", "whatever"],
        place: Place::Anywhere,
        per_thousand: 0.3,
        instead: "name the thing: the readings, the cause, the contents, the limitations",
    },
    Pattern {
        name: "a thing that speaks or knows",
        words: &[
            "tell", "tells", "told", "say", "says", "said", "know", "knows", "lets",
        ],
        place: Place::Anywhere,
        per_thousand: 0.2,
        instead: "write: shows, states, reports, contains, does not include, allows",
    },
    Pattern {
        name: "a sentence that begins with \"of\"",
        words: &["of"],
        place: Place::Beginning,
        per_thousand: 0.05,
        instead: "begin with the subject",
    },
    Pattern {
        name: "a pronoun in the place of a noun",
        words: &["that of", "those of", "that it has", "that they have"],
        place: Place::Anywhere,
        per_thousand: 0.16,
        instead: "repeat the noun: the resistance of the column, not \"that of the column\"",
    },
    Pattern {
        name: "an obligation that is written as a fact",
        words: &["has to", "have to", "had to"],
        place: Place::Anywhere,
        per_thousand: 0.05,
        instead: "write \"must\" for a requirement, \"should\" for advice, the imperative for safety",
    },
    Pattern {
        name: "a dated adverb or preposition",
        words: &["beside", "at once", "whoever", "for ever", "all the same"],
        place: Place::Anywhere,
        per_thousand: 0.16,
        instead: "write: next to, in addition to, compared with; immediately, together; anyone who",
    },
];

/// A line without the contents of its inline code, in small letters.
fn without_code(line: &str) -> String {
    let parts: Vec<_> = line.split('`').step_by(2).collect();
    parts.join("x").to_lowercase()
}

/// Whether `before`, the text up to a word, ends where a sentence or a cell begins.
fn is_beginning(before: &str) -> bool {
    let before = before.trim_end_matches([' ', '*', '_', '"']);
    let before = before.trim_start_matches([' ', '-', '#']);
    before.is_empty() || before.ends_with(['.', ':', ';', '|'])
}

/// The line, or without its first word if that is a small "of": the line then continues a sentence.
fn without_continuation(line: &str) -> String {
    let start = line.trim_start_matches(|it: char| !it.is_alphanumeric());
    match start.starts_with("of ") {
        true => start.replacen("of", "x", 1),
        false => line.to_owned(),
    }
}

/// How often a pattern occurs in a line that has no code.
fn occurrences(line: &str, pattern: &Pattern) -> usize {
    let is_letter = |it: char| it.is_alphanumeric() || it == '-';
    let count = |words: &str| {
        line.match_indices(words)
            .filter(|(at, _)| {
                let [before, after] = [&line[..*at], &line[at + words.len()..]];
                !before.ends_with(is_letter)
                    && !after.starts_with(is_letter)
                    && (pattern.place == Place::Anywhere || is_beginning(before))
            })
            .count()
    };
    pattern.words.iter().map(|words| count(words)).sum()
}

/// The text of a document with as many lines as its file: those of fenced code are empty.
fn lines_without_code(text: &str) -> Vec<String> {
    let mut is_fenced = false;
    text.lines()
        .map(|line| {
            let is_fence = line.trim_start().starts_with("```");
            is_fenced ^= is_fence;
            match is_fenced || is_fence {
                true => String::new(),
                false => without_code(&without_continuation(line)),
            }
        })
        .collect()
}

#[test]
fn documents_for_users_avoid_patterns_that_need_a_second_reading() {
    let documents: Vec<_> = pages()
        .into_iter()
        .filter(|path| !NOT_FOR_USERS.contains(&path.as_str()))
        .map(|path| match FENCED_PROSE.contains(&path.as_str()) {
            true => (read(&path).replace("```", ""), path),
            false => (read(&path), path),
        })
        .collect();
    let words: usize = documents
        .iter()
        .map(|(text, _)| prose(text).split_whitespace().count())
        .sum();
    assert!(words > 20_000, "{words} words");
    let mut faults = Vec::new();
    for pattern in &PATTERNS {
        let mut places = Vec::new();
        for (text, path) in &documents {
            let lines = lines_without_code(text);
            for (line, number) in lines.iter().zip(1..) {
                let found = occurrences(line, pattern);
                places.extend((0..found).map(|_| format!("  {path}:{number}")));
            }
        }
        let most = (pattern.per_thousand * words as f64 / 1000.0) as usize;
        if places.len() > most {
            faults.push(format!(
                "{} ({}): {} times in {words} words, at most {most}; {}\n{}",
                pattern.name,
                pattern.words.join(", "),
                places.len(),
                pattern.instead,
                places.join("\n")
            ));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The texts in the code of a source file: errors, log, output and report.
fn texts_in(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut rest = code;
    while let Some((_, after)) = rest.split_once('"') {
        let mut escaped = false;
        let is_end = |it: char| {
            let ends = it == '"' && !escaped;
            escaped = it == '\\' && !escaped;
            ends
        };
        let Some(end) = after.find(is_end) else { break };
        // A backslash at the end of a line continues the text.
        let lines: Vec<_> = after[..end].split("\\\n").map(str::trim_start).collect();
        found.push(lines.concat());
        rest = &after[end + 1..];
    }
    // Fewer words are names.
    found.retain(|text| text.split_whitespace().count() > 3);
    found
}

/// Most occurrences of each pattern in 1000 words of errors, log, output and report: as many as there were when they were last
/// edited. The patterns are those of `PATTERNS`, in their order.
const PER_THOUSAND_IN_TEXTS: [f64; PATTERNS.len()] = [0.9, 0.2, 0.6, 0.5, 0.15, 0.1];

#[test]
fn errors_logs_and_outputs_avoid_them_too() {
    let mut files = files_below("src");
    files.extend(files_below("crates"));
    files.retain(|path| {
        let text = path.to_string_lossy();
        text.ends_with(".rs")
            && text.contains("src/")
            && !text.contains("tests")
            && !text.contains("figures/validation/")
    });
    let texts: Vec<_> = files
        .iter()
        .flat_map(|path| {
            texts_in(&code_of(&read(path)))
                .into_iter()
                .map(move |it| (path, it.to_lowercase()))
        })
        .collect();
    let words: usize = texts
        .iter()
        .map(|(_, text)| text.split_whitespace().count())
        .sum();
    assert!(words > 20_000, "{words} words");
    for (pattern, per_thousand) in PATTERNS.iter().zip(PER_THOUSAND_IN_TEXTS) {
        let places: Vec<_> = texts
            .iter()
            .filter(|(_, text)| occurrences(text, pattern) > 0)
            .map(|(path, text)| format!("  {}: {text}", path.display()))
            .collect();
        let most = (per_thousand * words as f64 / 1000.0) as usize;
        println!(
            "{}: {} in {words} words, at most {most}",
            pattern.name,
            places.len()
        );
        assert!(
            places.len() <= most,
            "{} ({}): {} texts of {words} words, at most {most}; {}\n{}",
            pattern.name,
            pattern.words.join(", "),
            places.len(),
            pattern.instead,
            places.join("\n")
        );
    }
}

#[test]
fn texts_are_found_with_their_continuations() {
    let code = "f(\"one two three \\\n   four\", \"a \\\"quoted\\\" word here\", \"short\")";
    assert_eq!(
        texts_in(code),
        ["one two three four", "a \\\"quoted\\\" word here"]
    );
}

#[test]
fn patterns_are_found_in_prose_and_not_in_code() {
    let found = |line: &str| {
        let line = without_code(line);
        PATTERNS.each_ref().map(|it| occurrences(&line, it))
    };
    assert_eq!(
        found("What it says is that of `what says`."),
        [1, 1, 0, 1, 0, 0]
    );
    assert_eq!(
        found("- Of two, one stays. Of three, it has to go at once."),
        [0, 0, 2, 0, 1, 1]
    );
    assert_eq!(
        found("a pair of somewhat unknown besides"),
        [0, 0, 0, 0, 0, 0]
    );
    assert_eq!(lines_without_code("- of two\nOf two"), ["x two", "of two"]);
    assert_eq!(
        lines_without_code("a\n```\nwhat\n```\nb"),
        ["a", "", "", "", "b"]
    );
}
