//! Reads the files of a keystore.

use std::path::Path;

use bounded_file::read_at_most;
use openssl::x509::X509;

use crate::checks::MAX_ENCLAVE_FILE_BYTES;
use crate::error::KeystoreError;

/// Reads a file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, KeystoreError> {
    read_at_most(path, MAX_ENCLAVE_FILE_BYTES).map_err(KeystoreError::io("read", path))
}

/// Reads a text.
pub(super) fn read_text(path: &Path) -> Result<String, KeystoreError> {
    let text = String::from_utf8(read(path)?);
    text.map_err(|_| KeystoreError::document(path, "expected UTF-8 text"))
}

/// Reads a certificate.
pub(super) fn read_certificate(path: &Path) -> Result<X509, KeystoreError> {
    let certificate = X509::from_pem(&read(path)?);
    certificate.map_err(|_| {
        KeystoreError::document(path, "expected a certificate as PEM text, found none")
    })
}
