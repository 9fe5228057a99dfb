//! Names of topics and services: validation, expansion and remapping
//! (<https://design.ros2.org/articles/topic_and_service_names.html>, static remapping as in rcl).

use std::fmt;

use ros_interface::names::{full_name_fault, namespace_fault, part_fault};

/// Longest full name of a topic or service, as in rmw.
const MAX_TOPIC: usize = 247;

/// Longest name of a node, as in rmw.
const MAX_NODE_NAME: usize = 255;

/// A name is invalid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{name}` is not a valid {what}: {reason}")]
pub struct NameError {
    /// The name as written.
    pub name: String,
    /// Kind of name.
    pub what: &'static str,
    /// What is wrong with it.
    pub reason: &'static str,
}

/// Which names a remapping rule applies to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RemapTarget {
    /// `__node` or `__name`: the node's own name.
    NodeName,
    /// `__ns`: the node's namespace.
    Namespace,
    /// `rostopic://from`: topics only.
    Topic,
    /// `rosservice://from`: services only.
    Service,
    /// A plain name: topics and services.
    TopicOrService,
}

/// A remapping rule `-r [node:]from:=to`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RemapRule {
    /// The node that it applies to; `None`: every node of the process.
    pub node: Option<String>,
    /// The names that it applies to.
    pub target: RemapTarget,
    /// The name to replace; empty for the node's own name and namespace.
    pub from: String,
    /// The replacement.
    pub to: String,
}

/// Kind of a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NameKind {
    /// A topic.
    Topic,
    /// A service.
    Service,
}

/// The node's own name and the rules for the names that it uses.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Names {
    namespace: String,
    node: String,
    rules: Vec<RemapRule>,
}

impl Names {
    /// The names of a node called `node` in `namespace`, unless a rule renames it.
    ///
    /// # Errors
    /// A rule or the environment contains an invalid name.
    pub fn new(namespace: &str, node: &str, rules: &[RemapRule]) -> Result<Self, NameError> {
        let first = |target: RemapTarget| {
            rules
                .iter()
                .find(|rule| {
                    rule.target == target && rule.node.as_deref().is_none_or(|name| name == node)
                })
                .map(|rule| rule.to.as_str())
        };
        let namespace = first(RemapTarget::Namespace).unwrap_or(namespace);
        let renamed = first(RemapTarget::NodeName).unwrap_or(node);
        check_namespace(namespace)?;
        check_node_name(renamed)?;
        let names = Self {
            namespace: namespace.to_owned(),
            node: renamed.to_owned(),
            // A rule may refer to the node by its original name or by its new name.
            rules: rules
                .iter()
                .filter(|rule| {
                    rule.node
                        .as_deref()
                        .is_none_or(|name| name == node || name == renamed)
                })
                .cloned()
                .collect(),
        };
        for rule in &names.rules {
            if matches!(
                rule.target,
                RemapTarget::Topic | RemapTarget::Service | RemapTarget::TopicOrService
            ) {
                names.expand(&rule.from)?;
                names.expand(&rule.to)?;
            }
        }
        Ok(names)
    }

    /// Namespace, such as `/` or `/garage/a3`.
    #[must_use]
    pub fn namespace(&self) -> &str {
        &self.namespace
    }

    /// Name without the namespace.
    #[must_use]
    pub fn node(&self) -> &str {
        &self.node
    }

    /// Fully qualified name, such as `/garage/a3/column_twin`.
    #[must_use]
    pub fn fully_qualified(&self) -> String {
        joined(&self.namespace, &self.node)
    }

    /// Name of the node's logger as in rcl, such as `garage.a3.column_twin`.
    #[must_use]
    pub fn logger(&self) -> String {
        self.fully_qualified()
            .trim_start_matches('/')
            .replace('/', ".")
    }

    /// The full name of `name` after expansion and remapping; the first matching rule applies.
    ///
    /// # Errors
    /// `name` is invalid.
    pub fn resolve(&self, kind: NameKind, name: &str) -> Result<String, NameError> {
        let full = self.expand(name)?;
        for rule in &self.rules {
            let fits = match rule.target {
                RemapTarget::TopicOrService => true,
                RemapTarget::Topic => kind == NameKind::Topic,
                RemapTarget::Service => kind == NameKind::Service,
                RemapTarget::NodeName | RemapTarget::Namespace => false,
            };
            if fits && self.expand(&rule.from)? == full {
                return self.expand(&rule.to);
            }
        }
        Ok(full)
    }

    /// The full name of `name` in this node: `x` is in its namespace, `~/x` below its name, `/x` is absolute.
    fn expand(&self, name: &str) -> Result<String, NameError> {
        let substituted = name
            .replace("{node}", &self.node)
            .replace("{ns}", &self.namespace)
            .replace("{namespace}", &self.namespace);
        let full = match substituted.strip_prefix('~') {
            Some("") => self.fully_qualified(),
            Some(rest) if rest.starts_with('/') => format!("{}{rest}", self.fully_qualified()),
            Some(_) => return Err(invalid(name, "name", "`~` must be followed by `/`")),
            None if substituted.starts_with('/') => substituted.clone(),
            None => joined(&self.namespace, &substituted),
        };
        let too_long = (full.len() > MAX_TOPIC).then_some("it has at most 247 characters");
        full_name_fault(&full)
            .or(too_long)
            .map_or(Ok(()), Err)
            .map_err(|reason| invalid(name, "topic or service name", reason))
            .map(|()| full)
    }
}

impl fmt::Display for Names {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.fully_qualified())
    }
}

fn joined(namespace: &str, name: &str) -> String {
    format!("{}/{name}", namespace.trim_end_matches('/'))
}

fn invalid(name: &str, what: &'static str, reason: &'static str) -> NameError {
    NameError {
        name: name.to_owned(),
        what,
        reason,
    }
}

/// A node name has a single part: letters, digits and underscores, not beginning with a digit.
fn check_node_name(name: &str) -> Result<(), NameError> {
    let too_long = (name.len() > MAX_NODE_NAME).then_some("it has at most 255 characters");
    let fault = part_fault(name).or(too_long);
    fault.map_or(Ok(()), |reason| Err(invalid(name, "node name", reason)))
}

fn check_namespace(namespace: &str) -> Result<(), NameError> {
    namespace_fault(namespace).map_or(Ok(()), |reason| {
        Err(invalid(namespace, "namespace", reason))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(target: RemapTarget, from: &str, to: &str) -> RemapRule {
        RemapRule {
            node: None,
            target,
            from: from.to_owned(),
            to: to.to_owned(),
        }
    }

    fn names(rules: &[RemapRule]) -> Names {
        Names::new("/garage/a3", "column_twin", rules).expect("valid names")
    }

    fn topic(names: &Names, name: &str) -> String {
        names.resolve(NameKind::Topic, name).expect("a valid name")
    }

    /// The table of "Expansion of relative and private names" in the design article.
    #[test]
    fn names_are_expanded_as_in_the_design_article() {
        let in_garage = names(&[]);
        for (name, full) in [
            ("ping", "/garage/a3/ping"),
            ("/ping", "/ping"),
            ("~", "/garage/a3/column_twin"),
            ("~/ping", "/garage/a3/column_twin/ping"),
            ("foo/bar", "/garage/a3/foo/bar"),
            ("{node}/x", "/garage/a3/column_twin/x"),
            ("{ns}/x", "/garage/a3/x"),
        ] {
            assert_eq!(topic(&in_garage, name), full);
        }
        let at_root = Names::new("/", "column_twin", &[]).expect("valid");
        assert_eq!(topic(&at_root, "column_state"), "/column_state");
        assert_eq!(topic(&at_root, "~/reset"), "/column_twin/reset");
        assert_eq!(at_root.fully_qualified(), "/column_twin");
        assert_eq!(in_garage.logger(), "garage.a3.column_twin");
    }

    #[test]
    fn invalid_names_are_rejected() {
        let names = names(&[]);
        for name in ["", "~x", "x/", "a//b", "1x", "a b", "a__b", "/", "ä", "a-b"] {
            assert!(names.resolve(NameKind::Topic, name).is_err(), "{name:?}");
        }
        for namespace in ["", "garage", "/garage/", "/a//b", "/1"] {
            assert!(Names::new(namespace, "x", &[]).is_err(), "{namespace:?}");
        }
        for node in ["", "a/b", "1a", "a b"] {
            assert!(Names::new("/", node, &[]).is_err(), "{node:?}");
        }
    }

    /// They were accepted, and no node on rcl could talk to this one.
    #[test]
    fn names_that_are_too_long_for_rcl_are_rejected() {
        let long = |length: usize| "a".repeat(length);
        for (length, is_valid) in [(244, true), (300, false)] {
            let namespace = format!("/{}", long(length));
            let found = Names::new(&namespace, "x", &[]);
            assert_eq!(found.is_ok(), is_valid, "a namespace of {length}");
        }
        for (length, is_valid) in [(255, true), (256, false)] {
            let found = Names::new("/", &long(length), &[]);
            assert_eq!(found.is_ok(), is_valid, "a node name of {length}");
        }
        let names = Names::new("/", "x", &[]).expect("valid");
        for (length, is_valid) in [(246, true), (247, false)] {
            let found = names.resolve(NameKind::Topic, &long(length));
            assert_eq!(found.is_ok(), is_valid, "a topic of {length}");
        }
    }

    #[test]
    fn node_and_namespace_are_remapped_first() {
        let names = names(&[
            rule(RemapTarget::Namespace, "", "/hall"),
            rule(RemapTarget::NodeName, "", "pillar"),
            rule(RemapTarget::NodeName, "", "second_rule_loses"),
        ]);
        assert_eq!(names.fully_qualified(), "/hall/pillar");
        assert_eq!(topic(&names, "~/reset"), "/hall/pillar/reset");
        assert_eq!(topic(&names, "column_state"), "/hall/column_state");
    }

    #[test]
    fn rules_match_expanded_names_and_the_first_one_applies() {
        let names = names(&[
            rule(
                RemapTarget::TopicOrService,
                "column_state",
                "/monitor/state",
            ),
            rule(
                RemapTarget::TopicOrService,
                "/garage/a3/column_state",
                "never",
            ),
            rule(RemapTarget::Topic, "x", "only_topics"),
            rule(RemapTarget::Service, "y", "~/only_services"),
            rule(RemapTarget::TopicOrService, "/diagnostics", "diagnostics"),
        ]);
        let service = |name| names.resolve(NameKind::Service, name).expect("valid");
        assert_eq!(topic(&names, "column_state"), "/monitor/state");
        assert_eq!(topic(&names, "/garage/a3/column_state"), "/monitor/state");
        assert_eq!(topic(&names, "/column_state"), "/column_state");
        assert_eq!(topic(&names, "x"), "/garage/a3/only_topics");
        assert_eq!(service("x"), "/garage/a3/x");
        assert_eq!(topic(&names, "y"), "/garage/a3/y");
        assert_eq!(service("y"), "/garage/a3/column_twin/only_services");
        assert_eq!(topic(&names, "/diagnostics"), "/garage/a3/diagnostics");
    }

    #[test]
    fn a_rule_may_apply_to_one_node() {
        let mut for_other = rule(RemapTarget::TopicOrService, "a", "b");
        for_other.node = Some("lidar".to_owned());
        let mut for_us = rule(RemapTarget::TopicOrService, "c", "d");
        for_us.node = Some("column_twin".to_owned());
        let names = names(&[for_other, for_us]);
        assert_eq!(topic(&names, "a"), "/garage/a3/a");
        assert_eq!(topic(&names, "c"), "/garage/a3/d");
    }

    #[test]
    fn a_wrong_rule_is_found_at_the_start() {
        let error = Names::new(
            "/",
            "column_twin",
            &[rule(RemapTarget::TopicOrService, "column_state", "a b")],
        )
        .expect_err("a name with a space");
        assert_eq!(
            error.to_string(),
            "`a b` is not a valid topic or service name: only letters, digits and underscores are allowed between `/`"
        );
    }
}
