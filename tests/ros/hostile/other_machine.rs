//! Another machine on the network of a node that serves this machine only.

use std::path::Path;
use std::time::{Duration, Instant};

use column_twin::messages::cdr;

use super::EVENT;
use super::wire::{self, Datagram};
use crate::domain::Domain;
use crate::loopback::{PATIENCE, event, now};
use crate::network::Network;
use crate::program::Program;

/// The machine of the node, and the other one.
const NODE: usize = 0;
const OTHER: usize = 1;

/// Sends a datagram from one of them.
fn send(
    network: &Network,
    machine: usize,
    folder: &Path,
    datagram: &Datagram,
    (to, port): (&str, u16),
) {
    let file = folder.join("datagram");
    std::fs::write(&file, &datagram.0).unwrap();
    let script = format!("cat {} > /dev/udp/{to}/{port}", file.display());
    let status = network.on(machine, "bash").args(["-c", &script]).status();
    assert!(status.unwrap().success(), "{script}");
}

/// The addresses that the node's UDP sockets are bound to, with their ports.
fn sockets(program: &Program) -> Vec<(String, u16)> {
    let table = std::fs::read_to_string(format!("/proc/{}/net/udp", program.id())).unwrap();
    let local = table
        .lines()
        .skip(1)
        .filter_map(|line| line.split_whitespace().nth(1));
    local
        .map(|local| {
            let (address, port) = local.split_once(':').unwrap();
            let address = u32::from_str_radix(address, 16).unwrap();
            let address = std::net::Ipv4Addr::from(address.to_ne_bytes()).to_string();
            (address, u16::from_str_radix(port, 16).unwrap())
        })
        .collect()
}

/// A participant announces itself and a writer, which sends an event that the twin rejects and logs, because it is for
/// another column. Each with the ports that it goes to.
fn steps(prefix: wire::Prefix, event_id: &str, first: u16) -> [([u16; 2], Datagram); 3] {
    let mut event = event(event_id, now(), 1500.0, 1.0);
    "another".clone_into(&mut event.column_id);
    let event = cdr::encode(&event).unwrap();
    let writer = [0, 0, 0x33, 3];
    let participant = wire::participant(prefix, 9).payload();
    let publication = wire::endpoint(prefix, writer, EVENT.0, EVENT.1, 9).payload();
    let (readers, writers) = (wire::PUBLICATIONS_READER, wire::PUBLICATIONS_WRITER);
    let from = || Datagram::from(prefix);
    [
        (
            [first, first + 10],
            from().data(wire::SPDP_READER, wire::SPDP_WRITER, 1, &participant),
        ),
        (
            [first, first + 10],
            from().data(readers, writers, 1, &publication),
        ),
        (
            [first + 1, first + 11],
            from().data(wire::UNKNOWN, writer, 1, &event),
        ),
    ]
}

/// RustDDS 0.15.1 bound its sockets to 0.0.0.0, and the node took an event that was sent to the machine's address.
#[test]
#[ignore = "needs root and iproute2"]
fn an_event_from_another_machine_is_not_received_on_localhost() {
    if !rustix::process::geteuid().is_root() {
        println!("SKIPPED: only root can make network namespaces");
        return;
    }
    let network = Network::connected().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let domain = Domain::fresh();
    let mut command = network.on(NODE, env!("CARGO_BIN_EXE_column-twin"));
    command.args(["run", "--ros-args", "-p", "state.directory:=\"\""]);
    let mut program = Program::spawn(&domain, folder.path(), command);
    program.wait_for("is ready in domain");
    let first = 7400 + 250 * domain.environment.domain_id;

    let deliver = |machine: usize, addresses: &[&str], event_id: &str, prefix| {
        for (ports, datagram) in steps(prefix, event_id, first) {
            for port in ports {
                for address in addresses {
                    send(&network, machine, folder.path(), &datagram, (address, port));
                }
            }
            std::thread::sleep(Duration::from_millis(500));
        }
    };
    deliver(
        OTHER,
        &[&Network::address(NODE), "239.255.0.1"],
        "from-outside",
        [0x55; 12],
    );
    // Such datagrams are valid: from the node's own machine they arrive.
    let deadline = Instant::now() + PATIENCE;
    let has_arrived = |line: &String| line.contains("from-inside");
    while !program.log_so_far().iter().any(has_arrived) {
        assert!(Instant::now() < deadline, "the node takes no event");
        deliver(NODE, &["127.0.0.1"], "from-inside", [0x66; 12]);
    }
    for (address, port) in sockets(&program) {
        let multicast = [first, first + 1].contains(&port);
        assert!(address == "127.0.0.1" || multicast, "{address}:{port}");
    }
    let (status, _, log) = program.terminate();
    assert!(status.success(), "{status}");
    let outside = log.iter().find(|line| line.contains("from-outside"));
    assert_eq!(outside, None);
}
