//! Faults in given parameters: what is wrong, where, and what is admissible.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};

use super::yaml::Location;
use printable::{Printable, is_printable};

/// One fault. `Display` is one line with place, name, value and what is admissible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{place}{}{problem}", Subject(.name.as_deref(), .value.as_deref()))]
pub struct Fault {
    /// The parameter, or the unknown name as written; `None` for a fault of a whole file.
    pub name: Option<String>,
    /// The value as written, of an array the element; `None` if the fault is not in a value.
    pub value: Option<String>,
    /// Where it was given.
    pub place: Origin,
    /// What is wrong.
    pub problem: Problem,
}

/// Where a value was given.
#[derive(Debug, Clone, PartialEq)]
pub enum Origin {
    /// In a parameter file.
    File {
        /// As the user wrote it.
        path: PathBuf,
        /// Line and column, from 1; `None` if the file could not be read.
        position: Option<(usize, usize)>,
        /// The bytes concerned and the file's text, for reports that show them.
        excerpt: Option<Excerpt>,
    },
    /// On the command line, in this argument: `-p name:=value` or a flag with its value.
    CommandLine(String),
    /// By a program or a service call, or as a default.
    Direct,
}

/// A part of a file's text.
#[derive(Clone, PartialEq)]
pub struct Excerpt {
    /// The whole text.
    pub text: Arc<str>,
    /// The bytes concerned.
    pub bytes: std::ops::Range<usize>,
}

/// What is wrong, and what is admissible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The file cannot be read.
    #[error("cannot be read: {0}; check the path and its permissions")]
    Unreadable(String),
    /// The text is not a parameter file.
    #[error("{0}")]
    Syntax(String),
    /// No parameter has this name.
    #[error("is not a parameter{}", Suggestion(.nearest, "; docs/parameters.md lists all parameters"))]
    UnknownName {
        /// Names with a similar spelling, closest first.
        nearest: Vec<String>,
    },
    /// A parameter of a sensor that is not declared.
    #[error(
        "is given, but sensors.names does not contain {}{}{}",
        Shortened(.sensor),
        Suggestion(.nearest, ""),
        Known(.known.as_deref())
    )]
    UnknownSensor {
        /// The sensor, as written.
        sensor: String,
        /// Sensors with a similar name.
        nearest: Vec<String>,
        /// All sensors that are declared; `None` where enough faults have listed them.
        known: Option<Vec<String>>,
    },
    /// No parameter of this node has this name, which was given for any node: a warning, not a fault.
    #[error(
        "is not a parameter of this node and has no effect on it{}",
        Suggestion(.nearest, "")
    )]
    OfAnotherNode {
        /// Names with a similar spelling, closest first.
        nearest: Vec<String>,
    },
    /// Further names as in [`OfAnotherNode`](Self::OfAnotherNode): a warning, not a fault.
    #[error("{count} more names in sections for any node are not parameters of this node")]
    MoreOfOtherNodes {
        /// How many.
        count: usize,
    },
    /// The name is that of a group of parameters.
    #[error("is a group of parameters, not a parameter; it contains {}", .members.join(", "))]
    Group {
        /// The parameters of the group.
        members: Vec<String>,
    },
    /// The same name is given twice in one place.
    #[error("is given a second time; the first is in line {first_line}; remove one of the two")]
    Duplicate {
        /// Line of the first, from 1.
        first_line: usize,
    },
    /// The name has no value.
    #[error("has no value; allowed: {expected}")]
    NoValue {
        /// What is admissible.
        expected: String,
    },
    /// The value has the wrong type.
    #[error("is {found}; allowed: {expected}")]
    WrongType {
        /// Description of the value.
        found: String,
        /// What is admissible.
        expected: String,
    },
    /// The value is not a finite number.
    #[error("is not a finite number; allowed: {expected}")]
    NotFinite {
        /// What is admissible.
        expected: String,
    },
    /// The array has too few or too many elements.
    #[error("has {found} elements; allowed: {expected}")]
    WrongLength {
        /// Number of elements.
        found: usize,
        /// What is admissible.
        expected: String,
    },
    /// An element of an array is wrong.
    #[error("(element {number}) {problem}")]
    Element {
        /// Number of the element, from 1.
        number: usize,
        /// What is wrong with it.
        problem: Box<Problem>,
    },
    /// The value is outside its range.
    #[error("is out of range; allowed: {expected}")]
    OutOfRange {
        /// What is admissible.
        expected: String,
    },
    /// The duration is not a whole number of nanoseconds.
    #[error("is not a whole number of nanoseconds; the nearest is {nearest}")]
    NotWholeNanoseconds {
        /// The closest admissible duration \[s\].
        nearest: String,
    },
    /// The string is too short or too long, or contains characters that are not admissible.
    #[error("is not a valid string; allowed: {expected}")]
    InvalidText {
        /// What is admissible.
        expected: String,
    },
    /// The value is not one of the known words.
    #[error("is not known{}; allowed: {expected}", Suggestion(.nearest, ""))]
    UnknownWord {
        /// Words with a similar spelling, closest first.
        nearest: Vec<String>,
        /// What is admissible.
        expected: String,
    },
    /// The value is deprecated: a warning, not a fault.
    #[error("is deprecated; write {replacement}")]
    Deprecated {
        /// The value that replaces it.
        replacement: &'static str,
    },
    /// The value is admissible, and nobody can have meant it: a warning, not a fault.
    #[error("{0}")]
    Implausible(String),
    /// The parameter is not compatible with another one, or requires one that is missing.
    #[error("{0}")]
    Inconsistent(String),
}

struct Subject<'a>(Option<&'a str>, Option<&'a str>);

impl fmt::Display for Subject<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self(Some(name), Some(value)) => {
                write!(f, "{}: `{}` ", Shortened(name), Shortened(value))
            }
            Self(Some(name), None) => write!(f, "{} ", Shortened(name)),
            Self(None, _) => Ok(()),
        }
    }
}

/// A name or value that the user wrote, on one line of bounded length.
struct Shortened<'a>(&'a str);

impl fmt::Display for Shortened<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const MAX_CHARS: usize = 60;
        match self.0.char_indices().nth(MAX_CHARS) {
            Some((end, _)) => write!(f, "{}...", Printable(&self.0[..end])),
            None => write!(f, "{}", Printable(self.0)),
        }
    }
}

struct Suggestion<'a>(&'a [String], &'static str);

impl fmt::Display for Suggestion<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            [] => f.write_str(self.1),
            [one] => write!(f, " (did you mean {one}?)"),
            [most @ .., last] => write!(f, " (did you mean {} or {last}?)", most.join(", ")),
        }
    }
}

struct Known<'a>(Option<&'a [String]>);

impl fmt::Display for Known<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            None => Ok(()),
            Some([]) => f.write_str("; known: none"),
            Some(names) => write!(f, "; known: {}", names.join(", ")),
        }
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File {
                path,
                position: Some((line, column)),
                ..
            } => {
                write!(f, "{}:{line}:{column}: ", path.display())
            }
            Self::File {
                path,
                position: None,
                ..
            } => write!(f, "{}: ", path.display()),
            Self::CommandLine(text) => write!(f, "{}: ", Shortened(text)),
            Self::Direct => Ok(()),
        }
    }
}

impl Excerpt {
    /// Whether a report can quote the lines around it. It cannot at the end of a text, where no line is left to point at, and it
    /// should not where a line is very long, or would change the terminal.
    fn can_be_quoted(&self) -> bool {
        const MAX_LINE_CHARS: usize = 240;
        /// Lines before and after, more than a report shows.
        const CONTEXT: usize = 2;
        let (text, range) = (&*self.text, &self.bytes);
        let Some((before, rest)) = text.split_at_checked(range.start) else {
            return false;
        };
        let Some(after) = text.get(range.end..) else {
            return false;
        };
        let begin = before.rmatch_indices('\n').nth(CONTEXT);
        let end = after.match_indices('\n').nth(CONTEXT);
        let begin = begin.map_or(0, |(at, _)| at + 1);
        let end = end.map_or(text.len(), |(at, _)| range.end + at);
        let is_quotable = |line: &str| {
            line.chars().count() <= MAX_LINE_CHARS
                && line.chars().all(|c| c == '\t' || is_printable(c))
        };
        !rest.trim().is_empty() && text[begin..end].lines().all(is_quotable)
    }
}

impl fmt::Debug for Excerpt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Excerpt")
            .field(&self.text.get(self.bytes.clone()).unwrap_or_default())
            .finish()
    }
}

/// All faults of the given parameters, in the order of files and lines; never empty.
///
/// `Display` is a line with their number, followed by one line per fault; [`report`](Self::report) shows them in the text
/// of the files.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterFaults(Vec<Fault>);

impl ParameterFaults {
    /// `Ok` if there are none.
    ///
    /// # Errors
    /// All of them.
    pub(crate) fn none_of(faults: Vec<Fault>) -> Result<(), Self> {
        if faults.is_empty() {
            Ok(())
        } else {
            Err(Self(faults))
        }
    }

    /// These faults, of which there is at least one.
    pub(super) fn of(faults: Vec<Fault>) -> Self {
        debug_assert!(!faults.is_empty());
        Self(faults)
    }

    pub(super) fn into_faults(self) -> Vec<Fault> {
        self.0
    }

    /// The faults.
    #[must_use]
    pub fn faults(&self) -> &[Fault] {
        &self.0
    }

    /// All faults in one line, for an answer or a log.
    #[must_use]
    pub fn in_one_line(&self) -> String {
        let faults: Vec<_> = self.0.iter().map(ToString::to_string).collect();
        faults.join("; ")
    }

    /// A report for people: the lines of the files with the faults below them.
    #[must_use]
    pub fn report(&self) -> miette::Report {
        let mut parts: Vec<ReportPart> = Vec::new();
        for fault in &self.0 {
            match &fault.place {
                Origin::File {
                    path,
                    excerpt: Some(excerpt),
                    ..
                } if excerpt.can_be_quoted() => {
                    let label =
                        LabeledSpan::at(excerpt.bytes.clone(), FaultInPlace(fault).to_string());
                    let name = path.display().to_string();
                    match parts
                        .iter_mut()
                        .find(|part| part.file.as_ref().is_some_and(|file| file.name() == name))
                    {
                        Some(part) => part.labels.push(label),
                        None => parts.push(ReportPart::of_file(name, excerpt.text.clone(), label)),
                    }
                }
                _ => parts.push(ReportPart {
                    message: fault.to_string(),
                    file: None,
                    labels: Vec::new(),
                }),
            }
        }
        miette::Report::new(Listing {
            count: self.0.len(),
            parts,
        })
    }
}

impl fmt::Display for ParameterFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", Count(self.0.len()))?;
        self.0.iter().try_for_each(|fault| write!(f, "\n  {fault}"))
    }
}

impl std::error::Error for ParameterFaults {}

impl From<Fault> for ParameterFaults {
    fn from(fault: Fault) -> Self {
        Self(vec![fault])
    }
}

struct Count(usize);

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 == 1 {
            f.write_str("1 fault in the parameters")
        } else {
            write!(f, "{} faults in the parameters", self.0)
        }
    }
}

/// A fault shown below the line concerned, which needs no place.
struct FaultInPlace<'a>(&'a Fault);

impl fmt::Display for FaultInPlace<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let subject = Subject(self.0.name.as_deref(), self.0.value.as_deref());
        write!(f, "{subject}{}", self.0.problem)
    }
}

#[derive(Debug, thiserror::Error)]
#[error("{}", Count(*.count))]
struct Listing {
    count: usize,
    parts: Vec<ReportPart>,
}

impl Diagnostic for Listing {
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(
            self.parts.iter().map(|part| part as &dyn Diagnostic),
        ))
    }
}

/// The faults of one file, or a single fault outside of files.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
struct ReportPart {
    message: String,
    file: Option<NamedSource<Arc<str>>>,
    labels: Vec<LabeledSpan>,
}

impl ReportPart {
    fn of_file(name: String, text: Arc<str>, label: LabeledSpan) -> Self {
        Self {
            message: format!("in {name}"),
            file: Some(NamedSource::new(name, text)),
            labels: vec![label],
        }
    }
}

impl Diagnostic for ReportPart {
    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.file.as_ref().map(|file| file as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        Some(Box::new(self.labels.iter().cloned()))
    }
}

/// A file that is being read, for the places of faults.
#[derive(Debug, Clone)]
pub(super) struct SourceFile {
    pub path: PathBuf,
    pub text: Arc<str>,
}

impl SourceFile {
    pub(super) fn place(&self, at: &Location) -> Origin {
        Origin::File {
            path: self.path.clone(),
            position: Some((at.line, at.column)),
            excerpt: Some(Excerpt {
                text: self.text.clone(),
                bytes: at.bytes.clone(),
            }),
        }
    }
}
