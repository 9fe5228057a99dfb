//! Why a client of the twin ends without what it was asked for.

use std::time::Duration;

use super::node::NodeError;
use printable::Printable;
use ros_node::names::NameError;

/// Timeout for the status that a twin keeps for late joiners.
pub(super) const STATUS_WAIT: Duration = Duration::from_secs(2);

/// Errors of the client.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// A name is invalid.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The node cannot be created.
    #[error(transparent)]
    Node(#[from] NodeError),
    /// Signal handlers cannot be installed.
    #[error("cannot handle signals: {0}")]
    Signals(#[from] std::io::Error),
    /// No twin was found.
    #[error(
        "no twin subscribes to {topic} in domain {domain_id} (waited {waited:?}); {}",
        elsewhere(.others)
    )]
    NoTwin {
        /// The topic.
        topic: String,
        /// The topics of this type on which there are twins, in other namespaces or with other names.
        others: Vec<String>,
        /// The domain.
        domain_id: u16,
        /// The timeout.
        waited: Duration,
    },
    /// The only twin does not tell its column.
    #[error(
        "no twin_status arrived within {STATUS_WAIT:?}, so the column is not known; name it with --column"
    )]
    NoColumn,
    /// There are twins of several columns.
    #[error("there are twins of several columns: {}; choose one with --column", listed(.0))]
    SeveralColumns(Vec<String>),
    /// The event cannot be sent.
    #[error("cannot send the event: {0}")]
    NotSent(String),
    /// The event was sent, but there was no reply.
    #[error(
        "the event {event_id} was sent, but neither a forecast nor a rejection arrived within {waited:?}; check `twin_status`"
    )]
    NoAnswer {
        /// The event.
        event_id: String,
        /// The timeout.
        waited: Duration,
    },
    /// The twin rejected the event.
    #[error("the twin rejected the event: {0}")]
    Rejected(String),
    /// The twin is faulted.
    #[error("the twin is faulted: {0}; call ~/reset to restore the undamaged column")]
    Faulted(String),
    /// The readings last too long.
    #[error(
        "the readings last {found} s, but at most {most} s are published; cut the table to the time of the impact"
    )]
    TooLong {
        /// Their duration \[s\].
        found: f64,
        /// The longest \[s\].
        most: f64,
    },
    /// A thread of the DDS library panicked.
    #[error(
        "a thread of the DDS library panicked, so that nothing more is received; start it again, and report the messages above"
    )]
    Deaf,
    /// Interrupted.
    #[error("interrupted")]
    Interrupted,
}

/// What to do if there is no twin on a topic.
fn elsewhere(others: &[String]) -> String {
    if others.is_empty() {
        return "check that `column-twin run` is running with the same ROS_DOMAIN_ID, namespace and \
                ROS_AUTOMATIC_DISCOVERY_RANGE"
            .to_owned();
    }
    format!(
        "there are twins on {}: choose the namespace with --ros-args -r __ns:=/NAMESPACE",
        others.join(", ")
    )
}

fn listed(columns: &[String]) -> String {
    const MAX_LISTED: usize = 20;
    let quoted = columns.iter().map(|it| format!("\"{}\"", Printable(it)));
    let mut listed: Vec<_> = quoted.take(MAX_LISTED).collect();
    if columns.len() > MAX_LISTED {
        listed.push(format!("and {} more", columns.len() - MAX_LISTED));
    }
    listed.join(", ")
}
