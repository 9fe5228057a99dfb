//! The permissions document: what the participant may do, and until when.

use glob::Pattern;
use jiff::Timestamp;
use roxmltree::Node;

use crate::domain_ranges::DomainRanges;

use super::dates;
use super::documents::{child, children, domains_of, parse, text_of};
use super::fault::{Action, EnclaveFault, EnclaveFile};

/// The grant of one subject.
#[derive(Debug)]
pub(super) struct Grant {
    pub not_before: Timestamp,
    pub not_after: Timestamp,
    rules: Vec<Rule>,
    allows_the_rest: bool,
}

#[derive(Debug)]
struct Rule {
    allows: bool,
    domains: DomainRanges,
    publish: Vec<Pattern>,
    subscribe: Vec<Pattern>,
}

impl Grant {
    /// The grant for this subject. `None` after a fault that leaves nothing to check.
    pub fn read(
        text: &str,
        subject: &str,
        now: Timestamp,
        faults: &mut Vec<EnclaveFault>,
    ) -> Option<Self> {
        let file = EnclaveFile::Permissions;
        let document = match parse(file, text) {
            Ok(document) => document,
            Err(fault) => {
                faults.push(fault);
                return None;
            }
        };
        match Self::of_document(document.root(), subject, now) {
            Ok(grant) => grant.map_err(|fault| faults.push(fault)).ok(),
            Err(reason) => {
                faults.push(EnclaveFault::Document { file, reason });
                None
            }
        }
    }

    /// As RustDDS chooses it: the first grant of the subject that is valid now.
    fn of_document(
        root: Node<'_, '_>,
        subject: &str,
        now: Timestamp,
    ) -> Result<Result<Self, EnclaveFault>, String> {
        let permissions = child(child(root, "dds")?, "permissions")?;
        let (mut others, mut untimely) = (Vec::new(), None);
        for grant in children(permissions, "grant") {
            let name = text_of(grant, "subject_name")?;
            if !is_same_name(name, subject) {
                others.push(name.to_owned());
                continue;
            }
            let grant = Self::of_grant(grant)?;
            if (grant.not_before..grant.not_after).contains(&now) {
                return Ok(Ok(grant));
            }
            untimely.get_or_insert(EnclaveFault::PermissionsNotValid {
                from: grant.not_before,
                until: grant.not_after,
                now,
            });
        }
        Ok(Err(untimely.unwrap_or(EnclaveFault::NoGrant {
            subject: subject.to_owned(),
            found: others.join("; "),
        })))
    }

    fn of_grant(grant: Node<'_, '_>) -> Result<Self, String> {
        let validity = child(grant, "validity")?;
        let date = |name| {
            let text = text_of(validity, name)?;
            dates::of_document(text).ok_or_else(|| {
                format!("<{name}>: expected a date such as 2026-01-31T12:00:00, found `{text}`")
            })
        };
        let is_rule =
            |it: &Node<'_, '_>| it.has_tag_name("allow_rule") || it.has_tag_name("deny_rule");
        let rules = grant.children().filter(is_rule);
        Ok(Self {
            not_before: date("not_before")?,
            not_after: date("not_after")?,
            rules: rules.map(Rule::of).collect::<Result<_, _>>()?,
            allows_the_rest: match text_of(grant, "default")? {
                "ALLOW" => true,
                "DENY" => false,
                other => {
                    return Err(format!(
                        "<default>: expected ALLOW or DENY, found `{other}`"
                    ));
                }
            },
        })
    }

    /// Whether any rule is for this domain; otherwise the participant may not join it.
    pub fn is_for(&self, domain_id: u16) -> bool {
        let mut rules = self.rules.iter();
        self.allows_the_rest || rules.any(|it| it.allows && it.domains.contain(domain_id))
    }

    /// The domains of the rules, for messages.
    pub fn domains(&self) -> String {
        let rules = self.rules.iter().filter(|it| it.allows);
        let domains: Vec<_> = rules.map(|it| it.domains.to_string()).collect();
        domains.join(", ")
    }

    /// Whether an action is permitted: the first rule that applies decides (DDS Security 9.4.1.3.2.3).
    pub fn permits(&self, action: Action, domain_id: u16, topic: &str) -> bool {
        let applies = |rule: &&Rule| {
            let topics = match action {
                Action::Publish => &rule.publish,
                Action::Subscribe => &rule.subscribe,
            };
            rule.domains.contain(domain_id) && topics.iter().any(|it| it.matches(topic))
        };
        let decisive = self.rules.iter().find(applies);
        decisive.map_or(self.allows_the_rest, |it| it.allows)
    }
}

impl Rule {
    fn of(node: Node<'_, '_>) -> Result<Self, String> {
        let patterns = |name| {
            let mut patterns = Vec::new();
            for criterion in children(node, name) {
                for topic in children(child(criterion, "topics")?, "topic") {
                    let text = topic.text().unwrap_or_default().trim();
                    patterns.push(Pattern::new(text).map_err(|error| {
                        format!("the topic `{text}` is not a pattern: {error}")
                    })?);
                }
            }
            Ok::<_, String>(patterns)
        };
        Ok(Self {
            allows: node.has_tag_name("allow_rule"),
            domains: domains_of(node)?,
            publish: patterns("publish")?,
            subscribe: patterns("subscribe")?,
        })
    }
}

/// Whether two names have the same parts, such as `CN=/twin,O=garage` and `O=garage, CN=/twin`. RustDDS is stricter about
/// the order, and names its own error.
fn is_same_name(one: &str, other: &str) -> bool {
    let parts = |name: &str| {
        let mut parts: Vec<_> = name.split(',').map(|it| it.trim().to_owned()).collect();
        parts.sort_unstable();
        parts
    };
    parts(one) == parts(other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_compared_by_their_parts() {
        assert!(is_same_name("CN=/talker", "CN=/talker"));
        assert!(is_same_name("CN=/twin,O=garage", "O=garage, CN=/twin"));
        assert!(!is_same_name("CN=/twin", "CN=/twin2"));
        assert!(!is_same_name("CN=/twin", "CN=/twin,O=garage"));
    }
}
