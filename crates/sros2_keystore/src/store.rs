//! Making, extending and renewing a keystore on disk.

use std::collections::BTreeMap;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};

use openssl::pkey::{HasPublic, PKey, PKeyRef};
use openssl::x509::X509;

use crate::access::EnclavePlan;
use crate::certificates::{Authority, new_key};
use crate::checks::{STRICT_FILES, of_certificate};
use crate::documents::{
    DataProtection, Validity, date, governance_xml, permissions_xml, with_validity,
};
use crate::domain_ranges::DomainRanges;
use crate::enclave_name::EnclaveName;
use crate::error::KeystoreError;
use crate::inspection::{enclaves_of, governance_domains};
use crate::layout::{
    CA_CERTIFICATE, CA_KEY, CERTIFICATE, ENCLAVES, FOLDER_CONTENT, GOVERNANCE, GOVERNANCE_XML,
    IDENTITY_CA, IDENTITY_CA_KEY, KEY, PERMISSIONS, PERMISSIONS_CA, PERMISSIONS_CA_KEY,
    PERMISSIONS_XML, PRIVATE, PUBLIC, enclave_folder, links,
};
use crate::reading::{read, read_certificate, read_text};

/// Days for which the certificate and the permissions of an enclave are valid, unless told otherwise. One year: a key that
/// was copied becomes useless by itself, and renewing once a year is little work.
pub const ENCLAVE_DAYS: u32 = 365;

/// Days for which the authority's certificate is valid, unless an enclave needs more: ten years, as in SROS 2.
pub const AUTHORITY_DAYS: u32 = 3650;

/// Most days that anything can be valid: a century, so that no date leaves the range of the certificates' format.
pub const MAX_DAYS: u32 = 36_500;

/// Certificates are valid from one day before they are made, as in SROS 2, so that a clock that is behind accepts them.
const BACKDATED_SECS: i64 = 86_400;

/// Mode of files that only their owner may read.
const SECRET_FILE: u32 = 0o600;

/// Mode of folders that only their owner may enter.
const SECRET_FOLDER: u32 = 0o700;

/// Mode of files and folders for everyone, before the umask.
const OPEN_FILE: u32 = 0o644;
const OPEN_FOLDER: u32 = 0o755;

/// A keystore to be made.
#[derive(Debug, Clone)]
pub struct Creation<'a> {
    /// Its folder, which does not exist or is empty.
    pub folder: &'a Path,
    /// Common name of its authority, such as `sros2CA`.
    pub authority: &'a str,
    /// Its enclaves.
    pub enclaves: &'a [EnclavePlan],
    /// The domains of governance and permissions.
    pub domains: &'a DomainRanges,
    /// How payloads are protected.
    pub data: DataProtection,
    /// Validity of the enclaves \[days\].
    pub days: u32,
    /// The time \[s since 1970\].
    pub now: i64,
}

/// An enclave to be added.
#[derive(Debug, Clone)]
pub struct Addition<'a> {
    /// Folder of the keystore.
    pub folder: &'a Path,
    /// The enclave.
    pub enclave: &'a EnclavePlan,
    /// The domains of its permissions; `None`: those of the governance.
    pub domains: Option<&'a DomainRanges>,
    /// Its validity \[days\].
    pub days: u32,
    /// The time \[s since 1970\].
    pub now: i64,
}

/// Certificates and permissions to be renewed. Keys stay as they are.
#[derive(Debug, Clone)]
pub struct Renewal<'a> {
    /// Folder of the keystore.
    pub folder: &'a Path,
    /// The enclaves; empty: all.
    pub enclaves: &'a [EnclaveName],
    /// Whether the authority's certificate is renewed, too, and with it everything that it has signed.
    pub authority: bool,
    /// The new validity of the enclaves \[days\].
    pub days: u32,
    /// The time \[s since 1970\].
    pub now: i64,
}

/// What the file says to a person.
const STRICT_FILES_TEXT: &[u8] =
    b"Enclaves of this keystore with a private key that other users can read are rejected.\n\
    Remove this file to have a warning instead.\n";

/// Makes a keystore. Its folder appears complete or not at all.
///
/// # Errors
/// The folder is in use, or it cannot be written.
pub fn create(creation: &Creation<'_>) -> Result<(), KeystoreError> {
    let folder = creation.folder;
    let validity = validity(creation.days, creation.now)?;
    let in_use = match fs::read_dir(folder) {
        Ok(mut entries) => entries.next().is_some(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => false,
        Err(error) => return Err(KeystoreError::io("open the folder", folder)(error)),
    };
    if in_use {
        return Err(KeystoreError::Occupied(folder.to_path_buf()));
    }
    let authority_days = AUTHORITY_DAYS.max(creation.days);
    let authority = Authority::new(
        creation.authority,
        self::validity(authority_days, creation.now)?,
    )
    .map_err(KeystoreError::openssl("make the authority"))?;
    let staged = Staged::beside(folder)?;
    let at = |path: &str| staged.path().join(path);
    for (name, mode) in [
        (PUBLIC, OPEN_FOLDER),
        (PRIVATE, SECRET_FOLDER),
        (ENCLAVES, OPEN_FOLDER),
    ] {
        new_folder(&at(name), mode)?;
    }
    let public = at(PUBLIC);
    let private = at(PRIVATE);
    new_file(&public.join(CA_CERTIFICATE), &pem(&authority.certificate)?)?;
    new_secret(&private.join(CA_KEY), &key_pem(&authority.key)?)?;
    for (link, to) in [
        (public.join(IDENTITY_CA), CA_CERTIFICATE),
        (public.join(PERMISSIONS_CA), CA_CERTIFICATE),
        (private.join(IDENTITY_CA_KEY), CA_KEY),
        (private.join(PERMISSIONS_CA_KEY), CA_KEY),
    ] {
        new_link(&link, Path::new(to))?;
    }
    new_file(&at(STRICT_FILES), STRICT_FILES_TEXT)?;
    let governance = governance_xml(creation.domains, creation.data);
    let enclaves = at(ENCLAVES);
    new_file(&enclaves.join(GOVERNANCE_XML), governance.as_bytes())?;
    new_file(
        &enclaves.join(GOVERNANCE),
        &signed(&authority, &governance)?,
    )?;
    for plan in creation.enclaves {
        let folder = enclave_folder(staged.path(), &plan.name);
        all_folders(&folder)?;
        write_enclave(
            &folder,
            plan,
            creation.domains,
            validity,
            &authority,
            &authority,
        )?;
    }
    staged.commit(folder)
}

/// Adds an enclave to a keystore, also to one that `ros2 security create_keystore` has made. Its folder appears complete or not
/// at all.
///
/// # Errors
/// The keystore or the authority's key is missing, the enclave exists, or it would outlive the authority.
pub fn add(addition: &Addition<'_>) -> Result<(), KeystoreError> {
    let Addition {
        folder, enclave, ..
    } = *addition;
    let keystore = Opened::at(folder)?;
    let validity = keystore.validity(addition.days, addition.now)?;
    let domains = match addition.domains {
        Some(domains) => domains.clone(),
        None => governance_domains(folder)?,
    };
    let target = enclave_folder(folder, &enclave.name);
    if let Some(taken) = FOLDER_CONTENT
        .iter()
        .find(|file| is_there(&target.join(file)))
    {
        return Err(match *taken {
            KEY | CERTIFICATE => KeystoreError::Exists(enclave.name.to_string()),
            other => KeystoreError::Occupied(target.join(other)),
        });
    }
    let parent = target.parent().unwrap_or(folder);
    all_folders(parent)?;
    let staged = Staged::beside(&target)?;
    let (identity, permissions) = (&keystore.identity, &keystore.permissions);
    write_enclave(
        staged.path(),
        enclave,
        &domains,
        validity,
        identity,
        permissions,
    )?;
    if is_there(&target) {
        // The folder exists because of other enclaves below it.
        staged.move_files(&target, &FOLDER_CONTENT)
    } else {
        staged.commit(&target)
    }
}

/// Renews certificates and permissions, and returns the enclaves that were renewed. Keys, topics and everything that was written
/// into the permissions by hand stay as they are. Nothing is written before everything is signed.
///
/// # Errors
/// The keystore or the authority's key is missing, an enclave does not exist, or a document cannot be understood.
pub fn renew(renewal: &Renewal<'_>) -> Result<Vec<EnclaveName>, KeystoreError> {
    let folder = renewal.folder;
    let mut keystore = Opened::at(folder)?;
    let known = enclaves_of(folder)?;
    let chosen = if renewal.enclaves.is_empty() {
        known.clone()
    } else {
        renewal.enclaves.to_vec()
    };
    if let Some(unknown) = chosen.iter().find(|name| !known.contains(name)) {
        let known: Vec<_> = known.iter().map(EnclaveName::as_str).collect();
        return Err(KeystoreError::NoEnclave {
            name: unknown.to_string(),
            known: known.join(", "),
        });
    }
    let mut files = BTreeMap::new();
    if renewal.authority {
        let days = AUTHORITY_DAYS.max(renewal.days);
        keystore.renew_authorities(validity(days, renewal.now)?, &mut files)?;
    }
    let validity = keystore.validity(renewal.days, renewal.now)?;
    for name in &chosen {
        keystore.renew_enclave(name, validity, &mut files)?;
    }
    for (path, content) in files {
        replace_file(&path, &content)?;
    }
    Ok(chosen)
}

/// A keystore with the keys of its authorities, which are usually one and the same.
struct Opened {
    folder: PathBuf,
    identity: Authority,
    permissions: Authority,
}

impl Opened {
    fn at(folder: &Path) -> Result<Self, KeystoreError> {
        let authority = |certificate: &str, key: &str| {
            let certificate_path = folder.join(PUBLIC).join(certificate);
            let key_path = folder.join(PRIVATE).join(key);
            if !certificate_path.is_file() {
                return Err(KeystoreError::NotAKeystore {
                    path: folder.to_path_buf(),
                    missing: format!("{PUBLIC}/{certificate}"),
                });
            }
            let certificate = read_certificate(&certificate_path)?;
            if !key_path.is_file() {
                return Err(KeystoreError::NoAuthority(key_path));
            }
            let key = PKey::private_key_from_pem(&read(&key_path)?)
                .map_err(|error| KeystoreError::document(&key_path, error))?;
            let public = certificate.public_key();
            if !public.is_ok_and(|public| public.public_eq(&key)) {
                return Err(KeystoreError::ForeignKey {
                    key: key_path,
                    certificate: certificate_path,
                });
            }
            Ok(Authority { certificate, key })
        };
        Ok(Self {
            folder: folder.to_path_buf(),
            identity: authority(IDENTITY_CA, IDENTITY_CA_KEY)?,
            permissions: authority(PERMISSIONS_CA, PERMISSIONS_CA_KEY)?,
        })
    }

    /// The validity of an enclave, which must not outlive the authorities: DDS implementations would reject it from then on.
    fn validity(&self, days: u32, now: i64) -> Result<Validity, KeystoreError> {
        let validity = validity(days, now)?;
        for authority in [&self.identity, &self.permissions] {
            let end = of_certificate(authority.certificate.not_after())
                .map_err(KeystoreError::openssl("read the expiry of the authority"))?
                .as_second();
            if end < validity.until {
                return Err(KeystoreError::OutlivesAuthority {
                    wanted: date(validity.until),
                    authority: date(end),
                });
            }
        }
        Ok(validity)
    }

    /// New certificates of the authorities with the keys that they have, and the governance signed by them.
    fn renew_authorities(
        &mut self,
        validity: Validity,
        files: &mut BTreeMap<PathBuf, Vec<u8>>,
    ) -> Result<(), KeystoreError> {
        let path = |name: &str| {
            let path = self.folder.join(PUBLIC).join(name);
            fs::canonicalize(&path).map_err(KeystoreError::io("open", &path))
        };
        let (identity, permissions) = (path(IDENTITY_CA)?, path(PERMISSIONS_CA)?);
        let renewed = |authority: &Authority| {
            let renewed = authority.renewed(validity);
            renewed.map_err(KeystoreError::openssl("renew the authority"))
        };
        // One certificate for both purposes stays one.
        let is_one = identity == permissions;
        self.identity = renewed(&self.identity)?;
        self.permissions = if is_one {
            Authority {
                certificate: self.identity.certificate.clone(),
                key: self.identity.key.clone(),
            }
        } else {
            renewed(&self.permissions)?
        };
        files.insert(identity, pem(&self.identity.certificate)?);
        files.insert(permissions, pem(&self.permissions.certificate)?);
        let enclaves = self.folder.join(ENCLAVES);
        let governance = read_text(&enclaves.join(GOVERNANCE_XML))?;
        files.insert(
            enclaves.join(GOVERNANCE),
            signed(&self.permissions, &governance)?,
        );
        Ok(())
    }

    fn renew_enclave(
        &self,
        name: &EnclaveName,
        validity: Validity,
        files: &mut BTreeMap<PathBuf, Vec<u8>>,
    ) -> Result<(), KeystoreError> {
        let folder = enclave_folder(&self.folder, name);
        let path = folder.join(CERTIFICATE);
        // The public key is enough, so the private key may be on another machine only.
        let key = read_certificate(&path)?
            .public_key()
            .map_err(|error| KeystoreError::document(&path, error))?;
        files.insert(path, identity(&self.identity, name, &key, validity)?);
        let path = folder.join(PERMISSIONS_XML);
        let permissions = with_validity(&read_text(&path)?, validity)
            .map_err(|reason| KeystoreError::document(&path, reason))?;
        let signature = signed(&self.permissions, &permissions)?;
        files.insert(path, permissions.into_bytes());
        files.insert(folder.join(PERMISSIONS), signature);
        Ok(())
    }
}

fn validity(days: u32, now: i64) -> Result<Validity, KeystoreError> {
    if days == 0 || days > MAX_DAYS {
        return Err(KeystoreError::Days {
            found: days,
            max: MAX_DAYS,
        });
    }
    Ok(Validity {
        from: now - BACKDATED_SECS,
        until: now + i64::from(days) * 86_400,
    })
}

/// Writes all files of an enclave into its folder.
fn write_enclave(
    folder: &Path,
    plan: &EnclavePlan,
    domains: &DomainRanges,
    validity: Validity,
    identity_authority: &Authority,
    permissions_authority: &Authority,
) -> Result<(), KeystoreError> {
    let permissions = permissions_xml(&plan.name, &plan.access, domains, validity);
    let key = new_key().map_err(KeystoreError::openssl("make a key"))?;
    new_secret(&folder.join(KEY), &key_pem(&key)?)?;
    let certificate = identity(identity_authority, &plan.name, &key, validity)?;
    new_file(&folder.join(CERTIFICATE), &certificate)?;
    new_file(&folder.join(PERMISSIONS_XML), permissions.as_bytes())?;
    let signature = signed(permissions_authority, &permissions)?;
    new_file(&folder.join(PERMISSIONS), &signature)?;
    for (link, to) in links(&plan.name) {
        new_link(&folder.join(link), &to)?;
    }
    Ok(())
}

fn identity(
    authority: &Authority,
    name: &EnclaveName,
    key: &PKeyRef<impl HasPublic>,
    validity: Validity,
) -> Result<Vec<u8>, KeystoreError> {
    let certificate = authority.issue(name.as_str(), key, validity);
    pem(&certificate.map_err(KeystoreError::openssl("issue a certificate"))?)
}

fn signed(authority: &Authority, document: &str) -> Result<Vec<u8>, KeystoreError> {
    let signed = authority.sign(document);
    signed.map_err(KeystoreError::openssl("sign a document"))
}

fn pem(certificate: &X509) -> Result<Vec<u8>, KeystoreError> {
    let pem = certificate.to_pem();
    pem.map_err(KeystoreError::openssl("write a certificate"))
}

fn key_pem(key: &PKey<openssl::pkey::Private>) -> Result<Vec<u8>, KeystoreError> {
    let pem = key.private_key_to_pem_pkcs8();
    pem.map_err(KeystoreError::openssl("write a key"))
}

/// A folder under a temporary name beside its place; [`commit`](Self::commit) renames it, dropping it removes it.
struct Staged(tempfile::TempDir);

impl Staged {
    fn beside(target: &Path) -> Result<Self, KeystoreError> {
        let parent = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let staged = tempfile::Builder::new()
            .prefix(".keystore-")
            .suffix(".partial")
            .permissions(fs::Permissions::from_mode(OPEN_FOLDER))
            .tempdir_in(parent)
            .map_err(|error| io::Error::new(error.kind(), error.kind().to_string()))
            .map_err(KeystoreError::io("create a folder in", parent))?;
        Ok(Self(staged))
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// Gives the folder its name, which is free or that of an empty folder.
    fn commit(self, target: &Path) -> Result<(), KeystoreError> {
        fs::rename(self.path(), target).map_err(KeystoreError::io("create", target))?;
        // It is no longer under its temporary name.
        let _ = self.0.keep();
        Ok(())
    }

    /// Moves the files into a folder that has none of these names; if one cannot be moved, those before it are removed.
    fn move_files(&self, target: &Path, names: &[&str]) -> Result<(), KeystoreError> {
        for (index, name) in names.iter().enumerate() {
            if let Err(error) = fs::rename(self.path().join(name), target.join(name)) {
                for moved in &names[..index] {
                    let _ = fs::remove_file(target.join(moved));
                }
                return Err(KeystoreError::io("create", &target.join(name))(error));
            }
        }
        Ok(())
    }
}

fn new_folder(path: &Path, mode: u32) -> Result<(), KeystoreError> {
    let created = fs::DirBuilder::new().mode(mode).create(path);
    created.map_err(KeystoreError::io("create the folder", path))
}

fn all_folders(path: &Path) -> Result<(), KeystoreError> {
    let mut builder = fs::DirBuilder::new();
    let created = builder.recursive(true).mode(OPEN_FOLDER).create(path);
    created.map_err(KeystoreError::io("create the folder", path))
}

fn new_file(path: &Path, content: &[u8]) -> Result<(), KeystoreError> {
    write_new(path, content, OPEN_FILE)
}

fn new_secret(path: &Path, content: &[u8]) -> Result<(), KeystoreError> {
    write_new(path, content, SECRET_FILE)
}

/// Writes a file that must not exist yet.
fn write_new(path: &Path, content: &[u8], mode: u32) -> Result<(), KeystoreError> {
    let mut options = OpenOptions::new();
    let file = options.write(true).create_new(true).mode(mode).open(path);
    file.and_then(|mut file| {
        file.write_all(content)?;
        file.sync_all()
    })
    .map_err(KeystoreError::io("create", path))
}

/// Replaces a file as a whole.
fn replace_file(path: &Path, content: &[u8]) -> Result<(), KeystoreError> {
    let failed = |error: io::Error| KeystoreError::io("replace", path)(error);
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new()
        .prefix(".keystore-")
        .suffix(".partial")
        .permissions(fs::Permissions::from_mode(OPEN_FILE))
        .tempfile_in(folder)
        .map_err(|error| failed(io::Error::new(error.kind(), error.kind().to_string())))?;
    file.write_all(content).map_err(failed)?;
    file.as_file().sync_all().map_err(failed)?;
    file.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

fn new_link(path: &Path, to: &Path) -> Result<(), KeystoreError> {
    symlink(to, path).map_err(KeystoreError::io("create the link", path))
}

/// Whether there is anything of this name, also a link that points nowhere.
fn is_there(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}
