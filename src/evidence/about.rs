//! The program that made a recording.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use printable::Hexadecimal;

/// The program that made a recording, and the names of its topics.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct About {
    /// Name and version of the program.
    pub program: String,
    /// The build of the program, see [`build`]: the same build computes the same bits.
    pub build: String,
    /// Resolved topic names by their names in the table of endpoints.
    pub topics: BTreeMap<String, String>,
    /// Whether status and diagnostics were left out while nothing happened.
    pub events_only: bool,
}

impl About {
    /// This program with these topics; `events_only` if it leaves out status and diagnostics while nothing happens.
    #[must_use]
    pub fn this_program(topics: BTreeMap<String, String>, events_only: bool) -> Self {
        Self {
            program: format!("column_twin {}", env!("CARGO_PKG_VERSION")),
            build: build().to_owned(),
            topics,
            events_only,
        }
    }
}

/// Identifies this build: target, profile, and a hash of the program file. The first call reads the file.
pub fn build() -> &'static str {
    static BUILD: OnceLock<String> = OnceLock::new();
    BUILD.get_or_init(|| {
        let profile = if cfg!(debug_assertions) {
            "debug"
        } else {
            "release"
        };
        let hash = program_hash().unwrap_or_else(|_| "unknown".to_owned());
        format!(
            "{}-{} {profile} {hash}",
            std::env::consts::ARCH,
            std::env::consts::OS
        )
    })
}

fn program_hash() -> io::Result<String> {
    const DIGITS: usize = 32;
    let mut hash = sha256_of_file(&std::env::current_exe()?)?;
    hash.truncate(DIGITS);
    Ok(hash)
}

/// The SHA-256 of a file, in hexadecimal digits.
///
/// # Errors
/// The file cannot be read.
pub fn sha256_of_file(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 20];
    loop {
        match file.read(&mut buffer)? {
            0 => break,
            read => hash.update(&buffer[..read]),
        }
    }
    Ok(Hexadecimal(&hash.finalize()).to_string())
}

/// The SHA-256 of some bytes, in hexadecimal digits.
pub(super) fn sha256_of(bytes: &[u8]) -> String {
    Hexadecimal(&Sha256::digest(bytes)).to_string()
}
