//! The governance document: how the domain is protected.

use std::fmt;

use roxmltree::Node;

use super::documents::{child, children, domains_of, parse, text_of};
use super::fault::{EnclaveFault, EnclaveFile};

/// The protection kinds of a domain as the governance document names them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProtectionKinds {
    /// `rtps_protection_kind`
    pub rtps: String,
    /// `discovery_protection_kind`
    pub discovery: String,
    /// `liveliness_protection_kind`
    pub liveliness: String,
    /// `metadata_protection_kind` of the topic rules, in their order, without repetition.
    pub metadata: Vec<String>,
    /// `data_protection_kind` of the topic rules, in their order, without repetition.
    pub data: Vec<String>,
}

impl fmt::Display for ProtectionKinds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            rtps,
            discovery,
            liveliness,
            metadata,
            data,
        } = self;
        let (metadata, data) = (metadata.join("/"), data.join("/"));
        write!(
            f,
            "rtps {rtps}, discovery {discovery}, liveliness {liveliness}, metadata {metadata}, data {data}"
        )
    }
}

/// What governs the domain of the participant.
#[derive(Debug)]
pub(super) struct Governance {
    pub kinds: ProtectionKinds,
    /// Peers without a certificate take part.
    pub allows_unauthenticated: bool,
    topics: Vec<TopicRule>,
}

#[derive(Debug)]
struct TopicRule {
    expression: glob::Pattern,
    protects_reading: bool,
    protects_writing: bool,
}

/// The kinds of protection that a whole message or submessage may have.
const KINDS: [&str; 5] = [
    "NONE",
    "SIGN",
    "ENCRYPT",
    "SIGN_WITH_ORIGIN_AUTHENTICATION",
    "ENCRYPT_WITH_ORIGIN_AUTHENTICATION",
];

impl Governance {
    /// The rules for a domain. `None` after a fault that leaves nothing to check.
    pub fn read(text: &str, domain_id: u16, faults: &mut Vec<EnclaveFault>) -> Option<Self> {
        let file = EnclaveFile::Governance;
        let document = match parse(file, text) {
            Ok(document) => document,
            Err(fault) => {
                faults.push(fault);
                return None;
            }
        };
        Self::of_document(document.root(), domain_id, faults)
            .inspect_err(|reason| {
                faults.push(EnclaveFault::Document {
                    file,
                    reason: reason.clone(),
                });
            })
            .ok()
            .flatten()
    }

    fn of_document(
        root: Node<'_, '_>,
        domain_id: u16,
        faults: &mut Vec<EnclaveFault>,
    ) -> Result<Option<Self>, String> {
        let rules = child(child(root, "dds")?, "domain_access_rules")?;
        let mut others = Vec::new();
        for rule in children(rules, "domain_rule") {
            let domains = domains_of(rule)?;
            // The first rule for the domain applies, as in RustDDS (DDS Security 9.4.1.2.7).
            if domains.contain(domain_id) {
                return Self::of_rule(rule, faults).map(Some);
            }
            others.push(domains.to_string());
        }
        faults.push(EnclaveFault::Domain {
            file: EnclaveFile::Governance,
            domain_id,
            found: others.join(", "),
        });
        Ok(None)
    }

    fn of_rule(rule: Node<'_, '_>, faults: &mut Vec<EnclaveFault>) -> Result<Self, String> {
        let mut kind = |node: Node<'_, '_>, name: &'static str, topics: &str, known: &[&str]| {
            let found = text_of(node, name)?.to_owned();
            if !known.contains(&found.as_str()) {
                faults.push(EnclaveFault::ProtectionKind {
                    element: name,
                    topics: topics.to_owned(),
                    found: found.clone(),
                    expected: known.join(", "),
                });
            }
            Ok::<_, String>(found)
        };
        let mut kinds = ProtectionKinds {
            rtps: kind(rule, "rtps_protection_kind", "", &KINDS)?,
            discovery: kind(rule, "discovery_protection_kind", "", &KINDS)?,
            liveliness: kind(rule, "liveliness_protection_kind", "", &KINDS)?,
            metadata: Vec::new(),
            data: Vec::new(),
        };
        let add = |to: &mut Vec<String>, kind: String| {
            if !to.contains(&kind) {
                to.push(kind);
            }
        };
        let mut topics = Vec::new();
        for topic in children(child(rule, "topic_access_rules")?, "topic_rule") {
            let expression = text_of(topic, "topic_expression")?;
            let metadata = kind(topic, "metadata_protection_kind", expression, &KINDS)?;
            // RustDDS does not read its own signed payloads: see the fault's text.
            let data = kind(
                topic,
                "data_protection_kind",
                expression,
                &["NONE", "ENCRYPT"],
            )?;
            add(&mut kinds.metadata, metadata);
            add(&mut kinds.data, data);
            topics.push(TopicRule {
                expression: glob::Pattern::new(expression).map_err(|error| {
                    format!("the topic_expression `{expression}` is not a pattern: {error}")
                })?,
                protects_reading: flag(topic, "enable_read_access_control")?,
                protects_writing: flag(topic, "enable_write_access_control")?,
            });
        }
        Ok(Self {
            kinds,
            allows_unauthenticated: flag(rule, "allow_unauthenticated_participants")?,
            topics,
        })
    }

    /// Whether publishing needs a permission; a topic without a rule needs one.
    pub fn protects_writing(&self, topic: &str) -> bool {
        self.rule(topic).is_none_or(|it| it.protects_writing)
    }

    /// Whether subscribing needs a permission.
    pub fn protects_reading(&self, topic: &str) -> bool {
        self.rule(topic).is_none_or(|it| it.protects_reading)
    }

    fn rule(&self, topic: &str) -> Option<&TopicRule> {
        self.topics.iter().find(|it| it.expression.matches(topic))
    }

    /// The topics that any authenticated peer may read or write, whatever its permissions say.
    pub fn open_topics(&self) -> Vec<&str> {
        let open = |it: &&TopicRule| !it.protects_reading || !it.protects_writing;
        let open = self.topics.iter().filter(open);
        open.map(|it| it.expression.as_str()).collect()
    }
}

fn flag(node: Node<'_, '_>, name: &'static str) -> Result<bool, String> {
    match text_of(node, name)? {
        "true" | "TRUE" | "1" => Ok(true),
        "false" | "FALSE" | "0" => Ok(false),
        other => Err(format!("<{name}>: expected true or false, found `{other}`")),
    }
}
