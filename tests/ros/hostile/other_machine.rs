//! Another machine on the network of a node that serves this machine only. Both are network namespaces with a virtual cable
//! between them: nothing leaves this machine, and no address of it is used.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use column_twin::messages::cdr;

use super::EVENT;
use super::wire::{self, Datagram};
use crate::domain::Domain;
use crate::loopback::{PATIENCE, event, now};
use crate::program::Program;

/// The node's address on the cable.
const NODE: &str = "10.211.77.1";
/// The address of the other machine.
const OTHER: &str = "10.211.77.2";

/// Two namespaces, which vanish when dropped.
struct Machines {
    node: String,
    other: String,
}

fn ip(arguments: &[&str]) -> Result<(), String> {
    let output = Command::new("ip")
        .args(arguments)
        .output()
        .map_err(|error| format!("ip: {error}"))?;
    match output.status.success() {
        true => Ok(()),
        false => Err(format!(
            "ip {}: {}",
            arguments.join(" "),
            String::from_utf8_lossy(&output.stderr)
        )),
    }
}

impl Machines {
    fn connected() -> Result<Self, String> {
        let id = std::process::id();
        let machines = Self {
            node: format!("twin-node-{id}"),
            other: format!("twin-other-{id}"),
        };
        let (node, other) = (machines.node.as_str(), machines.other.as_str());
        ip(&["netns", "add", node])?;
        ip(&["netns", "add", other])?;
        ip(&[
            "link", "add", "veth0", "netns", node, "type", "veth", "peer", "name", "veth0",
            "netns", other,
        ])?;
        for (machine, address) in [(node, NODE), (other, OTHER)] {
            let address = format!("{address}/24");
            ip(&["-n", machine, "link", "set", "lo", "up"])?;
            ip(&["-n", machine, "addr", "add", &address, "dev", "veth0"])?;
            ip(&["-n", machine, "link", "set", "veth0", "up"])?;
            // So that a multicast datagram has somewhere to go.
            ip(&["-n", machine, "route", "add", "239.0.0.0/8", "dev", "veth0"])?;
        }
        Ok(machines)
    }

    /// A command on one of them.
    fn on(machine: &str, program: &str) -> Command {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", machine, program]);
        command
    }

    /// Sends a datagram from one of them.
    fn send(&self, machine: &str, folder: &Path, datagram: &Datagram, to: &str, port: u16) {
        let file = folder.join("datagram");
        std::fs::write(&file, &datagram.0).unwrap();
        let script = format!("cat {} > /dev/udp/{to}/{port}", file.display());
        let status = Self::on(machine, "bash").args(["-c", &script]).status();
        assert!(status.unwrap().success(), "{script}");
    }
}

impl Drop for Machines {
    fn drop(&mut self) {
        for machine in [&self.node, &self.other] {
            if let Err(error) = ip(&["netns", "del", machine]) {
                println!("{error}");
            }
        }
    }
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
    let machines = Machines::connected().unwrap_or_else(|error| {
        panic!("{error}; this test needs iproute2 and the right to make network namespaces")
    });
    let folder = tempfile::tempdir().unwrap();
    let domain = Domain::fresh();
    let mut command = Machines::on(&machines.node, env!("CARGO_BIN_EXE_column-twin"));
    command.args(["run", "--ros-args", "-p", "state.directory:=\"\""]);
    let mut program = Program::spawn(&domain, folder.path(), command);
    program.wait_for("is ready in domain");
    let first = 7400 + 250 * domain.environment.domain_id;

    let deliver = |machine: &str, addresses: &[&str], event_id: &str, prefix| {
        for (ports, datagram) in steps(prefix, event_id, first) {
            for port in ports {
                for address in addresses {
                    machines.send(machine, folder.path(), &datagram, address, port);
                }
            }
            std::thread::sleep(Duration::from_millis(500));
        }
    };
    deliver(
        &machines.other,
        &[NODE, "239.255.0.1"],
        "from-outside",
        [0x55; 12],
    );
    // Such datagrams are valid: from the node's own machine they arrive.
    let deadline = Instant::now() + PATIENCE;
    let has_arrived = |line: &String| line.contains("from-inside");
    while !program.log_so_far().iter().any(has_arrived) {
        assert!(Instant::now() < deadline, "the node takes no event");
        deliver(&machines.node, &["127.0.0.1"], "from-inside", [0x66; 12]);
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
