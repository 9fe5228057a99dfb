//! Names of enclaves.

use std::fmt;
use std::path::PathBuf;

use crate::ros::security::{DEFAULT_ENCLAVE, enclave_name};
use crate::ros::{NameError, Names};

use super::error::KeystoreError;

/// Name of an enclave, such as `/monitor` or `/garage/a3/column_twin`: it begins with a slash and has at least one part.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct EnclaveName(String);

impl EnclaveName {
    /// Most characters: the name is the common name of a certificate, which has at most 64.
    const MAX_LENGTH: usize = 64;

    /// Checks the name.
    ///
    /// # Errors
    /// It is not the name of an enclave, it is that of the whole keystore, or too long for a certificate.
    pub fn new(name: &str) -> Result<Self, KeystoreError> {
        let name = enclave_name("the enclave", name)?;
        if name == DEFAULT_ENCLAVE {
            return Err(KeystoreError::NoName);
        }
        if name.len() > Self::MAX_LENGTH {
            return Err(KeystoreError::LongName {
                found: name.len(),
                max: Self::MAX_LENGTH,
            });
        }
        Ok(Self(name))
    }

    /// The name as text, with its slash.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The last part of the name.
    #[must_use]
    pub fn last(&self) -> &str {
        self.0.rsplit('/').next().unwrap_or_default()
    }

    /// The folder of the enclave below `enclaves/`.
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        self.0.split('/').skip(1).collect()
    }

    /// The node with the name of the enclave.
    pub(super) fn node(&self) -> Result<Names, NameError> {
        let (namespace, node) = self.0.rsplit_once('/').unwrap_or_default();
        let namespace = if namespace.is_empty() { "/" } else { namespace };
        Names::new(namespace, node, &[])
    }
}

impl fmt::Display for EnclaveName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}
