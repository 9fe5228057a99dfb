//! Forged datagrams against a running node: it lives, its memory is bounded, and the next genuine event is accepted.
//!
//! Everything stays on loopback. What an attacker can still do is described in `docs/security.md`: without DDS security
//! anyone on the network can speak for anyone else.

mod mutated;
mod other_machine;
mod peer;
mod wire;

use std::time::{Duration, Instant};

use peer::{Peer, Victim};
use wire::{Datagram, Fragment, Set};

use crate::domain::PATIENCE;

const EVENT: (&str, &str) = (
    "rt/impact_event",
    "column_twin_msgs::msg::dds_::ImpactEvent_",
);
const STATUS: (&str, &str) = ("rt/twin_status", "column_twin_msgs::msg::dds_::TwinStatus_");

/// Datagrams between two looks at how many the node has taken.
const ROUND: u32 = 20_000;

/// Sends so many datagrams about as fast as the node can take them.
fn flood(peer: &Peer, port: u16, count: u32, datagram: impl Fn(u32) -> Datagram) {
    for number in 0..count {
        peer.send(port, &datagram(number));
        if number % 50 == 49 {
            std::thread::sleep(Duration::from_micros(500));
        }
    }
}

/// Sends numbered datagrams until the node has taken so many, however many the system drops because the node is not fast enough.
fn flood_until_taken(peer: &Peer, port: u16, count: u32, datagram: impl Fn(u32) -> Datagram) {
    let (_, dropped_before) = at_port(port);
    let mut sent = 0;
    loop {
        flood(peer, port, ROUND, |number| datagram(sent + number));
        sent += ROUND;
        let taken = u64::from(sent) - (dropped_once_taken(port) - dropped_before);
        if taken >= u64::from(count) {
            return;
        }
        let most = 40 * count.max(ROUND);
        assert!(sent < most, "{taken} of {sent} datagrams were taken");
    }
}

/// Waits until the node has taken what waits at its port, and returns how many datagrams the system has dropped there.
fn dropped_once_taken(port: u16) -> u64 {
    let deadline = Instant::now() + PATIENCE;
    loop {
        let (waiting, dropped) = at_port(port);
        if waiting == 0 {
            return dropped;
        }
        assert!(Instant::now() < deadline, "the node takes no datagrams");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// What waits at the sockets of this port \[bytes\], and how many datagrams the system has dropped there.
fn at_port(port: u16) -> (u64, u64) {
    let sockets = std::fs::read_to_string("/proc/net/udp").expect("readable");
    let end = format!(":{port:04X}");
    let (mut found, mut waiting, mut dropped) = (false, 0, 0);
    for socket in sockets.lines().skip(1) {
        let fields: Vec<&str> = socket.split_whitespace().collect();
        if fields[1].ends_with(&end) {
            let (_, queue) = fields[4].split_once(':').expect("two queues");
            waiting += u64::from_str_radix(queue, 16).expect("a length");
            dropped += fields[12].parse::<u64>().expect("a count");
            found = true;
        }
    }
    assert!(found, "no socket has port {port}");
    (waiting, dropped)
}

/// A prefix like no other.
fn prefix(number: u32) -> wire::Prefix {
    let mut prefix = [0xee; 12];
    prefix[8..].copy_from_slice(&number.to_le_bytes());
    prefix
}

/// RustDDS 0.15.1 allocated what a DATA_FRAG claimed.
#[test]
fn a_datagram_of_160_bytes_does_not_cost_4_gb() {
    let folder = tempfile::tempdir().unwrap();
    let victim = Victim::start(folder.path());
    let peer = Peer::join(&victim, 1);
    let writer = peer.publish(EVENT.0, EVENT.1);
    let before = victim.program.megabytes();
    for (number, sample_size) in [(1, u32::MAX), (2, 1 << 30), (3, 100 << 20)] {
        let fragment = Fragment {
            number,
            first: 1,
            count: 1,
            size: 100,
            sample_size,
            bytes: &[7; 100],
        };
        let datagram = Datagram::from(peer.prefix).data_frag(wire::UNKNOWN, writer, &fragment);
        assert!(datagram.0.len() <= 160);
        peer.send(victim.user, &datagram);
    }
    // As large as they may be, and many of them.
    flood(&peer, victim.user, 1000, |number| {
        let fragment = Fragment {
            number: i64::from(number) + 10,
            first: 1,
            count: 1,
            size: 100,
            sample_size: 4 << 20,
            bytes: &[7; 100],
        };
        Datagram::from(peer.prefix).data_frag(wire::UNKNOWN, writer, &fragment)
    });
    dropped_once_taken(victim.user);
    let grown = victim.program.megabytes() - before;
    assert!(grown < 64.0, "{grown} MB");
    victim.assert_well();
}

/// The fragments of writers that nobody knows are not assembled.
#[test]
fn fragments_of_unknown_writers_cost_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let victim = Victim::start(folder.path());
    let peer = Peer::join(&victim, 1);
    let writer = peer.publish(EVENT.0, EVENT.1);
    let before = victim.program.megabytes();
    flood_until_taken(&peer, victim.user, 20_000, |number| {
        let fragment = Fragment {
            number: 1,
            first: 1,
            count: 1,
            size: 1000,
            sample_size: 4 << 20,
            bytes: &[7; 1000],
        };
        Datagram::from(prefix(number)).data_frag(wire::UNKNOWN, writer, &fragment)
    });
    let grown = victim.program.megabytes() - before;
    assert!(grown < 32.0, "{grown} MB");
    victim.assert_well();
}

#[test]
fn a_range_of_2_to_the_63_samples_does_not_stop_the_node() {
    let folder = tempfile::tempdir().unwrap();
    let victim = Victim::start(folder.path());
    let peer = Peer::join(&victim, 1);
    let writer = peer.publish(EVENT.0, EVENT.1);
    let from = || Datagram::from(peer.prefix);
    let anyone = wire::UNKNOWN;
    for (count, (first, last)) in (1..).zip([
        (1, i64::MAX),
        (i64::MIN, i64::MAX),
        (i64::MAX, i64::MIN),
        (0, 0),
        (-1, 1 << 40),
        (5, i64::MAX),
    ]) {
        peer.send(
            victim.user,
            &from().heartbeat(anyone, writer, first, last, count),
        );
    }
    for (start, base) in [(9, i64::MAX), (9, i64::MAX - 200), (i64::MAX, 1), (-5, 9)] {
        let gap = from().gap(anyone, writer, start, &Set::full(base));
        peer.send(victim.user, &gap);
    }
    peer.send(
        victim.user,
        &from().heartbeat(anyone, writer, i64::MAX, i64::MAX, i32::MAX),
    );
    victim.assert_well();
}

/// Fragment 0 does not exist, and RustDDS 0.15.1 panicked; the last one of 2^32 cost half a gigabyte.
#[test]
fn requests_for_fragments_that_do_not_exist_are_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let victim = Victim::start(folder.path());
    let peer = Peer::join(&victim, 1);
    let (reader, writer) = peer.subscribe(STATUS.0, STATUS.1);
    let before = victim.program.megabytes();
    let mut count = 0;
    for number in [i64::MIN, -1, 0, 1, 2, 3, 1000, i64::MAX] {
        for base in [0, 1, i64::from(u32::MAX) - 255] {
            count += 1;
            let set = Set::full(base);
            let from = || Datagram::from(peer.prefix).to([0; 12]);
            let nack_frag = from().nack_frag(reader, writer, number, &set, count);
            peer.send(victim.user, &nack_frag);
            for set in [Set::full(number), Set::empty(number)] {
                peer.send(
                    victim.user,
                    &from().acknack(reader, writer, &set, 2 * count),
                );
            }
        }
    }
    dropped_once_taken(victim.user);
    let grown = victim.program.megabytes() - before;
    assert!(grown < 32.0, "{grown} MB");
    victim.assert_well();
}

#[test]
fn a_flood_of_participants_does_not_fill_the_memory() {
    let folder = tempfile::tempdir().unwrap();
    let victim = Victim::start(folder.path());
    let peer = Peer::join(&victim, 1);
    flood_until_taken(&peer, victim.discovery, 20_000, |number| {
        let data = wire::participant(prefix(number), peer.port).payload();
        let (reader, writer) = (wire::SPDP_READER, wire::SPDP_WRITER);
        Datagram::from(prefix(number)).data(reader, writer, 1, &data)
    });
    victim.assert_well();
}

/// RustDDS 0.15.1 kept a record of about 80 bytes of the source of every datagram with a new prefix.
#[test]
fn datagrams_of_400_000_prefixes_do_not_fill_the_memory() {
    let folder = tempfile::tempdir().unwrap();
    let victim = Victim::start(folder.path());
    let peer = Peer::join(&victim, 1);
    let before = victim.program.megabytes();
    flood_until_taken(&peer, victim.user, 400_000, |number| {
        Datagram::from(prefix(number)).stamp(1, 2)
    });
    // With the records they would be 32 MB.
    let grown = victim.program.megabytes() - before;
    assert!(grown < 16.0, "{grown} MB");
    victim.assert_well();
}

#[test]
fn a_flood_of_endpoints_with_long_names_does_not_fill_the_memory() {
    let folder = tempfile::tempdir().unwrap();
    let victim = Victim::start(folder.path());
    let peer = Peer::join(&victim, 1);
    let endpoint = |number: u32, topic: &str| {
        let [a, b, c, _] = number.to_le_bytes();
        wire::endpoint(peer.prefix, [a, b, c, 4], topic, "a::b::C_", peer.port).payload()
    };
    let (reader, writer) = (wire::SUBSCRIPTIONS_READER, wire::SUBSCRIPTIONS_WRITER);
    let long = "x".repeat(60_000);
    flood(&peer, victim.discovery, 5_000, |number| {
        let data = endpoint(number, &long);
        Datagram::from(peer.prefix).data(reader, writer, 1 + i64::from(number), &data)
    });
    flood(&peer, victim.discovery, 40_000, |number| {
        let data = endpoint(number, &format!("rt/topic_{number}"));
        Datagram::from(peer.prefix).data(reader, writer, 10_000 + i64::from(number), &data)
    });
    victim.assert_well();
}

/// The participant waited for its own acknowledgement, and sent HEARTBEATs of discovery ten times a second for ever.
#[test]
fn discovery_is_silent_when_everything_is_acknowledged() {
    const WINDOW: Duration = Duration::from_secs(1);
    let folder = tempfile::tempdir().unwrap();
    let victim = Victim::start(folder.path());
    let peer = Peer::join(&victim, 1);
    let writers = [
        (wire::PUBLICATIONS_READER, wire::PUBLICATIONS_WRITER),
        (wire::SUBSCRIPTIONS_READER, wire::SUBSCRIPTIONS_WRITER),
        (wire::TOPICS_READER, wire::TOPICS_WRITER),
        ([0, 2, 0, 0xc7], [0, 2, 0, 0xc2]),
    ];
    let heartbeats = || {
        let received = peer.received();
        let all = received.iter().flat_map(|it| wire::submessages(it));
        let of_discovery = all.filter(|(id, _, content)| {
            let writer = content.get(4..8);
            *id == wire::HEARTBEAT && writers.iter().any(|(_, it)| writer == Some(&it[..]))
        });
        of_discovery.count()
    };
    // The reader has what it asks for when it asks for nothing below a number that is beyond the last one.
    let mut count = 0;
    for last in 0..200 {
        for (reader, writer) in writers {
            count += 1;
            let all =
                Datagram::from(peer.prefix).acknack(reader, writer, &Set::empty(last + 1), count);
            peer.send(victim.discovery, &all);
        }
        if last % 20 == 0 {
            std::thread::sleep(Duration::from_millis(20));
        }
    }
    // What was sent before may still be answered; ten times a second is never silent.
    let deadline = Instant::now() + PATIENCE;
    loop {
        heartbeats();
        std::thread::sleep(WINDOW);
        let found = heartbeats();
        if found <= 2 {
            break;
        }
        assert!(
            Instant::now() < deadline,
            "{found} in {WINDOW:?}, and no end"
        );
    }
    // It is silent because all is acknowledged, not because it is gone.
    victim.assert_well();
}
