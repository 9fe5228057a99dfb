//! The files of an enclave, and what can be wrong with them.

use std::fmt;

use jiff::Timestamp;

/// A file of an enclave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EnclaveFile {
    /// The certificate of the authority that issues identities.
    IdentityCa,
    /// The certificate of the participant.
    Certificate,
    /// The private key that belongs to it.
    Key,
    /// The certificate of the authority that signs governance and permissions.
    PermissionsCa,
    /// How the domain is protected.
    Governance,
    /// What the participant may do.
    Permissions,
}

/// The files with their names, as SROS 2 lays them out.
pub const ENCLAVE_FILES: [(EnclaveFile, &str); 6] = [
    (EnclaveFile::IdentityCa, "identity_ca.cert.pem"),
    (EnclaveFile::Certificate, "cert.pem"),
    (EnclaveFile::Key, "key.pem"),
    (EnclaveFile::PermissionsCa, "permissions_ca.cert.pem"),
    (EnclaveFile::Governance, "governance.p7s"),
    (EnclaveFile::Permissions, "permissions.p7s"),
];

/// Maximum size of a file \[bytes\]; genuine ones have some kilobytes.
pub const MAX_ENCLAVE_FILE_BYTES: u64 = 1 << 20;

/// A file at the top of a keystore by which its private keys must not be readable by others. [`create`](crate::create) writes it;
/// SROS 2 does not know it.
pub const STRICT_FILES: &str = "security.strict_files";

impl EnclaveFile {
    /// Its name in the directory of the enclave.
    #[must_use]
    pub fn name(self) -> &'static str {
        let file = ENCLAVE_FILES.iter().find(|(file, _)| *file == self);
        file.map_or("", |(_, name)| *name)
    }
}

impl fmt::Display for EnclaveFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What is wrong with an enclave, one fault each.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EnclaveFault {
    /// A file is missing.
    #[error(
        "{0} is missing; create the enclave completely, with the program that made the keystore or `ros2 security create_enclave`"
    )]
    Missing(EnclaveFile),
    /// A file cannot be read.
    #[error("{file} cannot be read: {reason}")]
    Unreadable {
        /// The file.
        file: EnclaveFile,
        /// The error of the system.
        reason: String,
    },
    /// Others can read the private key, and the keystore forbids it.
    #[error("{0}; the file {STRICT_FILES} of the keystore demands it")]
    ExposedKey(String),
    /// A PEM file does not contain what it should.
    #[error("{file}: expected {expected} in PEM format, but it cannot be read: {reason}")]
    NotPem {
        /// The file.
        file: EnclaveFile,
        /// What it should contain.
        expected: &'static str,
        /// The error of OpenSSL.
        reason: String,
    },
    /// The key has a password.
    #[error(
        "key.pem is encrypted with a password, which RustDDS does not support; decrypt it with `openssl pkey`, and protect it by its file permissions"
    )]
    EncryptedKey,
    /// The key is in an older format.
    #[error(
        "key.pem is not in PKCS#8 format (BEGIN PRIVATE KEY), the only one that RustDDS reads; convert it with `openssl pkcs8 -topk8 -nocrypt`"
    )]
    NotPkcs8,
    /// The algorithm of a key is not supported.
    #[error(
        "{file} uses {found}; RustDDS supports EC keys on prime256v1 (as `ros2 security` makes them) and RSA with 2048 bits"
    )]
    Algorithm {
        /// The file.
        file: EnclaveFile,
        /// The algorithm.
        found: String,
    },
    /// The key is not that of the certificate.
    #[error(
        "key.pem is not the private key of cert.pem ({subject}), so that every peer would reject this node; restore the key that was made with the certificate, or make both again"
    )]
    ForeignKey {
        /// The subject of the certificate.
        subject: String,
    },
    /// A certificate has expired.
    #[error(
        "{file} ({subject}) expired on {until} (it is {now}); renew it, or correct the clock of this machine"
    )]
    CertificateExpired {
        /// The file.
        file: EnclaveFile,
        /// The subject.
        subject: String,
        /// Its last second.
        until: Timestamp,
        /// The time of the check.
        now: Timestamp,
    },
    /// A certificate is not valid yet.
    #[error(
        "{file} ({subject}) is not valid before {from} (it is {now}); check the clock of this machine"
    )]
    CertificateNotYetValid {
        /// The file.
        file: EnclaveFile,
        /// The subject.
        subject: String,
        /// Its first second.
        from: Timestamp,
        /// The time of the check.
        now: Timestamp,
    },
    /// The certificate was not issued by the identity CA.
    #[error(
        "cert.pem ({subject}) was not issued by identity_ca.cert.pem ({authority}), but by `{issuer}` or by another key of that name; use the files of one keystore"
    )]
    ForeignCertificate {
        /// The subject of the certificate.
        subject: String,
        /// The issuer that the certificate names.
        issuer: String,
        /// The subject of the identity CA.
        authority: String,
    },
    /// A document was not signed by the permissions CA, or was changed.
    #[error(
        "{file} does not carry a valid signature of permissions_ca.cert.pem ({authority}): {reason}; sign it again, and do not edit signed documents"
    )]
    Signature {
        /// The document.
        file: EnclaveFile,
        /// The subject of the permissions CA.
        authority: String,
        /// The error of OpenSSL.
        reason: String,
    },
    /// A document cannot be understood.
    #[error("{file}: {reason}")]
    Document {
        /// The document.
        file: EnclaveFile,
        /// What is wrong.
        reason: String,
    },
    /// No rule of a document is for the domain.
    #[error(
        "{file} has no rule for the domain {domain_id} (it has rules for: {found}); set ROS_DOMAIN_ID to one of them, or sign the document for this domain"
    )]
    Domain {
        /// The document.
        file: EnclaveFile,
        /// The domain of the participant.
        domain_id: u16,
        /// The domains of the rules.
        found: String,
    },
    /// The permissions are for other subjects.
    #[error(
        "permissions.p7s has no grant for the subject of cert.pem: expected `{subject}`, found `{found}`; use the files of one enclave"
    )]
    NoGrant {
        /// The subject of the certificate.
        subject: String,
        /// The subjects of the document.
        found: String,
    },
    /// The grant is not valid at this time.
    #[error(
        "permissions.p7s is valid from {from} to {until} only (it is {now}); sign it again with new dates, or correct the clock of this machine"
    )]
    PermissionsNotValid {
        /// First second.
        from: Timestamp,
        /// The second after the last one.
        until: Timestamp,
        /// The time of the check.
        now: Timestamp,
    },
    /// A protection kind does not exist, or RustDDS does not support it.
    #[error("governance.p7s: {element}{} is `{found}`, expected one of {expected}{}", of_topics(.topics), sign_advice(.element, .found))]
    ProtectionKind {
        /// The element.
        element: &'static str,
        /// The expression of the topic rule; empty for the domain rule.
        topics: String,
        /// The kind.
        found: String,
        /// What is supported.
        expected: String,
    },
    /// The participant lacks a permission without which no node starts.
    #[error(
        "permissions.p7s does not permit to {action} {topic}, without which no node can start; add the topic to the allow_rule for domain {domain_id}"
    )]
    NotPermitted {
        /// What it must be permitted to do.
        action: Action,
        /// The topic.
        topic: &'static str,
        /// The domain of the participant.
        domain_id: u16,
    },
}

fn of_topics(topics: &str) -> String {
    match topics {
        "" => String::new(),
        topics => format!(" of the topics `{topics}`"),
    }
}

/// A signed payload is padded on the wire and carries no length, so that RustDDS cannot find its end.
fn sign_advice(element: &str, found: &str) -> &'static str {
    if element == "data_protection_kind" && found == "SIGN" {
        "; RustDDS loses signed payloads, and metadata_protection_kind ENCRYPT with data_protection_kind NONE protects the same data"
    } else {
        ""
    }
}

/// What a participant does with a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// It publishes.
    Publish,
    /// It subscribes.
    Subscribe,
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Publish => "publish",
            Self::Subscribe => "subscribe to",
        })
    }
}
