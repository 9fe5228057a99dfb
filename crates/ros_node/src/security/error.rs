//! Why a participant must not be created.

#[cfg(feature = "security")]
use sros2_keystore::EnclaveError;

/// Why a participant must not be created.
#[derive(Debug, thiserror::Error)]
pub enum SecurityError {
    /// Security is enforced, but there is no keystore.
    #[error(
        "SECURITY ERROR: ROS_SECURITY_STRATEGY=Enforce requires a keystore, but ROS_SECURITY_KEYSTORE is not set; set it to \
         the directory that contains `enclaves`"
    )]
    NoKeystore,
    /// Security is enforced, but this program does not contain it.
    #[error(
        "SECURITY ERROR: ROS_SECURITY_STRATEGY=Enforce, but this program was built without DDS security; build it with \
         `--features security` (needs OpenSSL: Debian's libssl-dev and pkg-config)"
    )]
    NotBuilt,
    /// The enclave does not exist, which is an error if security is enforced; or it exists and cannot be used, whatever the strategy.
    #[cfg(feature = "security")]
    #[error(transparent)]
    Enclave(#[from] EnclaveError),
}
