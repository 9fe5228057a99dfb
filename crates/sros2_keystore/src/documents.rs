//! The governance and the permissions as XML (DDS Security 1.1, 9.4.1.2 and 9.4.1.3), in the words of SROS 2.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use jiff::Timestamp;

use crate::access::Access;
use crate::domain_ranges::DomainRanges;
use crate::enclave_name::EnclaveName;

/// How the payload of a message is protected by itself, besides the submessage around it, which is always encrypted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DataProtection {
    /// Not once more. The payload is still encrypted on the wire, as a part of its submessage.
    ///
    /// This is our default, and the only difference to SROS 2's: a payload that is encrypted by itself costs a second
    /// encryption of every message, and RustDDS cannot receive one of more than 64 kB.
    #[default]
    None,
    /// Encrypted by itself, as in SROS 2's default.
    Encrypt,
}

impl DataProtection {
    /// The word of the governance.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::None => "NONE",
            Self::Encrypt => "ENCRYPT",
        }
    }
}

/// The governance: only participants with a valid identity and permissions may join, every message is signed, and discovery,
/// liveliness and all submessages are encrypted.
pub(super) fn governance_xml(domains: &DomainRanges, data: DataProtection) -> String {
    let domains = domains_xml(domains, "      ");
    let data = data.word();
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
{domains}      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>{data}</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
"#
    )
}

/// From when until when something is valid \[s since 1970\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Validity {
    /// First second.
    pub from: i64,
    /// Last second.
    pub until: i64,
}

/// The permissions of an enclave; what is not named is denied.
pub(super) fn permissions_xml(
    enclave: &EnclaveName,
    access: &Access,
    domains: &DomainRanges,
    validity: Validity,
) -> String {
    let domains = domains_xml(domains, "        ");
    let publish = criteria_xml("publish", &access.dds_publish());
    let subscribe = criteria_xml("subscribe", &access.dds_subscribe());
    let (from, until) = (xml_time(validity.from), xml_time(validity.until));
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name="{enclave}">
      <subject_name>CN={enclave}</subject_name>
      <validity>
        <not_before>{from}</not_before>
        <not_after>{until}</not_after>
      </validity>
      <allow_rule>
{domains}{publish}{subscribe}      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
"#
    )
}

fn domains_xml(domains: &DomainRanges, indent: &str) -> String {
    let mut xml = format!("{indent}<domains>\n");
    for range in domains.ranges() {
        let (first, last) = (range.start(), range.end());
        let _ = match first == last {
            true => writeln!(xml, "{indent}  <id>{first}</id>"),
            false => writeln!(
                xml,
                "{indent}  <id_range>\n{indent}    <min>{first}</min>\n{indent}    <max>{last}</max>\n{indent}  </id_range>"
            ),
        };
    }
    xml + &format!("{indent}</domains>\n")
}

fn criteria_xml(action: &str, topics: &BTreeSet<String>) -> String {
    let mut xml = format!("        <{action}>\n          <topics>\n");
    for topic in topics {
        let _ = writeln!(xml, "            <topic>{topic}</topic>");
    }
    xml + &format!("          </topics>\n        </{action}>\n")
}

/// A time as SROS 2 writes it: UTC without a zone, to the second.
pub(super) fn xml_time(secs: i64) -> String {
    let time = Timestamp::from_second(secs).unwrap_or_default();
    time.strftime("%Y-%m-%dT%H:%M:%S").to_string()
}

/// A date in UTC for people.
pub(super) fn date(secs: i64) -> String {
    let time = Timestamp::from_second(secs).unwrap_or_default();
    time.strftime("%Y-%m-%d %H:%M UTC").to_string()
}

/// The permissions with another validity in every grant; everything else stays as it is, also what was written by hand.
///
/// # Errors
/// The reason why the text is not a permissions document.
pub(super) fn with_validity(xml: &str, validity: Validity) -> Result<String, String> {
    let document = roxmltree::Document::parse(xml).map_err(|error| error.to_string())?;
    let mut replacements = Vec::new();
    for node in document.descendants() {
        let time = match node.tag_name().name() {
            "not_before" => validity.from,
            "not_after" => validity.until,
            _ => continue,
        };
        let text = node.first_child().filter(roxmltree::Node::is_text);
        let text = text.ok_or_else(|| format!("<{}> is empty", node.tag_name().name()))?;
        replacements.push((text.range(), xml_time(time)));
    }
    if replacements.is_empty() {
        return Err("expected a grant with a validity, found none".to_owned());
    }
    let mut renewed = xml.to_owned();
    // From the end, so that earlier places stay where they are.
    for (range, time) in replacements.into_iter().rev() {
        renewed.replace_range(range, &time);
    }
    Ok(renewed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn documents_are_well_formed_and_name_the_domains() {
        let domains: DomainRanges = "0,4-6".parse().expect("domains");
        let name = EnclaveName::new("/monitor").expect("a name");
        let validity = Validity {
            from: 1_795_246_800,
            until: 1_795_246_801,
        };
        let permissions = permissions_xml(&name, &Access::default(), &domains, validity);
        for xml in [
            governance_xml(&domains, DataProtection::None),
            permissions.clone(),
        ] {
            let document = roxmltree::Document::parse(&xml).expect("XML");
            let texts = |tag: &'static str| -> Vec<_> {
                let nodes = document.descendants();
                nodes
                    .filter(|it| it.has_tag_name(tag))
                    .filter_map(|it| it.text())
                    .collect()
            };
            assert_eq!(texts("id"), ["0"]);
            assert_eq!((texts("min"), texts("max")), (vec!["4"], vec!["6"]));
        }
        assert!(permissions.contains("<not_after>2026-11-21T07:40:01</not_after>"));
    }

    #[test]
    fn only_the_validity_changes_and_comments_stay() {
        let xml = "<dds><!-- ours --><validity><not_before>2020-01-01T00:00:00</not_before>\n\
                   <not_after>2021-01-01T00:00:00</not_after></validity><topic>rt/own</topic></dds>";
        let validity = Validity {
            from: 0,
            until: 86_400,
        };
        assert_eq!(
            with_validity(xml, validity).as_deref(),
            Ok(
                "<dds><!-- ours --><validity><not_before>1970-01-01T00:00:00</not_before>\n\
                   <not_after>1970-01-02T00:00:00</not_after></validity><topic>rt/own</topic></dds>"
            )
        );
        for wrong in ["", "<dds/>", "<dds><not_after/></dds>", "<dds>"] {
            assert!(with_validity(wrong, validity).is_err(), "{wrong}");
        }
    }
}
