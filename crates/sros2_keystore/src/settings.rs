//! What the environment and the command line ask for, with the rules of rcl (`rcl/src/rcl/security.c`).

use std::fmt;
use std::path::PathBuf;

use crate::enclave_name::{DEFAULT_ENCLAVE, EnclaveNameError, MAX_SHOWN, enclave_name};

/// Values of `ROS_SECURITY_ENABLE` that are meant as a no.
const NO: [&str; 4] = ["false", "0", "no", "off"];

/// What happens without usable security files: `ROS_SECURITY_STRATEGY`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SecurityStrategy {
    /// Without an enclave the node runs unprotected, with a warning. Everything except `Enforce` means this, as in rcl.
    #[default]
    Permissive,
    /// Without an enclave the node does not start.
    Enforce,
}

impl fmt::Display for SecurityStrategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Permissive => "Permissive",
            Self::Enforce => "Enforce",
        })
    }
}

/// Settings of DDS Security from `ROS_SECURITY_*` and `--enclave`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SecuritySettings {
    /// `ROS_SECURITY_ENABLE=true`; any other value means no.
    pub is_enabled: bool,
    /// A value of `ROS_SECURITY_ENABLE` that is neither `true` nor says no, such as `True` or `1`, which rcl takes for a no.
    pub odd_enable: Option<String>,
    /// `ROS_SECURITY_STRATEGY`.
    pub strategy: SecurityStrategy,
    /// A value of `ROS_SECURITY_STRATEGY` that rcl does not know, such as `enforce`.
    pub odd_strategy: Option<String>,
    /// `ROS_SECURITY_KEYSTORE`.
    pub keystore: Option<PathBuf>,
    /// `ROS_SECURITY_ENCLAVE_OVERRIDE`, or else `--enclave`, or else [`DEFAULT_ENCLAVE`].
    pub enclave: String,
    /// Whether the enclave comes from `ROS_SECURITY_ENCLAVE_OVERRIDE`, which wins over `--enclave`.
    pub is_overridden: bool,
}

impl Default for SecuritySettings {
    /// Security is off.
    fn default() -> Self {
        Self {
            is_enabled: false,
            odd_enable: None,
            strategy: SecurityStrategy::default(),
            odd_strategy: None,
            keystore: None,
            enclave: DEFAULT_ENCLAVE.to_owned(),
            is_overridden: false,
        }
    }
}

impl SecuritySettings {
    /// From the variables that `get` returns; an empty one counts as unset, as in rcl.
    ///
    /// # Errors
    /// `ROS_SECURITY_ENCLAVE_OVERRIDE` is not the name of an enclave while security is enabled.
    pub fn from_variables(get: &impl Fn(&str) -> Option<String>) -> Result<Self, EnclaveNameError> {
        let get = |name: &str| get(name).filter(|value| !value.is_empty());
        let shown = |value: String| value.escape_default().take(MAX_SHOWN).collect();
        let enable = get("ROS_SECURITY_ENABLE");
        let strategy = get("ROS_SECURITY_STRATEGY");
        let mut settings = Self {
            is_enabled: enable.as_deref() == Some("true"),
            strategy: match strategy.as_deref() {
                Some("Enforce") => SecurityStrategy::Enforce,
                _ => SecurityStrategy::Permissive,
            },
            odd_enable: enable
                .filter(|it| it != "true" && !NO.contains(&it.to_lowercase().as_str()))
                .map(shown),
            odd_strategy: strategy
                .filter(|it| !["Enforce", "Permissive"].contains(&it.as_str()))
                .map(shown),
            keystore: get("ROS_SECURITY_KEYSTORE").map(PathBuf::from),
            ..Self::default()
        };
        if settings.is_enabled
            && let Some(name) = get("ROS_SECURITY_ENCLAVE_OVERRIDE")
        {
            settings.enclave = enclave_name("ROS_SECURITY_ENCLAVE_OVERRIDE", &name)?;
            settings.is_overridden = true;
        }
        Ok(settings)
    }

    /// With the enclave of `--enclave`, unless `ROS_SECURITY_ENCLAVE_OVERRIDE` names another.
    #[must_use]
    pub fn with_enclave(mut self, enclave: Option<&str>) -> Self {
        if let Some(enclave) = enclave
            && !self.is_overridden
        {
            enclave.clone_into(&mut self.enclave);
        }
        self
    }

    /// A warning if security is off although the variables look as if it was meant to be on; rcl says nothing then.
    #[must_use]
    pub fn warning_of_security_off(&self) -> Option<String> {
        let why = match (self.is_enabled, &self.odd_enable, self.strategy) {
            (true, ..) | (false, None, SecurityStrategy::Permissive) => return None,
            (false, Some(odd), _) => {
                format!("only ROS_SECURITY_ENABLE=true enables it, found `{odd}`")
            }
            (false, None, SecurityStrategy::Enforce) => {
                "ROS_SECURITY_STRATEGY=Enforce has no effect without ROS_SECURITY_ENABLE=true"
                    .to_owned()
            }
        };
        Some(format!(
            "DDS security is off: {why}. Messages are neither signed nor encrypted, and every peer is accepted; set \
             ROS_SECURITY_ENABLE=true, or unset both variables to run without security"
        ))
    }

    /// The directory of the enclave's files, whether it exists or not; `None` without a keystore.
    #[must_use]
    pub fn enclave_directory(&self) -> Option<PathBuf> {
        let enclaves = self.keystore.as_ref()?.join("enclaves");
        Some(match self.enclave.trim_start_matches('/') {
            "" => enclaves,
            relative => enclaves.join(relative),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(variables: &[(&str, &str)]) -> Result<SecuritySettings, EnclaveNameError> {
        SecuritySettings::from_variables(&|name| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn the_variables_are_read_as_in_rcl() {
        assert_eq!(with(&[]), Ok(SecuritySettings::default()));
        for (value, is_enabled) in [("true", true), ("True", false), ("1", false), ("", false)] {
            let settings = with(&[("ROS_SECURITY_ENABLE", value)]).expect("valid");
            assert_eq!(settings.is_enabled, is_enabled, "{value}");
        }
        for (value, strategy) in [
            ("Enforce", SecurityStrategy::Enforce),
            ("enforce", SecurityStrategy::Permissive),
            ("Permissive", SecurityStrategy::Permissive),
            ("", SecurityStrategy::Permissive),
        ] {
            let settings = with(&[("ROS_SECURITY_STRATEGY", value)]).expect("valid");
            assert_eq!(settings.strategy, strategy, "{value}");
        }
    }

    /// Security was off without a word.
    #[test]
    fn security_that_is_off_by_a_misspelt_value_is_a_warning() {
        let warning = |variables: &[(&str, &str)]| {
            let settings = with(variables).expect("valid").with_enclave(Some("/twin"));
            settings.warning_of_security_off()
        };
        for odd in ["True", "TRUE", "1", "yes", "on", "true "] {
            for strategy in ["Enforce", "Permissive", ""] {
                let variables = [
                    ("ROS_SECURITY_ENABLE", odd),
                    ("ROS_SECURITY_STRATEGY", strategy),
                ];
                let warning = warning(&variables).expect(odd);
                assert!(warning.contains(&format!("found `{odd}`")), "{warning}");
            }
        }
        let enforced = ("ROS_SECURITY_STRATEGY", "Enforce");
        let said = warning(&[enforced]).expect("a warning");
        assert!(said.contains("Enforce has no effect"), "{said}");
        let enabled = [("ROS_SECURITY_ENABLE", "true"), enforced];
        assert_eq!(warning(&enabled), None);
        for no in ["false", "False", "0", "no", "off", ""] {
            assert_eq!(warning(&[("ROS_SECURITY_ENABLE", no)]), None, "{no}");
        }
        assert_eq!(warning(&[]), None);
    }

    #[test]
    fn the_override_wins_over_the_argument_and_the_argument_over_the_default() {
        let keystore = ("ROS_SECURITY_KEYSTORE", "/keys");
        let enabled = ("ROS_SECURITY_ENABLE", "true");
        let settings = with(&[enabled, keystore]).expect("valid");
        assert_eq!(
            settings.enclave_directory(),
            Some(PathBuf::from("/keys/enclaves"))
        );
        let named = settings.with_enclave(Some("/garage/twin"));
        assert_eq!(
            named.enclave_directory(),
            Some(PathBuf::from("/keys/enclaves/garage/twin"))
        );
        let overridden = with(&[
            enabled,
            keystore,
            ("ROS_SECURITY_ENCLAVE_OVERRIDE", "/other"),
        ]);
        let overridden = overridden.expect("valid").with_enclave(Some("/named"));
        assert_eq!(
            overridden.enclave_directory(),
            Some(PathBuf::from("/keys/enclaves/other"))
        );
        assert_eq!(
            with(&[enabled]).expect("valid").enclave_directory(),
            None,
            "without a keystore"
        );
    }

    #[test]
    fn an_override_does_not_lead_out_of_the_keystore() {
        assert!(
            with(&[
                ("ROS_SECURITY_ENABLE", "true"),
                ("ROS_SECURITY_ENCLAVE_OVERRIDE", "../x")
            ])
            .is_err()
        );
        assert!(
            with(&[("ROS_SECURITY_ENCLAVE_OVERRIDE", "../x")]).is_ok(),
            "without effect while security is off"
        );
    }
}
