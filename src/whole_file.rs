//! A file that appears whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// Most symbolic links from a path to its file, as in Linux.
const MAX_LINKS: u32 = 40;

/// A file without a name; [`commit`](Self::commit) gives it its name, dropping it removes it.
///
/// Whoever looks at the place sees the old content or the complete new one, also when the program is
/// killed or the disk is full. Where the file system has no files without a name, it is written under a temporary name beside
/// its place. Symbolic links are followed. Devices and pipes are written directly.
pub struct WholeFile {
    writer: BufWriter<Target>,
    path: PathBuf,
}

/// What is written to.
enum Target {
    /// A file in this folder that has no name yet.
    #[cfg(target_os = "linux")]
    Unnamed { file: File, folder: PathBuf },
    /// A file under a temporary name.
    Named(NamedTempFile),
    /// A device or a pipe.
    Device(File),
}

impl Target {
    /// Opens a file that does not appear in the folder at all, or under a temporary name.
    fn in_folder(folder: &Path) -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        if Path::new(OPEN_FILES).is_dir() {
            use rustix::fs::{Mode, OFlags};
            // As any other new file: the user's umask decides who may read it.
            let mode = Mode::from_raw_mode(0o666);
            let flags = OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC;
            if let Ok(file) = rustix::fs::open(folder, flags, mode) {
                return Ok(Self::Unnamed {
                    file: file.into(),
                    folder: folder.to_path_buf(),
                });
            }
        }
        // The library's words name the temporary file, which would puzzle the reader.
        let named = |fault: io::Error| io::Error::new(fault.kind(), fault.kind().to_string());
        temporary()
            .tempfile_in(folder)
            .map(Self::Named)
            .map_err(named)
    }
}

/// Where Linux lists the open files of a process.
#[cfg(target_os = "linux")]
const OPEN_FILES: &str = "/proc/self/fd";

/// Temporary names.
fn temporary() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".column-twin-").suffix(".partial");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

impl Write for Target {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            #[cfg(target_os = "linux")]
            Self::Unnamed { file, .. } => file.write(bytes),
            Self::Named(file) => file.write(bytes),
            Self::Device(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Follows symbolic links, also to a file that does not exist yet, but not into the devices and open files of the system.
fn resolved(path: &Path) -> PathBuf {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        if is_of_the_system(&path) {
            return path;
        }
        let Ok(target) = fs::read_link(&path) else {
            break;
        };
        path = match path.parent() {
            Some(folder) => folder.join(target),
            None => target,
        };
    }
    fs::canonicalize(&path).unwrap_or(path)
}

fn is_of_the_system(path: &Path) -> bool {
    path.starts_with("/dev") || path.starts_with("/proc")
}

impl WholeFile {
    /// Opens the file; the folder must exist.
    ///
    /// # Errors
    /// The folder cannot be written to, or a folder stands at `path`.
    pub fn create(path: &Path) -> io::Result<Self> {
        let path = resolved(path);
        let found = fs::metadata(&path).ok();
        if found.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(io::Error::new(
                io::ErrorKind::IsADirectory,
                "a folder has this name",
            ));
        }
        let is_device = found.as_ref().is_some_and(|found| !found.is_file());
        let target = if found.is_some() && (is_device || is_of_the_system(&path)) {
            Target::Device(File::options().append(true).open(&path)?)
        } else {
            let folder = match path.parent() {
                Some(folder) if !folder.as_os_str().is_empty() => folder,
                _ => Path::new("."),
            };
            if !folder.is_dir() {
                let reason = format!("there is no folder {}", folder.display());
                return Err(io::Error::new(io::ErrorKind::NotFound, reason));
            }
            Target::in_folder(folder)?
        };
        Ok(Self {
            writer: BufWriter::new(target),
            path,
        })
    }

    /// Writes out what is buffered and gives the file its name.
    ///
    /// # Errors
    /// The rest cannot be written, or the file cannot be named; then nothing stays behind.
    pub fn commit(self) -> io::Result<()> {
        let target = self
            .writer
            .into_inner()
            .map_err(io::IntoInnerError::into_error)?;
        match target {
            #[cfg(target_os = "linux")]
            Target::Unnamed { file, folder } => {
                use rustix::fs::{AtFlags, CWD};
                use std::os::fd::AsRawFd;
                let open = format!("{OPEN_FILES}/{}", file.as_raw_fd());
                // A name can be given, but not taken from another file: that takes a temporary one.
                let link = |name: &Path| {
                    rustix::fs::linkat(CWD, &open, CWD, name, AtFlags::SYMLINK_FOLLOW)
                        .map_err(io::Error::from)
                };
                let linked = temporary().make_in(folder, link)?;
                linked.persist(&self.path).map_err(|fault| fault.error)?;
            }
            Target::Named(file) => drop(file.persist(&self.path).map_err(|fault| fault.error)?),
            Target::Device(_) => {}
        }
        Ok(())
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// Writes `content` to `path`, whole or not at all.
///
/// # Errors
/// See [`WholeFile`].
pub fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(content)?;
    file.commit()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    #[test]
    fn appears_only_when_committed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let mut file = WholeFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        assert!(!path.exists());
        file.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.csv"]);
    }

    #[test]
    fn an_abandoned_file_leaves_the_old_one_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        fs::write(&path, "old").unwrap();
        let mut file = WholeFile::create(&path).unwrap();
        file.write_all(b"half").unwrap();
        drop(file);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.csv"]);
    }

    #[test]
    fn a_folder_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        assert!(WholeFile::create(folder.path()).is_err());
        assert!(folder.path().is_dir());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn an_interrupted_program_leaves_no_partial_file() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = WholeFile::create(&folder.path().join("a.csv")).unwrap();
        file.write_all(&[b'x'; 100_000]).unwrap();
        file.flush().unwrap();
        // A program that is killed now removes nothing: there must be nothing to remove.
        assert_eq!(names(folder.path()), [""; 0]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_to_the_file_that_is_written() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let inside = |name: &str| folder.path().join(name);
        fs::write(inside("old.csv"), "old").unwrap();
        symlink("old.csv", inside("to_old")).unwrap();
        symlink("new.csv", inside("to_new")).unwrap();
        symlink("to_new", inside("to_to_new")).unwrap();
        for (link, file) in [("to_old", "old.csv"), ("to_to_new", "new.csv")] {
            write(&inside(link), b"written").unwrap();
            assert!(inside(link).is_symlink());
            assert_eq!(fs::read(inside(file)).unwrap(), b"written");
        }
        assert!(inside("to_new").is_symlink());
        assert_eq!(names(folder.path()).len(), 5);
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_written_directly() {
        let folder = tempfile::tempdir().unwrap();
        write(Path::new("/dev/null"), b"nothing").unwrap();
        let link = folder.path().join("to_null");
        std::os::unix::fs::symlink("/dev/null", &link).unwrap();
        write(&link, b"nothing").unwrap();
        assert!(link.is_symlink() && !Path::new("/dev/null").is_file());
    }

    #[cfg(unix)]
    #[test]
    fn others_may_read_it_as_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (plain, whole) = (folder.path().join("plain"), folder.path().join("whole"));
        fs::write(&plain, "").unwrap();
        write(&whole, b"").unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&whole), mode(&plain));
    }
}
