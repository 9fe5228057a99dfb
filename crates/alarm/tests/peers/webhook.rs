//! Webhooks against an HTTPS server in Python.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use column_alarm::{Alarms, Settings, StartError, TlsFiles, WebhookSettings, try_out};
use serde_json::Value;
use tempfile::tempdir;

use super::certificates::Authority;
use super::programs::Lines;
use super::{condition, listening, rules, wait_until};

const SECRET: &str = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw\n";

fn secret_file(folder: &Path) -> PathBuf {
    let path = folder.join("secret");
    fs::write(&path, SECRET).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
    path
}

/// A server with this certificate, and its address.
fn receiver(folder: &Path, identity: (PathBuf, PathBuf), answers: &str) -> (Lines, String) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/https_receiver.py");
    let mut command = Command::new("python3");
    command
        .arg(script)
        .arg(identity.0)
        .arg(identity.1)
        .arg(secret_file(folder));
    if !answers.is_empty() {
        command.arg(answers);
    }
    let lines = Lines::of(&mut command);
    let port = lines.next();
    (lines, format!("https://127.0.0.1:{port}/alarms"))
}

fn settings(url: &str, authority: &Authority, folder: &Path) -> Settings {
    Settings {
        node: "twin".to_owned(),
        spool: folder.to_owned(),
        heartbeat: None,
        mqtt: None,
        webhook: Some(WebhookSettings {
            url: url.to_owned(),
            key_file: secret_file(folder),
            tls: TlsFiles {
                authorities: Some(authority.file()),
                ..TlsFiles::default()
            },
            rules: rules(),
        }),
    }
}

fn next(lines: &Lines) -> Value {
    serde_json::from_str(&lines.next()).unwrap()
}

#[test]
#[ignore = "needs Python"]
fn an_alarm_arrives_signed_and_is_repeated_with_its_id_until_it_is_taken() {
    let folder = tempdir().unwrap();
    let ours = Authority::new(folder.path(), "ours");
    let (lines, url) = receiver(
        folder.path(),
        ours.issue("receiver", false),
        "503,500,204,400",
    );
    let (notices, told) = listening();
    let alarms = Alarms::start(&settings(&url, &ours, folder.path()), notices).unwrap();
    alarms.observe(condition("a3", 3));
    let attempts: Vec<Value> = (0..3).map(|_| next(&lines)).collect();
    for attempt in &attempts {
        assert_eq!(attempt["right"], true);
        assert_eq!(attempt, &attempts[0], "the same id and the same body");
        assert_eq!(attempt["id"], attempt["body"]["id"]);
    }
    let body = &attempts[0]["body"];
    assert_eq!(
        (&body["state"], &body["kind"], &body["rank"]),
        (&"raised".into(), &"action".into(), &3.into())
    );
    wait_until(&alarms, "delivered", |it| it.channels[0].delivered == 1);
    // This one is rejected; others pass it.
    alarms.observe(condition("rejected", 3));
    assert_eq!(next(&lines)["body"]["subject"], "rejected");
    alarms.observe(condition("a3", 0));
    loop {
        let it = next(&lines)["body"].clone();
        if it["subject"] == "a3" {
            assert_eq!(
                (&it["state"], &it["alarm"]),
                (&"cleared".into(), &body["alarm"])
            );
            break;
        }
    }
    wait_until(&alarms, "delivered", |it| it.channels[0].waiting == 0);
    alarms.stop("A test stops it.", Duration::from_secs(10));
    let stopped =
        std::iter::repeat_with(|| next(&lines)).find(|it| it["body"]["kind"] == "node_stopped");
    assert_eq!(stopped.unwrap()["body"]["reason"], "A test stops it.");
    let told = told.lock().unwrap().clone();
    assert!(told[0].1.contains("answered 503"), "{told:?}");
}

#[test]
#[ignore = "needs Python"]
fn wrong_and_expired_certificates_are_told() {
    let folder = tempdir().unwrap();
    let (ours, other) = (
        Authority::new(folder.path(), "ours"),
        Authority::new(folder.path(), "other"),
    );
    for (identity, trusted, expected) in [
        (ours.issue("receiver", false), &ours, ""),
        (other.issue("receiver", false), &ours, "UnknownIssuer"),
        (ours.issue("expired", true), &ours, "expired"),
    ] {
        let (lines, url) = receiver(folder.path(), identity, "");
        let tried = try_out(&settings(&url, trusted, folder.path()))
            .unwrap()
            .remove(0)
            .1;
        match tried {
            Ok(()) => {
                assert_eq!(expected, "");
                assert_eq!(next(&lines)["body"]["state"], "test");
            }
            Err(fault) => assert!(!expected.is_empty() && fault.contains(expected), "{fault}"),
        }
    }
}

#[test]
#[ignore = "needs Python"]
fn settings_that_would_leak_or_cannot_work_are_errors_at_the_start() {
    let folder = tempdir().unwrap();
    let ours = Authority::new(folder.path(), "ours");
    let fault = |url: &str, change: &dyn Fn(&mut WebhookSettings)| {
        let mut settings = settings(url, &ours, folder.path());
        change(settings.webhook.as_mut().unwrap());
        Alarms::start(&settings, listening().0).err()
    };
    let good = "https://127.0.0.1:1/";
    assert!(fault(good, &|_| {}).is_none());
    assert!(matches!(
        fault("http://example.org/", &|_| {}),
        Some(StartError::Unencrypted(_))
    ));
    for url in ["", "ftp://127.0.0.1/", "https://", "127.0.0.1"] {
        assert!(
            matches!(fault(url, &|_| {}), Some(StartError::Url(_))),
            "{url}"
        );
    }
    let open = |it: &mut WebhookSettings| {
        fs::set_permissions(&it.key_file, fs::Permissions::from_mode(0o640)).unwrap();
    };
    assert!(matches!(
        fault(good, &open),
        Some(StartError::Mode { mode: 0o640, .. })
    ));
    let short = |it: &mut WebhookSettings| fs::write(&it.key_file, "whsec_AAAA").unwrap();
    assert!(matches!(
        fault(good, &short),
        Some(StartError::Content { .. })
    ));
    let half = |it: &mut WebhookSettings| it.tls.certificate = Some(ours.file());
    assert!(matches!(
        fault(good, &half),
        Some(StartError::HalfAnIdentity)
    ));
    let absent = |it: &mut WebhookSettings| it.tls.authorities = Some("/nowhere".into());
    assert!(matches!(
        fault(good, &absent),
        Some(StartError::File { .. })
    ));
    let mixed = |it: &mut WebhookSettings| {
        it.tls.certificate = Some(ours.issue("one", false).0);
        it.tls.key = Some(ours.issue("two", false).1);
    };
    assert!(matches!(fault(good, &mixed), Some(StartError::Tls(_))));
}
