//! How a command ends: exit codes, failures, and printing.

use std::io;

use printable::PrintableLines;

/// Exit codes of commands that do not succeed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// The command failed.
    Failed = 1,
    /// The input or the usage is wrong.
    BadInput = 2,
    /// Done, but some data were lost.
    Lossy = 3,
}

/// Why a command did not succeed, for a person and for the shell.
#[derive(Debug)]
pub struct Failure {
    /// Exit code for the shell.
    pub exit: Exit,
    /// What was wrong, where, and what to do next.
    pub report: miette::Report,
}

impl Failure {
    /// A failure with a diagnostic.
    pub fn new(exit: Exit, fault: impl miette::Diagnostic + Send + Sync + 'static) -> Self {
        Self {
            exit,
            report: miette::Report::new(fault),
        }
    }

    /// A failure with an error or a message.
    pub fn plain(exit: Exit, fault: impl std::fmt::Display) -> Self {
        Self {
            exit,
            report: miette::Report::msg(PrintableLines(&fault.to_string()).to_string()),
        }
    }
}

impl From<column_twin::parameters::ParameterFaults> for Failure {
    fn from(faults: column_twin::parameters::ParameterFaults) -> Self {
        Self {
            exit: Exit::BadInput,
            report: faults.report(),
        }
    }
}

#[cfg(feature = "record")]
impl From<column_twin::recording::RecordingError> for Failure {
    fn from(error: column_twin::recording::RecordingError) -> Self {
        let exit = match error.is_bad_input() {
            true => Exit::BadInput,
            false => Exit::Failed,
        };
        match error.repairable() {
            Some(path) => {
                let command = format!("column-twin repair {}", path.display());
                Self::plain(exit, format!("{error}, with: {command}"))
            }
            None => Self::plain(exit, error),
        }
    }
}

/// A reader that stops reading early (`| head`) is not a failure.
pub(super) fn unless_closed(written: io::Result<()>) -> io::Result<()> {
    match written {
        Err(closed) if closed.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// The end of a command that has printed something.
pub(super) fn printed(written: io::Result<()>) -> Result<(), Failure> {
    unless_closed(written)
        .map_err(|error| Failure::plain(Exit::Failed, format!("cannot print: {error}")))
}

/// Prints lines for several owners. After the first line that cannot be printed it prints no more.
#[cfg(feature = "ros")]
pub(super) struct LinePrinter<'a> {
    out: std::cell::RefCell<&'a mut dyn io::Write>,
    fault: std::cell::RefCell<Option<io::Error>>,
}

#[cfg(feature = "ros")]
impl<'a> LinePrinter<'a> {
    pub fn new(out: &'a mut dyn io::Write) -> Self {
        Self {
            out: out.into(),
            fault: None.into(),
        }
    }

    pub fn print(&self, line: impl std::fmt::Display) {
        let mut fault = self.fault.borrow_mut();
        if fault.is_none() {
            *fault = writeln!(self.out.borrow_mut(), "{line}").err();
        }
    }

    /// The first failure to print, if any.
    pub fn end(self) -> Result<(), Failure> {
        printed(self.fault.into_inner().map_or(Ok(()), Err))
    }
}
