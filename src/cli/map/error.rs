//! Why there is no map, and how a map ends.

use std::io::{self, Write};
use std::path::PathBuf;

use crate::cli::failure::{Exit, Failure, unless_closed};
use column_twin::figures::FigureError;
use column_twin::study::{MapError, RefineError};

/// Why there is no map.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub(super) enum MapCommandError {
    #[error(transparent)]
    #[diagnostic(help("see `column-twin map --help` and docs/study.md"))]
    Map(#[from] MapError),
    #[error("a map has two axes; found {found}{}", listed(.names))]
    #[diagnostic(help(
        "give a range from:to:number of points to two of --mass, --velocity, --height and --vary, such as --mass 2000:12000:100 --velocity 1:25:100"
    ))]
    NotTwoAxes { found: usize, names: Vec<String> },
    #[error("--{name} {given}: expected one number or a range, such as {example}")]
    #[diagnostic(help("omit the unit; SI units apply"))]
    NotANumber {
        name: &'static str,
        given: String,
        example: &'static str,
    },
    #[error(
        "--shard {given}: expected the number of the part and the number of parts, such as 3/16"
    )]
    #[diagnostic(help("the parts are numbered from 1; together they are the map"))]
    Shard { given: String },
    #[error("only one of {0} can write to the standard output")]
    #[diagnostic(help("name a file for the other one"))]
    OneOutput(&'static str),
    #[error("--bands belongs to the two bars; found --model beam or both")]
    #[diagnostic(help("leave out --bands, or judge by --model bars"))]
    BandsOfBars,
    #[error(
        "--compare {given}: expected section=HEB200,HEB240, any parameter with its values, or config=a.yaml,b.yaml"
    )]
    #[diagnostic(help("name at least two"))]
    Compare { given: String },
    #[error("the boundaries cannot be computed: {0}")]
    #[diagnostic(help(
        "check the ranges; without --refine, the map leaves out cells that cannot be computed"
    ))]
    Refine(#[from] RefineError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    File(#[from] MapFileError),
    #[error("cannot start the threads of the map: {0}")]
    Threads(String),
    #[error("cannot write to the standard output: {0}")]
    Output(io::Error),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Figures(#[from] FigureError),
    #[cfg(feature = "viewer")]
    #[error(transparent)]
    #[diagnostic(transparent)]
    Viewer(#[from] column_twin::viewer::ViewerError),
}

fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        names => format!(" ({})", names.join(", ")),
    }
}

impl From<rayon::ThreadPoolBuildError> for MapCommandError {
    fn from(error: rayon::ThreadPoolBuildError) -> Self {
        Self::Threads(error.to_string())
    }
}

impl From<MapCommandError> for Failure {
    fn from(fault: MapCommandError) -> Self {
        let exit = match &fault {
            MapCommandError::Map(_)
            | MapCommandError::NotTwoAxes { .. }
            | MapCommandError::NotANumber { .. }
            | MapCommandError::Shard { .. }
            | MapCommandError::OneOutput(_)
            | MapCommandError::BandsOfBars
            | MapCommandError::Compare { .. }
            | MapCommandError::Refine(RefineError::NotARange(_)) => Exit::BadInput,
            _ => Exit::Failed,
        };
        Self::new(exit, fault)
    }
}

/// A file of a map that cannot be written.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("cannot write the map to {}: {reason}", path.display())]
#[diagnostic(help("name a file in an existing, writable folder"))]
pub(super) struct MapFileError {
    pub path: PathBuf,
    pub reason: io::Error,
}

impl MapFileError {
    /// Whether a reader has stopped reading.
    pub fn is_closed(&self) -> bool {
        self.reason.kind() == io::ErrorKind::BrokenPipe
    }
}

/// How a command ended that may have been interrupted.
pub(super) struct Ended {
    /// What is printed.
    pub(super) text: String,
    /// What is missing.
    pub(super) missing: Option<String>,
}

impl Ended {
    /// Prints the text where no file has taken the standard output, and ends the command.
    pub fn print(self, to_error: bool, output: &mut dyn Write) -> Result<(), Failure> {
        if to_error {
            tell!("{}", self.text.trim_end());
        } else {
            let written = output
                .write_all(self.text.as_bytes())
                .and_then(|()| output.flush());
            unless_closed(written).map_err(MapCommandError::Output)?;
        }
        match self.missing {
            None => Ok(()),
            Some(missing) => Err(Failure::plain(Exit::Lossy, missing)),
        }
    }
}
