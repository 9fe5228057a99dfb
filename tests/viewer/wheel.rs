//! The real viewer from PyPI.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The viewer's program, installed when it is not there.
pub fn program() -> PathBuf {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/interop/viewer.sh");
    let output = Command::new(script)
        .stderr(Stdio::inherit())
        .output()
        .expect("runs");
    assert!(output.status.success(), "viewer.sh: {}", output.status);
    PathBuf::from(String::from_utf8(output.stdout).expect("a path").trim())
}

/// The viewer with its own home, where it is told to say nothing about its users.
pub fn viewer(program: &Path) -> Command {
    let venv = program
        .ancestors()
        .find(|it| it.join(".complete").exists())
        .expect("in its environment");
    let mut command = Command::new(program);
    command
        .env("HOME", venv.join("home"))
        .env("XDG_CONFIG_HOME", venv.join("home"))
        .env("XDG_RUNTIME_DIR", venv.join("home"))
        .env("RUST_LOG", "error")
        .stdout(Stdio::null());
    command
}
