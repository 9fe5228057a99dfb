//! The program `column-twin`.

mod cli;

use std::process::ExitCode;

// The reference responses, which the tests of the library share, name these modules by the root.
#[cfg(test)]
use column_twin::{column, figures, twin};

fn main() -> ExitCode {
    cli::run(std::env::args_os())
}
