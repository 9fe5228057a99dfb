//! The same permissions as a policy for `ros2 security create_permission` and `generate_artifacts`.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::access::EnclavePlan;

/// A policy in the format of SROS 2 (`sros2/policy/schemas/policy.xsd`, version 0.2.0), with a comment at its head that says where it
/// comes from; the comment contains no `--`. SROS 2 adds `ros_discovery_info` itself.
#[must_use]
pub fn policy(enclaves: &[EnclavePlan], comment: &str) -> String {
    let mut xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- {comment} -->\n<policy version=\"0.2.0\">\n  <enclaves>\n"
    );
    for EnclavePlan { name, access } in enclaves {
        // All names are absolute, so the node's namespace and name only label the profile.
        let (namespace, node) = name.namespace_and_node();
        let _ = write!(
            xml,
            "    <enclave path=\"{name}\">\n      <profiles>\n        <profile ns=\"{namespace}\" node=\"{node}\">\n"
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
    xml + "  </enclaves>\n</policy>\n"
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
