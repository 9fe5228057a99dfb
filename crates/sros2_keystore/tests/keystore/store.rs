//! Making, extending, renewing and reading keystores.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;

use jiff::Timestamp;
use sros2_keystore::{
    Addition, Creation, DataProtection, ENCLAVE_DAYS, EnclaveName, KeystoreError, Remedy, Renewal,
    add, create, inspect, renew,
};

use super::made::{AUTHORITY, DAY, Made, listing, name, plans, today};

/// What `ros2 security create_keystore` and `create_enclave` of SROS 2 0.13.0 make; only the modes are stricter, and one file demands it.
const LAYOUT: [&str; 31] = [
    "enclaves 755",
    "enclaves/arm 755",
    "enclaves/arm/cert.pem 644",
    "enclaves/arm/governance.p7s -> ../governance.p7s",
    "enclaves/arm/identity_ca.cert.pem -> ../../public/identity_ca.cert.pem",
    "enclaves/arm/key.pem 600",
    "enclaves/arm/permissions.p7s 644",
    "enclaves/arm/permissions.xml 644",
    "enclaves/arm/permissions_ca.cert.pem -> ../../public/permissions_ca.cert.pem",
    "enclaves/governance.p7s 644",
    "enclaves/governance.xml 644",
    "enclaves/monitor 755",
    "enclaves/monitor/cert.pem 644",
    "enclaves/monitor/governance.p7s -> ../governance.p7s",
    "enclaves/monitor/identity_ca.cert.pem -> ../../public/identity_ca.cert.pem",
    "enclaves/monitor/key.pem 600",
    "enclaves/monitor/permissions.p7s 644",
    "enclaves/monitor/permissions.xml 644",
    "enclaves/monitor/permissions_ca.cert.pem -> ../../public/permissions_ca.cert.pem",
    "private 700",
    "private/ca.key.pem 600",
    "private/identity_ca.key.pem -> ca.key.pem",
    "private/permissions_ca.key.pem -> ca.key.pem",
    "public 755",
    "public/ca.cert.pem 644",
    "public/identity_ca.cert.pem -> ca.cert.pem",
    "public/permissions_ca.cert.pem -> ca.cert.pem",
    // Not of SROS 2.
    "security.strict_files 644",
    "enclaves/garage 755",
    "enclaves/garage/a1 755",
    "enclaves/garage/a1/governance.p7s -> ../../governance.p7s",
];

#[test]
fn a_keystore_is_laid_out_as_sros_2_lays_it_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("keystore");
    let creation = Creation {
        folder: &path,
        authority: AUTHORITY,
        enclaves: &plans(&["/arm", "/monitor", "/garage/a1"]),
        domains: &0.into(),
        data: DataProtection::None,
        days: ENCLAVE_DAYS,
        now: today(),
    };
    create(&creation).unwrap();
    let found = listing(&path);
    for expected in LAYOUT {
        assert!(
            found.iter().any(|it| it == expected),
            "{expected}: {found:#?}"
        );
    }
    // Besides, the nested enclave has six more files.
    assert_eq!(found.len(), LAYOUT.len() + 6, "{found:#?}");
    // Every link leads to a file.
    for line in found.iter().filter_map(|it| it.split_once(" -> ")) {
        assert!(path.join(line.0).is_file(), "{line:?}");
    }
}

#[test]
fn every_enclave_of_a_new_keystore_can_be_used() {
    let made = Made::new();
    let summary = inspect(&made.path(), None, Timestamp::now()).unwrap();
    assert_eq!(summary.domains.to_string(), "0-232");
    assert!(summary.is_usable() && summary.can_sign);
    assert_eq!(summary.warnings, []);
    let names: Vec<_> = summary.enclaves.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, ["/arm", "/monitor", "/operator"]);
    for enclave in &summary.enclaves {
        let state = enclave.state.as_ref().expect("usable");
        assert_eq!(state.subject, format!("CN={}", enclave.name));
        let left = state.first_end.1.as_second() - today();
        assert!((364 * DAY..=365 * DAY).contains(&left), "{left}");
        assert_eq!(enclave.warnings, []);
    }
}

/// Our default differs from SROS 2's in one word, and that word can be asked for.
#[test]
fn only_the_protection_of_the_payload_differs_from_sros_2() {
    let governance = |data| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("keystore");
        let creation = Creation {
            folder: &path,
            authority: AUTHORITY,
            enclaves: &plans(&[]),
            domains: &7.into(),
            data,
            days: 1,
            now: today(),
        };
        create(&creation).unwrap();
        fs::read_to_string(path.join("enclaves/governance.xml")).unwrap()
    };
    let kinds = |text: &str| -> Vec<String> {
        let lines = text.lines().map(str::trim);
        let kinds = lines.filter(|it| it.contains("protection_kind") || it.contains("control>"));
        kinds.map(str::to_owned).collect()
    };
    let sros = [
        "<enable_join_access_control>true</enable_join_access_control>",
        "<discovery_protection_kind>ENCRYPT</discovery_protection_kind>",
        "<liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>",
        "<rtps_protection_kind>SIGN</rtps_protection_kind>",
        "<enable_read_access_control>true</enable_read_access_control>",
        "<enable_write_access_control>true</enable_write_access_control>",
        "<metadata_protection_kind>ENCRYPT</metadata_protection_kind>",
        "<data_protection_kind>ENCRYPT</data_protection_kind>",
    ];
    assert_eq!(kinds(&governance(DataProtection::Encrypt)), sros);
    let ours = governance(DataProtection::None);
    assert_eq!(kinds(&ours)[..7], sros[..7]);
    assert_eq!(
        kinds(&ours)[7],
        "<data_protection_kind>NONE</data_protection_kind>"
    );
    assert!(ours.contains("<id>7</id>"));
    assert!(ours.contains("<allow_unauthenticated_participants>false<"));
}

#[test]
fn a_folder_in_use_is_not_touched() {
    let made = Made::new();
    let before = listing(&made.path());
    let key = made.read("private/ca.key.pem");
    let creation = Creation {
        folder: &made.path(),
        authority: AUTHORITY,
        enclaves: &plans(&[]),
        domains: &0.into(),
        data: DataProtection::None,
        days: 1,
        now: today(),
    };
    let error = create(&creation).expect_err("in use");
    assert!(matches!(error, KeystoreError::Occupied(_)), "{error}");
    assert_eq!(error.remedy(), Some(Remedy::Add(made.path())));
    assert_eq!(listing(&made.path()), before);
    assert_eq!(made.read("private/ca.key.pem"), key);
    // An empty folder is as good as none.
    let empty = tempfile::tempdir().unwrap();
    create(&Creation {
        folder: empty.path(),
        ..creation
    })
    .expect("an empty folder is free");
}

#[test]
fn a_keystore_that_cannot_be_written_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    for place in ["file/keystore", "nowhere/keystore"] {
        let path = folder.path().join(place);
        let creation = Creation {
            folder: &path,
            authority: AUTHORITY,
            enclaves: &plans(&[]),
            domains: &0.into(),
            data: DataProtection::None,
            days: 1,
            now: today(),
        };
        let error = create(&creation).expect_err(place);
        assert!(!error.is_bad_input(), "{error}");
    }
    assert_eq!(listing(folder.path()).len(), 1);
    // An enclave that cannot be made whole does not appear, either: a link of its name is in the way.
    let made = Made::new();
    let target = made.enclave("/late");
    std::os::unix::fs::symlink("nowhere", &target).unwrap();
    let before = listing(&made.path());
    let plans = plans(&["/late"]);
    let addition = Addition {
        folder: &made.path(),
        enclave: &plans[0],
        domains: None,
        days: 1,
        now: today(),
    };
    add(&addition).expect_err("a link is in the way");
    assert_eq!(listing(&made.path()), before);
}

#[test]
fn a_private_key_is_never_overwritten() {
    let made = Made::new();
    let key = made.read("enclaves/monitor/key.pem");
    let plans = plans(&["/monitor"]);
    let addition = Addition {
        folder: &made.path(),
        enclave: &plans[0],
        domains: None,
        days: 10,
        now: today(),
    };
    let error = add(&addition).expect_err("it exists");
    let renewal = Remedy::Renew("/monitor".to_owned());
    assert_eq!(error.remedy(), Some(renewal), "{error}");
    renew(&Renewal {
        folder: &made.path(),
        enclaves: &[],
        authority: true,
        days: 10,
        now: today(),
    })
    .unwrap();
    assert_eq!(made.read("enclaves/monitor/key.pem"), key);
    // A key without a certificate is still a key.
    fs::remove_file(made.file("enclaves/monitor/cert.pem")).unwrap();
    add(&addition).expect_err("the key exists");
    assert_eq!(made.read("enclaves/monitor/key.pem"), key);
}

#[test]
fn an_enclave_is_added_also_above_and_below_others() {
    let made = Made::new();
    for text in ["/garage/a1/arm", "/garage", "/monitor/second"] {
        let plans = plans(&[text]);
        add(&Addition {
            folder: &made.path(),
            enclave: &plans[0],
            domains: None,
            days: 10,
            now: today(),
        })
        .expect(text);
    }
    let summary = inspect(&made.path(), Some(42), Timestamp::now()).unwrap();
    assert!(summary.is_usable(), "{summary:#?}");
    let names: Vec<_> = summary.enclaves.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "/arm",
            "/garage",
            "/garage/a1/arm",
            "/monitor",
            "/monitor/second",
            "/operator"
        ]
    );
    assert!(
        !listing(&made.path())
            .iter()
            .any(|it| it.contains("partial")),
        "nothing temporary stays"
    );
}

#[test]
fn an_added_enclave_is_for_the_domains_of_the_governance() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("keystore");
    let domains = "3,7-9".parse().unwrap();
    create(&Creation {
        folder: &path,
        authority: AUTHORITY,
        enclaves: &plans(&[]),
        domains: &domains,
        data: DataProtection::None,
        days: 10,
        now: today(),
    })
    .unwrap();
    let plans = plans(&["/late"]);
    add(&Addition {
        folder: &path,
        enclave: &plans[0],
        domains: None,
        days: 10,
        now: today(),
    })
    .unwrap();
    for (domain, is_usable) in [(3, true), (8, true), (4, false)] {
        let summary = inspect(&path, Some(domain), Timestamp::now()).unwrap();
        assert_eq!(summary.is_usable(), is_usable, "domain {domain}");
    }
    let foreign = inspect(&path, Some(4), Timestamp::now()).unwrap();
    let faults = foreign.enclaves[0].state.as_ref().expect_err("no rule");
    assert!(faults[0].contains("no rule for the domain 4"), "{faults:?}");
}

#[test]
fn renewal_keeps_keys_and_everything_written_by_hand() {
    let made = Made::at(today() - 400 * DAY, 365);
    let expired = inspect(&made.path(), None, Timestamp::now()).unwrap();
    assert!(!expired.is_usable());
    let faults = expired.enclaves[1].state.as_ref().expect_err("expired");
    assert!(
        faults.iter().any(|it| it.contains("expired on")),
        "{faults:?}"
    );
    // A topic of the user's own, and a deployed key that is no longer here.
    let path = made.file("enclaves/monitor/permissions.xml");
    let permissions = fs::read_to_string(&path).unwrap();
    let edited = permissions.replacen(
        "<topic>rt/rosout</topic>",
        "<!-- ours --><topic>rt/rosout</topic><topic>rt/own</topic>",
        1,
    );
    fs::write(&path, &edited).unwrap();
    let unsigned = inspect(&made.path(), None, Timestamp::now()).unwrap();
    let [warning] = &unsigned.enclaves[1].warnings[..] else {
        panic!("{unsigned:#?}");
    };
    assert!(
        warning.text.contains("only the signed text counts"),
        "{warning:?}"
    );
    assert_eq!(warning.remedy, Some(Remedy::Renew("/monitor".to_owned())));
    assert!(!unsigned.enclaves[1].publish.contains("rt/own"));
    let operator_key = made.file("enclaves/operator/key.pem");
    let deployed = fs::read(&operator_key).unwrap();
    fs::remove_file(&operator_key).unwrap();

    let renewed = renew(&Renewal {
        folder: &made.path(),
        enclaves: &[],
        authority: false,
        days: 90,
        now: today(),
    });
    assert_eq!(renewed.unwrap().len(), 3);
    fs::write(&operator_key, deployed).unwrap();
    // Copied carelessly, it can be read by others, which the keystore forbids.
    let careless = inspect(&made.path(), None, Timestamp::now()).unwrap();
    assert!(!careless.is_usable(), "{careless:#?}");
    fs::set_permissions(&operator_key, fs::Permissions::from_mode(0o600)).unwrap();
    let summary = inspect(&made.path(), None, Timestamp::now()).unwrap();
    assert!(summary.is_usable(), "{summary:#?}");
    assert!(summary.enclaves[1].publish.contains("rt/own"));
    assert!(
        made.read("enclaves/monitor/permissions.xml")
            .contains("<!-- ours -->")
    );
    let left = summary.enclaves[0].state.as_ref().unwrap().first_end.1;
    assert!((89 * DAY..=90 * DAY).contains(&(left.as_second() - today())));
}

#[test]
fn an_enclave_does_not_outlive_the_authority_until_that_is_renewed() {
    let nine_years_ago = today() - 9 * 365 * DAY;
    let made = Made::at(nine_years_ago, 365);
    let before = listing(&made.path());
    let certificate = made.read("enclaves/monitor/cert.pem");
    let path = made.path();
    let rejected = Renewal {
        folder: &path,
        enclaves: &[],
        authority: false,
        days: 2 * 365,
        now: today(),
    };
    let error = renew(&rejected).expect_err("too long");
    assert_eq!(error.remedy(), Some(Remedy::RenewAuthority), "{error}");
    assert_eq!(listing(&made.path()), before);
    assert_eq!(made.read("enclaves/monitor/cert.pem"), certificate);
    renew(&Renewal {
        authority: true,
        ..rejected
    })
    .unwrap();
    let summary = inspect(&made.path(), None, Timestamp::now()).unwrap();
    assert!(summary.is_usable(), "{summary:#?}");
    assert_eq!(listing(&made.path()), before, "no link became a file");
}

#[test]
fn a_faulty_keystore_is_described_before_anything_is_written() {
    let made = Made::new();
    let path = made.path();
    let try_to_renew = |enclaves: &[EnclaveName]| {
        let renewal = Renewal {
            folder: &path,
            enclaves,
            authority: false,
            days: 10,
            now: today(),
        };
        renew(&renewal).expect_err("rejected").to_string()
    };
    let error = try_to_renew(&[name("/nobody")]);
    assert!(error.contains("/arm, /monitor, /operator"), "{error}");
    // Permissions that cannot be read: nothing of the other enclaves is renewed, either.
    let twin = made.read("enclaves/arm/cert.pem");
    fs::write(made.file("enclaves/operator/permissions.xml"), "<dds>").unwrap();
    let error = try_to_renew(&[]);
    assert!(error.contains("operator/permissions.xml"), "{error}");
    assert_eq!(made.read("enclaves/arm/cert.pem"), twin);
    // The key of another authority.
    let other = Made::new();
    fs::copy(
        other.file("private/ca.key.pem"),
        made.file("private/ca.key.pem"),
    )
    .unwrap();
    let error = try_to_renew(&[]);
    assert!(error.contains("is not the key of"), "{error}");
    // No key.
    fs::remove_file(made.file("private/ca.key.pem")).unwrap();
    let error = try_to_renew(&[]);
    assert!(
        error.contains("only the machine with the authority's key"),
        "{error}"
    );
    assert!(!inspect(&path, None, Timestamp::now()).unwrap().can_sign);
    // No keystore.
    fs::remove_dir_all(made.file("public")).unwrap();
    let error = try_to_renew(&[]);
    assert!(error.contains("is not a keystore"), "{error}");
    for days in [0, 36_501, u32::MAX] {
        let creation = Creation {
            folder: &path.join("new"),
            authority: AUTHORITY,
            enclaves: &plans(&[]),
            domains: &0.into(),
            data: DataProtection::None,
            days,
            now: today(),
        };
        let error = create(&creation).expect_err("out of range").to_string();
        assert!(error.contains("1 to 36500 days"), "{error}");
    }
}
