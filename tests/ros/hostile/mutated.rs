//! Genuine datagrams of every kind, mutated.

use std::net::{Ipv4Addr, UdpSocket};
use std::time::{Duration, Instant};

use column_twin::messages::cdr;

use super::peer::{Peer, Victim};
use super::wire::{self, Datagram, Fragment, Set};
use super::{EVENT, STATUS};
use crate::loopback::{PATIENCE, event, now};

/// What random bits begin with; the same seed gives the same datagrams.
const SEED: u64 = 0x5eed_c01d_7e57_0013;

/// xorshift64*: any generator will do, as long as it is the same everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// Below `end`, which is not 0.
    fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.next() >> 32).unwrap() % end
    }

    fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len())]
    }
}

/// Numbers at which programs go wrong.
const NUMBERS: [u32; 12] = [
    0,
    1,
    2,
    0x7f,
    0xff,
    0x100,
    0xffff,
    0x0001_0000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
];

/// Changes a few places of a datagram, or puts it together from parts of others.
fn mutated(seeds: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = random.pick(seeds).clone();
    for _ in 0..1 + random.below(4) {
        let place = random.below(bytes.len().max(1));
        match random.below(9) {
            // A bit, a byte, a number of four bytes anywhere; mostly behind the header.
            0 => {
                if let Some(byte) = bytes.get_mut(place) {
                    *byte ^= 1 << random.below(8);
                }
            }
            1 => {
                if let Some(byte) = bytes.get_mut(place) {
                    *byte = random.next().to_le_bytes()[0];
                }
            }
            2 | 3 => {
                let number = random.pick(&NUMBERS).to_le_bytes();
                let aligned = place / 4 * 4;
                if let Some(slice) = bytes.get_mut(aligned..aligned + 4) {
                    slice.copy_from_slice(&number);
                }
            }
            4 => {
                let number = u16::try_from(random.pick(&NUMBERS) & 0xffff).unwrap();
                if let Some(slice) = bytes.get_mut(place..place + 2) {
                    slice.copy_from_slice(&number.to_le_bytes());
                }
            }
            // The end is missing.
            5 => bytes.truncate(place),
            // Another message's submessages follow.
            6 => {
                let other = random.pick(seeds);
                bytes.extend(other.get(wire::HEADER..).unwrap_or_default());
            }
            // The kind, flags or length of a submessage.
            7 => {
                let offsets = offsets(&bytes);
                if !offsets.is_empty() {
                    let header = *random.pick(&offsets) + random.below(4);
                    if let Some(byte) = bytes.get_mut(header) {
                        *byte = random.next().to_le_bytes()[0];
                    }
                }
            }
            // Another participant says it.
            _ => {
                let prefix = random.next().to_le_bytes();
                if let Some(slice) = bytes.get_mut(12..20) {
                    slice.copy_from_slice(&prefix);
                }
            }
        }
    }
    bytes.truncate(65_000);
    bytes
}

/// Where the submessages of a datagram begin.
fn offsets(datagram: &[u8]) -> Vec<usize> {
    let mut offset = wire::HEADER;
    let mut found = Vec::new();
    for (_, _, content) in wire::submessages(datagram) {
        found.push(offset);
        offset += 4 + content.len();
    }
    found
}

/// What genuine participants announce to the twelfth slot of this machine.
fn announcements(victim: &Victim) -> Vec<Vec<u8>> {
    let port = victim.discovery + 2 * 11;
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, port)).unwrap();
    socket
        .set_read_timeout(Some(Duration::from_millis(200)))
        .unwrap();
    // Whoever is new to the node makes it announce itself.
    let _peer = Peer::join(victim, 0xa1);
    let mut buffer = [0; 65536];
    let mut found = Vec::new();
    let deadline = Instant::now() + PATIENCE;
    while found.is_empty() && Instant::now() < deadline {
        while let Ok(length) = socket.recv(&mut buffer) {
            found.push(buffer[..length].to_vec());
        }
    }
    assert!(!found.is_empty(), "the node announces itself");
    found
}

/// What the node says about its endpoints to whoever asks for it.
fn discovered(victim: &Victim, peer: &Peer) -> Vec<Vec<u8>> {
    let carries_data = |datagram: &Vec<u8>| {
        let all = wire::submessages(datagram);
        all.iter().any(|(id, ..)| *id == wire::DATA)
    };
    let mut found = Vec::new();
    let deadline = Instant::now() + PATIENCE;
    let mut count = 1000;
    // A busy machine may answer after the socket has been found empty.
    while !found.iter().any(carries_data) {
        assert!(
            Instant::now() < deadline,
            "the node describes its endpoints"
        );
        for (reader, writer) in [
            (wire::PUBLICATIONS_READER, wire::PUBLICATIONS_WRITER),
            (wire::SUBSCRIPTIONS_READER, wire::SUBSCRIPTIONS_WRITER),
        ] {
            let ask = Datagram::from(peer.prefix).acknack(reader, writer, &Set::full(1), count);
            peer.send(victim.discovery, &ask);
        }
        count += 1;
        found.append(&mut peer.received());
    }
    found
}

/// Genuine datagrams of the node, and valid ones of every kind from a peer that it knows.
fn seeds(victim: &Victim, peer: &Peer) -> Vec<Vec<u8>> {
    let mut seeds = announcements(victim);
    seeds.extend(discovered(victim, peer));
    let writer = peer.publish(EVENT.0, EVENT.1);
    let (reader, of_node) = peer.subscribe(STATUS.0, STATUS.1);
    let from = || Datagram::from(peer.prefix);
    let anyone = wire::UNKNOWN;
    // For another column: no mutation of it damages this one, which must accept the next genuine event.
    let mut event = event("mutated", now(), 1500.0, 1.0);
    "another".clone_into(&mut event.column_id);
    let event = cdr::encode(&event).unwrap();
    let endpoint = |topic: &str, entity| {
        wire::endpoint(peer.prefix, entity, topic, EVENT.1, peer.port).payload()
    };
    let fragment = Fragment {
        number: 3,
        first: 1,
        count: 2,
        size: 64,
        sample_size: 256,
        bytes: &event[..128.min(event.len())],
    };
    let related = wire::Parameters::default()
        .with(0x0083, &[peer.prefix.as_slice(), &writer, &[0; 8]].concat())
        .with(0x0070, &[1; 16])
        .with(0x0071, &[0, 0, 0, 3]);
    let built = [
        peer.announcement(),
        from().stamp(1, 2).data(anyone, writer, 1, &event),
        from().data_with_qos(anyone, writer, 2, &related, &event),
        from().data_frag(anyone, writer, &fragment),
        from()
            .heartbeat(anyone, writer, 1, 3, 1)
            .reply_to(peer.port),
        from().gap(anyone, writer, 4, &Set::full(6)),
        from().heartbeat_frag(anyone, writer, 3),
        from()
            .to([0; 12])
            .acknack(reader, of_node, &Set::full(1), 1),
        from().nack_frag(reader, of_node, 1, &Set::full(1), 1),
        from().source([9; 12]).stamp(u32::MAX, u32::MAX),
        from().submessage(wire::PAD, 0, &[0; 8]),
        from()
            .submessage(0x31, 0, &[1; 40])
            .submessage(0x32, 0, &[2; 40]),
        from()
            .submessage(0x33, 0, &[1; 40])
            .submessage(0x34, 0, &[2; 40]),
        from().data(
            wire::PUBLICATIONS_READER,
            wire::PUBLICATIONS_WRITER,
            2,
            &endpoint(EVENT.0, [0, 0, 0x34, 3]),
        ),
        from().data(
            wire::SUBSCRIPTIONS_READER,
            wire::SUBSCRIPTIONS_WRITER,
            2,
            &endpoint("rt/column_state", [0, 0, 0x45, 4]),
        ),
        from().data(
            wire::TOPICS_READER,
            wire::TOPICS_WRITER,
            1,
            &endpoint("rt/any", [0, 0, 0x46, 5]),
        ),
    ];
    seeds.extend(built.map(|datagram| datagram.0));
    println!("{} seeds", seeds.len());
    seeds
}

/// Sends so many mutated datagrams to both ports of a node. Returns its memory afterwards \[MB\].
fn survives(count: usize) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let victim = Victim::start(folder.path());
    let peer = Peer::join(&victim, 0xa2);
    let seeds = seeds(&victim, &peer);
    println!(
        "seed {SEED:#x}, {:.0} MB before",
        victim.program.megabytes()
    );
    let mut random = Random(SEED);
    let (mut highest, start) = (0_f64, Instant::now());
    for number in 0..count {
        let datagram = mutated(&seeds, &mut random);
        let port = [victim.discovery, victim.user][number % 2];
        let _ = peer.socket.send_to(&datagram, (Ipv4Addr::LOCALHOST, port));
        if number % 50 == 49 {
            std::thread::sleep(Duration::from_micros(500));
        }
        if number % 10_000 == 0 {
            highest = victim.program.megabytes().max(highest);
        }
    }
    println!(
        "{count} datagrams in {:?}, {} of them dropped by full sockets, at most {highest:.0} MB",
        start.elapsed(),
        victim.dropped()
    );
    assert!(highest < super::peer::MAX_MEGABYTES, "{highest} MB");
    victim.assert_well()
}

#[test]
fn the_node_survives_mutated_datagrams() {
    survives(50_000);
}

#[test]
#[ignore = "slow: a million datagrams take a minute"]
fn the_node_survives_a_million_mutated_datagrams() {
    survives(1_000_000);
}
