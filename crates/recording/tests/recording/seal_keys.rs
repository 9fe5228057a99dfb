//! The files of keys, as OpenSSL writes them, and what else a user may give.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use rosbag2_mcap::{
    PublicKey, Recorder, RecorderOptions, RecorderReport, RecordingError, ReportLevel, SealKey,
};
use tempfile::TempDir;

use super::recorder::Reports;
use super::sample::text_topics;

/// `openssl genpkey -algorithm ed25519`
const PRIVATE: &str = "\
-----BEGIN PRIVATE KEY-----
MC4CAQAwBQYDK2VwBCIEIGrJEbjRgeB96JKCHzdL3tOtD6suGiIer9pIoWzHeQC5
-----END PRIVATE KEY-----
";

/// `openssl pkey -in PRIVATE -pubout`
const PUBLIC: &str = "\
-----BEGIN PUBLIC KEY-----
MCowBQYDK2VwAyEAaL8BJg+JDVh2Qksm9wGR+cw5CAeDIPTSw/D76BdktnE=
-----END PUBLIC KEY-----
";

/// The last 32 bytes of `openssl pkey -in PRIVATE -pubout -outform DER`
const DIGITS: &str = "68bf01260f890d5876424b26f70191f9cc3908078320f4d2c3f0fbe81764b671";

/// `openssl genpkey -algorithm ec -pkeyopt ec_paramgen_curve:P-256`
const OTHER_KIND: &str = "\
-----BEGIN PRIVATE KEY-----
MIGHAgEAMBMGByqGSM49AgEGCCqGSM49AwEHBG0wawIBAQQgMP9hFFpeNuu/H5OF
E7Qdw6cJ0LpfrdNBuqTKKTl0YQShRANCAAS7pUGOohgKiWVAm17NzFuSEbaCo1Uq
ankp/j7qyN55PhPJO8FXfD4zqzogDMdU6216pDvQDdn9UwCQleo7UfBr
-----END PRIVATE KEY-----
";

struct Files(TempDir);

impl Files {
    fn file(&self, content: &str) -> PathBuf {
        let path = self.0.path().join("key.pem");
        fs::write(&path, content).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
        path
    }
}

fn files() -> Files {
    Files(TempDir::new().unwrap())
}

#[test]
fn keys_of_openssl_are_read() {
    let files = files();
    let path = files.file(PRIVATE);
    let key = SealKey::read(&path).unwrap();
    assert_eq!(key.public_key().to_string(), DIGITS);
    assert_eq!(
        (key.is_fresh(), key.path(), key.warning()),
        (false, Some(&*path), None)
    );
    assert!(
        !format!("{key:?}").contains("6ac911b8"),
        "the private key is not shown"
    );
    for public in [PUBLIC, DIGITS, &format!("  {}\n", DIGITS.to_uppercase())] {
        let read = PublicKey::read(&files.file(public)).unwrap();
        assert_eq!(read, key.public_key());
    }
    assert_eq!(DIGITS.parse(), Ok(key.public_key()));
}

#[test]
fn fresh_keys_differ() {
    let [first, second] = [(); 2].map(|()| SealKey::fresh().unwrap());
    assert!(first != second && first.public_key() != second.public_key());
    assert!(first.is_fresh() && first.path().is_none());
}

fn reason(error: RecordingError) -> String {
    assert!(matches!(error, RecordingError::BadKey { .. }), "{error:?}");
    assert!(error.is_bad_input());
    error.to_string()
}

#[test]
fn a_file_that_is_no_private_key_is_rejected_with_what_to_do() {
    let files = files();
    let rejected = |path: &Path| reason(SealKey::read(path).unwrap_err());
    for (content, found) in [
        (
            PUBLIC,
            "found a public key; give the file of the private key",
        ),
        (OTHER_KIND, "of another kind"),
        (
            &PRIVATE.replace("MC4C", "MC5C"),
            "or a damaged one; make a key with: openssl genpkey",
        ),
        (
            &PRIVATE.replace("PRIVATE", "ENCRYPTED PRIVATE"),
            "decrypt it with: openssl pkey",
        ),
        (
            &PRIVATE.replace("PRIVATE", "OPENSSH PRIVATE"),
            "found \"OPENSSH PRIVATE KEY\"",
        ),
        ("", "found no text in PEM"),
        (DIGITS, "found no text in PEM"),
        ("\u{0}\u{fffd}", "found no text in PEM"),
    ] {
        let path = files.file(content);
        let reason = rejected(&path);
        assert!(reason.contains(found), "{reason}");
        assert!(reason.contains(&path.display().to_string()), "{reason}");
    }
    let missing = rejected(Path::new("nothing/key.pem"));
    assert!(
        missing.contains("does not exist; make a key with"),
        "{missing}"
    );
    let folder = rejected(files.0.path());
    assert!(folder.contains("directory"), "{folder}");
    let large = rejected(&files.file(&"x".repeat(100_000)));
    assert!(
        large.contains("expected the file of a key") && large.contains("larger than 65536 bytes"),
        "{large}"
    );
}

#[test]
fn a_file_that_is_no_public_key_is_rejected_with_what_to_do() {
    let files = files();
    for (content, found) in [
        (
            PRIVATE,
            "found a private key, which should stay where the recordings are made",
        ),
        (
            &PUBLIC.replace("PUBLIC", "RSA PUBLIC"),
            "found \"RSA PUBLIC KEY\"",
        ),
        (&PUBLIC.replace("MCow", "MCox"), "or a damaged one"),
        (&DIGITS[1..], "found neither"),
        ("", "found neither"),
    ] {
        let reason = reason(PublicKey::read(&files.file(content)).unwrap_err());
        assert!(reason.contains(found), "{reason}");
    }
}

#[test]
fn a_key_that_others_can_read_is_used_with_a_warning() {
    let files = files();
    let path = files.file(PRIVATE);
    for (mode, warned) in [
        (0o644, true),
        (0o640, false),
        (0o604, true),
        (0o611, false),
        (0o400, false),
    ] {
        fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        let key = SealKey::read(&path).unwrap();
        assert_eq!(key.warning().is_some(), warned, "{mode:o}");
        if let Some(warning) = key.warning() {
            assert!(warning.contains("chmod 600"), "{warning}");
        }
    }
}

/// A fresh key is worth something only to those who know its public part.
#[test]
fn the_key_is_reported_at_the_start() {
    let files = files();
    let path = files.file(PRIVATE);
    fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).unwrap();
    let given = SealKey::read(&path).unwrap();
    for (key, warnings) in [(SealKey::fresh().unwrap(), 0), (given, 1)] {
        let mut options = RecorderOptions::new(files.0.path(), std::time::SystemTime::now());
        options.seal = Some(key.clone());
        let reports = Reports::default();
        reports.listen(&mut options);
        assert_eq!(
            Recorder::start(options, text_topics()).unwrap().stop().lost,
            0
        );
        let all = reports.all();
        assert_eq!(all.len(), 1 + warnings, "{all:?}");
        assert!(
            matches!(&all[0], RecorderReport::Sealing { key: it, .. } if *it == key.public_key())
        );
        assert_eq!(all[0].level(), ReportLevel::Info);
        let line = all[0].to_string();
        assert!(line.contains(&key.public_key().to_string()), "{line}");
        assert_eq!(
            line.contains("made for this run only"),
            key.is_fresh(),
            "{line}"
        );
        if let Some(warning) = all.get(1) {
            assert_eq!(warning.level(), ReportLevel::Warning);
            assert!(warning.to_string().contains("chmod 600"), "{warning}");
        }
    }
}
