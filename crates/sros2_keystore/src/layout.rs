//! Names of the files and folders of a keystore, as in SROS 2.

use std::path::{Path, PathBuf};

use crate::enclave_name::EnclaveName;

pub(super) const PUBLIC: &str = "public";
pub(super) const PRIVATE: &str = "private";
pub(super) const ENCLAVES: &str = "enclaves";

pub(super) const CA_CERTIFICATE: &str = "ca.cert.pem";
pub(super) const CA_KEY: &str = "ca.key.pem";
pub(super) const IDENTITY_CA: &str = "identity_ca.cert.pem";
pub(super) const PERMISSIONS_CA: &str = "permissions_ca.cert.pem";
pub(super) const IDENTITY_CA_KEY: &str = "identity_ca.key.pem";
pub(super) const PERMISSIONS_CA_KEY: &str = "permissions_ca.key.pem";

pub(super) const GOVERNANCE_XML: &str = "governance.xml";
pub(super) const GOVERNANCE: &str = "governance.p7s";

pub(super) const CERTIFICATE: &str = "cert.pem";
pub(super) const KEY: &str = "key.pem";
pub(super) const PERMISSIONS_XML: &str = "permissions.xml";
pub(super) const PERMISSIONS: &str = "permissions.p7s";

/// Everything in the folder of an enclave.
pub(super) const FOLDER_CONTENT: [&str; 7] = [
    CERTIFICATE,
    KEY,
    IDENTITY_CA,
    PERMISSIONS_CA,
    GOVERNANCE,
    PERMISSIONS,
    PERMISSIONS_XML,
];

/// Folder of an enclave.
pub(super) fn enclave_folder(keystore: &Path, name: &EnclaveName) -> PathBuf {
    keystore.join(ENCLAVES).join(name.folder())
}

/// The files by which a program of an enclave proves who it is, and knows who else does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IdentityFiles {
    /// Certificate of the authority.
    pub authority: PathBuf,
    /// Certificate of the enclave.
    pub certificate: PathBuf,
    /// Its private key.
    pub key: PathBuf,
}

impl IdentityFiles {
    /// Of an enclave of a keystore; nothing is read.
    #[must_use]
    pub fn of(keystore: &Path, name: &EnclaveName) -> Self {
        let folder = enclave_folder(keystore, name);
        Self {
            authority: keystore.join(PUBLIC).join(IDENTITY_CA),
            certificate: folder.join(CERTIFICATE),
            key: folder.join(KEY),
        }
    }
}

/// Names of links in the folder of an enclave, and what each of them points to, relative to the folder.
pub(super) fn links(name: &EnclaveName) -> [(&'static str, PathBuf); 3] {
    let up: PathBuf = name.folder().iter().map(|_| "..").collect();
    let public = up.join("..").join(PUBLIC);
    [
        (IDENTITY_CA, public.join(IDENTITY_CA)),
        (PERMISSIONS_CA, public.join(PERMISSIONS_CA)),
        (GOVERNANCE, up.join(GOVERNANCE)),
    ]
}
