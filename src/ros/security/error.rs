//! Why a participant must not be created.

use std::path::PathBuf;

#[cfg(feature = "security")]
use super::fault::EnclaveFault;

/// Why a participant must not be created.
#[derive(Debug, thiserror::Error)]
pub enum SecurityError {
    /// Security is enforced, but there is no keystore.
    #[error(
        "SECURITY ERROR: ROS_SECURITY_STRATEGY=Enforce requires a keystore, but ROS_SECURITY_KEYSTORE is not set; set it to \
         the directory that contains `enclaves`"
    )]
    NoKeystore,
    /// Security is enforced, but the enclave does not exist.
    #[error(
        "SECURITY ERROR: directory '{}' does not exist. Choose an enclave of the keystore with --ros-args --enclave or \
         ROS_SECURITY_ENCLAVE_OVERRIDE, or create this one",
        .0.display()
    )]
    NoDirectory(PathBuf),
    /// Security is enforced, but the directory contains no files of an enclave.
    #[error(
        "SECURITY ERROR: directory '{}' contains none of the files of an enclave (cert.pem, key.pem and others). Choose an \
         enclave of the keystore with --ros-args --enclave or ROS_SECURITY_ENCLAVE_OVERRIDE, or create this one",
        .0.display()
    )]
    NoFiles(PathBuf),
    /// Security is enforced, but this program does not contain it.
    #[error(
        "SECURITY ERROR: ROS_SECURITY_STRATEGY=Enforce, but this program was built without DDS security; build it with \
         `--features security` (needs OpenSSL: Debian's libssl-dev and pkg-config)"
    )]
    NotBuilt,
    /// The enclave exists, but cannot be used, whatever the strategy.
    #[cfg(feature = "security")]
    #[error("SECURITY ERROR: the enclave in '{}' cannot be used:{}", .directory.display(), listed(.faults))]
    Broken {
        /// Its directory.
        directory: PathBuf,
        /// All faults that were found; not empty.
        faults: Vec<EnclaveFault>,
    },
}

#[cfg(feature = "security")]
fn listed(faults: &[EnclaveFault]) -> String {
    faults.iter().map(|fault| format!("\n- {fault}")).collect()
}
