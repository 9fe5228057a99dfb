//! The environment variables of ROS 2 for domain, discovery and namespace.

use std::net::Ipv4Addr;

use sros2_keystore::{EnclaveNameError, MAX_DOMAIN_ID, SecuritySettings};

/// Where the node discovers others and can be discovered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DiscoveryRange {
    /// On this machine only; nothing is sent to other machines.
    Localhost,
    /// By multicast on every network of this machine.
    Subnet,
}

/// How messages travel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Transport {
    /// By DDS.
    #[default]
    Dds,
    /// By Zenoh, as `rmw_zenoh` speaks it.
    Zenoh,
}

/// The variables of `rmw_zenoh`; they mean something only with [`Transport::Zenoh`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ZenohVariables {
    /// `ZENOH_SESSION_CONFIG_URI`: the file with the configuration of the session.
    pub session_config: Option<String>,
    /// `ZENOH_CONFIG_OVERRIDE`: settings in the form `key=value;key=value` that win over the configuration.
    pub config_override: Option<String>,
    /// `ZENOH_ROUTER_CHECK_ATTEMPTS`: a negative number means that no router is expected.
    pub router_check_attempts: Option<String>,
}

/// Settings from the environment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Environment {
    /// `ROS_DOMAIN_ID`, 0 to 232.
    pub domain_id: u16,
    /// `ROS_AUTOMATIC_DISCOVERY_RANGE` and `ROS_LOCALHOST_ONLY`.
    pub discovery_range: DiscoveryRange,
    /// `ROS_NAMESPACE`, with a leading `/`.
    pub namespace: String,
    /// `ROS_SECURITY_*` and `--enclave`.
    pub security: SecuritySettings,
    /// `--transport`.
    pub transport: Transport,
    /// The variables of rmw_zenoh.
    pub zenoh: ZenohVariables,
    /// Invalid or unsupported settings, to be logged at the start.
    pub warnings: Vec<String>,
}

/// Settings that are invalid, or unsupported and must not be ignored.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EnvironmentError {
    /// The domain is invalid.
    #[error("ROS_DOMAIN_ID: expected a whole number from 0 to {MAX_DOMAIN_ID}, found `{0}`")]
    DomainId(String),
    /// Discovery is switched off.
    #[error(
        "ROS_AUTOMATIC_DISCOVERY_RANGE=OFF is not supported: RustDDS cannot switch discovery off, and other nodes would \
         discover this one; use LOCALHOST, which restricts discovery to this machine"
    )]
    DiscoveryOff,
    /// The enclave is invalid.
    #[error(transparent)]
    Enclave(#[from] EnclaveNameError),
}

impl Default for Environment {
    /// The settings without any of the variables.
    fn default() -> Self {
        Self {
            domain_id: 0,
            discovery_range: DiscoveryRange::Subnet,
            namespace: "/".to_owned(),
            security: SecuritySettings::default(),
            transport: Transport::default(),
            zenoh: ZenohVariables::default(),
            warnings: Vec::new(),
        }
    }
}

impl Environment {
    /// The settings of this process.
    ///
    /// # Errors
    /// See [`EnvironmentError`].
    pub fn of_process() -> Result<Self, EnvironmentError> {
        Self::from_variables(|name| std::env::var(name).ok())
    }

    /// From the variables that `get` returns; an empty one counts as unset, as in rcl.
    ///
    /// # Errors
    /// See [`EnvironmentError`].
    pub fn from_variables(get: impl Fn(&str) -> Option<String>) -> Result<Self, EnvironmentError> {
        let get = |name: &str| get(name).filter(|value| !value.is_empty());
        let mut warnings = Vec::new();
        let localhost_only = get("ROS_LOCALHOST_ONLY").is_some_and(|value| value == "1");
        let discovery_range = if localhost_only {
            if get("ROS_AUTOMATIC_DISCOVERY_RANGE").is_some() || get("ROS_STATIC_PEERS").is_some() {
                warnings.push(
                    "ROS_LOCALHOST_ONLY=1 is deprecated and overrides ROS_AUTOMATIC_DISCOVERY_RANGE and ROS_STATIC_PEERS"
                        .to_owned(),
                );
            }
            DiscoveryRange::Localhost
        } else {
            warnings.extend(peers_warning(get("ROS_STATIC_PEERS").as_deref()));
            discovery_range(
                get("ROS_AUTOMATIC_DISCOVERY_RANGE").as_deref(),
                &mut warnings,
            )?
        };
        Ok(Self {
            domain_id: domain_id(get("ROS_DOMAIN_ID"))?,
            discovery_range,
            namespace: get("ROS_NAMESPACE").map_or_else(
                || "/".to_owned(),
                |namespace| format!("/{}", namespace.trim_matches('/')),
            ),
            security: SecuritySettings::from_variables(&get)?,
            transport: Transport::default(),
            zenoh: ZenohVariables {
                session_config: get("ZENOH_SESSION_CONFIG_URI"),
                config_override: get("ZENOH_CONFIG_OVERRIDE"),
                router_check_attempts: get("ZENOH_ROUTER_CHECK_ATTEMPTS"),
            },
            warnings,
        })
    }
}

fn domain_id(value: Option<String>) -> Result<u16, EnvironmentError> {
    let Some(value) = value else {
        return Ok(0);
    };
    match value.trim().parse() {
        Ok(id) if id <= MAX_DOMAIN_ID => Ok(id),
        _ => Err(EnvironmentError::DomainId(value)),
    }
}

fn discovery_range(
    value: Option<&str>,
    warnings: &mut Vec<String>,
) -> Result<DiscoveryRange, EnvironmentError> {
    match value {
        None | Some("SUBNET" | "SYSTEM_DEFAULT") => Ok(DiscoveryRange::Subnet),
        Some("LOCALHOST") => Ok(DiscoveryRange::Localhost),
        Some("OFF") => Err(EnvironmentError::DiscoveryOff),
        // As in rcl: a typing error must not extend discovery.
        Some(other) => {
            warnings.push(format!(
                "ROS_AUTOMATIC_DISCOVERY_RANGE: expected OFF, LOCALHOST, SUBNET or SYSTEM_DEFAULT, found `{other}`; \
                 using LOCALHOST"
            ));
            Ok(DiscoveryRange::Localhost)
        }
    }
}

/// RustDDS contacts this machine and the multicast group and does not support a list of further peers.
fn peers_warning(value: Option<&str>) -> Option<String> {
    let far: Vec<_> = value?
        .split(';')
        .map(str::trim)
        .filter(|peer| !peer.is_empty() && !is_this_machine(peer))
        .collect();
    (!far.is_empty()).then(|| {
        format!(
            "ROS_STATIC_PEERS is not supported by RustDDS, which will not contact {}; peers on this machine and in the \
             same subnet are discovered without it, others need a DDS router",
            far.join(", ")
        )
    })
}

fn is_this_machine(peer: &str) -> bool {
    peer == "localhost" || peer.parse::<Ipv4Addr>().is_ok_and(|ip| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(variables: &[(&str, &str)]) -> Result<Environment, EnvironmentError> {
        Environment::from_variables(|name| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| (*value).to_owned())
        })
    }

    fn range(value: &str) -> Result<DiscoveryRange, EnvironmentError> {
        with(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", value)]).map(|it| it.discovery_range)
    }

    #[test]
    fn the_default_applies_when_nothing_is_set() {
        assert_eq!(with(&[]), Ok(Environment::default()));
        assert_eq!(
            with(&[("ROS_DOMAIN_ID", ""), ("ROS_NAMESPACE", "")]),
            Ok(Environment::default())
        );
    }

    #[test]
    fn domains() {
        let domain = |value| with(&[("ROS_DOMAIN_ID", value)]).map(|it| it.domain_id);
        assert_eq!(domain("42"), Ok(42));
        assert_eq!(domain("232"), Ok(232));
        for wrong in ["233", "-1", "a", "1.5", "99999999"] {
            assert_eq!(
                domain(wrong),
                Err(EnvironmentError::DomainId(wrong.to_owned()))
            );
        }
    }

    #[test]
    fn ranges() {
        assert_eq!(range("LOCALHOST"), Ok(DiscoveryRange::Localhost));
        assert_eq!(range("SUBNET"), Ok(DiscoveryRange::Subnet));
        assert_eq!(range("SYSTEM_DEFAULT"), Ok(DiscoveryRange::Subnet));
        assert_eq!(range("OFF"), Err(EnvironmentError::DiscoveryOff));
        assert_eq!(range("localhost"), Ok(DiscoveryRange::Localhost));
        let odd = with(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "ALL")]).expect("goes on");
        assert!(odd.warnings[0].contains("found `ALL`; using LOCALHOST"));
    }

    #[test]
    fn localhost_only_is_still_supported() {
        let old = with(&[
            ("ROS_LOCALHOST_ONLY", "1"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"),
        ])
        .expect("goes on");
        assert_eq!(old.discovery_range, DiscoveryRange::Localhost);
        assert!(old.warnings[0].contains("deprecated"));
        let off = with(&[("ROS_LOCALHOST_ONLY", "0")]).expect("goes on");
        assert_eq!(off, Environment::default());
    }

    #[test]
    fn peers_that_are_not_contacted_are_named() {
        let here = with(&[("ROS_STATIC_PEERS", "localhost;127.0.0.1; ")]).expect("goes on");
        assert!(here.warnings.is_empty());
        let far =
            with(&[("ROS_STATIC_PEERS", "192.168.0.1;127.0.0.1;far.example")]).expect("goes on");
        assert!(
            far.warnings[0].contains("will not contact 192.168.0.1, far.example"),
            "{far:?}"
        );
    }

    #[test]
    fn namespaces_have_a_leading_slash() {
        for (given, expected) in [
            ("garage", "/garage"),
            ("/garage/a3/", "/garage/a3"),
            ("/", "/"),
        ] {
            let environment = with(&[("ROS_NAMESPACE", given)]).expect("goes on");
            assert_eq!(environment.namespace, expected);
        }
    }

    #[test]
    fn settings_of_security_are_read() {
        let environment = with(&[
            ("ROS_SECURITY_ENABLE", "true"),
            ("ROS_SECURITY_KEYSTORE", "/keys"),
            ("ROS_SECURITY_ENCLAVE_OVERRIDE", "/twin"),
        ]);
        let directory = environment.expect("goes on").security.enclave_directory();
        assert_eq!(directory, Some("/keys/enclaves/twin".into()));
        let wrong = with(&[
            ("ROS_SECURITY_ENABLE", "true"),
            ("ROS_SECURITY_ENCLAVE_OVERRIDE", "../twin"),
        ]);
        assert!(matches!(wrong, Err(EnvironmentError::Enclave(_))));
    }
}
