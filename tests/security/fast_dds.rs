//! A node in its enclave, and peers of another make: Fast DDS, as Debian delivers it (`libfastrtps-dev`). The hostile ones do not
//! check certificates themselves, so that only the twin's own checks stand between them and the column.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use column_twin::keystore::AUTHORITY_NAME;
use openssl::pkcs7::{Pkcs7, Pkcs7Flags};
use openssl::pkey::PKey;
use openssl::stack::Stack;
use openssl::x509::X509;
use serde_json::Value as Json;
use sros2_keystore::{Creation, DataProtection, Renewal, create, renew};
use tempfile::TempDir;

use super::domain::Domain;
use super::made::{DAY, Made, name, plans, today};
use super::program::Program;

/// How long a hostile peer tries \[s\]; a permitted one is through after one or two.
const HOSTILE_SECS: u32 = 8;

/// How long a permitted peer waits at most \[s\].
const PERMITTED_SECS: u32 = 30;

/// The compiled program.
fn peer() -> &'static Path {
    static PEER: OnceLock<PathBuf> = OnceLock::new();
    PEER.get_or_init(|| {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/interop/fastdds/peer.cpp");
        let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fastdds_peer");
        let output = Command::new("c++")
            .args(["-std=c++17", "-O1", "-Wall", "-Wextra", "-rdynamic"])
            .arg(source)
            .arg("-o")
            .arg(&program)
            .args(["-lfastrtps", "-lfastcdr", "-ldl"])
            .output()
            .expect("a C++ compiler; on Debian: apt-get install g++ libfastrtps-dev");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.success(),
            "cannot compile the peer; on Debian: apt-get install g++ libfastrtps-dev: {errors}"
        );
        program
    })
}

/// What a peer reports of itself.
struct Told(Json);

impl Told {
    fn count(&self, path: &str) -> u64 {
        self.0.pointer(path).and_then(Json::as_u64).unwrap_or(0)
    }

    fn received(&self) -> u64 {
        let topics = self.0["received"].as_object().expect("counts by topic");
        topics.values().filter_map(Json::as_u64).sum()
    }

    fn has_created(&self, topic: &str) -> bool {
        self.0["created"][topic] == 1
    }

    /// It has tried, and nothing came of it in either direction.
    fn assert_shut_out(&self) {
        assert!(
            self.has_created("participant"),
            "it could not even try: {}",
            self.0
        );
        assert!(self.count("/sent") > 10, "it has not tried: {}", self.0);
        assert_eq!(self.received(), 0, "{}", self.0);
        assert_eq!(self.count("/matched_readers"), 0, "{}", self.0);
        assert_eq!(self.count("/matched_writers"), 0, "{}", self.0);
    }
}

/// A peer that sends events with this prefix; `how` are its arguments about clock and credulity.
fn ask(domain: &Domain, secs: u32, prefix: &str, enclave: Option<&Path>, how: &[&str]) -> Told {
    let mut command = Command::new(peer());
    command
        .arg(domain.environment.domain_id.to_string())
        .arg(secs.to_string())
        .args(["column", prefix]);
    if let Some(folder) = enclave {
        command.arg(folder).args(how);
    }
    let output = command.stdin(Stdio::null()).output().expect("runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().rev().find(|line| line.starts_with('{'));
    let line = line.unwrap_or_else(|| panic!("no report: {output:?}"));
    println!("{prefix}: {line}");
    Told(serde_json::from_str(line).expect("JSON"))
}

/// A running twin in the enclave `/column_twin` of a keystore.
struct SecuredTwin {
    domain: Domain,
    program: Program,
    _folder: TempDir,
}

impl SecuredTwin {
    fn start(keystore: &Path) -> Self {
        let domain = Domain::fresh();
        let folder = tempfile::tempdir().expect("a folder");
        let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
        command
            .args(["run", "--ros-args", "--enclave", "/column_twin"])
            .env("ROS_SECURITY_ENABLE", "true")
            .env("ROS_SECURITY_STRATEGY", "Enforce")
            .env("ROS_SECURITY_KEYSTORE", keystore);
        let mut program = Program::spawn(&domain, folder.path(), command);
        program.wait_for("is ready in domain");
        Self {
            domain,
            program,
            _folder: folder,
        }
    }

    /// A permitted operator still gets its event through, and only its events have been counted; then the log.
    fn end(self, keystore: &Path) -> Vec<String> {
        let operator = keystore.join("enclaves/operator");
        let told = ask(
            &self.domain,
            PERMITTED_SECS,
            "permitted",
            Some(&operator),
            &[],
        );
        assert_eq!(told.count("/forecasts_of_own_events"), 1, "{}", told.0);
        let counted = told.count("/status/events_accepted");
        assert!((1..=told.count("/sent")).contains(&counted), "{}", told.0);
        assert_eq!(told.count("/status/events_rejected"), 0, "{}", told.0);
        let (status, _, log) = self.program.terminate();
        assert!(status.success(), "{log:#?}");
        let accepted = log.iter().filter(|line| line.contains("accepted"));
        for line in accepted {
            assert!(line.contains("permitted-"), "{line}");
        }
        assert!(log.len() < 200, "the log has {} lines", log.len());
        log
    }
}

/// Copies the files of an enclave, some of them replaced.
fn mixed(enclave: &Path, replaced: &[(&str, Vec<u8>)]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for entry in fs::read_dir(enclave).expect("an enclave") {
        let path = entry.expect("a file").path();
        let target = folder.path().join(path.file_name().expect("a name"));
        fs::copy(&path, target).expect("copied");
    }
    for (file, content) in replaced {
        fs::write(folder.path().join(file), content).expect("written");
    }
    folder
}

fn bytes(path: PathBuf) -> Vec<u8> {
    fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A document signed by the authority of a keystore, which stands for a peer that does not look at signatures.
fn signed(made: &Made, document: &str) -> Vec<u8> {
    let certificate = X509::from_pem(&bytes(made.file("public/ca.cert.pem"))).unwrap();
    let key = PKey::private_key_from_pem(&bytes(made.file("private/ca.key.pem"))).unwrap();
    let flags = Pkcs7Flags::DETACHED | Pkcs7Flags::TEXT;
    let text = document.as_bytes();
    let none = Stack::new().unwrap();
    let signature = Pkcs7::sign(&certificate, &key, &none, text, flags).unwrap();
    signature.to_smime(text, flags).unwrap()
}

fn rejections(log: &[String]) -> Vec<&String> {
    log.iter()
        .filter(|line| line.contains("was rejected"))
        .collect()
}

#[test]
#[ignore = "slow: compiles and runs a program on Fast DDS"]
fn a_permitted_operator_on_fast_dds_sends_an_event_and_receives_the_forecast() {
    let made = Made::new();
    let twin = SecuredTwin::start(&made.path());
    let log = twin.end(&made.path());
    assert!(
        log.iter().any(|line| line.contains("CN=/operator")),
        "{log:#?}"
    );
}

/// The governance that SROS 2 makes, whose payloads are encrypted by themselves.
#[test]
#[ignore = "slow: compiles and runs a program on Fast DDS"]
fn the_default_governance_of_sros_2_works_with_fast_dds() {
    let folder = tempfile::tempdir().unwrap();
    let keystore = folder.path().join("keystore");
    create(&Creation {
        folder: &keystore,
        authority: AUTHORITY_NAME,
        enclaves: &plans(&[]),
        domains: &"0-232".parse().unwrap(),
        data: DataProtection::Encrypt,
        days: 10,
        now: today(),
    })
    .unwrap();
    SecuredTwin::start(&keystore).end(&keystore);
}

#[test]
#[ignore = "slow: compiles and runs a program on Fast DDS"]
fn a_peer_without_identity_gets_nothing_through() {
    let made = Made::new();
    let twin = SecuredTwin::start(&made.path());
    ask(&twin.domain, HOSTILE_SECS, "stranger", None, &[]).assert_shut_out();
    let log = twin.end(&made.path());
    assert!(!rejections(&log).is_empty(), "{log:#?}");
}

#[test]
#[ignore = "slow: compiles and runs a program on Fast DDS"]
fn a_peer_with_a_foreign_ca_gets_nothing_through() {
    let (made, foreign) = (Made::new(), Made::new());
    let twin = SecuredTwin::start(&made.path());
    // It knows the true authority, and would accept the twin.
    let authority = bytes(made.file("public/ca.cert.pem"));
    let enclave = mixed(
        &foreign.enclave("/operator"),
        &[("identity_ca.cert.pem", authority)],
    );
    ask(
        &twin.domain,
        HOSTILE_SECS,
        "foreign",
        Some(enclave.path()),
        &["0", "credulous"],
    )
    .assert_shut_out();
    let log = twin.end(&made.path());
    let rejections = rejections(&log);
    let reason = "ignature verification failure";
    assert!(
        rejections.iter().any(|line| line.contains(reason)),
        "{log:#?}"
    );
}

/// Its identity is right, but its permissions are signed by an authority of its own.
#[test]
#[ignore = "slow: compiles and runs a program on Fast DDS"]
fn a_peer_with_forged_permissions_gets_nothing_through() {
    let (made, foreign) = (Made::new(), Made::new());
    let twin = SecuredTwin::start(&made.path());
    let forged = foreign.enclave("/operator");
    let enclave = mixed(
        &made.enclave("/operator"),
        &[
            (
                "permissions_ca.cert.pem",
                bytes(forged.join("permissions_ca.cert.pem")),
            ),
            ("permissions.p7s", bytes(forged.join("permissions.p7s"))),
            ("governance.p7s", bytes(forged.join("governance.p7s"))),
        ],
    );
    ask(
        &twin.domain,
        HOSTILE_SECS,
        "forged",
        Some(enclave.path()),
        &["0", "credulous"],
    )
    .assert_shut_out();
    let log = twin.end(&made.path());
    assert!(!rejections(&log).is_empty(), "{log:#?}");
}

/// The certificate expired a year ago, and the peer believes that it is still before. Its permissions are valid.
#[test]
#[ignore = "slow: compiles and runs a program on Fast DDS"]
fn a_peer_with_an_expired_certificate_gets_nothing_through() {
    let made = Made::at(today() - 500 * DAY, 3000);
    let valid = bytes(made.file("enclaves/operator/permissions.p7s"));
    let kept = mixed(&made.enclave("/operator"), &[]);
    renew(&Renewal {
        folder: &made.path(),
        enclaves: &[name("/operator")],
        authority: false,
        days: 30,
        now: today() - 400 * DAY,
    })
    .unwrap();
    let expired = mixed(&made.enclave("/operator"), &[("permissions.p7s", valid)]);
    for file in ["cert.pem", "permissions.p7s"] {
        let certificate = bytes(kept.path().join(file));
        fs::write(made.enclave("/operator").join(file), certificate).unwrap();
    }
    let twin = SecuredTwin::start(&made.path());
    let told = ask(
        &twin.domain,
        HOSTILE_SECS,
        "expired",
        Some(expired.path()),
        &[&(-390 * DAY).to_string()],
    );
    told.assert_shut_out();
    let log = twin.end(&made.path());
    let rejections = rejections(&log);
    assert!(
        rejections.iter().any(|line| line.contains("expired")),
        "{log:#?}"
    );
}

/// The monitor's own stack does not create the writer, and it reads what it may read.
#[test]
#[ignore = "slow: compiles and runs a program on Fast DDS"]
fn a_monitor_reads_and_cannot_send_an_event() {
    let made = Made::new();
    let twin = SecuredTwin::start(&made.path());
    let monitor = made.enclave("/monitor");
    let told = ask(&twin.domain, HOSTILE_SECS, "monitor", Some(&monitor), &[]);
    assert!(!told.has_created("rt/impact_event"), "{}", told.0);
    assert!(told.count("/received/rt~1twin_status") > 0, "{}", told.0);
    twin.end(&made.path());
}

/// Only the twin's own check stands between this peer and the column. The peer skips exactly one thing: its own stack obeys other
/// permissions than those that it shows to the twin. Its identity, its signatures and its governance are those of the keystore, so
/// that its endpoints are compatible with those of the twin. The control is the same peer, which shows what it obeys.
#[test]
#[ignore = "slow: compiles and runs a program on Fast DDS"]
fn a_monitor_without_checks_of_its_own_cannot_send_an_event_and_the_same_one_with_permission_can() {
    let made = Made::new();
    let allowing = made
        .read("enclaves/operator/permissions.xml")
        .replace("/operator", "/monitor");
    let allowing = signed(&made, &allowing);
    for is_permitted in [true, false] {
        let mut replaced = vec![("own_permissions.p7s", allowing.clone())];
        if is_permitted {
            replaced.push(("permissions.p7s", allowing.clone()));
        }
        let enclave = mixed(&made.enclave("/monitor"), &replaced);
        let (secs, prefix) = match is_permitted {
            true => (PERMITTED_SECS, "permitted"),
            false => (HOSTILE_SECS, "lax"),
        };
        let twin = SecuredTwin::start(&made.path());
        let told = ask(&twin.domain, secs, prefix, Some(enclave.path()), &[]);
        assert!(told.has_created("rt/impact_event"), "{}", told.0);
        // It takes part, and reads what it may read.
        assert!(told.count("/received/rt~1twin_status") > 0, "{}", told.0);
        let log = match is_permitted {
            true => {
                assert_eq!(told.count("/forecasts_of_own_events"), 1, "{}", told.0);
                twin.program.terminate().2
            }
            false => {
                assert!(told.count("/sent") > 10, "it has not tried: {}", told.0);
                assert_eq!(told.count("/forecasts_of_own_events"), 0, "{}", told.0);
                twin.end(&made.path())
            }
        };
        assert!(
            log.iter().any(|line| line.contains("CN=/monitor")),
            "it was authenticated: {log:#?}"
        );
    }
}
