//! A small disk for tests of full disks.

use std::path::Path;
use std::process::Command;

/// Size of the disk.
const SIZE: &str = "12m";

/// A small file system in memory; needs root.
pub struct SmallDisk(tempfile::TempDir);

impl SmallDisk {
    /// `None`, with a message, if it cannot be mounted.
    pub fn mount() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let mut mount = Command::new("mount");
        mount
            .args([
                "-t",
                "tmpfs",
                "-o",
                &format!("size={SIZE}"),
                "column_twin_test",
            ])
            .arg(folder.path());
        let mounted = mount.output().is_ok_and(|it| it.status.success());
        if !mounted {
            println!("not tested: mounting a small file system needs root");
        }
        mounted.then_some(Self(folder))
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0.path()).status();
    }
}
