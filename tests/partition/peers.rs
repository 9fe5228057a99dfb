//! Nodes, and peers of theirs that keep exchanging messages with them.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use super::domain::Domain;
use super::network::Network;
use super::program::Program;

/// The machine of the node, and that of its peer.
pub const NODE: usize = 0;
pub const PEER: usize = 1;

/// The column that is hit.
const COLUMN: &str = "c1";

/// Interval between impacts.
pub const INTERVAL: Duration = Duration::from_millis(500);

/// Who talks to whom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// `column-twin run` and ROS 2 on Fast DDS.
    Rclpy,
    /// `column-twin run` and a program on Cyclone DDS.
    Cyclone,
    /// `column-twin fleet` and ROS 2 on Fast DDS.
    RclpyOfFleet,
    /// `column-twin run` and `column-twin watch`; the impacts come from the machine of the node.
    OwnWatch,
    /// The same in enclaves.
    #[cfg(feature = "security")]
    SecuredWatch,
}

impl Kind {
    /// After this time of silence the node gives the peer up.
    pub fn lease(self) -> Duration {
        Duration::from_secs(match self {
            Self::Cyclone => 10,
            Self::Rclpy | Self::RclpyOfFleet => 20,
            Self::OwnWatch => 50,
            #[cfg(feature = "security")]
            Self::SecuredWatch => 50,
        })
    }

    /// The node with these parameters, in a folder of its own.
    pub fn node(
        self,
        network: &Network,
        domain: &Domain,
        folder: &Path,
        parameters: &[&str],
    ) -> Program {
        self.make_keystore(domain, folder);
        let mut command = self.own_program(network, NODE, folder);
        match self {
            Self::RclpyOfFleet => {
                let table = folder.join("fleet.csv");
                std::fs::write(&table, "namespace,column_id\n/hall/c0,c0\n/hall/c1,c1\n").unwrap();
                command.arg("fleet").arg("--columns").arg(table);
            }
            _ => {
                command.arg("run");
            }
        }
        command.arg("--ros-args").args(self.enclave("/column_twin"));
        command.args(["-p", "state.directory:=''", "-p", "real_time.priority:=0"]);
        // Long enough for a vehicle that comes from afar.
        command.args(["-p", "response.duration:=10.0"]);
        for parameter in parameters {
            command.args(["-p", parameter]);
        }
        if self != Self::RclpyOfFleet {
            command.args(["-p", &format!("column_id:={COLUMN}")]);
        }
        Program::spawn(domain, folder, command)
    }

    /// The program on a machine, which serves the network.
    fn own_program(self, network: &Network, machine: usize, folder: &Path) -> Command {
        let mut command = network.on(machine, "env");
        command.arg("ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET");
        // Of its own, so that a terminal's stop has an effect.
        command.process_group(0);
        if self.is_secured() {
            let keystore = folder.join("keystore");
            command.args(["ROS_SECURITY_ENABLE=true", "ROS_SECURITY_STRATEGY=Enforce"]);
            command.arg(format!("ROS_SECURITY_KEYSTORE={}", keystore.display()));
        }
        command.arg(env!("CARGO_BIN_EXE_column-twin"));
        command
    }

    fn enclave(self, name: &str) -> Vec<String> {
        match self.is_secured() {
            true => vec!["--enclave".to_owned(), name.to_owned()],
            false => Vec::new(),
        }
    }

    fn is_secured(self) -> bool {
        #[cfg(feature = "security")]
        if self == Self::SecuredWatch {
            return true;
        }
        false
    }

    fn make_keystore(self, domain: &Domain, folder: &Path) {
        if self.is_secured() {
            let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
            let domain = domain.environment.domain_id.to_string();
            command.args(["keystore", "create", "--domain", &domain]);
            command.arg(folder.join("keystore"));
            let output = command.output().unwrap();
            assert!(output.status.success(), "{output:?}");
        }
    }

    /// The script that sends impacts and tells which forecasts arrive; `None` for a peer of our own.
    fn script(self) -> Option<&'static str> {
        match self {
            Self::Rclpy | Self::RclpyOfFleet => Some("answers_with_rclpy.py"),
            Self::Cyclone => Some("answers_with_cyclonedds.py"),
            _ => None,
        }
    }
}

/// The Python of the environment, which is built if necessary.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let output = Command::new(interop("environment.sh"))
            .stderr(Stdio::inherit())
            .output()
            .unwrap();
        assert!(output.status.success(), "environment.sh: {}", output.status);
        let environment = String::from_utf8(output.stdout).unwrap();
        Path::new(environment.trim()).join("bin/python")
    })
}

/// A program of `tests/interop`.
pub fn interop(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/interop")
        .join(file)
}

/// A peer that was there before the cut.
pub struct Peer<'a> {
    kind: Kind,
    child: Child,
    lines: Receiver<String>,
    /// When each impact was sent, by its identifier.
    sent: BTreeMap<String, Instant>,
    /// Impacts whose forecasts have arrived.
    answered: BTreeSet<String>,
    /// Impacts whose reports have arrived.
    reported: BTreeSet<String>,
    /// Impacts that the column has accepted, by its last status.
    accepted: u64,
    /// The last thing that `/diagnostics` said of the messages of the node.
    diagnostics: Option<String>,
    /// Forecasts that the peer itself said were lost, or impacts that the column rejected.
    missed: u64,
    /// Sends impacts, where the peer does not.
    sender: Option<Sender<'a>>,
}

/// Sends impacts from the machine of the node.
struct Sender<'a> {
    network: &'a Network,
    domain: &'a Domain,
    folder: &'a Path,
    interval: Duration,
    due: Instant,
}

impl<'a> Peer<'a> {
    /// Starts it; there is an impact in every interval.
    pub fn start(
        kind: Kind,
        network: &'a Network,
        domain: &'a Domain,
        folder: &'a Path,
        interval: Duration,
    ) -> Self {
        let mut command = match kind.script() {
            Some(script) => {
                let mut command = network.on(PEER, "env");
                command.args(["ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET", "CYCLONEDDS_URI="]);
                command.arg(python()).arg(interop(script)).arg(COLUMN);
                command.arg(interval.as_secs_f64().to_string());
                command
            }
            None => {
                let mut command = kind.own_program(network, PEER, folder);
                command
                    .args(["watch", "--ros-args"])
                    .args(kind.enclave("/monitor"));
                command
            }
        };
        let mut child = command
            .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
            .env_remove("_ROS_WHEELS_BOOTSTRAP_COMPLETE")
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let output = BufReader::new(child.stdout.take().unwrap()).lines();
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in output.map_while(Result::ok) {
                let _ = sender.send(line);
            }
        });
        Self {
            kind,
            child,
            lines,
            sent: BTreeMap::new(),
            answered: BTreeSet::new(),
            reported: BTreeSet::new(),
            accepted: 0,
            diagnostics: None,
            missed: 0,
            sender: kind.script().is_none().then(|| Sender {
                network,
                domain,
                folder,
                interval,
                due: Instant::now(),
            }),
        }
    }

    /// Waits for the forecast of an impact that was sent after an instant; `None` at the deadline.
    pub fn wait_for_answer(
        &mut self,
        after: Option<Instant>,
        deadline: Instant,
    ) -> Option<Instant> {
        while Instant::now() < deadline {
            if let Some(event_id) = self.next_forecast(deadline)
                && let Some(sent) = self.sent.get(&event_id)
                && after.is_none_or(|after| *sent > after)
            {
                return Some(Instant::now());
            }
        }
        None
    }

    /// The process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Whether the impacts come from the machine of the node, where the test sends them.
    pub fn is_sent_to(&self) -> bool {
        self.sender.is_some()
    }

    /// Whether the peer counts the impacts that were rejected, as ROS 2 does.
    pub fn counts_rejected(&self) -> bool {
        matches!(self.kind, Kind::Rclpy | Kind::RclpyOfFleet)
    }

    /// Number of impacts sent between two instants whose forecasts have not arrived.
    pub fn unanswered(&self, from: Instant, until: Instant) -> u64 {
        self.count(from, until, |id| !self.answered.contains(id))
    }

    /// Number of impacts sent between two instants whose reports have not arrived.
    pub fn unreported(&self, from: Instant, until: Instant) -> u64 {
        self.count(from, until, |id| !self.reported.contains(id))
    }

    /// Number of impacts sent between two instants.
    pub fn sent_between(&self, from: Instant, until: Instant) -> u64 {
        self.count(from, until, |_| true)
    }

    fn count(&self, from: Instant, until: Instant, is_counted: impl Fn(&str) -> bool) -> u64 {
        let sent = self.sent.iter();
        let found = sent.filter(|(id, at)| (from..until).contains(*at) && is_counted(id));
        found.count() as u64
    }

    /// Number of impacts that the column has accepted, by its last status, where the peer tells it.
    pub fn accepted(&self) -> Option<u64> {
        self.kind.script().map(|_| self.accepted)
    }

    /// What `/diagnostics` said last of the messages of the node, where the peer tells it.
    pub fn diagnostics(&self) -> Option<&str> {
        self.diagnostics.as_deref()
    }

    /// Forecasts that the peer itself said were lost, as one of our own does, or impacts that were rejected, as ROS 2 tells.
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// Sends an impact from a distance \[m\] at 1 m/s; it must be one to which the test sends. Returns its identifier.
    pub fn send_from(&mut self, gap: f64) -> String {
        let sender = self.sender.as_mut().expect("the test sends");
        let gap = gap.to_string();
        let event_id = sender.send(self.kind, &["--velocity", "1", "--gap", &gap]);
        self.sent.insert(event_id.clone(), Instant::now());
        event_id
    }

    /// Waits for a line; `false` at the deadline.
    pub fn says(&mut self, text: &str, deadline: Instant) -> bool {
        while let Some(rest) = deadline.checked_duration_since(Instant::now()) {
            match self.lines.recv_timeout(rest) {
                Ok(line) => {
                    self.take(&line);
                    if line.contains(text) {
                        return true;
                    }
                }
                Err(_) => return false,
            }
        }
        false
    }

    /// Reads what it prints.
    pub fn follow_until(&mut self, end: Instant) {
        while Instant::now() < end {
            self.next_forecast(end);
        }
    }

    /// The identifier of the next forecast, if there is one within an interval.
    fn next_forecast(&mut self, deadline: Instant) -> Option<String> {
        self.send_if_due();
        let rest = deadline.saturating_duration_since(Instant::now());
        let line = self.lines.recv_timeout(rest.min(INTERVAL)).ok()?;
        self.take(&line)
    }

    /// Takes a line; returns the identifier of a forecast.
    fn take(&mut self, line: &str) -> Option<String> {
        if let Some(event_id) = line.strip_prefix("sent ") {
            self.sent.insert(event_id.to_owned(), Instant::now());
        }
        if let Some(event_id) = line.strip_prefix("report ") {
            self.reported.insert(event_id.to_owned());
        }
        // As `column-twin watch` tells it.
        if let Some(result) = line.strip_prefix("result of ")
            && let Some((event_id, _)) = result.split_once(':')
        {
            self.reported.insert(event_id.to_owned());
        }
        if let Some(count) = line.strip_prefix("accepted ") {
            self.accepted = count.parse().unwrap_or(0);
        }
        if let Some(text) = line.strip_prefix("diagnostics ") {
            self.diagnostics = Some(text.to_owned());
        }
        if let Some(count) = line.strip_prefix("rejected ") {
            self.missed = count.parse().unwrap_or(0);
        }
        if line.contains("messages were lost")
            && let Some((before, _)) = line.split_once(" on impact_forecast")
        {
            let count = before.rsplit(' ').next().and_then(|it| it.parse().ok());
            self.missed += count.unwrap_or(0);
        }
        // As the scripts tell it, or as `column-twin watch` does.
        let event_id = line.strip_prefix("forecast ")?;
        let event_id = event_id.strip_prefix("of ").unwrap_or(event_id);
        let event_id = event_id.split(':').next()?.to_owned();
        self.answered.insert(event_id.clone());
        Some(event_id)
    }

    fn send_if_due(&mut self) {
        let kind = self.kind;
        let Some(sender) = self.sender.as_mut().filter(|it| Instant::now() >= it.due) else {
            return;
        };
        let sent = Instant::now();
        let event_id = sender.send(kind, &["--velocity", "0.5"]);
        sender.due = Instant::now() + sender.interval;
        self.sent.insert(event_id, sent);
    }
}

impl Sender<'_> {
    /// Sends a light impact, which leaves no damage, and returns its identifier once its forecast is there.
    fn send(&self, kind: Kind, arguments: &[&str]) -> String {
        let mut command = kind.own_program(self.network, NODE, self.folder);
        command.args(["impact", "--mass", "10", "--column", COLUMN]);
        let output = command
            .args(arguments)
            .arg("--ros-args")
            .args(kind.enclave("/operator"))
            .env(
                "ROS_DOMAIN_ID",
                self.domain.environment.domain_id.to_string(),
            )
            .output()
            .unwrap();
        assert!(output.status.success(), "{output:?}");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        let event_id = said.split('"').nth(1);
        let event_id = event_id.unwrap_or_else(|| panic!("no identifier in {said}"));
        event_id.to_owned()
    }
}

impl Drop for Peer<'_> {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
