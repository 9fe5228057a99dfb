//! Peers that were there before the network broke hear the node again afterwards, and it hears them. Each node and its peer are on
//! machines of their own: network namespaces, for which the tests need root and iproute2.
#![cfg(all(feature = "cli", feature = "ros"))]
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

#[path = "../ros/domain.rs"]
#[allow(dead_code)] // the tests of the node use more of it
mod domain;
#[path = "../ros/network.rs"]
mod network;
mod peers;
#[path = "../ros/program.rs"]
#[allow(dead_code)] // the tests of the node use more of it
mod program;

use std::time::{Duration, Instant};

use domain::Domain;
use network::Network;
use peers::{Kind, Peer};
use program::Program;

/// Lengths of the cuts: within all leases; beyond those of Cyclone DDS (10 s) and Fast DDS (20 s); beyond ours, too (50 s).
const CUTS: [u64; 4] = [5, 25, 60, 90];

/// By when a peer has to hear the node again \[s\]. It takes up to 10 s; the rest is for a loaded machine.
const HEALED: Duration = Duration::from_secs(20);

/// What came of a cut.
struct Healing {
    kind: Kind,
    cut: Duration,
    /// From the restored connection to the first forecast of an impact that was sent after it.
    took: Duration,
}

impl Healing {
    /// Cuts the connection for a time while node and peer exchange messages.
    fn after(kind: Kind, cut: Duration) -> Result<Self, String> {
        let network = Network::connected()?;
        let domain = Domain::fresh();
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let mut node = kind.node(&network, &domain, folder.path());
        node.wait_for("is ready in domain");
        let mut peer = Peer::start(kind, &network, &domain, folder.path());
        peer.wait_for_answer(None, Instant::now() + domain::PATIENCE)
            .ok_or("the peer does not hear the node before the cut")?;
        network.cut();
        let began = Instant::now();
        // The cut is the scenario. Meanwhile the peer keeps sending, and what it prints is read.
        peer.follow_until(began + cut);
        network.heal();
        let healed = Instant::now();
        let answered = peer.wait_for_answer(Some(healed), healed + HEALED);
        let log = |node: &mut Program| node.log_so_far().iter().rev().take(20).cloned().collect();
        let Some(answered) = answered else {
            let log: Vec<_> = log(&mut node);
            return Err(format!(
                "{kind:?}, cut for {cut:?}: the peer does not hear the node any more; the end of the node's log: {log:#?}"
            ));
        };
        // A loss is logged if and only if the cut outlasts the lease.
        if cut > kind.lease() {
            node.wait_for("counts as lost");
            node.wait_for("is back after");
        } else if let Some(line) = node
            .log_so_far()
            .iter()
            .find(|it| it.contains("counts as lost"))
        {
            return Err(format!("{kind:?}, cut for {cut:?}: {line}"));
        }
        Ok(Self {
            kind,
            cut,
            took: answered - healed,
        })
    }
}

/// All at once: most of the time nothing happens.
fn all_heal(kinds: &[Kind]) {
    let scenarios: Vec<_> = kinds
        .iter()
        .flat_map(|kind| CUTS.map(|cut| (*kind, Duration::from_secs(cut))))
        .map(|(kind, cut)| std::thread::spawn(move || Healing::after(kind, cut)))
        .collect();
    let mut faults = Vec::new();
    for scenario in scenarios {
        match scenario.join() {
            Ok(Ok(Healing { kind, cut, took })) => {
                println!("{kind:?}, cut for {cut:?}: heard again after {took:.1?}")
            }
            Ok(Err(fault)) => faults.push(fault),
            Err(_) => faults.push("a scenario panicked".to_owned()),
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// After a cut of 30 s nothing passed between the node and a peer on Fast DDS any more, and both believed that they were matched.
#[test]
#[ignore = "needs root, iproute2 and the Python environment of tests/interop"]
fn known_peers_hear_each_other_again_after_a_partition() {
    all_heal(&[
        Kind::Rclpy,
        Kind::Cyclone,
        Kind::RclpyOfFleet,
        Kind::OwnWatch,
    ]);
}

#[cfg(feature = "security")]
#[test]
#[ignore = "needs root and iproute2"]
fn known_peers_in_enclaves_hear_each_other_again_after_a_partition() {
    all_heal(&[Kind::SecuredWatch]);
}
