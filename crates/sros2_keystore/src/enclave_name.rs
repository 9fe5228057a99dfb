//! Names of enclaves.

use std::fmt;
use std::path::PathBuf;

/// The enclave of a process that names none, as in rcl.
pub const DEFAULT_ENCLAVE: &str = "/";

/// How much of a text from outside a message shows \[characters\].
pub(crate) const MAX_SHOWN: usize = 200;

/// The name of an enclave is invalid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EnclaveNameError {
    /// It is no name.
    #[error(
        "{origin}: expected the full name of an enclave such as /talker or /garage/talker (letters, digits and _; no \
         part begins with a digit), found `{name}`"
    )]
    Invalid {
        /// The argument or variable that names it.
        origin: &'static str,
        /// The name.
        name: String,
    },
    /// The name is that of the folder above all enclaves.
    #[error("`/` is no enclave of its own; write a name such as /monitor or /garage/a3/talker")]
    Root,
    /// The name does not fit into a certificate.
    #[error(
        "the name of the enclave has {found} characters; the common name of a certificate has at most {max}, so shorten it"
    )]
    Long {
        /// Its length.
        found: usize,
        /// The limit.
        max: usize,
    },
}

/// Checks the name of an enclave, which must not lead out of the keystore. The name is returned as it is.
///
/// # Errors
/// It is not `/`, nor a sequence of parts that ROS accepts as a namespace.
pub fn enclave_name(origin: &'static str, name: &str) -> Result<String, EnclaveNameError> {
    let is_part = |part: &str| {
        part.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
            && part
                .chars()
                .all(|it| it.is_ascii_alphanumeric() || it == '_')
    };
    let is_valid = name == DEFAULT_ENCLAVE
        || name
            .strip_prefix('/')
            .is_some_and(|parts| parts.split('/').all(is_part));
    if is_valid {
        Ok(name.to_owned())
    } else {
        Err(EnclaveNameError::Invalid {
            origin,
            name: name.escape_default().take(MAX_SHOWN).collect(),
        })
    }
}

/// Name of an enclave, such as `/monitor` or `/garage/a3/talker`: it begins with a slash and has at least one part.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct EnclaveName(String);

impl EnclaveName {
    /// Most characters: the name is the common name of a certificate, which has at most 64.
    const MAX_LENGTH: usize = 64;

    /// Checks the name.
    ///
    /// # Errors
    /// It is not the name of an enclave, it is that of the folder above all enclaves, or too long for a certificate.
    pub fn new(name: &str) -> Result<Self, EnclaveNameError> {
        let name = enclave_name("the enclave", name)?;
        if name == DEFAULT_ENCLAVE {
            return Err(EnclaveNameError::Root);
        }
        if name.len() > Self::MAX_LENGTH {
            return Err(EnclaveNameError::Long {
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
        self.namespace_and_node().1
    }

    /// Namespace and name of the node that is called as the enclave: `/` and `monitor` for `/monitor`.
    #[must_use]
    pub fn namespace_and_node(&self) -> (&str, &str) {
        match self.0.rsplit_once('/').unwrap_or_default() {
            ("", node) => ("/", node),
            names => names,
        }
    }

    /// The folder of the enclave below `enclaves/`.
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        self.0.split('/').skip(1).collect()
    }
}

impl fmt::Display for EnclaveName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_an_enclave_does_not_lead_out_of_the_keystore() {
        for valid in ["/", "/talker", "/garage/a_3/talker"] {
            assert_eq!(enclave_name("-e", valid).as_deref(), Ok(valid));
        }
        for wrong in [
            "", "twin", "//", "/a/", "/../b", "/a//b", "/a/..", "/3a", "/a b", "/a\0", "/\u{e4}",
        ] {
            assert!(enclave_name("-e", wrong).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn an_enclave_is_a_folder_and_a_node() {
        let of = |text: &str| EnclaveName::new(text).expect(text);
        let nested = of("/garage/a3/talker");
        assert_eq!(nested.namespace_and_node(), ("/garage/a3", "talker"));
        assert_eq!(nested.folder(), PathBuf::from("garage/a3/talker"));
        assert_eq!(of("/monitor").namespace_and_node(), ("/", "monitor"));
        assert_eq!(EnclaveName::new("/"), Err(EnclaveNameError::Root));
        of(&format!("/{}", "x".repeat(63)));
        let long = EnclaveName::new(&format!("/{}", "x".repeat(64)));
        assert_eq!(long, Err(EnclaveNameError::Long { found: 65, max: 64 }));
    }
}
