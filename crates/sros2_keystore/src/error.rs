//! Errors of keystores.

use std::io;
use std::path::{Path, PathBuf};

/// Why a keystore cannot be made, changed or read.
#[derive(Debug, thiserror::Error)]
pub enum KeystoreError {
    /// The folder of a new keystore is in use.
    #[error(
        "{} exists and is not empty, and nothing in it is overwritten; choose another folder, or add an enclave to an existing \
         keystore", .0.display()
    )]
    Occupied(PathBuf),
    /// The folder is no keystore.
    #[error("{} is not a keystore: there is no {missing}; choose another folder, or make a keystore", path.display())]
    NotAKeystore {
        /// The folder.
        path: PathBuf,
        /// What it lacks.
        missing: String,
    },
    /// The authority's key is elsewhere.
    #[error(
        "{} is missing: only the machine with the authority's key can sign; run the command there and copy the folder of the \
         enclave", .0.display()
    )]
    NoAuthority(PathBuf),
    /// The authority's key does not belong to its certificate.
    #[error(
        "{} is not the key of {}: its signatures would be rejected by every node; restore the two from one backup",
        key.display(), certificate.display()
    )]
    ForeignKey {
        /// The key.
        key: PathBuf,
        /// The certificate.
        certificate: PathBuf,
    },
    /// The enclave exists.
    #[error(
        "the enclave {0} exists, and its key is not overwritten; to replace a key that became known, delete the folder of the \
         enclave first; to extend its validity, renew it"
    )]
    Exists(String),
    /// The enclave does not exist.
    #[error("there is no enclave {name} in this keystore; it has {known}")]
    NoEnclave {
        /// The enclave.
        name: String,
        /// Those that there are.
        known: String,
    },
    /// The validity is out of range.
    #[error("expected a validity of 1 to {max} days, found {found}")]
    Days {
        /// The value.
        found: u32,
        /// Upper limit.
        max: u32,
    },
    /// The authority would expire before the enclave.
    #[error(
        "the enclave would be valid until {wanted}, but the authority's certificate expires on {authority}; choose fewer days, or \
         renew the authority too"
    )]
    OutlivesAuthority {
        /// End of the enclave.
        wanted: String,
        /// End of the authority.
        authority: String,
    },
    /// A document cannot be understood.
    #[error("{}: {reason}", path.display())]
    Document {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A file or folder cannot be read or written.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// OpenSSL failed.
    #[error("OpenSSL cannot {action}: {source}")]
    OpenSsl {
        /// What was tried.
        action: &'static str,
        /// Its error.
        source: openssl::error::ErrorStack,
    },
}

/// What settles an error or a warning: a function of this crate, so that a program can name its command for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Remedy {
    /// [`create`](crate::create) makes a keystore in this folder.
    Create(PathBuf),
    /// [`add`](crate::add) adds an enclave to the keystore in this folder.
    Add(PathBuf),
    /// [`renew`](crate::renew) renews the enclave of this name.
    Renew(String),
    /// [`renew`](crate::renew) renews the authority.
    RenewAuthority,
}

impl KeystoreError {
    /// What settles it, where a function of this crate does.
    #[must_use]
    pub fn remedy(&self) -> Option<Remedy> {
        match self {
            Self::Occupied(folder) => Some(Remedy::Add(folder.clone())),
            Self::NotAKeystore { path, .. } => Some(Remedy::Create(path.clone())),
            Self::Exists(name) => Some(Remedy::Renew(name.clone())),
            Self::OutlivesAuthority { .. } => Some(Remedy::RenewAuthority),
            _ => None,
        }
    }

    /// Whether the command was given something wrong, rather than failing at it.
    #[must_use]
    pub fn is_bad_input(&self) -> bool {
        !matches!(self, Self::Io { .. } | Self::OpenSsl { .. })
    }

    pub(super) fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io {
            action,
            path,
            source,
        }
    }

    pub(super) fn openssl(action: &'static str) -> impl FnOnce(openssl::error::ErrorStack) -> Self {
        move |source| Self::OpenSsl { action, source }
    }

    pub(super) fn document(path: &Path, reason: impl ToString) -> Self {
        Self::Document {
            path: path.to_path_buf(),
            reason: reason.to_string(),
        }
    }
}
