//! MQTT 5 against mosquitto.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use column_alarm::{Alarms, Importance, Message, MqttSettings, Settings, State, TlsFiles, try_out};
use tempfile::tempdir;

use super::certificates::Authority;
use super::programs::{Lines, Mosquitto};
use super::{condition, listening, rules, wait_until};

fn settings(broker: &str, spool: &Path) -> Settings {
    Settings {
        node: "twin".to_owned(),
        spool: spool.to_owned(),
        heartbeat: None,
        mqtt: Some(MqttSettings {
            broker: broker.to_owned(),
            client_id: "twin".to_owned(),
            topic: "site/{node}/{subject}/{kind}".to_owned(),
            rules: rules(),
            ..MqttSettings::default()
        }),
        webhook: None,
    }
}

/// Topic, whether it was retained, and the message of a line of the subscriber; `None` for its own greeting.
fn parsed(line: &str) -> Option<(String, bool, Message)> {
    let mut parts = line.splitn(3, ' ');
    let (topic, retained, payload) = (parts.next()?, parts.next()?, parts.next()?);
    let message = serde_json::from_str(payload).ok()?;
    Some((topic.to_owned(), retained == "1", message))
}

fn next(lines: &Lines) -> (String, bool, Message) {
    loop {
        if let Some(found) = parsed(&lines.next()) {
            return found;
        }
    }
}

#[test]
#[ignore = "needs mosquitto"]
fn an_alarm_arrives_and_a_late_subscriber_has_its_present_state() {
    let folder = tempdir().unwrap();
    let broker = Mosquitto::started(folder.path(), "");
    let lines = broker.subscriber();
    let (notices, told) = listening();
    let alarms = Alarms::start(&settings(&broker.address(), folder.path()), notices).unwrap();
    alarms.observe(condition("a/3", 3));
    let (topic, retained, raised) = next(&lines);
    assert_eq!(
        (topic.as_str(), retained, raised.state),
        ("site/twin/a%2F3/action", false, State::Raised)
    );
    alarms.observe(condition("a/3", 0));
    let (_, _, cleared) = next(&lines);
    assert_eq!(
        (cleared.state, &cleared.alarm),
        (State::Cleared, &raised.alarm)
    );
    drop(lines);
    let late = broker.subscriber_afresh();
    let (topic, retained, state) = next(&late);
    assert_eq!(
        (topic.as_str(), retained, &state),
        ("site/twin/a%2F3/action", true, &cleared)
    );
    alarms.stop("A test stops it.", Duration::from_secs(10));
    let (topic, _, stopped) = next(&late);
    assert_eq!(
        (topic.as_str(), stopped.state),
        ("site/twin/twin/node_stopped", State::Raised)
    );
    assert_eq!(stopped.reason, "A test stops it.");
    assert_eq!(
        late.next_soon(),
        None,
        "the broker publishes no will after an orderly end"
    );
    assert_eq!(told.lock().unwrap().len(), 0, "{told:?}");
}

#[test]
#[ignore = "needs mosquitto"]
fn ten_thousand_alarms_through_restarts_of_the_broker_are_neither_lost_nor_new_ones() {
    const ALARMS: usize = 10_000;
    let folder = tempdir().unwrap();
    let mut broker = Mosquitto::started(folder.path(), "");
    let lines = broker.subscriber();
    let (notices, told) = listening();
    let alarms = Alarms::start(&settings(&broker.address(), folder.path()), notices).unwrap();
    for number in 0..ALARMS {
        alarms.observe(condition(&number.to_string(), 3));
    }
    let began = Instant::now();
    for round in 1..=5 {
        let enough = round * ALARMS as u64 / 7;
        wait_until(&alarms, "delivered", |it| {
            it.channels[0].delivered >= enough
        });
        broker.stop();
        wait_until(&alarms, "noticed", |it| it.channels[0].works == Some(false));
        broker.start();
    }
    wait_until(&alarms, "delivered", |it| it.channels[0].waiting == 0);
    println!(
        "{ALARMS} alarms through 5 restarts in {:.1} s",
        began.elapsed().as_secs_f64()
    );
    let mut by_id: BTreeMap<String, Message> = BTreeMap::new();
    let mut repeats = 0;
    let actions = |by_id: &BTreeMap<String, Message>| {
        by_id
            .values()
            .filter(|it| it.watched.kind == "action")
            .count()
    };
    while actions(&by_id) < ALARMS {
        let (_, _, message) = next(&lines);
        if let Some(before) = by_id.insert(message.id.clone(), message.clone()) {
            assert_eq!(before, message);
            repeats += 1;
        }
    }
    let subjects: BTreeSet<&String> = by_id
        .values()
        .filter(|it| it.watched.kind == "action")
        .map(|it| &it.watched.subject)
        .collect();
    assert_eq!(subjects.len(), ALARMS);
    println!("{repeats} repeats, each with its id");
    let statistics = alarms.statistics();
    assert_eq!((statistics.dropped, statistics.channels[0].lost), (0, 0));
    let told = told.lock().unwrap();
    assert!(told.iter().all(|it| it.0 != Importance::Error), "{told:?}");
}

/// Not a test of its own: the process that the next one kills.
#[test]
#[ignore = "is started by another test"]
fn child_that_is_killed() {
    let Ok(broker) = std::env::var("ALARM_TEST_BROKER") else {
        return;
    };
    let spool = std::env::var("ALARM_TEST_SPOOL").unwrap();
    let alarms = Alarms::start(&settings(&broker, Path::new(&spool)), listening().0).unwrap();
    for subject in ["a", "b", "c"] {
        alarms.observe(condition(subject, 3));
    }
    let delivers = std::env::var("ALARM_TEST_DELIVERS").is_ok();
    wait_until(&alarms, "spooled", |it| {
        let channel = &it.channels[0];
        (if delivers {
            channel.delivered
        } else {
            channel.waiting
        }) == 3
    });
    println!("\nspooled");
    std::thread::park();
}

fn killed_child(broker: &str, spool: &Path, delivers: bool) {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args([
        "mqtt::child_that_is_killed",
        "--exact",
        "--ignored",
        "--nocapture",
    ]);
    command
        .env("ALARM_TEST_BROKER", broker)
        .env("ALARM_TEST_SPOOL", spool);
    if delivers {
        command.env("ALARM_TEST_DELIVERS", "1");
    }
    let child = Lines::of(&mut command);
    while !child.next().contains("spooled") {}
    // `Running` kills with SIGKILL.
    drop(child);
}

#[test]
#[ignore = "needs mosquitto"]
fn a_kill_between_an_alarm_and_its_delivery_loses_nothing() {
    let folder = tempdir().unwrap();
    let mut broker = Mosquitto::new(folder.path(), "");
    killed_child(&broker.address(), folder.path(), false);
    broker.start();
    let lines = broker.subscriber();
    let alarms = Alarms::start(&settings(&broker.address(), folder.path()), listening().0).unwrap();
    // What was active is active still, and is not raised again.
    alarms.observe(condition("a", 3));
    let arrived: Vec<(String, State)> = (0..5)
        .map(|_| {
            let (topic, _, message) = next(&lines);
            (topic, message.state)
        })
        .collect();
    let stopped = "site/twin/twin/node_stopped";
    let expected = [
        ("site/twin/a/action", State::Raised),
        ("site/twin/b/action", State::Raised),
        ("site/twin/c/action", State::Raised),
        (stopped, State::Raised),
        (stopped, State::Cleared),
    ];
    assert_eq!(
        arrived,
        expected.map(|(topic, state)| (topic.to_owned(), state))
    );
    assert_eq!(lines.next_soon(), None);
    drop(alarms);
}

#[test]
#[ignore = "needs mosquitto"]
fn the_broker_says_that_a_killed_node_stopped_and_the_next_start_clears_it() {
    let folder = tempdir().unwrap();
    let broker = Mosquitto::started(folder.path(), "");
    let lines = broker.subscriber();
    killed_child(&broker.address(), folder.path(), true);
    let mut will = None;
    while will.is_none() {
        let (topic, _, message) = next(&lines);
        will = (topic == "site/twin/twin/node_stopped").then_some(message);
    }
    let will = will.unwrap();
    assert_eq!(will.state, State::Raised);
    let alarms = Alarms::start(&settings(&broker.address(), folder.path()), listening().0).unwrap();
    let (_, _, repeated) = next(&lines);
    assert_eq!(repeated, will, "the same message with the same id");
    let (_, _, cleared) = next(&lines);
    assert_eq!(
        (cleared.state, &cleared.alarm),
        (State::Cleared, &will.alarm)
    );
    alarms.stop("A test stops it.", Duration::from_secs(10));
}

#[test]
#[ignore = "needs mosquitto"]
fn heartbeats_come_only_from_a_host_that_lives() {
    let folder = tempdir().unwrap();
    let broker = Mosquitto::started(folder.path(), "");
    let lines = broker.subscriber();
    let mut settings = settings(&broker.address(), folder.path());
    settings.heartbeat = Some(Duration::from_millis(100));
    let alarms = Alarms::start(&settings, listening().0).unwrap();
    assert_eq!(
        lines.next_soon(),
        None,
        "a heartbeat without a sign of life"
    );
    alarms.sign_of_life();
    let (topic, _, beat) = next(&lines);
    assert_eq!(
        (topic.as_str(), beat.state),
        ("site/twin/twin/heartbeat", State::Alive)
    );
    assert_eq!(lines.next_soon(), None, "one sign of life is one heartbeat");
    assert_eq!(alarms.statistics().channels[0].heartbeats, 1);
}

#[test]
#[ignore = "needs mosquitto"]
fn a_topic_that_the_broker_forbids_is_told_and_kept_and_does_not_hold_up_others() {
    let folder = tempdir().unwrap();
    let acl = folder.path().join("acl");
    fs::write(
        &acl,
        "topic read #\ntopic write hello\ntopic write site/twin/good/#\ntopic write site/twin/twin/node_stopped\n",
    )
    .unwrap();
    let broker = Mosquitto::started(folder.path(), &format!("acl_file {}", acl.display()));
    let lines = broker.subscriber();
    let (notices, told) = listening();
    let alarms = Alarms::start(&settings(&broker.address(), folder.path()), notices).unwrap();
    alarms.observe(condition("bad", 3));
    alarms.observe(condition("good", 3));
    while next(&lines).0 != "site/twin/good/action" {}
    wait_until(&alarms, "rejected", |it| {
        it.channels[0].rejected > 0 && it.channels[0].waiting > 0
    });
    let told = told.lock().unwrap().clone();
    let expected = "does not take site/twin/bad/action: NotAuthorized";
    assert!(told.iter().any(|it| it.1.contains(expected)), "{told:?}");
    let tried = try_out(&settings(&broker.address(), folder.path())).unwrap();
    assert!(
        tried[0]
            .1
            .as_ref()
            .unwrap_err()
            .contains("site/twin/twin/test: NotAuthorized"),
        "{tried:?}"
    );
}

#[test]
#[ignore = "needs mosquitto"]
fn certificates_decide_who_talks_to_whom() {
    let folder = tempdir().unwrap();
    let (ours, other) = (
        Authority::new(folder.path(), "ours"),
        Authority::new(folder.path(), "other"),
    );
    let start = |name: &str, expired: bool| {
        let place = folder.path().join(name);
        fs::create_dir(&place).unwrap();
        let (certificate, key) = ours.issue(name, expired);
        let more = format!(
            "cafile {}\ncertfile {}\nkeyfile {}\nrequire_certificate true\n",
            ours.file().display(),
            certificate.display(),
            key.display()
        );
        Mosquitto::started(&place, &more)
    };
    let (broker, expired) = (start("broker", false), start("expired", true));
    let files = |authority: &Authority,
                 identity: Option<(std::path::PathBuf, std::path::PathBuf)>| {
        let (certificate, key) = identity.unzip();
        TlsFiles {
            authorities: Some(authority.file()),
            certificate,
            key,
        }
    };
    let attempt = |broker: &Mosquitto, tls: TlsFiles| {
        let mut settings = settings(&broker.address().replace("mqtt:", "mqtts:"), folder.path());
        settings.mqtt.as_mut().unwrap().tls = tls;
        try_out(&settings).unwrap().remove(0).1
    };
    let us = ours.issue("us", false);
    assert_eq!(attempt(&broker, files(&ours, Some(us.clone()))), Ok(()));
    for (what, broker, tls, expected) in [
        (
            "an authority that we do not trust",
            &broker,
            files(&other, Some(us.clone())),
            "UnknownIssuer",
        ),
        (
            "an expired certificate of the broker",
            &expired,
            files(&ours, Some(us.clone())),
            "expired",
        ),
        ("no certificate", &broker, files(&ours, None), "ertificate"),
        (
            "a certificate of another authority",
            &broker,
            files(&ours, Some(other.issue("us", false))),
            "UnknownCA",
        ),
        (
            "our expired certificate",
            &broker,
            files(&ours, Some(ours.issue("late", true))),
            "xpired",
        ),
    ] {
        let fault = attempt(broker, tls).expect_err(what);
        assert!(fault.contains(expected), "{what}: {fault}");
    }
    // The same in a running node: it is told once, and everything waits.
    let mut settings = settings(&broker.address().replace("mqtt:", "mqtts:"), folder.path());
    settings.mqtt.as_mut().unwrap().tls = files(&other, Some(us));
    let (notices, told) = listening();
    let alarms = Alarms::start(&settings, notices).unwrap();
    alarms.observe(condition("a", 3));
    wait_until(&alarms, "failed", |it| {
        it.channels[0].failed >= 2 && it.channels[0].waiting == 1
    });
    let told = told.lock().unwrap().clone();
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!(told[0].0, Importance::Warning);
}

#[test]
#[ignore = "needs mosquitto"]
fn a_password_is_read_from_its_file() {
    let folder = tempdir().unwrap();
    let passwords = folder.path().join("passwords");
    let mut make = Command::new("mosquitto_passwd");
    let made = make
        .args(["-b", "-c"])
        .arg(&passwords)
        .args(["twin", "secret"]);
    assert!(made.status().unwrap().success());
    let more = format!(
        "allow_anonymous false\npassword_file {}",
        passwords.display()
    );
    let broker = Mosquitto::started(folder.path(), &more);
    let file = folder.path().join("password");
    fs::write(&file, "secret\n").unwrap();
    let mut settings = settings(&broker.address(), folder.path());
    let mqtt = settings.mqtt.as_mut().unwrap();
    mqtt.user = Some("twin".to_owned());
    mqtt.password_file = Some(file.clone());
    let fault = try_out(&settings)
        .expect_err("others may read it")
        .to_string();
    assert!(fault.contains("chmod 600"), "{fault}");
    let mode = |mode| {
        fs::set_permissions(&file, std::os::unix::fs::PermissionsExt::from_mode(mode)).unwrap()
    };
    mode(0o600);
    assert_eq!(try_out(&settings).unwrap(), [("mqtt", Ok(()))]);
    fs::write(&file, "wrong\n").unwrap();
    let fault = try_out(&settings).unwrap().remove(0).1.unwrap_err();
    assert!(
        fault.contains("NotAuthorized") || fault.contains("BadUserNamePassword"),
        "{fault}"
    );
}

/// Prints how long an alarm takes from the host to the subscriber; a table for a quiet machine, not a test of time.
#[test]
#[ignore = "needs mosquitto"]
fn the_way_of_an_alarm_is_measured() {
    let folder = tempdir().unwrap();
    let broker = Mosquitto::started(folder.path(), "");
    let lines = broker.subscriber();
    let alarms = Alarms::start(&settings(&broker.address(), folder.path()), listening().0).unwrap();
    let mut times: Vec<f64> = (0..300)
        .map(|number| {
            let began = Instant::now();
            alarms.observe(condition(&number.to_string(), 3));
            let (_, _, message) = next(&lines);
            assert_eq!(message.watched.subject, number.to_string());
            began.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!(
        "from the host to the subscriber: median {:.2} ms, p99 {:.2} ms, worst {:.2} ms",
        times[150], times[297], times[299]
    );
}
