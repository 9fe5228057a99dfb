//! `column-twin keystore` in a program without DDS security: explains how to build one with it.

use std::ffi::OsString;

use clap::Args;

use super::failure::{Exit, Failure};

/// Arguments of `column-twin keystore`, none of which is read.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE, disable_help_subcommand = true)]
pub struct KeystoreArgs {
    /// Subcommands of a program with DDS security: create, add, renew, show, policy, zenoh
    #[arg(
        value_name = "ARGUMENTS",
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    arguments: Vec<OsString>,
}

const EXAMPLE: &str = "\
This program was built without DDS security, which needs OpenSSL 3 (Debian: libssl-dev and
pkg-config):
  cargo build --release --features security

Example: with such a program
  column-twin keystore create keystore

Exit codes: 2 always.";

/// Fails with the way to a program that can do it.
pub fn run(_: &KeystoreArgs) -> Result<(), Failure> {
    Err(Failure::plain(
        Exit::BadInput,
        "this program was built without DDS security; build it with: cargo build --release --features security (it needs \
         OpenSSL 3, on Debian: apt-get install libssl-dev pkg-config). `ros2 security` can also make a keystore: see \
         docs/security.md",
    ))
}
