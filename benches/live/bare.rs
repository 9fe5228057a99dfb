//! The baseline: ros2-client without a twin, in separate processes of this benchmark.

use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use column_twin::column::Sample;
use column_twin::live::{Clock, Notifier, SystemClock};
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::{
    ColumnState, HingeForces, ImpactEvent, ImpactReport,
};
use column_twin::messages::std_msgs::Header;
use column_twin::ros::qos::{self, Endpoint};
use column_twin::ros::{Environment, Names, Node};
use futures::StreamExt;

use super::domain::Domain;

/// Like `column_state`, from a publisher that does nothing else.
pub const BARE_STATE: Endpoint = Endpoint {
    name: "bare_state",
    ..qos::COLUMN_STATE
};

/// Like `hinge_forces`.
pub const BARE_FORCES: Endpoint = Endpoint {
    name: "bare_forces",
    ..qos::HINGE_FORCES
};

/// The message to which the echo responds.
pub const PING: Endpoint = Endpoint {
    name: "ping",
    ..qos::IMPACT_EVENT
};

/// The response of the echo, as long as a forecast.
pub const PONG: Endpoint = Endpoint {
    name: "pong",
    ..qos::IMPACT_FORECAST
};

const PERIOD: i64 = 1_000_000;

/// The environment variable that gives this program the role of a peer.
const ROLE: &str = "COLUMN_TWIN_BENCHMARK_ROLE";

/// A process that publishes or echoes until it is dropped.
pub struct Bare(Child);

impl Bare {
    /// Publishes `count` pairs of messages at 1 kHz when its readers are present and [`Bare::go`] is called.
    pub fn publisher(domain: &Domain, count: u64) -> Self {
        Self::start(domain, &format!("publisher {count}"))
    }

    /// The identifier of its process.
    pub fn id(&self) -> u32 {
        self.0.id()
    }

    /// Answers every [`PING`].
    pub fn echo(domain: &Domain) -> Self {
        Self::start(domain, "echo")
    }

    fn start(domain: &Domain, role: &str) -> Self {
        let own = std::env::current_exe().expect("a path");
        let child = Command::new(own)
            .env(ROLE, role)
            .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .stdin(Stdio::piped())
            .spawn()
            .expect("this program again");
        Self(child)
    }

    /// Lets the publisher start, and waits for its end.
    pub fn go(mut self) {
        drop(self.0.stdin.take());
        let ended = self.0.wait().expect("a child");
        assert!(ended.success(), "{ended}");
    }
}

impl Drop for Bare {
    fn drop(&mut self) {
        // The process may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Plays the role in the environment variable, if there is one.
pub fn is_asked_for() -> bool {
    let Ok(role) = std::env::var(ROLE) else {
        return false;
    };
    let environment = Environment::of_process().expect("a domain");
    let names = Names::new("/", "bare", &[]).expect("a name");
    let node = Node::new(&environment, names).expect("a node");
    match role.split_once(' ') {
        Some((_, count)) => publish(node, count.parse().expect("a number")),
        None => echo(node),
    }
    true
}

fn publish(mut node: Node, count: u64) {
    let states = node
        .publisher::<ColumnState>(&BARE_STATE)
        .expect("a publisher");
    let forces = node
        .publisher::<HingeForces>(&BARE_FORCES)
        .expect("a publisher");
    // Closed when the readers are present.
    let _ = std::io::stdin().read(&mut [0]);
    let (clock, notifier) = (SystemClock::new(), Notifier::default());
    let first = clock.now() + 50 * PERIOD;
    for number in 0..count as i64 {
        let deadline = first + number * PERIOD;
        while clock.now() < deadline {
            clock.wait_until(deadline, &notifier);
        }
        let header = Header {
            stamp: Time::from_nanos(deadline).unwrap_or_default(),
            frame_id: "column".to_owned(),
        };
        let names = || ("column".to_owned(), "impact-000000".to_owned());
        let (column_id, event_id) = names();
        let state = ColumnState {
            header: header.clone(),
            column_id,
            event_id,
            ..ColumnState::default()
        };
        let _ = states.publish(state); // one too many is one lost, which the reader finds
        let (column_id, event_id) = names();
        let force = HingeForces {
            header,
            column_id,
            event_id,
            // With an entry for each hinge, as the node sends them.
            ..HingeForces::from(&Sample::default())
        };
        let _ = forces.publish(force);
    }
    // Messages must remain available for retransmission.
    std::thread::sleep(Duration::from_secs(1));
}

fn echo(mut node: Node) {
    let pings = node.subscription::<ImpactEvent>(&PING).expect("a reader");
    let pongs = node.publisher::<ImpactReport>(&PONG).expect("a publisher");
    let answers = pings.async_stream().for_each(|ping| {
        if let Ok((ping, _)) = ping {
            let _ = pongs.publish(ImpactReport {
                header: ping.header,
                column_id: ping.column_id,
                event_id: ping.event_id,
                ..ImpactReport::default()
            });
        }
        std::future::ready(())
    });
    futures::executor::block_on(answers);
}
