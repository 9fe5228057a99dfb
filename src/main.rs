//! The program `column-twin`.

use std::process::ExitCode;

fn main() -> ExitCode {
    column_twin::cli::run(std::env::args_os())
}
