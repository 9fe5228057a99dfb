//! The state of security for `/diagnostics`.

use crate::messages::diagnostic_msgs::DiagnosticStatus;

#[cfg(feature = "security")]
use ros_node::security::now;
use ros_node::security::{Peers, Protection};

/// Level, message and values of the status `security`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct SecurityHealth {
    pub level: u8,
    pub message: String,
    pub values: Vec<(String, String)>,
}

/// The state of this protection; `None` if security is off.
pub(super) fn security_health(protection: &Protection, peers: &Peers) -> Option<SecurityHealth> {
    match protection {
        Protection::Off => None,
        Protection::Unprotected(warning) => Some(SecurityHealth {
            level: DiagnosticStatus::WARN,
            message: warning.clone(),
            values: counts(peers),
        }),
        #[cfg(feature = "security")]
        Protection::Enclave(enclave) => Some(enclave_health(enclave, peers, now())),
    }
}

#[cfg(feature = "security")]
fn enclave_health(
    enclave: &sros2_keystore::Enclave,
    peers: &Peers,
    now: jiff::Timestamp,
) -> SecurityHealth {
    let (over, coming) = enclave.near_ends(now);
    let weak: Vec<_> = coming
        .into_iter()
        .chain(enclave.exposed_key.clone())
        .collect();
    let (level, message) = match (over.is_empty(), weak.is_empty()) {
        (true, true) => (DiagnosticStatus::OK, "protected".to_owned()),
        (true, false) => (DiagnosticStatus::WARN, weak.join("; ")),
        (false, _) => (DiagnosticStatus::ERROR, over.join("; ")),
    };
    let text = |key: &str, value: &dyn ToString| (key.to_owned(), value.to_string());
    let mut values = vec![
        text("enclave", &enclave.name),
        text("subject", &enclave.subject),
        text("protection", &enclave.kinds),
    ];
    let ends = enclave.ends.iter();
    values.extend(ends.map(|(file, until)| (format!("{file} valid until"), until.to_string())));
    values.extend(counts(peers));
    SecurityHealth {
        level,
        message,
        values,
    }
}

fn counts(peers: &Peers) -> Vec<(String, String)> {
    vec![
        ("peers joined".to_owned(), peers.joined().to_string()),
        ("peers rejected".to_owned(), peers.rejected().to_string()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use ros_node::security::protection;
    use sros2_keystore::{SecuritySettings, SecurityStrategy};

    #[test]
    fn a_misspelt_request_for_security_is_a_warning_in_diagnostics() {
        let peers = Peers::default();
        assert_eq!(security_health(&Protection::Off, &peers), None);
        let settings = SecuritySettings {
            odd_enable: Some("True".to_owned()),
            strategy: SecurityStrategy::Enforce,
            ..SecuritySettings::default()
        };
        let misspelt = protection(&settings, 0).expect("goes on");
        let health = security_health(&misspelt, &peers).expect("a status");
        assert_eq!(health.level, DiagnosticStatus::WARN);
        assert!(
            health.message.contains("found `True`"),
            "{}",
            health.message
        );
    }
}
