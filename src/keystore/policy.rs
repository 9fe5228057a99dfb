//! The same permissions as a policy for `ros2 security create_permission` and `generate_artifacts`.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::access::Access;
use super::enclave::EnclavePlan;
use super::error::KeystoreError;

/// A policy in the format of SROS 2 (`sros2/policy/schemas/policy.xsd`, version 0.2.0). SROS 2 adds `ros_discovery_info` itself.
///
/// # Errors
/// A name is invalid.
pub fn policy(enclaves: &[EnclavePlan]) -> Result<String, KeystoreError> {
    let mut xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
                   <!-- Made by `column-twin keystore policy` from the table of the node's topics and services. -->\n\
                   <policy version=\"0.2.0\">\n  <enclaves>\n"
        .to_owned();
    for enclave in enclaves {
        let access = Access::of(enclave.role, &enclave.name, &enclave.twins)?;
        // All names are absolute, so the node's namespace and name only label the profile.
        let (namespace, node) = enclave.name.as_str().rsplit_once('/').unwrap_or_default();
        let namespace = if namespace.is_empty() { "/" } else { namespace };
        let _ = write!(
            xml,
            "    <enclave path=\"{}\">\n      <profiles>\n        <profile ns=\"{namespace}\" node=\"{node}\">\n",
            enclave.name
        );
        for (list, name, attribute, names) in [
            ("topics", "topic", "publish", &access.publish),
            ("topics", "topic", "subscribe", &access.subscribe),
            ("services", "service", "reply", &access.reply),
            ("services", "service", "request", &access.request),
        ] {
            list_xml(&mut xml, list, name, attribute, names);
        }
        xml += "        </profile>\n      </profiles>\n    </enclave>\n";
    }
    Ok(xml + "  </enclaves>\n</policy>\n")
}

fn list_xml(xml: &mut String, list: &str, name: &str, attribute: &str, names: &BTreeSet<String>) {
    // The schema wants at least one name.
    if names.is_empty() {
        return;
    }
    let _ = writeln!(xml, "          <{list} {attribute}=\"ALLOW\">");
    for full in names {
        let _ = writeln!(xml, "            <{name}>{full}</{name}>");
    }
    let _ = writeln!(xml, "          </{list}>");
}
