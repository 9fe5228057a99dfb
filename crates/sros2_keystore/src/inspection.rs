//! What a keystore holds, and what is wrong with it.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use jiff::Timestamp;
use openssl::pkcs7::Pkcs7;
use openssl::x509::X509;
use roxmltree::Document;

use crate::checks::{Enclave, EnclaveError, EnclaveFile, domains_of, of_certificate};
use crate::documents::date;
use crate::domain_ranges::DomainRanges;
use crate::enclave_name::EnclaveName;
use crate::error::{KeystoreError, Remedy};
use crate::layout::{
    CERTIFICATE, ENCLAVES, GOVERNANCE, GOVERNANCE_XML, IDENTITY_CA, IDENTITY_CA_KEY, PERMISSIONS,
    PERMISSIONS_CA, PERMISSIONS_CA_KEY, PERMISSIONS_XML, PRIVATE, PUBLIC, enclave_folder,
};
use crate::reading::{read, read_certificate, read_text};

/// A keystore for people.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeystoreSummary {
    /// Domains of the governance.
    pub domains: DomainRanges,
    /// The domain that the enclaves were checked for.
    pub checked_domain: u16,
    /// Until when the authority's certificate is valid; several, if identities and permissions have authorities of their own.
    pub authorities: Vec<String>,
    /// Whether the authority's key is here, so that enclaves can be added and renewed.
    pub can_sign: bool,
    /// The enclaves by name.
    pub enclaves: Vec<EnclaveSummary>,
    /// What is wrong with the keystore itself, and should be changed.
    pub warnings: Vec<Warning>,
}

/// An enclave for people.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EnclaveSummary {
    /// Its name.
    pub name: EnclaveName,
    /// Whose certificate it is and how long it is valid, or why it cannot be used.
    pub state: Result<UsableEnclave, Vec<String>>,
    /// DDS topics that may be published.
    pub publish: BTreeSet<String>,
    /// DDS topics that may be subscribed to.
    pub subscribe: BTreeSet<String>,
    /// What should be changed.
    pub warnings: Vec<Warning>,
}

/// What should be changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// For people.
    pub text: String,
    /// What settles it, where a function of this crate does.
    pub remedy: Option<Remedy>,
}

impl From<String> for Warning {
    fn from(text: String) -> Self {
        Self { text, remedy: None }
    }
}

/// An enclave without faults.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UsableEnclave {
    /// Subject of the certificate.
    pub subject: String,
    /// How the governance protects the domain.
    pub protection: String,
    /// What expires first, and when.
    pub first_end: (EnclaveFile, Timestamp),
}

impl KeystoreSummary {
    /// Whether every enclave can be used.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        self.enclaves.iter().all(|enclave| enclave.state.is_ok())
    }
}

/// Reads a keystore and checks every enclave as a node does at its start, in this domain; without one, in the first domain of the
/// governance.
///
/// # Errors
/// The folder is no keystore, or cannot be read.
pub fn inspect(
    folder: &Path,
    domain: Option<u16>,
    now: Timestamp,
) -> Result<KeystoreSummary, KeystoreError> {
    let mut authorities = Vec::new();
    for (name, what) in [(IDENTITY_CA, "identities"), (PERMISSIONS_CA, "permissions")] {
        let path = folder.join(PUBLIC).join(name);
        if !path.is_file() {
            return Err(KeystoreError::NotAKeystore {
                path: folder.to_path_buf(),
                missing: format!("{PUBLIC}/{name}"),
            });
        }
        authorities.push((what, read_certificate(&path)?));
    }
    let domains = governance_domains(folder)?;
    let checked_domain = match domain {
        Some(domain) => domain,
        None => domains.ranges().first().map_or(0, |range| *range.start()),
    };
    let keys = [IDENTITY_CA_KEY, PERMISSIONS_CA_KEY].map(|key| folder.join(PRIVATE).join(key));
    let mut warnings = Vec::new();
    let enclaves = folder.join(ENCLAVES);
    warnings.extend(unsigned_change(
        &enclaves.join(GOVERNANCE_XML),
        &enclaves.join(GOVERNANCE),
        "renew the authority",
        Remedy::RenewAuthority,
    ));
    let mut loose: Vec<_> = keys.iter().filter_map(|key| loose_key(key)).collect();
    loose.dedup();
    warnings.extend(loose.into_iter().map(Warning::from));
    Ok(KeystoreSummary {
        domains,
        checked_domain,
        authorities: in_words(&authorities)?,
        can_sign: keys.iter().all(|key| key.is_file()),
        enclaves: enclaves_of(folder)?
            .into_iter()
            .map(|name| inspect_enclave(folder, name, checked_domain, now))
            .collect(),
        warnings,
    })
}

fn inspect_enclave(
    keystore: &Path,
    name: EnclaveName,
    domain: u16,
    now: Timestamp,
) -> EnclaveSummary {
    let folder = enclave_folder(keystore, &name);
    let (publish, subscribe) = allowed_topics(&folder.join(PERMISSIONS));
    let mut warnings = Vec::new();
    let state = match Enclave::load(name.as_str(), &folder, domain, now) {
        Ok(enclave) => {
            warnings.extend(enclave.warnings(now).into_iter().map(Warning::from));
            Ok(UsableEnclave {
                subject: enclave.subject.clone(),
                protection: enclave.kinds.to_string(),
                first_end: enclave.first_end(),
            })
        }
        Err(EnclaveError::Broken { faults, .. }) => {
            Err(faults.iter().map(ToString::to_string).collect())
        }
        Err(error) => Err(vec![error.to_string()]),
    };
    warnings.extend(unsigned_change(
        &folder.join(PERMISSIONS_XML),
        &folder.join(PERMISSIONS),
        "renew the enclave",
        Remedy::Renew(name.to_string()),
    ));
    EnclaveSummary {
        name,
        state,
        publish,
        subscribe,
        warnings,
    }
}

/// The names of all enclaves, in order: every folder below `enclaves/` with a certificate.
pub(super) fn enclaves_of(keystore: &Path) -> Result<Vec<EnclaveName>, KeystoreError> {
    let root = keystore.join(ENCLAVES);
    let mut names = Vec::new();
    let mut open: Vec<(PathBuf, String)> = vec![(root, String::new())];
    while let Some((folder, name)) = open.pop() {
        let failed = |error| KeystoreError::io("list the folder", &folder)(error);
        for entry in fs::read_dir(&folder).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let path = entry.path();
            // Folders only, not links to folders: a link could lead in a circle.
            if entry.file_type().map_err(failed)?.is_dir()
                && let Ok(part) = entry.file_name().into_string()
            {
                let name = format!("{name}/{part}");
                if path.join(CERTIFICATE).exists()
                    && let Ok(name) = EnclaveName::new(&name)
                {
                    names.push(name);
                }
                open.push((path, name));
            }
        }
    }
    names.sort();
    Ok(names)
}

/// The domains of the governance.
pub(super) fn governance_domains(keystore: &Path) -> Result<DomainRanges, KeystoreError> {
    let path = keystore.join(ENCLAVES).join(GOVERNANCE);
    let text = signed_text(&path)?;
    let wrong = |reason: String| KeystoreError::document(&path, reason);
    let document = Document::parse(&text).map_err(|error| wrong(error.to_string()))?;
    let nodes = document.descendants();
    let rules = nodes.filter(|node| node.has_tag_name("domain_rule"));
    let domains: Result<Vec<_>, String> = rules.map(domains_of).collect();
    let domains = domains.map_err(wrong)?;
    let ranges = domains.iter().flat_map(DomainRanges::ranges);
    match ranges.cloned().collect::<Vec<_>>() {
        none if none.is_empty() => Err(KeystoreError::document(
            &path,
            "expected the domains of the governance, found none",
        )),
        ranges => Ok(ranges.into_iter().collect()),
    }
}

/// The text of a signed document as it is, also if the signature is wrong: the checks of the enclave tell that.
fn signed_text(path: &Path) -> Result<String, KeystoreError> {
    let (_, text) = Pkcs7::from_smime(&read(path)?)
        .map_err(|_| KeystoreError::document(path, "expected a document signed as S/MIME"))?;
    let text = String::from_utf8(text.unwrap_or_default());
    let text = text.map_err(|_| KeystoreError::document(path, "expected UTF-8 text"))?;
    // The document follows the header of a part of a mail.
    let start = text.find('<').unwrap_or_default();
    Ok(text[start..].replace("\r\n", "\n"))
}

/// The topics of all rules that allow.
fn allowed_topics(permissions: &Path) -> (BTreeSet<String>, BTreeSet<String>) {
    let mut topics = (BTreeSet::new(), BTreeSet::new());
    // A document that cannot be read allows nothing; the checks of the enclave tell why.
    let Ok(text) = signed_text(permissions) else {
        return topics;
    };
    let Ok(document) = Document::parse(&text) else {
        return topics;
    };
    for topic in document.descendants().filter(|it| it.has_tag_name("topic")) {
        let is_in = |tag| topic.ancestors().any(|it| it.has_tag_name(tag));
        let name = topic.text().unwrap_or_default().trim().to_owned();
        match (is_in("allow_rule"), is_in("publish"), is_in("subscribe")) {
            (true, true, false) => topics.0.insert(name),
            (true, false, true) => topics.1.insert(name),
            _ => false,
        };
    }
    topics
}

/// A warning if a document was edited after it was signed: the edit has no effect.
fn unsigned_change(
    document: &Path,
    signed: &Path,
    advice: &str,
    remedy: Remedy,
) -> Option<Warning> {
    let text = read_text(document).ok()?;
    let signed_text = signed_text(signed).ok()?;
    let start = text.find('<').unwrap_or_default();
    (text[start..].trim() != signed_text.trim()).then(|| Warning {
        text: format!(
            "{} differs from {}, and only the signed text counts; to sign it, {advice}",
            document.display(),
            signed.display()
        ),
        remedy: Some(remedy),
    })
}

/// A warning if others may read a key.
fn loose_key(path: &Path) -> Option<String> {
    let path = fs::canonicalize(path).ok()?;
    let mode = path.metadata().ok()?.permissions().mode();
    (mode & 0o077 != 0).then(|| {
        format!(
            "{path} can be read by other users of this machine (mode {:03o}), who can then make enclaves of their own; \
             restrict it with: chmod 600 {path}",
            mode & 0o777,
            path = path.display()
        )
    })
}

fn in_words(authorities: &[(&str, X509)]) -> Result<Vec<String>, KeystoreError> {
    let mut words = Vec::new();
    for (what, certificate) in authorities {
        let end = of_certificate(certificate.not_after())
            .map_err(KeystoreError::openssl("read the expiry of the authority"))?;
        let is_one = authorities[0].1 == *certificate && authorities[1].1 == *certificate;
        let what = if is_one {
            "identities and permissions"
        } else {
            what
        };
        let line = format!("{what} until {}", date(end.as_second()));
        if !words.contains(&line) {
            words.push(line);
        }
    }
    Ok(words)
}
