//! DDS Security: which enclave a participant belongs to, and whether its files can be used.
//!
//! The settings and the messages are those of rcl. RustDDS authenticates, encrypts and enforces the permissions; the checks
//! of the crate `sros2_keystore` come before it.
//!
//! Without the feature `security`, only the settings exist: a node that must be protected does not start.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - error.rs: Why a participant must not be created
// - peers.rs: Peers that joined with a valid identity, and peers that were rejected: counted, and logged within a limit

mod error;
mod peers;

#[cfg(feature = "security")]
use sros2_keystore::{Enclave, EnclaveError};
use sros2_keystore::{SecuritySettings, SecurityStrategy};

pub use error::SecurityError;
pub use peers::Peers;

/// How a participant is protected.
#[derive(Debug)]
pub enum Protection {
    /// Security is not enabled.
    Off,
    /// The participant is unprotected for this reason: security is enabled, but not enforced, and there is no enclave; or it is
    /// not enabled, but the variables look as if it was meant to be.
    Unprotected(String),
    /// The participant belongs to this enclave.
    #[cfg(feature = "security")]
    Enclave(Box<Enclave>),
}

/// The time of day.
#[cfg(feature = "security")]
#[must_use]
pub fn now() -> jiff::Timestamp {
    jiff::Timestamp::now()
}

/// Determines the protection of a participant in a domain. Every program that opens a participant calls this first.
///
/// # Errors
/// Security is enforced, but there is no enclave; or the enclave exists, but cannot be used.
pub fn protection(
    settings: &SecuritySettings,
    domain_id: u16,
) -> Result<Protection, SecurityError> {
    if !settings.is_enabled {
        let warning = settings.warning_of_security_off();
        return Ok(warning.map_or(Protection::Off, Protection::Unprotected));
    }
    match enclave(settings, domain_id) {
        // Files that exist but are broken are an accident or an attack; running unprotected would hide it.
        #[cfg(feature = "security")]
        Err(error @ SecurityError::Enclave(EnclaveError::Broken { .. })) => Err(error),
        Err(error) if settings.strategy == SecurityStrategy::Enforce => Err(error),
        Err(error) => Ok(Protection::Unprotected(unprotected(settings, &error))),
        Ok(protection) => Ok(protection),
    }
}

#[cfg(feature = "security")]
fn enclave(settings: &SecuritySettings, domain_id: u16) -> Result<Protection, SecurityError> {
    let directory = settings
        .enclave_directory()
        .ok_or(SecurityError::NoKeystore)?;
    let enclave = Enclave::load(&settings.enclave, &directory, domain_id, now())?;
    Ok(Protection::Enclave(Box::new(enclave)))
}

#[cfg(not(feature = "security"))]
fn enclave(_: &SecuritySettings, _: u16) -> Result<Protection, SecurityError> {
    Err(SecurityError::NotBuilt)
}

/// The warning of a participant that runs unprotected in spite of `ROS_SECURITY_ENABLE=true`.
fn unprotected(settings: &SecuritySettings, error: &SecurityError) -> String {
    let reason = match error {
        SecurityError::NoKeystore => "ROS_SECURITY_KEYSTORE is not set".to_owned(),
        SecurityError::NotBuilt => {
            "this program was built without DDS security (build it with `--features security`)"
                .to_owned()
        }
        #[cfg(feature = "security")]
        SecurityError::Enclave(error) => match error {
            EnclaveError::NoDirectory(directory) => {
                format!("directory '{}' does not exist", directory.display())
            }
            EnclaveError::NoFiles(directory) => format!(
                "directory '{}' contains none of the files of an enclave",
                directory.display()
            ),
            broken @ EnclaveError::Broken { .. } => broken.to_string(),
        },
    };
    let strategy = match &settings.odd_strategy {
        Some(odd) => format!("ROS_SECURITY_STRATEGY=`{odd}`, which means the same as Permissive"),
        None => format!("ROS_SECURITY_STRATEGY={}", settings.strategy),
    };
    format!(
        "ROS_SECURITY_ENABLE=true, but messages are neither signed nor encrypted, and every peer is accepted: {reason}. With \
         {strategy}, this is not an error; set it to Enforce to require security"
    )
}

impl Protection {
    /// Whether the participant belongs to an enclave, so that its peers have to prove who they are.
    pub fn has_enclave(&self) -> bool {
        !matches!(self, Self::Off | Self::Unprotected(_))
    }

    /// Logs what holds from now on.
    pub fn announce(&self) {
        match self {
            Self::Off => {}
            Self::Unprotected(warning) => tracing::warn!("{warning}"),
            #[cfg(feature = "security")]
            Self::Enclave(enclave) => {
                tracing::info!("{}", enclave.summary());
                for warning in enclave.warnings(now()) {
                    tracing::warn!("{warning}");
                }
            }
        }
    }

    /// The warning of a client, which has no log, for its terminal.
    #[must_use]
    pub fn warning(&self) -> Option<&str> {
        match self {
            Self::Unprotected(warning) => Some(warning),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    fn settings(strategy: SecurityStrategy, keystore: Option<&str>) -> SecuritySettings {
        SecuritySettings {
            is_enabled: true,
            strategy,
            keystore: keystore.map(PathBuf::from),
            ..SecuritySettings::default()
        }
        .with_enclave(Some("/nobody"))
    }

    #[test]
    fn security_that_is_off_needs_nothing() {
        let off = protection(&SecuritySettings::default(), 0).expect("off");
        assert!(matches!(off, Protection::Off));
    }

    #[test]
    fn enforcing_security_without_an_enclave_is_rejected_and_permissive_warns() {
        for keystore in [None, Some("/nonexistent")] {
            let enforced = protection(&settings(SecurityStrategy::Enforce, keystore), 0);
            let text = enforced.expect_err("rejected").to_string();
            assert!(text.starts_with("SECURITY ERROR: "), "{text}");
            let permissive = protection(&settings(SecurityStrategy::Permissive, keystore), 0);
            let warning = permissive.expect("goes on");
            let warning = warning.warning().expect("a warning").to_owned();
            assert!(
                warning.contains("neither signed nor encrypted"),
                "{warning}"
            );
        }
    }

    #[test]
    fn the_warning_names_the_strategy_that_was_found() {
        let variables = [
            ("ROS_SECURITY_ENABLE", "true"),
            ("ROS_SECURITY_STRATEGY", "enforce"),
        ];
        let settings = SecuritySettings::from_variables(&|name| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| (*value).to_owned())
        });
        let protection = protection(&settings.expect("valid"), 0).expect("goes on");
        let said = protection.warning().expect("a warning");
        assert!(said.contains("STRATEGY=`enforce`"), "{said}");
        assert!(!said.contains("STRATEGY=Permissive"), "{said}");
    }

    #[test]
    fn a_misspelt_request_for_security_is_a_warning() {
        let settings = SecuritySettings {
            odd_enable: Some("True".to_owned()),
            strategy: SecurityStrategy::Enforce,
            ..SecuritySettings::default()
        };
        let off = protection(&settings, 0).expect("goes on");
        assert!(off.warning().is_some_and(|it| it.contains("found `True`")));
    }

    #[cfg(feature = "security")]
    #[test]
    fn a_missing_enclave_is_described_as_in_rcl() {
        let error = protection(
            &settings(SecurityStrategy::Enforce, Some("/nonexistent")),
            0,
        );
        let text = error.expect_err("rejected").to_string();
        assert!(
            text.starts_with(
                "SECURITY ERROR: directory '/nonexistent/enclaves/nobody' does not exist."
            ),
            "{text}"
        );
    }

    #[cfg(not(feature = "security"))]
    #[test]
    fn a_program_without_security_names_the_flag_to_build_it_with() {
        let error = protection(
            &settings(SecurityStrategy::Enforce, Some("/nonexistent")),
            0,
        );
        let text = error.expect_err("rejected").to_string();
        assert!(text.contains("--features security"), "{text}");
    }
}
