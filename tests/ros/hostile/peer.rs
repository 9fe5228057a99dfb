//! A participant that exists in a few datagrams only, and the node that it attacks.

use std::net::{Ipv4Addr, UdpSocket};
use std::path::Path;
use std::time::{Duration, Instant};

use column_twin::ros::ImpactOutcome;

use super::wire::{self, Datagram, EntityId, Prefix};
use crate::domain::{Domain, PATIENCE};
use crate::loopback::impact;
use crate::program::Program;

/// Highest memory of a node that was attacked \[MB\].
pub const MAX_MEGABYTES: f64 = 300.0;

/// A node in a process of its own, the first participant of its domain.
pub struct Victim {
    pub domain: Domain,
    pub program: Program,
    /// The port of its discovery.
    pub discovery: u16,
    /// The port of its topics.
    pub user: u16,
}

impl Victim {
    pub fn start(folder: &Path) -> Self {
        let domain = Domain::fresh();
        let arguments = ["-p", "state.directory:=\"\"", "-p", "real_time.priority:=0"];
        let program = Program::ready(&domain, folder, &arguments);
        let first = 7400 + 250 * domain.environment.domain_id;
        Self {
            domain,
            program,
            discovery: first + 10,
            user: first + 11,
        }
    }

    /// Datagrams that the sockets of the node have dropped, because they were full.
    pub fn dropped(&self) -> u64 {
        let ports = [self.discovery, self.user].map(|port| format!(":{port:04X}"));
        let sockets = std::fs::read_to_string("/proc/net/udp").expect("Linux");
        let of_node = sockets.lines().filter_map(|line| {
            let fields: Vec<_> = line.split_whitespace().collect();
            let local = fields.get(1)?;
            ports.iter().find(|port| local.ends_with(*port))?;
            fields.last()?.parse::<u64>().ok()
        });
        of_node.sum()
    }

    /// A new participant still gets an impact accepted, and the memory is bounded. Returns the memory \[MB\].
    pub fn assert_well(self) -> f64 {
        match impact(&self.domain, 1500.0, PATIENCE) {
            Ok(ImpactOutcome::Forecast(report)) => assert!(report.max_v1 > 0.0),
            other => panic!("{other:?}"),
        }
        let megabytes = self.program.megabytes();
        println!("{megabytes:.0} MB");
        assert!(megabytes < MAX_MEGABYTES, "{megabytes} MB");
        let (status, ..) = self.program.terminate();
        assert!(status.success(), "{status}");
        megabytes
    }
}

/// A participant without an implementation of DDS.
pub struct Peer {
    pub prefix: Prefix,
    pub socket: UdpSocket,
    pub port: u16,
    discovery: u16,
}

impl Peer {
    /// Announces itself to the node, and waits until that has added it to its discovery.
    pub fn join(victim: &Victim, name: u8) -> Self {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        socket
            .set_read_timeout(Some(Duration::from_millis(50)))
            .unwrap();
        let port = socket.local_addr().unwrap().port();
        let peer = Self {
            prefix: [name; 12],
            socket,
            port,
            discovery: victim.discovery,
        };
        let announcement = peer.announcement();
        peer.until(wire::HEARTBEAT, wire::PUBLICATIONS_WRITER, || {
            peer.send(victim.discovery, &announcement);
        });
        peer
    }

    /// The announcement of the participant.
    pub fn announcement(&self) -> Datagram {
        let data = wire::participant(self.prefix, self.port).payload();
        Datagram::from(self.prefix)
            .stamp(1, 0)
            .data(wire::SPDP_READER, wire::SPDP_WRITER, 1, &data)
    }

    pub fn send(&self, port: u16, datagram: &Datagram) {
        // A full socket drops it.
        let _ = self
            .socket
            .send_to(&datagram.0, (Ipv4Addr::LOCALHOST, port));
    }

    /// Announces a writer, and waits until a reader of the node asks it for its samples.
    pub fn publish(&self, topic: &str, type_name: &str) -> EntityId {
        let writer = [0, 0, 0x33, 0x03];
        let data = wire::endpoint(self.prefix, writer, topic, type_name, self.port).payload();
        let datagram = Datagram::from(self.prefix).data(
            wire::PUBLICATIONS_READER,
            wire::PUBLICATIONS_WRITER,
            1,
            &data,
        );
        self.until(wire::ACKNACK, writer, || {
            self.send(self.discovery, &datagram)
        });
        writer
    }

    /// Announces a reader, and returns the writer of the node that tells it what it has.
    pub fn subscribe(&self, topic: &str, type_name: &str) -> (EntityId, EntityId) {
        let reader = [0, 0, 0x44, 0x04];
        let data = wire::endpoint(self.prefix, reader, topic, type_name, self.port).payload();
        let datagram = Datagram::from(self.prefix).data(
            wire::SUBSCRIPTIONS_READER,
            wire::SUBSCRIPTIONS_WRITER,
            1,
            &data,
        );
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            self.send(self.discovery, &datagram);
            for received in self.received() {
                for (id, _, content) in wire::submessages(&received) {
                    // User-defined writers have no key, or a key.
                    if let (wire::HEARTBEAT, Some(writer @ [.., 2 | 3])) = (id, content.get(4..8)) {
                        return (reader, writer.try_into().unwrap());
                    }
                }
            }
        }
        panic!("the node does not write to {topic}");
    }

    /// What arrives until nothing does for a moment.
    pub fn received(&self) -> Vec<Vec<u8>> {
        let mut buffer = [0; 65536];
        std::iter::from_fn(|| {
            let length = self.socket.recv(&mut buffer).ok()?;
            Some(buffer[..length].to_vec())
        })
        .take(1000)
        .collect()
    }

    /// Repeats something until such a submessage arrives for, or from, this writer.
    fn until(&self, expected: u8, writer: EntityId, mut again: impl FnMut()) {
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            again();
            let received = self.received();
            let all = received.iter().flat_map(|it| wire::submessages(it));
            for (id, _, content) in all {
                if id == expected && content.get(4..8) == Some(&writer[..]) {
                    return;
                }
            }
        }
        panic!("no submessage {expected:#x} of {writer:?} arrives");
    }
}
