//! Peers that were there before the network broke, or before a process was stopped, hear the node again afterwards, and it hears
//! them; what was lost meanwhile is told. Each node and its peer are on machines of their own: network namespaces, for which the tests
//! need root and iproute2.
#![cfg(all(feature = "cli", feature = "ros"))]
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

#[path = "../ros/domain.rs"]
#[allow(dead_code)] // the tests of the node use more of it
mod domain;
mod lossy;
#[path = "../ros/network.rs"]
mod network;
mod peers;
#[path = "../ros/program.rs"]
#[allow(dead_code)] // the tests of the node use more of it
mod program;
#[path = "../ros/stop.rs"]
mod stop;

use std::time::{Duration, Instant};

use domain::Domain;
use network::Network;
use peers::{INTERVAL, Kind, Peer};
use program::Program;
use stop::{By, stop_for};

/// Lengths of the cuts: within all leases; beyond those of Cyclone DDS (10 s) and Fast DDS (20 s); beyond ours, too (50 s).
const CUTS: [u64; 4] = [5, 25, 60, 90];

/// Beyond the leases of others, which they must not count while the node is stopped.
const LONG: Duration = Duration::from_secs(30);

/// Long enough to interrupt every wait.
const SHORT: Duration = Duration::from_millis(300);

/// In a longer cut more impacts are sent than the history of their sender holds.
const FORGOTTEN: Duration = Duration::from_secs(10);

/// By when a peer has to hear the node again \[s\]. It takes up to 10 s; the rest is for a loaded machine.
const HEALED: Duration = Duration::from_secs(20);

/// Distance \[m\] of a vehicle at 1 m/s, so that a stop begins before the contact.
const APPROACH: f64 = 5.0;

/// What happens while node and peer exchange messages.
#[derive(Debug, Clone, Copy)]
enum Trouble {
    /// The network between them is interrupted.
    Cut(Duration),
    /// The node is stopped and continued; in a response, if the test sends the impacts.
    NodeStops(By, Duration),
    /// The peer is; it must be one of our own.
    PeerStops(By, Duration),
}

impl Trouble {
    fn duration(self) -> Duration {
        match self {
            Self::Cut(it) | Self::NodeStops(_, it) | Self::PeerStops(_, it) => it,
        }
    }

    /// Whether the node gives the peer up.
    fn loses(self, kind: Kind) -> bool {
        // The time in which the node does not run is not one in which the peer is silent.
        !matches!(self, Self::NodeStops(..)) && self.duration() > kind.lease()
    }

    /// Begins and ends; the peer keeps sending, and what it prints is read.
    fn happen(self, network: &Network, node: &mut Program, peer: &mut Peer) {
        match self {
            Self::Cut(time) => {
                network.cut();
                peer.follow_until(Instant::now() + time);
                network.heal();
            }
            // Nobody answers an impact that is sent meanwhile.
            Self::NodeStops(by, time) if peer.is_sent_to() => {
                let event_id = peer.send_from(APPROACH);
                let approach = Duration::from_secs_f64(APPROACH);
                stop_for(node.id(), by, approach + time);
                let result = format!("result of {event_id}:");
                let is_complete = peer.says(&result, Instant::now() + HEALED);
                assert!(is_complete, "the response of {event_id} is not completed");
            }
            Self::NodeStops(by, time) => stop_while_followed(node.id(), by, time, peer),
            Self::PeerStops(by, time) => stop_while_followed(peer.id(), by, time, peer),
        }
    }
}

fn stop_while_followed(process: u32, by: By, time: Duration, peer: &mut Peer) {
    let stop = std::thread::spawn(move || stop_for(process, by, time));
    while !stop.is_finished() {
        peer.follow_until(Instant::now() + SHORT);
    }
    stop.join().unwrap();
}

/// The log shows at most so many similar messages in a row.
const MAX_LOGGED: usize = 20;

/// Number of messages of which this log says that they were lost for a peer, or were rejected, unless the peer counts those; many if
/// the log does not show all.
fn told(log: &[String], peer_counts_rejected: bool) -> u64 {
    let number = |line: &String, text: &str| {
        let before = line.split_once(text)?.0;
        before.rsplit(' ').next()?.parse::<u64>().ok()
    };
    let in_line = |line: &String| {
        number(line, " messages on impact_event were lost")
            .or_else(|| number(line, " messages were published since then"))
    };
    let lost = log.iter().filter_map(in_line).sum::<u64>();
    let rejected = log.iter().filter(|it| it.contains("was rejected")).count();
    match rejected {
        _ if peer_counts_rejected => lost,
        MAX_LOGGED.. => u64::MAX / 2,
        rejected => lost + rejected as u64,
    }
}

/// What came of a trouble.
struct Healing {
    kind: Kind,
    trouble: Trouble,
    /// From its end to the first forecast of an impact that was sent after it.
    took: Duration,
    /// Impacts sent meanwhile whose forecasts did not reach the peer.
    unanswered: u64,
}

impl Healing {
    fn after(kind: Kind, trouble: Trouble) -> Result<Self, String> {
        let network = Network::connected()?;
        let domain = Domain::fresh();
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let mut node = kind.node(&network, &domain, folder.path(), &[]);
        node.wait_for("is ready in domain");
        let mut peer = Peer::start(kind, &network, &domain, folder.path(), INTERVAL);
        peer.wait_for_answer(None, Instant::now() + domain::PATIENCE)
            .ok_or("the peer does not hear the node before the trouble")?;
        let began = Instant::now();
        trouble.happen(&network, &mut node, &mut peer);
        let healed = Instant::now();
        let log = |node: &mut Program| node.log_so_far().iter().rev().take(20).cloned().collect();
        let Some(answered) = peer.wait_for_answer(Some(healed), healed + HEALED) else {
            let log: Vec<_> = log(&mut node);
            return Err(format!(
                "{kind:?}, {trouble:?}: the peer does not hear the node any more; the end of the node's log: {log:#?}"
            ));
        };
        // A loss is logged if and only if the cut outlasts the lease.
        if trouble.loses(kind) {
            node.wait_for("counts as lost");
            node.wait_for("is back after");
        } else if let Some(line) = node
            .log_so_far()
            .iter()
            .find(|it| it.contains("counts as lost"))
        {
            return Err(format!("{kind:?}, {trouble:?}: {line}"));
        }
        let unanswered = Self::all_is_told(trouble, &mut node, &mut peer, (began, healed));
        let unanswered = unanswered.map_err(|fault| format!("{kind:?}, {trouble:?}: {fault}"))?;
        Ok(Self {
            kind,
            trouble,
            took: answered - healed,
            unanswered,
        })
    }

    /// Every impact that was sent meanwhile is answered, or the log and `/diagnostics` of the node, or its watch, tell that messages
    /// were lost.
    fn all_is_told(
        trouble: Trouble,
        node: &mut Program,
        peer: &mut Peer,
        (began, healed): (Instant, Instant),
    ) -> Result<u64, String> {
        let deadline = Instant::now() + HEALED;
        let (mut unanswered, mut lost) = (0, 0);
        while Instant::now() < deadline {
            peer.follow_until(Instant::now() + SHORT);
            unanswered = peer.unanswered(began, healed);
            lost = told(node.log_so_far(), peer.counts_rejected()) + peer.missed();
            // What is sent to a stopped process waits in its sockets.
            let is_overrun = matches!(trouble, Trouble::Cut(time) if time >= FORGOTTEN);
            let is_overrun = is_overrun && !peer.is_sent_to();
            let is_diagnosed = peer
                .diagnostics()
                .is_none_or(|it| it == "messages were lost");
            if unanswered <= lost && (!is_overrun || (lost > 0 && is_diagnosed)) {
                return Ok(unanswered);
            }
        }
        Err(format!(
            "{unanswered} impacts were not answered, and the log tells of {lost} lost messages; /diagnostics: {:?}",
            peer.diagnostics()
        ))
    }
}

/// All at once: most of the time nothing happens.
fn all_heal(scenarios: impl IntoIterator<Item = (Kind, Trouble)>) {
    let scenarios: Vec<_> = scenarios
        .into_iter()
        .map(|(kind, trouble)| std::thread::spawn(move || Healing::after(kind, trouble)))
        .collect();
    let mut faults = Vec::new();
    for scenario in scenarios {
        match scenario.join() {
            Ok(Ok(Healing {
                kind,
                trouble,
                took,
                unanswered,
            })) => {
                println!(
                    "{kind:?}, {trouble:?}: heard again after {took:.1?}; {unanswered} impacts of meanwhile are unanswered"
                )
            }
            Ok(Err(fault)) => faults.push(fault),
            Err(_) => faults.push("a scenario panicked".to_owned()),
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

fn cuts(kinds: &[Kind]) -> impl Iterator<Item = (Kind, Trouble)> {
    let of = |kind: &Kind| {
        let kind = *kind;
        CUTS.map(|cut| (kind, Trouble::Cut(Duration::from_secs(cut))))
    };
    kinds.iter().flat_map(of)
}

/// After a cut of 30 s nothing passed between the node and a peer on Fast DDS any more, and both believed that they were matched.
#[test]
#[ignore = "needs root, iproute2 and the Python environment of tests/interop"]
fn known_peers_hear_each_other_again_after_a_partition() {
    all_heal(cuts(&[
        Kind::Rclpy,
        Kind::Cyclone,
        Kind::RclpyOfFleet,
        Kind::OwnWatch,
    ]));
}

/// With 10 % loss and 100 ms delay in both directions.
#[test]
#[ignore = "needs root, iproute2 and the Python environment of tests/interop"]
fn forecasts_reports_and_statuses_arrive_over_a_network_that_loses_a_tenth() {
    let kinds = [
        Kind::Rclpy,
        Kind::Cyclone,
        Kind::RclpyOfFleet,
        Kind::OwnWatch,
    ];
    let networks: Vec<_> = (1..)
        .zip(kinds)
        .map(|(seed, kind)| std::thread::spawn(move || lossy::all_arrives(kind, seed)))
        .collect();
    let mut faults = Vec::new();
    for network in networks {
        match network.join() {
            Ok(Ok(text)) => println!("{text}"),
            Ok(Err(fault)) => faults.push(fault),
            Err(_) => faults.push("a network panicked".to_owned()),
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// As a suspended virtual machine, whose peers go on; and debuggers that look at a fleet.
#[test]
#[ignore = "needs root, iproute2, gdb, strace and the Python environment of tests/interop"]
fn known_peers_hear_each_other_again_after_a_stop() {
    all_heal([
        (Kind::Rclpy, Trouble::NodeStops(By::Stop, LONG)),
        (Kind::Cyclone, Trouble::NodeStops(By::Stop, LONG)),
        (Kind::RclpyOfFleet, Trouble::NodeStops(By::Stop, LONG)),
        (Kind::OwnWatch, Trouble::NodeStops(By::Stop, LONG)),
        (Kind::OwnWatch, Trouble::PeerStops(By::Stop, LONG)),
        (Kind::RclpyOfFleet, Trouble::NodeStops(By::Gdb, SHORT)),
        (Kind::RclpyOfFleet, Trouble::NodeStops(By::Strace, SHORT)),
    ]);
}

#[cfg(feature = "security")]
#[test]
#[ignore = "needs root and iproute2"]
fn known_peers_in_enclaves_hear_each_other_again_after_a_partition() {
    all_heal(cuts(&[Kind::SecuredWatch]));
}

#[cfg(feature = "security")]
#[test]
#[ignore = "needs root, iproute2, gdb and strace"]
fn known_peers_in_enclaves_hear_each_other_again_after_a_stop() {
    let stops = [
        (By::Stop, SHORT),
        (By::Terminal, SHORT),
        (By::Gdb, SHORT),
        (By::Strace, SHORT),
        (By::Stop, LONG),
    ];
    let of_node = stops.map(|(by, time)| Trouble::NodeStops(by, time));
    let of_peer = stops.map(|(by, time)| Trouble::PeerStops(by, time));
    let all = of_node.into_iter().chain(of_peer);
    all_heal(all.map(|it| (Kind::SecuredWatch, it)));
}
