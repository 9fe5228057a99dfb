//! Errors of keystores.

use std::io;
use std::path::{Path, PathBuf};

use crate::ros::NameError;
use crate::ros::security::EnclaveNameError;

/// Why a keystore cannot be made, changed or read.
#[derive(Debug, thiserror::Error)]
pub enum KeystoreError {
    /// The folder of a new keystore is in use.
    #[error(
        "{} exists and is not empty, and nothing in it is overwritten; choose another folder, or add an enclave to an existing \
         keystore: column-twin keystore add {} /NAME=monitor", .0.display(), .0.display()
    )]
    Occupied(PathBuf),
    /// The folder is no keystore.
    #[error(
        "{} is not a keystore: there is no {missing}; make one with: column-twin keystore create {}", path.display(),
        path.display()
    )]
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
        "the enclave {0} exists, and its key is not overwritten; to extend its validity: column-twin keystore renew DIR {0}; to \
         replace a key that became known, delete the folder of the enclave first"
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
    /// An enclave is named twice.
    #[error("the enclave {0} is named twice; name it once, with one role")]
    Twice(String),
    /// A name of an enclave is invalid.
    #[error(transparent)]
    EnclaveName(#[from] EnclaveNameError),
    /// The name is that of the whole keystore.
    #[error(
        "`/` is no enclave of its own; write a name such as /monitor or /garage/a3/column_twin"
    )]
    NoName,
    /// The name does not fit into a certificate.
    #[error(
        "the name of the enclave has {found} characters; the common name of a certificate has at most {max}, so shorten it"
    )]
    LongName {
        /// Its length.
        found: usize,
        /// The limit.
        max: usize,
    },
    /// A name of a node, topic or service is invalid.
    #[error(transparent)]
    NodeName(#[from] NameError),
    /// The role is unknown.
    #[error("`{0}` gives the enclave no role; write NAME=twin, NAME=monitor or NAME=operator")]
    Role(String),
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
        "the enclave would be valid until {wanted}, but the authority's certificate expires on {authority}; choose fewer \
         --days, or renew the authority too: column-twin keystore renew DIR --authority"
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

impl KeystoreError {
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
