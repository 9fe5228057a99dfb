//! YAML text as a tree that knows the place of every node, keeps duplicate keys and bounds its own depth.

use std::borrow::Cow;
use std::ops::Range;

use saphyr::{Scalar, ScalarStyle, Tag};
use saphyr_parser::{Event, Marker, Parser, Span};

use super::value::Value;

/// Maximum depth of nesting; ROS 2 parameter files need about five levels.
const MAX_DEPTH: usize = 32;

/// A place in the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Location {
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
    /// Range of bytes in the text.
    pub bytes: Range<usize>,
}

/// A node of the document.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct YamlNode {
    pub at: Location,
    pub content: YamlContent,
}

/// YamlContent of a node.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum YamlContent {
    /// Nothing, or `null`.
    Null,
    Scalar {
        value: Value,
        /// As it was typed, without quotes.
        text: String,
    },
    List(Vec<YamlNode>),
    /// In the order of the text, duplicates included.
    Mapping(Vec<(YamlKey, YamlNode)>),
}

/// A key of a mapping.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct YamlKey {
    pub at: Location,
    pub text: String,
}

/// Why a text is not a document.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SyntaxError {
    pub at: Location,
    pub message: String,
}

/// The single document of a text; `None` if the text is empty.
pub(super) fn parse(text: &str) -> Result<Option<YamlNode>, SyntaxError> {
    let offsets = Offsets::of(text);
    let mut parser = Parser::new_from_str(text);
    let mut builder = Builder::default();
    loop {
        let Some(event) = parser.next_event() else {
            return Ok(builder.root);
        };
        let (event, span) = event.map_err(|error| SyntaxError {
            at: offsets.locate(Span::empty(*error.marker())),
            message: format!("not valid YAML: {}{}", error.info(), builder.unclosed(text)),
        })?;
        let at = offsets.locate(span);
        if matches!(event, Event::StreamEnd) {
            return Ok(builder.root);
        }
        builder
            .take(event, at.clone())
            .map_err(|message| SyntaxError { at, message })?;
    }
}

/// Builds the tree from the parser's events.
#[derive(Default)]
struct Builder {
    /// Collections that are still open, innermost last.
    open: Vec<Open>,
    root: Option<YamlNode>,
    documents: usize,
}

enum Open {
    List {
        at: Location,
        elements: Vec<YamlNode>,
    },
    Mapping {
        at: Location,
        entries: Vec<(YamlKey, YamlNode)>,
        key: Option<YamlKey>,
    },
}

impl Builder {
    fn take(&mut self, event: Event<'_>, at: Location) -> Result<(), String> {
        match event {
            Event::DocumentStart(_) => {
                self.documents += 1;
                if self.documents > 1 {
                    return Err(
                        "a second document, but a parameter file has only one; remove the `---`"
                            .to_owned(),
                    );
                }
                Ok(())
            }
            Event::Scalar(text, style, _, tag) => {
                self.insert(scalar(text, style, tag.as_ref(), at)?)
            }
            Event::SequenceStart(..) => self.open(Open::List {
                at,
                elements: Vec::new(),
            }),
            Event::MappingStart(..) => self.open(Open::Mapping {
                at,
                entries: Vec::new(),
                key: None,
            }),
            Event::SequenceEnd | Event::MappingEnd => self.close(),
            Event::Alias(_) => Err(
                "aliases (`*name`) are not supported in ROS parameter files; write the value itself".to_owned(),
            ),
            Event::Nothing | Event::StreamStart | Event::StreamEnd | Event::DocumentEnd => Ok(()),
        }
    }

    fn open(&mut self, collection: Open) -> Result<(), String> {
        if self.open.len() == MAX_DEPTH {
            return Err(format!("nested more than {MAX_DEPTH} levels deep"));
        }
        self.open.push(collection);
        Ok(())
    }

    /// What to add to a syntax error inside brackets: where they begin.
    fn unclosed(&self, text: &str) -> String {
        let at = match self.open.last() {
            Some(Open::List { at, .. } | Open::Mapping { at, .. }) => at,
            None => return String::new(),
        };
        let (bracket, closing) = match text.get(at.bytes.start..).and_then(|it| it.chars().next()) {
            Some('[') => ('[', ']'),
            Some('{') => ('{', '}'),
            _ => return String::new(),
        };
        let (line, column) = (at.line, at.column);
        format!("; the `{bracket}` of line {line}, column {column} needs a `{closing}`")
    }

    fn close(&mut self) -> Result<(), String> {
        match self.open.pop() {
            Some(Open::List { at, elements }) => self.insert(YamlNode {
                at,
                content: YamlContent::List(elements),
            }),
            Some(Open::Mapping { at, entries, .. }) => self.insert(YamlNode {
                at,
                content: YamlContent::Mapping(entries),
            }),
            None => Err("an end without a beginning".to_owned()),
        }
    }

    fn insert(&mut self, node: YamlNode) -> Result<(), String> {
        match self.open.last_mut() {
            None => self.root = Some(node),
            Some(Open::List { elements, .. }) => elements.push(node),
            Some(Open::Mapping { entries, key, .. }) => match key.take() {
                Some(key) => entries.push((key, node)),
                None => *key = Some(as_key(node)?),
            },
        }
        Ok(())
    }
}

fn as_key(node: YamlNode) -> Result<YamlKey, String> {
    match node.content {
        YamlContent::Scalar { text, .. } => Ok(YamlKey { at: node.at, text }),
        YamlContent::Null => Err("a key is missing before the colon".to_owned()),
        YamlContent::List(_) | YamlContent::Mapping(_) => {
            Err("a key must be a plain name".to_owned())
        }
    }
}

fn scalar(
    text: Cow<'_, str>,
    style: ScalarStyle,
    tag: Option<&Cow<'_, Tag>>,
    at: Location,
) -> Result<YamlNode, String> {
    let typed = text.clone().into_owned();
    let value = match Scalar::parse_from_cow_and_metadata(text, style, tag) {
        None => return Err(format!("`{typed}` does not match its tag; omit the tag")),
        Some(Scalar::Null) => {
            let content = YamlContent::Null;
            return Ok(YamlNode { at, content });
        }
        Some(Scalar::Boolean(value)) => Value::Bool(value),
        Some(Scalar::Integer(value)) => Value::Integer(value),
        Some(Scalar::FloatingPoint(value)) => Value::Double(value.0),
        Some(Scalar::String(value)) => Value::String(value.into_owned()),
    };
    let content = YamlContent::Scalar { value, text: typed };
    Ok(YamlNode { at, content })
}

/// Converts the parser's character counts into the lines, columns and bytes of editors and reports.
struct Offsets {
    /// Byte offset of every character, followed by the length of the text.
    bytes: Vec<usize>,
}

impl Offsets {
    fn of(text: &str) -> Self {
        Self {
            bytes: text
                .char_indices()
                .map(|(offset, _)| offset)
                .chain([text.len()])
                .collect(),
        }
    }

    fn locate(&self, span: Span) -> Location {
        let start = self.byte(span.start);
        Location {
            line: span.start.line(),
            column: span.start.col() + 1,
            bytes: start..self.byte(span.end).max(start),
        }
    }

    fn byte(&self, marker: Marker) -> usize {
        let end = self.bytes.last().copied().unwrap_or(0);
        self.bytes.get(marker.index()).copied().unwrap_or(end)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn entries(text: &str) -> Vec<(YamlKey, YamlNode)> {
        match parse(text).expect("valid").expect("not empty").content {
            YamlContent::Mapping(entries) => entries,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn places_are_right_beyond_ascii() {
        let text = "# Stütze – 1 €\r\nä: \"ö\"\nlänge: 3.5 # m\n";
        let entries = entries(text);
        let (key, value) = &entries[1];
        assert_eq!((key.at.line, key.at.column), (3, 1));
        assert_eq!(&text[key.at.bytes.clone()], "länge");
        assert_eq!((value.at.line, value.at.column), (3, 8));
        assert_eq!(&text[value.at.bytes.clone()], "3.5");
        assert_eq!(&text[entries[0].1.at.bytes.clone()], "\"ö\"");
    }

    #[test]
    fn scalars_have_the_types_of_yaml() {
        let kinds: Vec<_> = entries(
            "{a: 10, b: 1e1, c: '10', d: true, e: off, f: .nan, g: ~, h: [1, {a: 2}], i: }",
        )
        .into_iter()
        .map(|(_, node)| match node.content {
            YamlContent::Scalar { value, .. } => format!("{:?}", value.kind()),
            YamlContent::Null => "Null".to_owned(),
            YamlContent::List(elements) => format!("List of {}", elements.len()),
            YamlContent::Mapping(_) => "Mapping".to_owned(),
        })
        .collect();
        assert_eq!(
            kinds,
            [
                "Integer",
                "Double",
                "String",
                "Bool",
                "String",
                "Double",
                "Null",
                "List of 2",
                "Null"
            ]
        );
    }

    #[test]
    fn duplicates_are_kept() {
        assert_eq!(entries("a: 1\nb: 2\na: 3\n").len(), 3);
    }

    #[test]
    fn an_empty_text_is_no_document() {
        for text in ["", "\n\n", "# only a comment\n"] {
            assert_eq!(parse(text), Ok(None), "{text:?}");
        }
    }

    #[test]
    fn errors_have_their_place() {
        for (text, line, words) in [
            ("a: 1\nb: [1, 2\n", 3, "not valid YAML"),
            ("a: 1\nb: '2\n", 2, "not valid YAML"),
            ("a: &x 1\nb: *x\n", 2, "aliases"),
            ("a: 1\n---\nb: 2\n", 2, "second document"),
            ("[1, 2]: 3\n", 1, "plain name"),
            ("a: !!int x\n", 1, "tag"),
        ] {
            let error = parse(text).expect_err(text);
            assert_eq!(error.at.line, line, "{text:?} {error:?}");
            assert!(error.message.contains(words), "{text:?} {error:?}");
        }
    }

    #[test]
    fn an_unclosed_bracket_is_named_with_its_place() {
        for (text, words) in [
            (
                "a: 1\nb: [1, 2\n",
                "; the `[` of line 2, column 4 needs a `]`",
            ),
            (
                "a: {b: [1], c: 2\nd: 3\n",
                "; the `{` of line 1, column 4 needs a `}`",
            ),
            ("[1", "; the `[` of line 1, column 1 needs a `]`"),
        ] {
            let error = parse(text).expect_err(text);
            assert!(error.message.ends_with(words), "{text:?} {error:?}");
        }
        let error = parse("a: 'b\n").expect_err("a quote");
        assert!(!error.message.contains("needs a"), "{error:?}");
    }

    #[test]
    fn nesting_is_bounded() {
        for text in [
            "[".repeat(500_000),
            "{a: ".repeat(200_000),
            "- ".repeat(400_000),
        ] {
            assert!(parse(&text).is_err());
        }
        let steps: String = (0..600)
            .map(|depth| format!("{}a:\n", " ".repeat(depth)))
            .collect();
        assert!(parse(&steps).is_err_and(|error| error.message.contains("nested")));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn no_text_panics(characters in prop::collection::vec(any::<char>(), 0..60)) {
            let _ = parse(&characters.into_iter().collect::<String>());
        }

        #[test]
        fn no_text_made_of_yaml_panics(
            parts in prop::collection::vec(
                prop::sample::select(vec![
                    "a", "b: ", ": ", "- ", "\n", "\n  ", "\n    ", "[", "]", "{", "}", ", ", "&x ", "*x", "!t ", "!!int ",
                    "'", "\"", "|", ">", "?", "? ", "#", " #", "---\n", "...\n", "%YAML 1.2\n", "\\", "\t", "\r", "~",
                    ".nan", "1e9", "0x1", "<<", "@", "`", "\u{feff}", "\u{85}", "ä", "|2-\n", ">+\n", "\0",
                ]),
                0..40,
            )
        ) {
            let text = parts.concat();
            if let Err(error) = parse(&text) {
                prop_assert!(text.get(error.at.bytes.clone()).is_some(), "{error:?}");
            }
        }
    }
}
