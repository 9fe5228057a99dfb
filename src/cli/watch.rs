//! `column-twin watch`: prints what a running twin or a fleet publishes.

use std::io::{self, IsTerminal, Write};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use clap::Args;
use crossterm::cursor::MoveTo;
use crossterm::queue;
use crossterm::terminal::{self, Clear, ClearType};

use super::failure::{Exit, Failure, printed};
use super::run::client_environment;
use super::transport::TransportArgs;
use column_twin::fleet::{TableSize, table};
use column_twin::messages::column_twin_msgs::{ColumnStatus, FleetStatus};
use column_twin::ros::{RosArguments, Shown, watch};

/// Arguments of `column-twin watch`, besides the ROS arguments.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct WatchArgs {
    #[command(flatten)]
    transport: TransportArgs,
}

const EXAMPLE: &str = "\
Example: a twin in the namespace /garage, on this machine only
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin watch --ros-args -r __ns:=/garage

A fleet is shown as a table that fits the terminal, the worst columns first; in a pipe, as one
line for each column that changes.
Exit codes: 0 stopped by SIGINT or SIGTERM, 1 failed, 2 bad input or usage.";

/// Minimum time between two pictures of the table.
const TABLE_SPACING: Duration = Duration::from_millis(500);

/// The size of a terminal that does not tell it.
const USUAL_SIZE: TableSize = TableSize {
    width: 80,
    height: 24,
};

/// Prints until SIGINT or SIGTERM, or until the reader closes the pipe (`| head`).
pub fn run(arguments: &WatchArgs, ros: &RosArguments, out: &mut impl Write) -> Result<(), Failure> {
    let environment = client_environment(ros, arguments.transport)?;
    let mut written = Ok(());
    let is_terminal = io::stdout().is_terminal();
    let mut last_table: Option<Instant> = None;
    watch(&environment, &ros.remap_rules, &mut |shown| {
        written = match shown {
            // A line would destroy the table.
            Shown::Line(_) if is_terminal && last_table.is_some() => Ok(()),
            Shown::Line(line) => writeln!(out, "{line}"),
            Shown::Fleet {
                status,
                columns,
                is_settled,
            } if is_terminal => {
                // The last one of many messages is drawn when it has turned out to be the last.
                if !is_settled && last_table.is_some_and(|last| last.elapsed() < TABLE_SPACING) {
                    return ControlFlow::Continue(());
                }
                last_table = Some(Instant::now());
                draw(status, columns)
            }
            Shown::Fleet {
                status, is_settled, ..
            } if status.of_all || is_settled => Ok(()),
            Shown::Fleet { status, .. } => status
                .columns
                .iter()
                .try_for_each(|column| writeln!(out, "{}", line(status, column))),
        };
        match written {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        }
    })
    .map_err(|error| Failure::plain(Exit::Failed, error))?;
    printed(written)
}

/// One column of a fleet, without the heading.
fn line(status: &FleetStatus, column: &ColumnStatus) -> String {
    /// Summary, heading and the column, however long; and room for what is left out.
    const SIZE: TableSize = TableSize {
        width: usize::MAX,
        height: 4,
    };
    let mut lines = table(status, std::slice::from_ref(column), SIZE);
    lines.pop().unwrap_or_default()
}

/// Draws the table over the last one.
fn draw(status: &FleetStatus, columns: &[ColumnStatus]) -> io::Result<()> {
    let size = terminal::size().map_or(USUAL_SIZE, |(width, height)| TableSize {
        width: width.into(),
        height: usize::from(height).saturating_sub(1), // the cursor stays in the last line
    });
    let mut out = io::stdout().lock();
    queue!(out, MoveTo(0, 0), Clear(ClearType::All))?;
    for line in table(status, columns, size) {
        writeln!(out, "{line}")?;
    }
    out.flush()
}
