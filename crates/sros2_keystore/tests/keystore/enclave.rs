//! Files of an enclave that cannot be used: each fault is named, before RustDDS sees the files.

use std::fs;

use jiff::Timestamp;
use sros2_keystore::{Enclave as Checked, EnclaveError, EnclaveFault, EnclaveFile};

use super::by_openssl::{
    ALL_DOMAINS, Enclave, Governance, Identity, Keystore, NODE, Permissions, RECOMMENDED,
    SROS_DEFAULT, everything,
};

/// The faults of an enclave in domain 7.
fn faults(enclave: &Enclave) -> Vec<EnclaveFault> {
    match check(enclave) {
        Err(EnclaveError::Broken { faults, .. }) => faults,
        other => panic!("{other:?}"),
    }
}

fn check(enclave: &Enclave) -> Result<Checked, EnclaveError> {
    let folder = tempfile::tempdir().unwrap();
    let files = enclave.write_to(folder.path());
    Checked::load("/talker", &files, 7, Timestamp::now())
}

/// The only fault, and its text.
fn only(enclave: &Enclave) -> (EnclaveFault, String) {
    let faults = faults(enclave);
    let [fault] = &faults[..] else {
        panic!("expected one fault, found {faults:#?}");
    };
    (fault.clone(), fault.to_string())
}

fn talker() -> (Identity, Enclave) {
    let keystore = Keystore::new();
    let enclave = keystore.unrestricted("/talker", &RECOMMENDED);
    (keystore.authority, enclave)
}

#[test]
fn an_enclave_of_sros2_passes_all_checks() {
    for governance in [RECOMMENDED, SROS_DEFAULT] {
        let keystore = Keystore::new();
        let enclave = check(&keystore.unrestricted("/talker", &governance)).unwrap();
        assert_eq!(enclave.subject, "CN=/talker");
        assert_eq!(enclave.kinds.rtps, "SIGN");
        assert_eq!(enclave.kinds.data, [governance.data]);
        assert!(enclave.summary().contains("enclave /talker (CN=/talker)"));
        let is_warned = !enclave.warnings(Timestamp::now()).is_empty();
        assert_eq!(is_warned, governance.data == "ENCRYPT", "{enclave:?}");
    }
}

#[test]
fn a_missing_file_is_named() {
    let (_, enclave) = talker();
    let folder = tempfile::tempdir().unwrap();
    let files = enclave.write_to(folder.path());
    fs::remove_file(files.join("permissions.p7s")).unwrap();
    fs::remove_file(files.join("governance.p7s")).unwrap();
    std::os::unix::fs::symlink("../nowhere.p7s", files.join("governance.p7s")).unwrap();
    let error = Checked::load("/talker", &files, 7, Timestamp::now()).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("\n- permissions.p7s is missing"), "{text}");
    assert!(
        text.contains("\n- governance.p7s cannot be read: it is a link to ../nowhere.p7s"),
        "{text}"
    );
}

#[test]
fn the_key_of_another_is_rejected() {
    let (authority, mut enclave) = talker();
    let other = authority.issue("/talker", -1..365);
    enclave.key = other.key.private_key_to_pem_pkcs8().unwrap();
    let (fault, text) = only(&enclave);
    assert!(matches!(fault, EnclaveFault::ForeignKey { .. }), "{text}");
    assert!(
        text.starts_with("key.pem is not the private key of cert.pem (CN=/talker)"),
        "{text}"
    );
}

#[test]
fn a_key_that_rustdds_cannot_read_is_rejected() {
    let (authority, mut enclave) = talker();
    let key = authority.issue("/talker", -1..365).key;
    let cipher = openssl::symm::Cipher::aes_128_cbc();
    enclave.key = key
        .private_key_to_pem_pkcs8_passphrase(cipher, b"secret")
        .unwrap();
    assert_eq!(faults(&enclave), [EnclaveFault::EncryptedKey]);
    enclave.key = key.ec_key().unwrap().private_key_to_pem().unwrap();
    assert!(
        faults(&enclave).contains(&EnclaveFault::NotPkcs8),
        "{:?}",
        faults(&enclave)
    );
    enclave.key = b"no key".to_vec();
    assert!(
        only(&enclave)
            .1
            .starts_with("key.pem: expected a private key")
    );
}

#[test]
fn an_expired_certificate_is_rejected_and_one_that_is_not_valid_yet() {
    let keystore = Keystore::new();
    for (days, words) in [(-30..-1, "expired on"), (1..30, "is not valid before")] {
        let identity = keystore.authority.issue("/talker", days);
        let permissions = everything("/talker");
        let enclave = Enclave::of(&keystore.authority, &identity, &RECOMMENDED, &permissions);
        let (_, text) = only(&enclave);
        assert!(text.starts_with("cert.pem (CN=/talker)"), "{text}");
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn a_certificate_of_another_authority_is_rejected() {
    let (_, mut enclave) = talker();
    let foreign = Identity::authority("foreignCA");
    enclave.identity_ca = foreign.certificate.to_pem().unwrap();
    let (fault, text) = only(&enclave);
    assert!(
        matches!(fault, EnclaveFault::ForeignCertificate { .. }),
        "{text}"
    );
    assert!(
        text.contains("by identity_ca.cert.pem (CN=foreignCA), but by `CN=sros2CA`"),
        "{text}"
    );
}

#[test]
fn a_document_that_was_changed_or_signed_by_another_is_rejected() {
    let (_, mut enclave) = talker();
    let text = String::from_utf8(enclave.governance.clone()).unwrap();
    let changed = text.replace("<rtps_protection_kind>SIGN<", "<rtps_protection_kind>NONE<");
    assert_ne!(text, changed);
    enclave.governance = changed.into_bytes();
    enclave.permissions = Identity::authority("sros2CA").sign(&everything("/talker").xml());
    let faults = faults(&enclave);
    let files: Vec<_> = faults
        .iter()
        .filter_map(|fault| match fault {
            EnclaveFault::Signature { file, .. } => Some(*file),
            _ => None,
        })
        .collect();
    assert_eq!(
        files,
        [EnclaveFile::Governance, EnclaveFile::Permissions],
        "{faults:#?}"
    );
    enclave.governance = b"unsigned".to_vec();
    assert!(matches!(
        self::faults(&enclave)[0],
        EnclaveFault::Signature { .. }
    ));
}

#[test]
fn permissions_of_another_time_subject_or_domain_are_rejected() {
    let keystore = Keystore::new();
    let of = |permissions: &Permissions<'_>, governance: &Governance<'_>| {
        let identity = keystore.authority.issue("/talker", -1..365);
        only(&Enclave::of(
            &keystore.authority,
            &identity,
            governance,
            permissions,
        ))
    };
    let good = everything("/talker");
    for days in [-30..-1, 1..30] {
        let (fault, text) = of(
            &Permissions {
                days,
                ..good.clone()
            },
            &RECOMMENDED,
        );
        assert!(
            matches!(fault, EnclaveFault::PermissionsNotValid { .. }),
            "{text}"
        );
    }
    let (_, text) = of(&everything("/another"), &RECOMMENDED);
    assert!(
        text.contains("expected `CN=/talker`, found `CN=/another`"),
        "{text}"
    );
    let elsewhere = "<id>3</id><id_range><min>10</min><max>20</max></id_range>";
    let (_, text) = of(
        &Permissions {
            domains: elsewhere,
            ..good.clone()
        },
        &RECOMMENDED,
    );
    assert!(
        text.starts_with(
            "permissions.p7s has no rule for the domain 7 (it has rules for: 3,10-20)"
        ),
        "{text}"
    );
    let (_, text) = of(
        &good,
        &Governance {
            domains: elsewhere,
            ..RECOMMENDED
        },
    );
    assert!(
        text.starts_with("governance.p7s has no rule for the domain 7 (it has rules for: 3,10-20)"),
        "{text}"
    );
}

#[test]
fn a_permissions_document_without_the_topics_of_every_node_is_rejected() {
    let keystore = Keystore::new();
    let identity = keystore.authority.issue("/talker", -1..365);
    let permissions = Permissions {
        publish: &["rt/*"],
        subscribe: &["rt/*"],
        ..everything("/talker")
    };
    let enclave = Enclave::of(&keystore.authority, &identity, &RECOMMENDED, &permissions);
    let texts: Vec<_> = faults(&enclave).iter().map(ToString::to_string).collect();
    assert_eq!(texts.len(), 2, "{texts:#?}");
    assert!(
        texts[0].starts_with("permissions.p7s does not permit to publish ros_discovery_info"),
        "{texts:#?}"
    );
    let permissions = Permissions {
        publish: &NODE,
        subscribe: &NODE,
        ..permissions
    };
    let enclave = Enclave::of(&keystore.authority, &identity, &RECOMMENDED, &permissions);
    assert!(check(&enclave).is_ok());
}

#[test]
fn protection_that_rustdds_does_not_support_is_rejected_with_what_would_do() {
    let keystore = Keystore::new();
    for (governance, words) in [
        (
            Governance {
                data: "SIGN",
                ..RECOMMENDED
            },
            "data_protection_kind of the topics `*` is `SIGN`, expected one of NONE, ENCRYPT; RustDDS loses signed payloads",
        ),
        (
            Governance {
                metadata: "HIDE",
                ..RECOMMENDED
            },
            "metadata_protection_kind of the topics `*` is `HIDE`, expected one of NONE, SIGN",
        ),
    ] {
        let (_, text) = only(&keystore.unrestricted("/talker", &governance));
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn all_faults_are_reported_at_once() {
    let keystore = Keystore::new();
    let identity = keystore.authority.issue("/talker", -30..-1);
    let governance = Governance {
        domains: "<id>3</id>",
        ..RECOMMENDED
    };
    let permissions = Permissions {
        days: -30..-1,
        domains: ALL_DOMAINS,
        ..everything("/talker")
    };
    let mut enclave = Enclave::of(&keystore.authority, &identity, &governance, &permissions);
    enclave.key = b"no key".to_vec();
    let faults = faults(&enclave);
    assert_eq!(faults.len(), 4, "{faults:#?}");
}

#[test]
fn an_end_within_thirty_days_is_announced() {
    let keystore = Keystore::new();
    let identity = keystore.authority.issue("/talker", -1..20);
    let permissions = everything("/talker");
    let enclave = Enclave::of(&keystore.authority, &identity, &RECOMMENDED, &permissions);
    let enclave = check(&enclave).unwrap();
    let hour = std::time::Duration::from_secs(3600);
    let warnings = enclave.warnings(Timestamp::now() + hour);
    assert!(
        warnings[0].starts_with("cert.pem of the enclave expires in 19 days, on "),
        "{warnings:?}"
    );
    let (over, coming) = enclave.near_ends(Timestamp::now());
    assert_eq!((over.len(), coming.len()), (0, 1));
    let month = std::time::Duration::from_secs(30 * 86_400);
    let (over, _) = enclave.near_ends(Timestamp::now() + month);
    assert!(
        over[0].contains("cert.pem of the enclave expired on"),
        "{over:?}"
    );
}

#[test]
fn no_content_of_a_file_panics() {
    let (authority, enclave) = talker();
    let good = [
        &enclave.identity_ca,
        &enclave.certificate,
        &enclave.key,
        &enclave.permissions_ca,
        &enclave.governance,
        &enclave.permissions,
    ];
    for (index, content) in good.iter().enumerate() {
        for length in (0..content.len()).step_by(97) {
            let mut cut = enclave.clone();
            let files = [
                &mut cut.identity_ca,
                &mut cut.certificate,
                &mut cut.key,
                &mut cut.permissions_ca,
                &mut cut.governance,
                &mut cut.permissions,
            ];
            files.into_iter().nth(index).unwrap().truncate(length);
            assert!(check(&cut).is_err(), "file {index} of {length} bytes");
        }
    }
    for odd in [
        "",
        "<dds/>",
        "<dds><permissions/></dds>",
        "<dds><permissions><grant/></permissions></dds>",
        "<!DOCTYPE x [<!ENTITY a \"b\">]><dds>&a;</dds>",
        "<dds><domain_access_rules><domain_rule/></domain_access_rules></dds>",
    ] {
        let mut enclave = enclave.clone();
        enclave.governance = authority.sign(odd);
        enclave.permissions = authority.sign(odd);
        assert!(check(&enclave).is_err(), "{odd}");
    }
}
