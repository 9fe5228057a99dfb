//! Topic names of MQTT from one template.

use std::fmt::Write as _;

use crate::condition::Watched;
use crate::error::TopicFault;

/// Longest topic that MQTT carries \[bytes\] (MQTT 5, 1.5.4).
const MAX_TOPIC: usize = 65_535;

/// A template for topics: text with the fields `{node}`, `{subject}` and `{kind}`.
///
/// `{subject}` becomes `subject`, or `subject/part` where a message is about a part.
/// In a value, each byte outside of `A-Z a-z 0-9 . _ ~ -` is written as `%` and two hexadecimal digits, so that no
/// name can add a level or a wildcard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicTemplate(String);

impl TopicTemplate {
    /// Checks a template.
    ///
    /// # Errors
    ///
    /// If MQTT does not allow the name: it is empty or too long, holds `+`, `#` or a control character, or begins with
    /// `$`, which is for the broker; or if messages about different things would share a topic.
    pub fn new(text: &str) -> Result<Self, TopicFault> {
        if text.is_empty() {
            return Err(TopicFault::Empty);
        }
        if text.starts_with('$') {
            return Err(TopicFault::Reserved);
        }
        if let Some(found) = text
            .chars()
            .find(|it| matches!(it, '+' | '#') || it.is_control())
        {
            return Err(TopicFault::Forbidden(found));
        }
        if text.len() > MAX_TOPIC / 4 {
            return Err(TopicFault::TooLong(text.len()));
        }
        for field in text.split('{').skip(1) {
            let name = field.split('}').next().unwrap_or_default();
            if !field.contains('}') || !matches!(name, "node" | "subject" | "kind") {
                return Err(TopicFault::UnknownField(name.to_owned()));
            }
        }
        for field in ["{subject}", "{kind}"] {
            if !text.contains(field) {
                return Err(TopicFault::Missing(field));
            }
        }
        Ok(Self(text.to_owned()))
    }

    /// The topic of a message.
    pub fn topic(&self, node: &str, watched: &Watched) -> String {
        let mut subject = escaped(&watched.subject);
        if let Some(part) = &watched.part {
            subject.push('/');
            subject.push_str(&escaped(part));
        }
        self.0
            .replace("{kind}", &escaped(&watched.kind))
            .replace("{node}", &escaped(node.trim_start_matches('/')))
            .replace("{subject}", &subject)
    }
}

fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for byte in text.bytes() {
        if byte.is_ascii_alphanumeric() || b"._~-".contains(&byte) {
            escaped.push(char::from(byte));
        } else {
            let _ = write!(escaped, "%{byte:02X}");
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watched(subject: &str, part: Option<&str>) -> Watched {
        Watched {
            kind: "action".to_owned(),
            subject: subject.to_owned(),
            part: part.map(str::to_owned),
        }
    }

    #[test]
    fn a_topic_has_the_levels_of_its_template_whatever_the_names() {
        let template = TopicTemplate::new("site/{node}/{subject}/{kind}").unwrap();
        let topic = template.topic("/garage/twin", &watched("A3", Some("mid")));
        assert_eq!(topic, "site/garage%2Ftwin/A3/mid/action");
        let hostile = template.topic("n", &watched("a/+/#\0$\u{e9}{kind}", None));
        assert_eq!(hostile, "site/n/a%2F%2B%2F%23%00%24%C3%A9%7Bkind%7D/action");
    }

    #[test]
    fn templates_that_mqtt_forbids_are_rejected() {
        for (text, fault) in [
            ("", TopicFault::Empty),
            ("$SYS/{subject}/{kind}", TopicFault::Reserved),
            ("a/+/{subject}/{kind}", TopicFault::Forbidden('+')),
            ("{subject}/{kind}/#", TopicFault::Forbidden('#')),
            ("a\0/{subject}/{kind}", TopicFault::Forbidden('\0')),
            (
                "{subject}/{king}",
                TopicFault::UnknownField("king".to_owned()),
            ),
            (
                "{subject}/{kind",
                TopicFault::UnknownField("kind".to_owned()),
            ),
            ("alarms/{kind}", TopicFault::Missing("{subject}")),
        ] {
            assert_eq!(TopicTemplate::new(text), Err(fault), "{text:?}");
        }
    }
}
