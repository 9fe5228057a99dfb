#![doc = include_str!("../README.md")]

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - access.rs: What the programs of an enclave may publish and subscribe to
// - certificates.rs: Keys, certificates and signatures, all by OpenSSL: elliptic curve P-256 and SHA-256, which DDS Security
//   1.1 asks for and SROS 2 uses
// - checks/: The enclave of a participant, checked before the participant starts
// - documents.rs: The governance and the permissions as XML (DDS Security 1.1, 9.4.1.2 and 9.4.1.3), in the words of SROS 2
// - domain_ranges.rs: The domains that documents are valid for
// - enclave_name.rs: Names of enclaves
// - error.rs: Errors of keystores
// - inspection.rs: What a keystore holds, and what is wrong with it
// - layout.rs: Names of the files and folders of a keystore, as in SROS 2
// - policy.rs: The same permissions as a policy for `ros2 security create_permission` and `generate_artifacts`
// - reading.rs: Reads the files of a keystore
// - settings.rs: What the environment and the command line ask for, with the rules of rcl (`rcl/src/rcl/security.c`)
// - store.rs: Making, extending and renewing a keystore on disk

#[cfg(feature = "openssl")]
mod access;
#[cfg(feature = "openssl")]
mod certificates;
#[cfg(feature = "openssl")]
mod checks;
#[cfg(feature = "openssl")]
mod documents;
mod domain_ranges;
mod enclave_name;
#[cfg(feature = "openssl")]
mod error;
#[cfg(feature = "openssl")]
mod inspection;
#[cfg(feature = "openssl")]
mod layout;
#[cfg(feature = "openssl")]
mod policy;
#[cfg(feature = "openssl")]
mod reading;
mod settings;
#[cfg(feature = "openssl")]
mod store;

#[cfg(feature = "openssl")]
pub use access::{Access, EnclavePlan};
#[cfg(feature = "openssl")]
pub use checks::{
    Action, ENCLAVE_FILES, EXPIRY_NOTICE, Enclave, EnclaveError, EnclaveFault, EnclaveFile,
    MAX_ENCLAVE_FILE_BYTES, ProtectionKinds, STRICT_FILES,
};
#[cfg(feature = "openssl")]
pub use documents::DataProtection;
pub use domain_ranges::{DomainRanges, DomainRangesError, MAX_DOMAIN_ID};
pub use enclave_name::{DEFAULT_ENCLAVE, EnclaveName, EnclaveNameError, enclave_name};
#[cfg(feature = "openssl")]
pub use error::{KeystoreError, Remedy};
#[cfg(feature = "openssl")]
pub use inspection::{EnclaveSummary, KeystoreSummary, UsableEnclave, Warning, inspect};
#[cfg(feature = "openssl")]
pub use layout::IdentityFiles;
#[cfg(feature = "openssl")]
pub use policy::policy;
pub use settings::{SecuritySettings, SecurityStrategy};
#[cfg(feature = "openssl")]
pub use store::{
    AUTHORITY_DAYS, Addition, Creation, ENCLAVE_DAYS, MAX_DAYS, Renewal, add, create, renew,
};
