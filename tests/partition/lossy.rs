//! A network that loses a tenth of all frames and takes 100 ms for each of the others, in either direction: what a bad radio link does.

use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use super::SHORT;
use super::domain::{Domain, PATIENCE};
use super::network::{Network, PORTS};
use super::peers::{Kind, Peer, interop};

/// Probability that a frame is lost.
const LOSS: &str = "0.1";

/// How long a frame takes \[s\].
const DELAY: &str = "0.1";

/// How long impacts are sent.
const SENDING: Duration = Duration::from_secs(40);

/// Interval between impacts. A writer of ROS 2 keeps the last ten: Fast DDS asks every 3 s what was lost, and the question, the answer
/// and what is sent again are lost as often as everything else.
const RARE: Duration = Duration::from_secs(2);

/// For the same reason an impact may be older when it arrives than the default admits.
const PATIENT: &str = "event.max_age:=60.0";

/// By when a peer is heard, and by when everything has arrived.
const ARRIVED: Duration = PATIENCE.saturating_mul(3);

/// The program that passes frames on in the place of the switch; its end is that of the connection.
struct LossyWire(Child);

impl LossyWire {
    fn through(network: &Network, seed: u64) -> Self {
        let mut command = network.instead_of_the_switch("python3");
        let child = command
            .arg(interop("lossy_wire.py"))
            .args(PORTS)
            .args([LOSS, DELAY, &seed.to_string()])
            .stdout(Stdio::piped())
            .spawn();
        let mut wire = Self(child.expect("Python"));
        let output = wire.0.stdout.take().expect("a pipe");
        let first = BufReader::new(output).lines().next();
        assert_eq!(first.expect("a line").expect("readable"), "ready");
        wire
    }
}

impl Drop for LossyWire {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Sends impacts over such a network until the peer has the forecast and the report of each, and a status that counts them all.
pub fn all_arrives(kind: Kind, seed: u64) -> Result<String, String> {
    let network = Network::connected()?;
    let _wire = LossyWire::through(&network, seed);
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let mut node = kind.node(&network, &domain, folder.path(), &[PATIENT]);
    node.wait_for("is ready in domain");
    let mut peer = Peer::start(kind, &network, &domain, folder.path(), RARE);
    peer.wait_for_answer(None, Instant::now() + ARRIVED)
        .ok_or_else(|| format!("{kind:?}: the peer does not hear the node at all"))?;
    let began = Instant::now();
    peer.follow_until(began + SENDING);
    let ended = Instant::now();
    let sent = peer.sent_between(began, ended);
    let deadline = ended + ARRIVED;
    loop {
        let unanswered = peer.unanswered(began, ended);
        let unreported = peer.unreported(began, ended);
        let is_counted = peer.accepted().is_none_or(|it| it >= sent);
        if sent > 0 && unanswered == 0 && unreported == 0 && is_counted {
            return Ok(format!("{kind:?}: all of {sent} impacts"));
        }
        if Instant::now() >= deadline {
            let accepted = peer.accepted();
            let log: Vec<_> = node.log_so_far().iter().rev().take(20).collect();
            return Err(format!(
                "{kind:?}: of {sent} impacts {unanswered} have no forecast and {unreported} no report, and the last status counts {accepted:?}; the end of the node's log: {log:#?}"
            ));
        }
        peer.follow_until(Instant::now() + SHORT);
    }
}
