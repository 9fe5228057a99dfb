//! Keystores for DDS security, laid out as SROS 2 lays them out, so that `ros2 security` and every ROS 2 node can use them:
//!
//! ```text
//! DIR/public/ca.cert.pem                    the authority's certificate, with links to it by the names
//!                                           identity_ca.cert.pem and permissions_ca.cert.pem
//! DIR/private/ca.key.pem                    its key, with the same two links
//! DIR/enclaves/governance.{xml,p7s}         what is signed and encrypted, in which domains
//! DIR/enclaves/NAME/{cert,key}.pem          the identity of the programs in this enclave
//! DIR/enclaves/NAME/permissions.{xml,p7s}   what they may publish and subscribe to
//! DIR/enclaves/NAME/...                     links to the authority's certificates and the governance
//! ```
//!
//! The permissions follow from the one table of [`endpoints`](crate::endpoints). All cryptography is OpenSSL's, and so is the
//! randomness of keys and serial numbers; the time comes from the caller. Private keys are written with mode 0600 and are
//! never overwritten.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - access.rs: What the programs of an enclave may publish and subscribe to
// - certificates.rs: Keys, certificates and signatures, all by OpenSSL: elliptic curve P-256 and SHA-256, which DDS Security
//   1.1 asks for and SROS 2 uses
// - documents.rs: The governance and the permissions as XML (DDS Security 1.1, 9.4.1.2 and 9.4.1.3), in the words of SROS 2
// - enclave.rs: Which enclaves a keystore for some twins needs
// - enclave_name.rs: Names of enclaves
// - error.rs: Errors of keystores
// - inspection.rs: What a keystore holds, and what is wrong with it
// - layout.rs: Names of the files and folders of a keystore, as in SROS 2
// - policy.rs: The same permissions as a policy for `ros2 security create_permission` and `generate_artifacts`
// - reading.rs: Reads the files of a keystore
// - store.rs: Making, extending and renewing a keystore on disk

mod access;
mod certificates;
mod documents;
mod enclave;
mod enclave_name;
mod error;
mod inspection;
mod layout;
mod policy;
mod reading;
mod store;

pub use access::{Access, Role};
pub use documents::{DataProtection, DomainRanges, DomainRangesError};
pub use enclave::{EnclavePlan, Twins, plan};
pub use enclave_name::EnclaveName;
pub use error::KeystoreError;
pub use inspection::{EnclaveSummary, KeystoreSummary, UsableEnclave, inspect};
pub use policy::policy;
pub use store::{Addition, Creation, Renewal, add, create, renew};

/// Days for which the certificate and the permissions of an enclave are valid, unless told otherwise. One year: a key that
/// was copied becomes useless by itself, and renewing once a year is little work.
pub const ENCLAVE_DAYS: u32 = 365;

/// Days for which the authority's certificate is valid, unless an enclave needs more: ten years, as in SROS 2.
pub const AUTHORITY_DAYS: u32 = 3650;

/// Most days that anything can be valid: a century, so that no date leaves the range of the certificates' format.
pub const MAX_DAYS: u32 = 36_500;

/// Certificates are valid from one day before they are made, as in SROS 2, so that a clock that is behind accepts them.
const BACKDATED_SECS: i64 = 86_400;
