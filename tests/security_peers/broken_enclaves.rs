//! A node does not start in an enclave that is broken, whatever is wrong with it.

use std::fs;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::Path;

use sros2_keystore::STRICT_FILES;

use super::by_openssl::{Enclave, Identity, Keystore, Permissions, RECOMMENDED, everything};
use super::domain::Domain;
use super::start::rejected;

const NAME: &str = "/column_twin";

/// What is wrong with an enclave.
struct Fault {
    what: &'static str,
    /// Breaks the enclave before it is written.
    spoil: fn(&Keystore, &mut Enclave),
    /// Breaks it in its folder.
    spoil_files: fn(&Path),
    /// How the line about it begins.
    line: &'static str,
    /// What else it contains: what was found, or what to do.
    words: &'static str,
}

const NONE: Fault = Fault {
    what: "",
    spoil: |_, _| {},
    spoil_files: |_| {},
    line: "",
    words: "",
};

/// Signs these permissions with the authority of the keystore.
fn permit(keystore: &Keystore, enclave: &mut Enclave, permissions: &Permissions<'_>) {
    enclave.permissions = keystore.authority.sign(&permissions.xml());
}

const FAULTS: [Fault; 16] = [
    Fault {
        what: "a missing key",
        spoil_files: |folder| fs::remove_file(folder.join("key.pem")).unwrap(),
        line: "key.pem is missing",
        words: "create the enclave completely",
        ..NONE
    },
    Fault {
        what: "a missing governance",
        spoil_files: |folder| fs::remove_file(folder.join("governance.p7s")).unwrap(),
        line: "governance.p7s is missing",
        words: "create the enclave completely",
        ..NONE
    },
    Fault {
        what: "an expired certificate",
        spoil: |keystore, enclave| {
            let identity = keystore.authority.issue(NAME, -30..-1);
            *enclave = Enclave::of(
                &keystore.authority,
                &identity,
                &RECOMMENDED,
                &everything(NAME),
            );
        },
        line: "cert.pem (CN=/column_twin) expired on",
        words: "renew it",
        ..NONE
    },
    Fault {
        what: "a certificate of another authority",
        spoil: |_, enclave| {
            let identity = Identity::authority("otherCA").issue(NAME, -1..365);
            enclave.certificate = identity.certificate.to_pem().unwrap();
            enclave.key = identity.key.private_key_to_pem_pkcs8().unwrap();
        },
        line: "cert.pem (CN=/column_twin) was not issued by identity_ca.cert.pem (CN=sros2CA)",
        words: "but by `CN=otherCA`",
        ..NONE
    },
    Fault {
        what: "the key of another certificate",
        spoil: |keystore, enclave| {
            let other = keystore.authority.issue(NAME, -1..365);
            enclave.key = other.key.private_key_to_pem_pkcs8().unwrap();
        },
        line: "key.pem is not the private key of cert.pem (CN=/column_twin)",
        words: "restore the key",
        ..NONE
    },
    Fault {
        what: "a key in the format of older programs",
        spoil: |keystore, enclave| {
            let identity = keystore.authority.issue(NAME, -1..365);
            enclave.certificate = identity.certificate.to_pem().unwrap();
            let key = identity.key.ec_key().unwrap();
            enclave.key = key.private_key_to_pem().unwrap();
        },
        line: "key.pem is not in PKCS#8 format",
        words: "openssl pkcs8 -topk8 -nocrypt",
        ..NONE
    },
    Fault {
        what: "a certificate in a binary format",
        spoil: |keystore, enclave| {
            let identity = keystore.authority.issue(NAME, -1..365);
            enclave.certificate = identity.certificate.to_der().unwrap();
        },
        line: "cert.pem: expected an X.509 certificate in PEM format",
        words: "cannot be read",
        ..NONE
    },
    Fault {
        what: "an empty file",
        spoil: |_, enclave| enclave.identity_ca.clear(),
        line: "identity_ca.cert.pem: expected an X.509 certificate in PEM format",
        words: "cannot be read",
        ..NONE
    },
    Fault {
        // Not by its mode: root can read every file.
        what: "a file that cannot be read",
        spoil_files: |folder| {
            fs::remove_file(folder.join("permissions_ca.cert.pem")).unwrap();
            fs::create_dir(folder.join("permissions_ca.cert.pem")).unwrap();
        },
        line: "permissions_ca.cert.pem cannot be read",
        words: "directory",
        ..NONE
    },
    Fault {
        what: "a link to a device that never ends",
        spoil_files: |folder| {
            fs::remove_file(folder.join("identity_ca.cert.pem")).unwrap();
            symlink("/dev/zero", folder.join("identity_ca.cert.pem")).unwrap();
        },
        line: "identity_ca.cert.pem cannot be read",
        words: "larger than 1048576 bytes",
        ..NONE
    },
    Fault {
        what: "permissions without a signature",
        spoil: |_, enclave| enclave.permissions = everything(NAME).xml().into_bytes(),
        line: "permissions.p7s does not carry a valid signature of permissions_ca.cert.pem (CN=sros2CA)",
        words: "sign it again",
        ..NONE
    },
    Fault {
        what: "permissions that another authority has signed",
        spoil: |_, enclave| {
            enclave.permissions = Identity::authority("sros2CA").sign(&everything(NAME).xml());
        },
        line: "permissions.p7s does not carry a valid signature of permissions_ca.cert.pem (CN=sros2CA)",
        words: "sign it again",
        ..NONE
    },
    Fault {
        what: "permissions for another name",
        spoil: |keystore, enclave| permit(keystore, enclave, &everything("/another")),
        line: "permissions.p7s has no grant for the subject of cert.pem",
        words: "expected `CN=/column_twin`, found `CN=/another`",
        ..NONE
    },
    Fault {
        what: "expired permissions",
        spoil: |keystore, enclave| {
            let days = -30..-1;
            let permissions = Permissions {
                days,
                ..everything(NAME)
            };
            permit(keystore, enclave, &permissions);
        },
        line: "permissions.p7s is valid from",
        words: "sign it again with new dates",
        ..NONE
    },
    Fault {
        what: "a governance that was changed after it was signed",
        spoil: |_, enclave| {
            let text = String::from_utf8(enclave.governance.clone()).unwrap();
            let changed =
                text.replace("<rtps_protection_kind>SIGN<", "<rtps_protection_kind>NONE<");
            assert_ne!(text, changed);
            enclave.governance = changed.into_bytes();
        },
        line: "governance.p7s does not carry a valid signature of permissions_ca.cert.pem (CN=sros2CA)",
        words: "do not edit signed documents",
        ..NONE
    },
    Fault {
        what: "a key that others can read, where the keystore forbids it",
        spoil_files: |folder| {
            let open = fs::Permissions::from_mode(0o644);
            fs::set_permissions(folder.join("key.pem"), open).unwrap();
            let keystore = folder.parent().and_then(Path::parent).unwrap();
            fs::write(keystore.join(STRICT_FILES), "").unwrap();
        },
        line: "",
        words: "can be read by other users of this machine (mode 644)",
        ..NONE
    },
];

/// Exactly one fault is reported, as the fault that it is, and with the exit code of bad input.
#[test]
fn every_broken_enclave_keeps_the_node_from_starting_and_is_described() {
    let domain = Domain::fresh();
    for fault in &FAULTS {
        let keystore = Keystore::new();
        let mut enclave = keystore.unrestricted(NAME, &RECOMMENDED);
        (fault.spoil)(&keystore, &mut enclave);
        (fault.spoil_files)(&keystore.write(&enclave));
        let variables = [
            ("ROS_SECURITY_ENABLE", "true"),
            ("ROS_SECURITY_STRATEGY", "Enforce"),
            ("ROS_SECURITY_KEYSTORE", keystore.path().to_str().unwrap()),
        ];
        let log = rejected(&domain, &variables, &["--enclave", NAME]);
        let what = fault.what;
        assert!(
            log.contains("SECURITY ERROR: the enclave in"),
            "{what}: {log}"
        );
        // A bar stands before each line of an error.
        let lines = log.lines().map(|it| it.trim_start_matches([' ', '│']));
        let described: Vec<_> = lines.filter_map(|it| it.strip_prefix("- ")).collect();
        let [described] = described[..] else {
            panic!("{what}: expected one fault: {log}");
        };
        assert!(described.starts_with(fault.line), "{what}: {log}");
        assert!(described.contains(fault.words), "{what}: {log}");
    }
}
