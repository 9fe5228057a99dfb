//! An enclave: the six files of a participant, checked before it starts.

use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use bounded_file::read_at_most;
use jiff::Timestamp;

use super::certificates::{Certificate, private_key};
use super::dates::{is_near, remaining};
use super::documents::signed_text;
use super::fault::{
    Action, ENCLAVE_FILES, EnclaveFault, EnclaveFile, MAX_ENCLAVE_FILE_BYTES, STRICT_FILES,
};
use super::governance::{Governance, ProtectionKinds};
use super::permissions::Grant;

/// Topics without which no node of ros2-client starts.
const NEEDED: [(Action, &str); 3] = [
    (Action::Publish, "ros_discovery_info"),
    (Action::Subscribe, "ros_discovery_info"),
    (Action::Publish, "rt/parameter_events"),
];

/// The enclave of a participant; all checks have passed.
#[derive(Debug)]
pub struct Enclave {
    /// Its name, such as `/talker`.
    pub name: String,
    /// Where its files are.
    pub directory: PathBuf,
    /// The subject of its certificate, such as `CN=/talker`.
    pub subject: String,
    /// Until when its certificates and its permissions are valid, in the order in which they end, with the name of the file.
    pub ends: Vec<(EnclaveFile, Timestamp)>,
    /// How the governance document protects the domain.
    pub kinds: ProtectionKinds,
    /// What is wrong with the permissions of its private key, and what to do.
    pub exposed_key: Option<String>,
    /// Weak points that do not prevent the start.
    weak_points: Vec<String>,
}

/// Why an enclave cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum EnclaveError {
    /// Its directory does not exist.
    #[error(
        "SECURITY ERROR: directory '{}' does not exist. Choose an enclave of the keystore with --ros-args --enclave or \
         ROS_SECURITY_ENCLAVE_OVERRIDE, or create this one",
        .0.display()
    )]
    NoDirectory(PathBuf),
    /// Its directory contains no files of an enclave.
    #[error(
        "SECURITY ERROR: directory '{}' contains none of the files of an enclave (cert.pem, key.pem and others). Choose an \
         enclave of the keystore with --ros-args --enclave or ROS_SECURITY_ENCLAVE_OVERRIDE, or create this one",
        .0.display()
    )]
    NoFiles(PathBuf),
    /// It exists, but has faults.
    #[error("SECURITY ERROR: the enclave in '{}' cannot be used:{}", .directory.display(), listed(.faults))]
    Broken {
        /// Its directory.
        directory: PathBuf,
        /// All faults that were found; not empty.
        faults: Vec<EnclaveFault>,
    },
}

fn listed(faults: &[EnclaveFault]) -> String {
    faults.iter().map(|fault| format!("\n- {fault}")).collect()
}

impl Enclave {
    /// Reads and checks the files for a participant in this domain at this time.
    ///
    /// # Errors
    /// The directory or all files are missing ([`EnclaveError::NoDirectory`], [`EnclaveError::NoFiles`]), or the files
    /// cannot be used ([`EnclaveError::Broken`], with all faults).
    pub fn load(
        name: &str,
        directory: &Path,
        domain_id: u16,
        now: Timestamp,
    ) -> Result<Self, EnclaveError> {
        if !directory.is_dir() {
            return Err(EnclaveError::NoDirectory(directory.to_owned()));
        }
        let is_present = |(file, name): &(EnclaveFile, &str)| {
            // The folder above all enclaves, which a program without `--enclave` names, has a governance and nothing else. A
            // dangling link is a file that cannot be read, not a missing enclave.
            *file != EnclaveFile::Governance && directory.join(name).symlink_metadata().is_ok()
        };
        if !ENCLAVE_FILES.iter().any(is_present) {
            return Err(EnclaveError::NoFiles(directory.to_owned()));
        }
        let mut faults = Vec::new();
        let checked = Self::check(directory, domain_id, now, &mut faults);
        match checked {
            Some(checked) if faults.is_empty() => Ok(Self {
                name: name.to_owned(),
                directory: directory.to_owned(),
                ..checked
            }),
            _ => Err(EnclaveError::Broken {
                directory: directory.to_owned(),
                faults,
            }),
        }
    }

    /// Without name and directory. `None` only with faults.
    fn check(
        directory: &Path,
        domain_id: u16,
        now: Timestamp,
        faults: &mut Vec<EnclaveFault>,
    ) -> Option<Self> {
        let mut contents = ENCLAVE_FILES.map(|(file, _)| {
            let read = read(directory, file);
            read.map_err(|fault| faults.push(fault)).ok()
        });
        let [
            identity_ca,
            certificate,
            key,
            permissions_ca,
            governance,
            permissions,
        ] = contents.each_mut().map(Option::take);
        let mut certificate_of = |file, pem: Option<Vec<u8>>| {
            let read = Certificate::read(file, &pem?);
            let certificate = read.map_err(|fault| faults.push(fault)).ok()?;
            certificate.check(now, faults);
            Some(certificate)
        };
        let identity_ca = certificate_of(EnclaveFile::IdentityCa, identity_ca);
        let certificate = certificate_of(EnclaveFile::Certificate, certificate);
        let permissions_ca = certificate_of(EnclaveFile::PermissionsCa, permissions_ca);
        if let (Some(certificate), Some(authority)) = (&certificate, &identity_ca) {
            certificate.check_issued_by(authority, faults);
        }
        match key.map(|pem| private_key(&pem)) {
            Some(Ok(key)) => {
                if let Some(certificate) = &certificate {
                    certificate.check_key(&key, faults);
                }
            }
            Some(Err(fault)) => faults.push(fault),
            None => {}
        }
        let mut text_of = |file, smime: Option<Vec<u8>>| {
            let text = signed_text(file, &smime?, permissions_ca.as_ref()?);
            text.map_err(|fault| faults.push(fault)).ok()
        };
        let governance = text_of(EnclaveFile::Governance, governance);
        let permissions = text_of(EnclaveFile::Permissions, permissions);
        let governance = governance.and_then(|text| Governance::read(&text, domain_id, faults));
        let grant = permissions.zip(certificate.as_ref());
        let grant = grant.and_then(|(text, it)| Grant::read(&text, &it.subject, now, faults));
        if let (Some(grant), Some(governance)) = (&grant, &governance) {
            check_needed(grant, governance, domain_id, faults);
        }
        let (governance, grant) = (governance?, grant?);
        let certificates = [identity_ca?, certificate?, permissions_ca?];
        let mut ends: Vec<_> = certificates
            .iter()
            .map(|it| (it.file, it.not_after))
            .collect();
        let exposed_key = exposed_key(directory);
        if is_strict(directory) {
            faults.extend(exposed_key.clone().map(EnclaveFault::ExposedKey));
        }
        ends.push((EnclaveFile::Permissions, grant.not_after));
        ends.sort_by_key(|(_, until)| *until);
        let [_, certificate, _] = certificates;
        Some(Self {
            name: String::new(),
            directory: PathBuf::new(),
            subject: certificate.subject,
            ends,
            exposed_key: exposed_key.filter(|_| !is_strict(directory)),
            weak_points: weak_points(&governance),
            kinds: governance.kinds,
        })
    }

    /// One line for the log.
    #[must_use]
    pub fn summary(&self) -> String {
        let (first, until) = self.first_end();
        format!(
            "DDS security: enclave {} ({}) of {}; {}; {first} expires first, on {until}",
            self.name,
            self.subject,
            self.directory.display(),
            self.kinds
        )
    }

    /// What ends first, and when.
    #[must_use]
    pub fn first_end(&self) -> (EnclaveFile, Timestamp) {
        let first = self.ends.first();
        first.map_or((EnclaveFile::Certificate, Timestamp::MAX), |it| *it)
    }

    /// What an operator must know, at this time.
    #[must_use]
    pub fn warnings(&self, now: Timestamp) -> Vec<String> {
        let near = self.ends.iter().filter(|(_, until)| is_near(*until, now));
        let near = near.map(|(file, until)| expiry(*file, *until, now));
        let weak_points = self.exposed_key.iter().chain(&self.weak_points);
        near.chain(weak_points.cloned()).collect()
    }

    /// What has expired, and what will within [`EXPIRY_NOTICE`](crate::EXPIRY_NOTICE), in words.
    #[must_use]
    pub fn near_ends(&self, now: Timestamp) -> (Vec<String>, Vec<String>) {
        let near = self.ends.iter().filter(|(_, until)| is_near(*until, now));
        let (over, coming): (Vec<_>, Vec<_>) = near.partition(|(_, until)| *until < now);
        let in_words = |ends: Vec<&(EnclaveFile, Timestamp)>| {
            let ends = ends.into_iter();
            ends.map(|(file, until)| expiry(*file, *until, now))
                .collect()
        };
        (in_words(over), in_words(coming))
    }
}

fn expiry(file: EnclaveFile, until: Timestamp, now: Timestamp) -> String {
    if until < now {
        format!(
            "{file} of the enclave expired on {until}; peers reject this node when it connects again"
        )
    } else {
        let remaining = remaining(until, now);
        format!("{file} of the enclave expires {remaining}, on {until}; renew it before then")
    }
}

/// The file's content, with a bound.
fn read(directory: &Path, file: EnclaveFile) -> Result<Vec<u8>, EnclaveFault> {
    let path = directory.join(file.name());
    let unreadable = |reason: String| EnclaveFault::Unreadable { file, reason };
    read_at_most(&path, MAX_ENCLAVE_FILE_BYTES).map_err(|error| {
        match (error.kind(), path.read_link()) {
            (io::ErrorKind::NotFound, Ok(target)) => unreadable(format!(
                "it is a link to {}, which does not exist",
                target.display()
            )),
            (io::ErrorKind::NotFound, Err(_)) => EnclaveFault::Missing(file),
            _ => unreadable(error.to_string()),
        }
    })
}

/// What every node needs, unless the governance document leaves the topic open.
fn check_needed(
    grant: &Grant,
    governance: &Governance,
    domain_id: u16,
    faults: &mut Vec<EnclaveFault>,
) {
    let missing: Vec<_> = NEEDED
        .iter()
        .filter(|(action, topic)| {
            let is_protected = match action {
                Action::Publish => governance.protects_writing(topic),
                Action::Subscribe => governance.protects_reading(topic),
            };
            is_protected && !grant.permits(*action, domain_id, topic)
        })
        .collect();
    if missing.is_empty() {
        return;
    }
    if grant.is_for(domain_id) {
        faults.extend(
            missing
                .iter()
                .map(|(action, topic)| EnclaveFault::NotPermitted {
                    action: *action,
                    topic,
                    domain_id,
                }),
        );
    } else {
        faults.push(EnclaveFault::Domain {
            file: EnclaveFile::Permissions,
            domain_id,
            found: grant.domains(),
        });
    }
}

/// What is wrong with the permissions of the private key. A keystore of SROS 2 has mode 0644, and must work unchanged.
fn exposed_key(directory: &Path) -> Option<String> {
    let key = directory.join(EnclaveFile::Key.name());
    let mode = key.metadata().ok()?.permissions().mode() & 0o777;
    (mode & 0o077 != 0).then(|| {
        let key = key.display();
        format!(
            "{key} can be read by other users of this machine (mode {mode:03o}), who can then speak in the name of this node; \
             restrict it with: chmod 600 {key}"
        )
    })
}

/// Whether the keystore with this folder of an enclave has the file that forbids private keys that others can read.
fn is_strict(directory: &Path) -> bool {
    let enclaves = directory.ancestors().find(|it| it.ends_with("enclaves"));
    let keystore = enclaves.and_then(Path::parent);
    keystore.is_some_and(|it| it.join(STRICT_FILES).exists())
}

fn weak_points(governance: &Governance) -> Vec<String> {
    let mut weak = Vec::new();
    if governance.allows_unauthenticated {
        weak.push(
            "governance.p7s admits peers without a certificate (allow_unauthenticated_participants)"
                .to_owned(),
        );
    }
    let open = governance.open_topics();
    if !open.is_empty() {
        weak.push(format!(
            "governance.p7s leaves the topics {} open to every peer that it admits (enable_read_access_control, \
             enable_write_access_control)",
            open.join(", ")
        ));
    }
    let kinds = &governance.kinds;
    if kinds.rtps == "NONE"
        && kinds
            .metadata
            .iter()
            .zip(&kinds.data)
            .any(|(it, data)| it == "NONE" && data == "NONE")
    {
        weak.push(
            "governance.p7s leaves data unprotected: rtps, metadata and data protection are NONE"
                .to_owned(),
        );
    }
    if kinds.data.iter().any(|it| it == "ENCRYPT") {
        weak.push(
            "governance.p7s has data_protection_kind ENCRYPT, with which RustDDS loses messages of more than 64 kB; with \
             metadata_protection_kind ENCRYPT and data_protection_kind NONE, everything is encrypted too, and they arrive"
                .to_owned(),
        );
    }
    weak
}
