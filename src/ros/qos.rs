//! Converts the quality of service of every endpoint for ros2-client. The table is in [`crate::endpoints`].

use std::collections::HashMap;

use ros2_client::qos::{Durability, History, Liveliness, QosProfile, Reliability, WhenFull};

use ros_node::names::{NameError, NameKind, Names};

pub use crate::endpoints::*;

impl Qos {
    /// The profile for ros2-client.
    ///
    /// A writer whose reader cannot keep up fails immediately instead of waiting: the sample is lost and counted. RustDDS
    /// allows 8192 unacknowledged samples before that.
    #[must_use]
    pub fn profile(&self) -> QosProfile {
        QosProfile {
            reliability: match self.reliable {
                true => Reliability::Reliable {
                    when_full: WhenFull::Fail,
                },
                false => Reliability::BestEffort,
            },
            durability: match self.transient_local {
                true => Durability::TransientLocal,
                false => Durability::Volatile,
            },
            history: History::KeepLast { depth: self.depth },
            deadline: None,
            lifespan: self.lifespan.map(std::time::Duration::from_secs),
            liveliness: Liveliness::Automatic,
            liveliness_lease: None,
        }
    }
}

impl Endpoint {
    /// Whether the name is that of a topic or a service.
    #[must_use]
    pub fn kind(&self) -> NameKind {
        match self.direction {
            Direction::In | Direction::Out => NameKind::Topic,
            Direction::Service => NameKind::Service,
        }
    }
}

/// Checks that no topic and no service of a node has two types: rcl rejects that, and here each peer would match only one of them.
///
/// # Errors
/// Rules of remapping give two of them one name.
pub(super) fn check_types(names: &Names) -> Result<(), NameError> {
    let mut known: HashMap<_, &Endpoint> = HashMap::new();
    for endpoint in ENDPOINTS {
        let name = names.resolve(endpoint.kind(), endpoint.name)?;
        let first = *known
            .entry((endpoint.kind() == NameKind::Topic, name.clone()))
            .or_insert(endpoint);
        if first.type_name != endpoint.type_name {
            let (what, reason) = match endpoint.kind() {
                NameKind::Topic => (
                    "topic",
                    "two topics of the node with different types are remapped to it; give each a name of its own",
                ),
                NameKind::Service => (
                    "service",
                    "two services of the node with different types are remapped to it; give each a name of its own",
                ),
            };
            return Err(NameError { name, what, reason });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages;
    use ros_node::names::{RemapRule, RemapTarget};

    /// The node started, and its peers found one of the two types.
    #[test]
    fn two_types_on_one_remapped_topic_are_rejected() {
        let onto = |rules: &[(&str, &str)]| {
            let rules: Vec<_> = rules
                .iter()
                .map(|(from, to)| RemapRule {
                    node: None,
                    target: RemapTarget::TopicOrService,
                    from: (*from).to_owned(),
                    to: (*to).to_owned(),
                })
                .collect();
            check_types(&Names::new("/", "column_twin", &rules).expect("names"))
        };
        assert_eq!(onto(&[]), Ok(()));
        // Of one type.
        assert_eq!(
            onto(&[("impact_forecast", "/x"), ("impact_report", "/x")]),
            Ok(())
        );
        let fault =
            onto(&[("impact_event", "/x"), ("impact_report", "/x")]).expect_err("two types");
        assert_eq!(
            fault.to_string(),
            "`/x` is not a valid topic: two topics of the node with different types are remapped to it; give each a name of its own"
        );
        let fault = onto(&[("column_state", "twin_status")]).expect_err("two types");
        assert_eq!(fault.name, "/twin_status");
        assert!(onto(&[("~/predict", "~/reset")]).is_err());
        // A topic and a service may have one name.
        assert_eq!(onto(&[("~/predict", "/x"), ("impact_event", "/x")]), Ok(()));
    }

    /// The table of the interface specification, with the quality of service where it is specified.
    const CONTRACT: &str = "
        impact_event column_twin_msgs/msg/ImpactEvent In reliable volatile 100
        column_parameters column_twin_msgs/msg/ColumnParameters In reliable volatile 10
        column_state column_twin_msgs/msg/ColumnState Out reliable volatile 1000
        hinge_forces column_twin_msgs/msg/HingeForces Out reliable volatile 1000
        impact_forecast column_twin_msgs/msg/ImpactReport Out reliable transient_local 10
        impact_report column_twin_msgs/msg/ImpactReport Out reliable transient_local 10
        twin_status column_twin_msgs/msg/TwinStatus Out reliable transient_local 1
        joint_states sensor_msgs/msg/JointState Out
        markers visualization_msgs/msg/MarkerArray Out
        /diagnostics diagnostic_msgs/msg/DiagnosticArray Out
        ~/reset std_srvs/srv/Trigger Service
        ~/predict column_twin_msgs/srv/PredictImpact Service";

    fn row(endpoint: &Endpoint) -> String {
        let Qos {
            reliable,
            transient_local,
            depth,
            ..
        } = endpoint.qos;
        format!(
            "{} {} {:?} {} {} {depth}",
            endpoint.name,
            endpoint.type_name,
            endpoint.direction,
            if reliable { "reliable" } else { "best_effort" },
            if transient_local {
                "transient_local"
            } else {
                "volatile"
            },
        )
    }

    #[test]
    fn the_table_follows_the_specification() {
        let rows: Vec<_> = ENDPOINTS.iter().map(row).collect();
        for expected in CONTRACT
            .lines()
            .map(str::trim)
            .filter(|line| !line.is_empty())
        {
            assert!(
                rows.iter().any(|row| row.starts_with(expected)),
                "{expected} is not among\n{}",
                rows.join("\n")
            );
        }
    }

    #[test]
    fn names_are_unique_and_all_own_types_exist() {
        for (index, endpoint) in ENDPOINTS.iter().enumerate() {
            assert!(
                ENDPOINTS[..index]
                    .iter()
                    .all(|other| other.name != endpoint.name)
            );
            let (package, _) = endpoint.package_and_type();
            // The types of the parameter services come from ros2-client, and those of the description from its module.
            let is_foreign = ["rcl_interfaces", "type_description_interfaces"].contains(&package);
            if !is_foreign || endpoint.direction == Direction::Out {
                let known = match endpoint.direction {
                    Direction::Service => format!("{}_Request", endpoint.type_name),
                    _ => endpoint.type_name.to_owned(),
                };
                assert!(messages::find(&known).is_some(), "{known}");
            }
        }
    }

    #[test]
    fn no_writer_blocks_in_publish() {
        for endpoint in ENDPOINTS.iter().filter(|it| it.qos.reliable) {
            assert_eq!(
                endpoint.qos.profile().reliability,
                Reliability::Reliable {
                    when_full: WhenFull::Fail
                }
            );
        }
    }
}
