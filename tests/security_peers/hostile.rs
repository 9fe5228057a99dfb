//! A protected twin in its own process, an operator that it admits, and a third peer, which it must not admit.

use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use column_twin::column::ImpactSpecification;
use column_twin::messages::column_twin_msgs::TwinStatus;
use column_twin::messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use column_twin::ros::{
    ClientError, Environment, ImpactOptions, ImpactOutcome, ImpactRequest, Names, Node, qos,
    send_impact,
};
use sros2_keystore::{SecuritySettings, SecurityStrategy};

use super::by_openssl::{
    ALL_DOMAINS, Enclave, Governance, Identity, Keystore, NODE, Permissions, RECOMMENDED,
    SROS_DEFAULT, everything,
};
use super::domain::{Domain, PATIENCE};
use super::incoming::Incoming;
use super::peer::Peer;
use super::program::Program;

/// A peer that is permitted exchanges its first messages within 1.5 s; so long does a hostile one try.
const HOSTILE_TIME: Duration = Duration::from_secs(5);

/// How long a permitted peer tries before somebody looks whether it has got through.
const ATTEMPT: Duration = Duration::from_millis(500);

/// How long a peer tries.
enum Trial {
    Lasts(Duration),
    /// Until messages have got through in both directions, or [`PATIENCE`] ends.
    UntilThrough,
}

/// Peers of another authority beside a permitted one.
const STRANGERS: usize = 6;

/// A protected twin and its operator.
struct Bed {
    keystore: Keystore,
    domain: Domain,
    twin: Program,
    _folder: tempfile::TempDir,
}

impl Bed {
    fn start(governance: &Governance<'_>) -> Self {
        Self::with_certificate_for(governance, 365)
    }

    /// The certificate of the twin is valid for so many days.
    fn with_certificate_for(governance: &Governance<'_>, days: i64) -> Self {
        Self::prepared(governance, days, |_| {})
    }

    /// `prepare` may change the folder of the twin's enclave before the twin starts.
    fn prepared(governance: &Governance<'_>, days: i64, prepare: impl FnOnce(&Path)) -> Self {
        let (keystore, domain) = (Keystore::new(), Domain::fresh());
        keystore.write(&keystore.unrestricted("/operator", governance));
        let identity = keystore.authority.issue("/column_twin", -1..days);
        let permissions = everything("/column_twin");
        prepare(&keystore.write(&Enclave::of(
            &keystore.authority,
            &identity,
            governance,
            &permissions,
        )));
        let folder = tempfile::tempdir().unwrap();
        let mut twin = Program::spawn(&domain, folder.path(), twin(&keystore));
        twin.wait_for("is ready in domain");
        Self {
            keystore,
            domain,
            twin,
            _folder: folder,
        }
    }

    fn operator(&self) -> Environment {
        let settings = SecuritySettings {
            is_enabled: true,
            strategy: SecurityStrategy::Enforce,
            keystore: Some(self.keystore.path().to_owned()),
            ..SecuritySettings::default()
        };
        Environment {
            security: settings.with_enclave(Some("/operator")),
            ..self.domain.environment.clone()
        }
    }

    /// Lets a peer try, and returns it, and how many of its events the twin has seen.
    fn exchange(&mut self, files: Option<&Path>, trial: Trial) -> (Peer, u64) {
        let domain_id = self.domain.environment.domain_id;
        self.exchange_with(|| Peer::start(domain_id, files), trial)
    }

    fn exchange_with(&mut self, start: impl FnOnce() -> Peer, trial: Trial) -> (Peer, u64) {
        let names = Names::new("/", "operator", &[]).unwrap();
        let mut node = Node::new(&self.operator(), names).unwrap();
        let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
        let mut peer = start();
        match trial {
            Trial::Lasts(time) => peer.try_for(time),
            Trial::UntilThrough => {
                let deadline = Instant::now() + PATIENCE;
                let mut is_seen = false;
                while (peer.received == 0 || !is_seen) && Instant::now() < deadline {
                    peer.try_for(ATTEMPT);
                    let status = statuses.newest();
                    is_seen |= status.is_some_and(|it| it.events_accepted + it.events_rejected > 0);
                }
            }
        }
        // The twin is alive: it answers the operator, and counts its event with those of the peer.
        match send(&self.operator(), "operator") {
            Ok(ImpactOutcome::Forecast(_)) => {}
            other => panic!("{other:?}\n{:#?}", self.twin.log_so_far()),
        }
        let status = statuses.find("the operator's event", |it| it.events_accepted > 0);
        (peer, status.events_accepted + status.events_rejected - 1)
    }

    /// Lets a hostile peer try for a while. Nothing gets through, in either direction, and the twin says why.
    fn nothing_gets_through(mut self, files: Option<&Path>, reason: &str) {
        let (peer, seen) = self.exchange(files, Trial::Lasts(HOSTILE_TIME));
        assert_eq!(
            (peer.received, seen),
            (0, 0),
            "messages to the hostile peer, and from it"
        );
        let line = self.twin.wait_for("was rejected: ");
        // As long as it is there, the twin goes on with its authentication.
        drop(peer);
        assert!(line.contains(reason), "{line}");
        let (status, _, log) = self.twin.terminate();
        assert!(status.success(), "{log:#?}");
        assert!(log.len() < 60, "the log is flooded: {} lines", log.len());
    }
}

#[test]
fn a_permitted_peer_gets_through_in_both_directions() {
    let mut bed = Bed::start(&RECOMMENDED);
    let files = bed
        .keystore
        .write(&bed.keystore.unrestricted("/monitor", &RECOMMENDED));
    let (peer, seen) = bed.exchange(Some(&files), Trial::UntilThrough);
    assert!(
        peer.received > 0 && seen > 0,
        "{} messages to the peer, {seen} from it",
        peer.received
    );
    let (_, _, log) = bed.twin.terminate();
    for name in ["/operator", "/monitor"] {
        let joined = format!("joined with the identity CN={name}");
        assert!(log.iter().any(|line| line.contains(&joined)), "{log:#?}");
    }
    // Lines about errors came while a permitted peer joined.
    let wrong: Vec<_> = log.iter().filter(|it| it.contains("[ERROR]")).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_governance_of_ros2_security_works_unchanged() {
    let mut bed = Bed::start(&SROS_DEFAULT);
    let files = bed
        .keystore
        .write(&bed.keystore.unrestricted("/monitor", &SROS_DEFAULT));
    let (peer, seen) = bed.exchange(Some(&files), Trial::UntilThrough);
    assert!(
        peer.received > 0 && seen > 0,
        "{} messages to the peer, {seen} from it",
        peer.received
    );
    bed.twin.terminate();
}

/// The status `security` of the twin, when `is_it` says yes to it.
fn security_status(
    bed: &Bed,
    what: &str,
    is_it: impl Fn(&DiagnosticStatus) -> bool,
) -> DiagnosticStatus {
    let names = Names::new("/", "monitor", &[]).unwrap();
    let mut node = Node::new(&bed.operator(), names).unwrap();
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
    let of = |array: &DiagnosticArray| {
        let mut statuses = array.status.iter();
        let status = statuses.find(|it| it.name == "column_twin: security");
        status.expect("a status of security").clone()
    };
    of(&diagnostics.find(what, |array| is_it(&of(array))))
}

fn value(status: &DiagnosticStatus, key: &str) -> String {
    let value = status.values.iter().find(|it| it.key == key);
    value.expect(key).value.clone()
}

#[test]
fn who_joined_and_who_was_rejected_is_counted_in_diagnostics() {
    let bed = Bed::start(&RECOMMENDED);
    let stranger = Peer::start(bed.domain.environment.domain_id, None);
    let status = security_status(&bed, "a rejected peer", |it| {
        value(it, "peers rejected") != "0"
    });
    assert_eq!(status.level, DiagnosticStatus::OK, "{status:?}");
    assert_eq!(value(&status, "peers joined"), "1", "{status:?}");
    assert_eq!(value(&status, "peers rejected"), "1", "{status:?}");
    assert_eq!(value(&status, "subject"), "CN=/column_twin");
    drop(stranger);
    bed.twin.terminate();
}

#[test]
fn a_certificate_that_ends_within_thirty_days_is_announced_in_diagnostics() {
    let bed = Bed::with_certificate_for(&RECOMMENDED, 20);
    let status = security_status(&bed, "any", |_| true);
    assert_eq!(status.level, DiagnosticStatus::WARN, "{status:?}");
    assert!(
        status
            .message
            .starts_with("cert.pem of the enclave expires in "),
        "{status:?}"
    );
    let (_, _, log) = bed.twin.terminate();
    let announced =
        |line: &String| line.contains("[WARN]") && line.contains("cert.pem of the enclave expires");
    assert!(log.iter().any(announced), "{log:#?}");
}

#[test]
fn a_key_that_others_can_read_is_a_warning_in_diagnostics_with_the_chmod() {
    let bed = Bed::prepared(&RECOMMENDED, 365, |enclave| {
        let open = std::fs::Permissions::from_mode(0o644);
        std::fs::set_permissions(enclave.join("key.pem"), open).unwrap();
    });
    let status = security_status(&bed, "any", |_| true);
    assert_eq!(status.level, DiagnosticStatus::WARN, "{status:?}");
    assert!(status.message.contains("chmod 600"), "{status:?}");
    bed.twin.terminate();
}

#[test]
fn a_peer_without_identity_gets_nothing_through() {
    let bed = Bed::start(&RECOMMENDED);
    bed.nothing_gets_through(None, "it has no DDS security");
}

/// The participant with the lower identifier, which follows from the name, begins the handshake. `/visitor` is lower than
/// `/column_twin`, and `/operator` is higher: the twin meets them in different states.
const BOTH_SIDES: [&str; 2] = ["/visitor", "/operator"];

#[test]
fn a_peer_of_another_authority_gets_nothing_through() {
    for (name, reason) in BOTH_SIDES.into_iter().zip([
        "Certificate signature verification failure",
        "it did not complete the authentication, or rejected us",
    ]) {
        let bed = Bed::start(&RECOMMENDED);
        let foreign = Keystore::new();
        let files = foreign.write(&foreign.unrestricted(name, &RECOMMENDED));
        bed.nothing_gets_through(Some(&files), reason);
    }
}

/// The twin repeats its unanswered requests to all strangers together with that to the operator, in one burst per second. The
/// request to the operator was lost in it whenever another one followed before the operator had taken it.
#[test]
fn a_permitted_peer_gets_through_beside_many_that_do_not_answer() {
    let mut bed = Bed::start(&RECOMMENDED);
    let foreign = Keystore::new();
    let files = foreign.write(&foreign.unrestricted("/operator", &RECOMMENDED));
    let domain_id = bed.domain.environment.domain_id;
    let strangers: Vec<_> = (0..STRANGERS)
        .map(|_| Peer::start(domain_id, Some(&files)))
        .collect();
    match send(&bed.operator(), "operator") {
        Ok(ImpactOutcome::Forecast(_)) => {}
        other => panic!("{other:?}\n{:#?}", bed.twin.log_so_far()),
    }
    drop(strangers);
    bed.twin.terminate();
}

#[test]
fn a_peer_with_forged_permissions_gets_nothing_through() {
    let bed = Bed::start(&RECOMMENDED);
    let forger = Identity::authority("sros2CA");
    let enclave = bed.keystore.unrestricted("/monitor", &RECOMMENDED);
    let forged = enclave.with_permissions_of(&forger, &RECOMMENDED, &everything("/monitor"));
    let files = bed.keystore.write(&forged);
    bed.nothing_gets_through(Some(&files), "Could not verify signature");
}

#[test]
fn a_peer_with_an_expired_certificate_gets_nothing_through() {
    for name in BOTH_SIDES {
        let reason = format!("The certificate of CN={name} expired on");
        untimely_certificate(name, -30..-1, &reason);
    }
}

#[test]
fn a_peer_whose_certificate_is_not_valid_yet_gets_nothing_through() {
    for name in BOTH_SIDES {
        let reason = format!("The certificate of CN={name} is not valid before");
        untimely_certificate(name, 1..30, &reason);
    }
}

fn untimely_certificate(name: &str, days: std::ops::Range<i64>, reason: &str) {
    let bed = Bed::start(&RECOMMENDED);
    let authority = &bed.keystore.authority;
    let identity = authority.issue(name, days);
    let enclave = Enclave::of(authority, &identity, &RECOMMENDED, &everything(name));
    let folder = tempfile::tempdir().unwrap();
    let files = enclave.write_to(folder.path());
    bed.nothing_gets_through(Some(&files), reason);
}

/// The control: the same peer, with the same stack, gets through as soon as it is permitted. Only its permissions, which the
/// receiver checks, make the difference.
#[test]
fn a_peer_without_permission_gets_nothing_through_and_the_same_one_with_permission_does() {
    for is_permitted in [true, false] {
        let mut bed = Bed::start(&RECOMMENDED);
        let authority = &bed.keystore.authority;
        let identity = authority.issue("/attacker", -1..365);
        let permissions = match is_permitted {
            true => everything("/attacker"),
            false => Permissions {
                publish: &NODE,
                subscribe: &NODE,
                domains: ALL_DOMAINS,
                ..everything("/attacker")
            },
        };
        let enclave = Enclave::of(authority, &identity, &RECOMMENDED, &permissions);
        let files = bed.keystore.write(&enclave);
        let domain_id = bed.domain.environment.domain_id;
        let trial = match is_permitted {
            true => Trial::UntilThrough,
            false => Trial::Lasts(HOSTILE_TIME),
        };
        let (peer, seen) = bed.exchange_with(|| Peer::without_own_checks(domain_id, &files), trial);
        assert_eq!(
            (peer.received > 0, seen > 0),
            (is_permitted, is_permitted),
            "{} messages to the peer, {seen} from it",
            peer.received
        );
        bed.twin.wait_for("joined with the identity CN=/attacker");
        drop(peer);
        bed.twin.terminate();
    }
}

/// `column-twin run` in the enclave `/column_twin`.
fn twin(keystore: &Keystore) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
    command
        .args(["run", "--ros-args", "--enclave", "/column_twin"])
        .args(["-p", "state.directory:=''", "-p", "real_time.priority:=0"])
        .env("ROS_SECURITY_ENABLE", "true")
        .env("ROS_SECURITY_STRATEGY", "Enforce")
        .env("ROS_SECURITY_KEYSTORE", keystore.path())
        .env_remove("ROS_SECURITY_ENCLAVE_OVERRIDE");
    command
}

fn send(environment: &Environment, event_id: &str) -> Result<ImpactOutcome, ClientError> {
    let options = ImpactOptions {
        column_id: Some("column".to_owned()),
        request: ImpactRequest {
            event_id: Some(event_id.to_owned()),
            vehicle: String::new(),
            impact: ImpactSpecification {
                mass: 1500.0,
                velocity: 1.0,
                gap: None,
                restitution: None,
                height: None,
                direction: None,
            },
            match_timeout: PATIENCE,
            answer_timeout: PATIENCE,
        },
    };
    send_impact(environment, &[], &options, &mut |_| {})
}
