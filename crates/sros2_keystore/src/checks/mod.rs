//! The enclave of a participant, checked before the participant starts.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - certificates.rs: Certificates and keys of an enclave
// - dates.rs: Dates of certificates and documents
// - documents.rs: The signed documents of an enclave: their signature, and the XML elements that both share
// - enclave.rs: An enclave: the six files of a participant, checked before it starts
// - fault.rs: The files of an enclave, and what can be wrong with them
// - governance.rs: The governance document: how the domain is protected
// - permissions.rs: The permissions document: what the participant may do, and until when

mod certificates;
mod dates;
mod documents;
mod enclave;
mod fault;
mod governance;
mod permissions;

pub use dates::EXPIRY_NOTICE;
pub(crate) use dates::of_certificate;
pub(crate) use documents::domains_of;
pub use enclave::{Enclave, EnclaveError};
pub use fault::{
    Action, ENCLAVE_FILES, EnclaveFault, EnclaveFile, MAX_ENCLAVE_FILE_BYTES, STRICT_FILES,
};
pub use governance::ProtectionKinds;
