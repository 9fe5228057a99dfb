//! Keystores made by the library, in a temporary folder.

use std::path::PathBuf;

use column_twin::keystore::{AUTHORITY_NAME, Twins, plan};
use column_twin::ros::NODE_NAME;
use column_twin::ros::security::now;
use sros2_keystore::{
    Creation, DataProtection, DomainRanges, ENCLAVE_DAYS, EnclaveName, EnclavePlan, create,
};
use tempfile::TempDir;

pub const DAY: i64 = 86_400;

/// The time of day \[s since 1970\].
pub fn today() -> i64 {
    now().as_second()
}

/// One twin of the default name.
pub fn twin() -> Twins {
    Twins::new(&[], NODE_NAME, &[]).expect("valid names")
}

/// Enclaves by texts as on the command line; without any the three that every keystore has.
pub fn plans(wanted: &[&str]) -> Vec<EnclavePlan> {
    let wanted: Vec<String> = wanted.iter().map(|it| (*it).to_owned()).collect();
    let planned = plan(&wanted, &twin()).expect("valid enclaves");
    planned.into_iter().map(|it| it.plan).collect()
}

pub fn name(text: &str) -> EnclaveName {
    EnclaveName::new(text).expect("a valid name")
}

/// A keystore that is removed when dropped.
pub struct Made {
    folder: TempDir,
}

impl Made {
    /// Twin, monitor and operator, in all domains.
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
            authority: AUTHORITY_NAME,
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
