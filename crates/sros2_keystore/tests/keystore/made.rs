//! Keystores made by the library, in a temporary folder.

use std::path::{Path, PathBuf};

use jiff::Timestamp;
use sros2_keystore::{
    Access, Creation, DataProtection, DomainRanges, ENCLAVE_DAYS, EnclaveName, EnclavePlan, create,
};
use tempfile::TempDir;

pub const DAY: i64 = 86_400;

/// Common name of the authorities.
pub const AUTHORITY: &str = "sros2CA";

/// The time of day \[s since 1970\].
pub fn today() -> i64 {
    Timestamp::now().as_second()
}

/// Enclaves of these names, whose programs may do what every node does; without any, three.
pub fn plans(names: &[&str]) -> Vec<EnclavePlan> {
    let names = match names {
        [] => &["/arm", "/monitor", "/operator"],
        given => given,
    };
    let topics = ["/parameter_events", "/rosout"].map(str::to_owned);
    let access = Access {
        publish: topics.into(),
        ..Access::default()
    };
    names
        .iter()
        .map(|text| EnclavePlan {
            name: name(text),
            access: access.clone(),
        })
        .collect()
}

pub fn name(text: &str) -> EnclaveName {
    EnclaveName::new(text).expect("a valid name")
}

/// A keystore that is removed when dropped.
pub struct Made {
    folder: TempDir,
}

impl Made {
    /// Three enclaves, in all domains.
    pub fn new() -> Self {
        Self::at(today(), ENCLAVE_DAYS)
    }

    /// As if made at another time, valid for so many days.
    pub fn at(now: i64, days: u32) -> Self {
        let made = Self {
            folder: tempfile::tempdir().expect("a folder"),
        };
        let domains: DomainRanges = "0-232".parse().expect("domains");
        create(&Creation {
            folder: &made.path(),
            authority: AUTHORITY,
            enclaves: &plans(&[]),
            domains: &domains,
            data: DataProtection::None,
            days,
            now,
        })
        .expect("made");
        made
    }

    pub fn path(&self) -> PathBuf {
        self.folder.path().join("keystore")
    }

    pub fn file(&self, path: &str) -> PathBuf {
        self.path().join(path)
    }

    pub fn enclave(&self, name: &str) -> PathBuf {
        self.file(&format!("enclaves{name}"))
    }

    pub fn read(&self, path: &str) -> String {
        std::fs::read_to_string(self.file(path)).expect(path)
    }
}

/// Every path below a folder in order, with what a link points to or the mode of a file or folder.
pub fn listing(folder: &Path) -> Vec<String> {
    use std::os::unix::fs::PermissionsExt;
    let mut lines = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(&next).expect("a folder") {
            let path = entry.expect("an entry").path();
            let shown = path.strip_prefix(folder).expect("below").display();
            let kind = path.symlink_metadata().expect("there");
            lines.push(match path.read_link() {
                Ok(target) => format!("{shown} -> {}", target.display()),
                Err(_) => format!("{shown} {:o}", kind.permissions().mode() & 0o777),
            });
            if kind.is_dir() {
                open.push(path);
            }
        }
    }
    lines.sort();
    lines
}
