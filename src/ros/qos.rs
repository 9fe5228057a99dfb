//! The quality of service of every endpoint as ros2-client wants it. The table itself: [`crate::endpoints`].

use ros2_client::qos::{Durability, History, Liveliness, QosProfile, Reliability, WhenFull};

use super::names::NameKind;

pub use crate::endpoints::*;

impl Qos {
    /// As ros2-client wants it.
    ///
    /// A writer whose reader does not keep up refuses at once instead of waiting: the sample is lost and counted, and
    /// the others go on. RustDDS lets 8192 unacknowledged samples be under way before that.
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
    /// Topic or service.
    #[must_use]
    pub fn kind(&self) -> NameKind {
        match self.direction {
            Direction::In | Direction::Out => NameKind::Topic,
            Direction::Service => NameKind::Service,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages;

    /// The table of the contract (interfaces.md, section 1), where it says the quality of service.
    const CONTRACT: &str = "
        impact_event column_twin/msg/ImpactEvent In reliable volatile 100
        column_parameters column_twin/msg/ColumnParameters In reliable volatile 10
        column_state column_twin/msg/ColumnState Out reliable volatile 1000
        hinge_forces column_twin/msg/HingeForces Out reliable volatile 1000
        impact_forecast column_twin/msg/ImpactReport Out reliable transient_local 10
        impact_report column_twin/msg/ImpactReport Out reliable transient_local 10
        twin_status column_twin/msg/TwinStatus Out reliable transient_local 1
        joint_states sensor_msgs/msg/JointState Out
        markers visualization_msgs/msg/MarkerArray Out
        /diagnostics diagnostic_msgs/msg/DiagnosticArray Out
        ~/reset std_srvs/srv/Trigger Service
        ~/predict column_twin/srv/PredictImpact Service";

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
    fn the_table_is_that_of_the_contract() {
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
    fn every_name_stands_once_and_every_own_type_exists() {
        for (index, endpoint) in ENDPOINTS.iter().enumerate() {
            assert!(
                ENDPOINTS[..index]
                    .iter()
                    .all(|other| other.name != endpoint.name)
            );
            let (package, _) = endpoint.package_and_type();
            // Of the parameter services ros2-client has the types.
            if package != "rcl_interfaces" || endpoint.direction == Direction::Out {
                let known = match endpoint.direction {
                    Direction::Service => format!("{}_Request", endpoint.type_name),
                    _ => endpoint.type_name.to_owned(),
                };
                assert!(messages::find(&known).is_some(), "{known}");
            }
        }
    }

    #[test]
    fn no_writer_waits_inside_publish() {
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
