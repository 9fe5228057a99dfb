//! The command line: what can be asked for, and how a command ends.

#[cfg(all(feature = "ros", feature = "record"))]
mod demo;
#[cfg(feature = "record")]
mod export;
#[cfg(all(feature = "ros", feature = "record", feature = "viewer"))]
mod film;
mod history;
#[cfg(feature = "ros")]
mod idl;
#[cfg(feature = "ros")]
mod impact;
#[cfg(feature = "record")]
mod info;
#[cfg(feature = "record")]
mod repair;
#[cfg(all(feature = "ros", feature = "record"))]
mod replay;
#[cfg(feature = "ros")]
mod run;
mod simulate;
#[cfg(test)]
mod simulate_tests;
mod summary;
#[cfg(feature = "record")]
mod verify;
#[cfg(feature = "ros")]
mod watch;

use std::ffi::OsString;
use std::io;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

pub use history::HistoryWriter;
pub use simulate::SimulateArgs;
pub use summary::Summary;

/// Digital twin of a steel column hit by a vehicle.
#[derive(Debug, Parser)]
#[command(name = "column-twin", version, after_help = EXIT_CODES)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done, 1 failed, 2 bad input or usage, 3 done, but some data was lost.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Show all of it on this machine: node, impact, forecast, recording, figures, proof
    #[cfg(all(feature = "ros", feature = "record"))]
    Demo(demo::DemoArgs),
    /// Simulate one impact and say what it does to the column
    Simulate(SimulateArgs),
    /// Run the twin as a ROS 2 node until it is told to stop
    #[cfg(feature = "ros")]
    Run(run::RunArgs),
    /// Publish one impact event, and say what the twin forecasts
    #[cfg(feature = "ros")]
    Impact(impact::ImpactArgs),
    /// Publish a recording over DDS, with its timing
    #[cfg(all(feature = "ros", feature = "record"))]
    Replay(replay::ReplayArgs),
    /// Compute a recording anew, and compare every value
    #[cfg(feature = "record")]
    Verify(verify::VerifyArgs),
    /// Print what a running twin publishes, until it is told to stop
    #[cfg(feature = "ros")]
    Watch(watch::WatchArgs),
    /// Print the node's topics and messages as OMG IDL, for programs in plain DDS
    #[cfg(feature = "ros")]
    Idl(idl::IdlArgs),
    /// Say what is in a recording: topics, impacts and their outcome, losses
    #[cfg(feature = "record")]
    Info(info::InfoArgs),
    /// Write a recording anew that was cut off or damaged; the original stays
    #[cfg(feature = "record")]
    Repair(repair::RepairArgs),
    /// Write the messages of a recording as CSV or JSON
    #[cfg(feature = "record")]
    Export(export::ExportArgs),
}

/// Exit codes of commands that do not end well.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// What was asked for could not be done.
    Failed = 1,
    /// What was asked for makes no sense.
    BadInput = 2,
    /// Done, but some data was lost.
    Lossy = 3,
}

/// Why a command did not end well: for a person, and for the shell.
#[derive(Debug)]
pub struct Failure {
    /// What the shell sees.
    pub exit: Exit,
    /// What was wrong, where, and what to do next.
    pub report: miette::Report,
}

impl Failure {
    /// A failure with the reason that `fault` gives.
    pub fn new(exit: Exit, fault: impl miette::Diagnostic + Send + Sync + 'static) -> Self {
        Self {
            exit,
            report: miette::Report::new(fault),
        }
    }

    /// A failure with the reason that a plain error gives.
    #[cfg(any(feature = "ros", feature = "record"))]
    fn plain(exit: Exit, fault: impl std::fmt::Display) -> Self {
        Self {
            exit,
            report: miette::Report::msg(fault.to_string()),
        }
    }
}

/// A reader that has seen enough (`| head`) is no failure.
fn unless_closed(written: io::Result<()>) -> io::Result<()> {
    match written {
        Err(closed) if closed.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// How a command ends that has printed something.
#[cfg(any(feature = "ros", feature = "record"))]
fn printed(written: io::Result<()>) -> Result<(), Failure> {
    unless_closed(written)
        .map_err(|error| Failure::plain(Exit::Failed, format!("cannot print: {error}")))
}

/// Lines for the standard output, by several who do not know of each other. After the first that cannot be printed there
/// are no more.
#[cfg(feature = "ros")]
struct Lines<'a> {
    out: std::cell::RefCell<&'a mut dyn io::Write>,
    fault: std::cell::RefCell<Option<io::Error>>,
}

#[cfg(feature = "ros")]
impl<'a> Lines<'a> {
    fn new(out: &'a mut dyn io::Write) -> Self {
        Self {
            out: out.into(),
            fault: None.into(),
        }
    }

    fn say(&self, line: impl std::fmt::Display) {
        let mut fault = self.fault.borrow_mut();
        if fault.is_none() {
            *fault = writeln!(self.out.borrow_mut(), "{line}").err();
        }
    }

    /// Whether all was printed that somebody wanted to read.
    fn end(self) -> Result<(), Failure> {
        printed(self.fault.into_inner().map_or(Ok(()), Err))
    }
}

/// Runs the command that the arguments, the program's name first, ask for; results go to the standard output, what
/// went wrong to the standard error.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    // Lines of a report are not broken, so that paths and names can be copied; a hook set before stays.
    let _ = miette::set_hook(Box::new(|_| {
        Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).build())
    }));
    #[cfg(feature = "ros")]
    let (arguments, ros) = match crate::ros::RosArguments::split(arguments) {
        Ok(split) => split,
        Err(faults) => {
            for fault in faults {
                eprintln!("{fault}");
            }
            return ExitCode::from(Exit::BadInput as u8);
        }
    };
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(request) => {
            // Also a request for help or the version, which is no error. Nowhere to tell if this cannot be printed.
            let _ = request.print();
            return u8::try_from(request.exit_code()).map_or(ExitCode::FAILURE, ExitCode::from);
        }
    };
    let ended = match &cli.command {
        #[cfg(all(feature = "ros", feature = "record"))]
        Command::Demo(arguments) => demo::run(arguments, &mut io::stdout().lock()),
        Command::Simulate(arguments) => simulate::run(arguments, &mut io::stdout().lock()),
        #[cfg(all(feature = "ros", feature = "record"))]
        Command::Replay(arguments) => replay::run(arguments, &ros, &mut io::stdout().lock()),
        #[cfg(feature = "record")]
        Command::Verify(arguments) => verify::run(arguments, &mut io::stdout().lock()),
        #[cfg(feature = "ros")]
        Command::Run(arguments) => run::run(arguments, ros),
        #[cfg(feature = "ros")]
        Command::Impact(arguments) => impact::run(arguments, &ros, &mut io::stdout().lock()),
        #[cfg(feature = "ros")]
        Command::Watch(arguments) => watch::run(arguments, &ros, &mut io::stdout().lock()),
        #[cfg(feature = "ros")]
        Command::Idl(arguments) => idl::run(arguments, &mut io::stdout().lock()),
        #[cfg(feature = "record")]
        Command::Info(arguments) => info::run(arguments, &mut io::stdout().lock()),
        #[cfg(feature = "record")]
        Command::Repair(arguments) => repair::run(arguments, &mut io::stdout().lock()),
        #[cfg(feature = "record")]
        Command::Export(arguments) => export::run(arguments, &mut io::stdout().lock()),
    };
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{:?}", failure.report);
            ExitCode::from(failure.exit as u8)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_option_says_what_it_is() {
        for command in Cli::command().get_subcommands() {
            for option in command.get_arguments() {
                assert!(
                    option.get_help().is_some(),
                    "{} {}",
                    command.get_name(),
                    option.get_id()
                );
            }
        }
    }
}
