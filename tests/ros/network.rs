//! Machines on a network of their own: network namespaces with virtual cables to a switch, in a namespace of its own as well. Nothing
//! leaves this machine, and no address of it is used.

use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};

/// The first three bytes of all addresses.
const SUBNET: &str = "10.211.77";

/// The port of a machine on the switch.
pub const PORTS: [&str; 2] = ["first", "second"];

/// Two machines and the switch between them, which vanish when dropped.
pub struct Network {
    machines: [String; 2],
    switch: String,
}

fn ip(arguments: &[&str]) -> Result<(), String> {
    run("ip", arguments)
}

fn run(program: &str, arguments: &[&str]) -> Result<(), String> {
    let output = Command::new(program)
        .args(arguments)
        .output()
        .map_err(|error| format!("{program}: {error}"))?;
    match output.status.success() {
        true => Ok(()),
        false => Err(format!(
            "{program} {}: {}",
            arguments.join(" "),
            String::from_utf8_lossy(&output.stderr)
        )),
    }
}

impl Network {
    /// Connects two machines.
    ///
    /// # Errors
    /// Network namespaces cannot be made: that takes root and iproute2.
    pub fn connected() -> Result<Self, String> {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let id = format!(
            "{}-{}",
            std::process::id(),
            NUMBER.fetch_add(1, Ordering::Relaxed)
        );
        let network = Self {
            machines: [format!("twin-{id}-first"), format!("twin-{id}-second")],
            switch: format!("twin-{id}-switch"),
        };
        network.connect().map_err(|error| {
            format!("{error}; this test needs iproute2 and the right to make network namespaces")
        })?;
        Ok(network)
    }

    fn connect(&self) -> Result<(), String> {
        let switch = self.switch.as_str();
        ip(&["netns", "add", switch])?;
        ip(&["-n", switch, "link", "add", "switch", "type", "bridge"])?;
        // Multicast goes to all ports: nobody here asks who wants it.
        ip(&[
            "-n",
            switch,
            "link",
            "set",
            "switch",
            "type",
            "bridge",
            "mcast_snooping",
            "0",
        ])?;
        ip(&["-n", switch, "link", "set", "switch", "up"])?;
        for (index, (machine, port)) in self.machines.iter().zip(PORTS).enumerate() {
            let address = format!("{}/24", Self::address(index));
            ip(&["netns", "add", machine])?;
            ip(&[
                "link", "add", "veth0", "netns", machine, "type", "veth", "peer", "name", port,
                "netns", switch,
            ])?;
            ip(&["-n", switch, "link", "set", port, "master", "switch", "up"])?;
            ip(&["-n", machine, "link", "set", "lo", "up"])?;
            ip(&["-n", machine, "addr", "add", &address, "dev", "veth0"])?;
            ip(&["-n", machine, "link", "set", "veth0", "up"])?;
            // So that a multicast datagram has somewhere to go.
            ip(&["-n", machine, "route", "add", "239.0.0.0/8", "dev", "veth0"])?;
        }
        Ok(())
    }

    /// The address of a machine, 0 or 1.
    pub fn address(machine: usize) -> String {
        format!("{SUBNET}.{}", machine + 1)
    }

    /// A command on a machine, 0 or 1.
    pub fn on(&self, machine: usize, program: &str) -> Command {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &self.machines[machine], program]);
        command
    }

    /// Takes both machines off the switch, and returns a command in its place, which sees them at [`PORTS`].
    #[allow(dead_code)] // for the tests of a lossy network
    pub fn instead_of_the_switch(&self, program: &str) -> Command {
        for port in PORTS {
            ip(&["-n", &self.switch, "link", "set", port, "nomaster"]).unwrap();
        }
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &self.switch, program]);
        command
    }

    /// Cuts the connection: the switch passes nothing on, and neither machine notices.
    #[allow(dead_code)] // for the tests of partitions
    pub fn cut(&self) {
        self.isolate("on");
    }

    /// Restores the connection.
    #[allow(dead_code)] // for the tests of partitions
    pub fn heal(&self) {
        self.isolate("off");
    }

    fn isolate(&self, state: &str) {
        for port in PORTS {
            let of_port = ["link", "set", "dev", port, "isolated", state];
            run("bridge", &[&["-n", &self.switch], &of_port[..]].concat()).unwrap();
        }
    }
}

impl Drop for Network {
    fn drop(&mut self) {
        for namespace in self.machines.iter().chain([&self.switch]) {
            if let Err(error) = ip(&["netns", "del", namespace]) {
                println!("{error}");
            }
        }
    }
}
