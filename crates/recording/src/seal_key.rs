//! Ed25519 keys of seals.

use std::fmt;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use bounded_file::read_at_most;
use ed25519_dalek::pkcs8::DecodePrivateKey as _;
use ed25519_dalek::pkcs8::spki::DecodePublicKey as _;
use ed25519_dalek::{SECRET_KEY_LENGTH, Signature, Signer as _, SigningKey, VerifyingKey};

use crate::chain::{from_hex, to_hex};
use crate::error::RecordingError;

/// Maximum length of a file with a key \[bytes\].
const MAX_LENGTH: u64 = 64 << 10;

const PRIVATE: &str = "PRIVATE KEY";
const PUBLIC: &str = "PUBLIC KEY";

/// A private key with which recordings are sealed. It never appears in a text.
#[derive(Clone, PartialEq, Eq)]
pub struct SealKey {
    signing: SigningKey,
    origin: Origin,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Origin {
    Fresh,
    File {
        path: PathBuf,
        warning: Option<String>,
    },
}

impl SealKey {
    /// A new key. It exists in the memory of this process only.
    ///
    /// # Errors
    /// The system provides no random numbers.
    pub fn fresh() -> Result<Self, RecordingError> {
        let secret: [u8; SECRET_KEY_LENGTH] = random()?;
        Ok(Self {
            signing: SigningKey::from_bytes(&secret),
            origin: Origin::Fresh,
        })
    }

    /// The key in a file: PKCS#8 in PEM, as `openssl genpkey -algorithm ed25519` writes it.
    ///
    /// # Errors
    /// The file cannot be read, or contains something else.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let bad = |reason: String| RecordingError::BadKey {
            path: path.to_path_buf(),
            reason,
        };
        let make = format!(
            "make a key with: openssl genpkey -algorithm ed25519 -out {}",
            path.display()
        );
        let text = read_text(path).map_err(|error| match error.kind() {
            ErrorKind::NotFound => bad(format!("the file does not exist; {make}")),
            ErrorKind::PermissionDenied => bad(format!(
                "{error}; let the user that runs this program own the file"
            )),
            _ => bad(error.to_string()),
        })?;
        let expected = "expected a private Ed25519 key (PKCS#8 in PEM, without a password)";
        let signing = match label(&text) {
            Some(PRIVATE) => SigningKey::from_pkcs8_pem(&text).map_err(|_| {
                bad(format!(
                    "{expected}, found a private key of another kind, or a damaged one; {make}"
                ))
            })?,
            Some(PUBLIC) => {
                return Err(bad(format!(
                    "{expected}, found a public key; give the file of the private key, of which this is the public part"
                )));
            }
            Some("ENCRYPTED PRIVATE KEY") => {
                return Err(bad(format!(
                    "{expected}, found an encrypted one; decrypt it with: openssl pkey -in {} -out DECRYPTED.pem",
                    path.display()
                )));
            }
            Some(other) => return Err(bad(format!("{expected}, found {other:?}; {make}"))),
            None => return Err(bad(format!("{expected}, found no text in PEM; {make}"))),
        };
        Ok(Self {
            signing,
            origin: Origin::File {
                path: path.to_path_buf(),
                warning: exposure(path),
            },
        })
    }

    /// The public part.
    #[must_use]
    pub fn public_key(&self) -> PublicKey {
        PublicKey(self.signing.verifying_key().to_bytes())
    }

    /// Whether the key was made by [`fresh`](Self::fresh).
    #[must_use]
    pub fn is_fresh(&self) -> bool {
        self.origin == Origin::Fresh
    }

    /// The file of the key.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        match &self.origin {
            Origin::Fresh => None,
            Origin::File { path, .. } => Some(path),
        }
    }

    /// What is wrong with the permissions of the file, and what to do.
    #[must_use]
    pub fn warning(&self) -> Option<&str> {
        match &self.origin {
            Origin::Fresh => None,
            Origin::File { warning, .. } => warning.as_deref(),
        }
    }

    pub(crate) fn sign(&self, bytes: &[u8]) -> [u8; 64] {
        self.signing.sign(bytes).to_bytes()
    }
}

impl fmt::Debug for SealKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SealKey({})", self.public_key())
    }
}

/// The public part of a key, by which everyone can check a seal. Its text is 64 hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct PublicKey([u8; 32]);

impl PublicKey {
    /// The key in a file: in PEM, as `openssl pkey -in PRIVATE -pubout` writes it, or its 64 hexadecimal digits.
    ///
    /// # Errors
    /// The file cannot be read, or contains something else.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let bad = |reason: String| RecordingError::BadKey {
            path: path.to_path_buf(),
            reason,
        };
        let text = read_text(path).map_err(|error| bad(error.to_string()))?;
        let expected = "expected a public Ed25519 key (PEM, or 64 hexadecimal digits)";
        match label(&text) {
            Some(PUBLIC) => VerifyingKey::from_public_key_pem(&text)
                .map(|key| Self(key.to_bytes()))
                .map_err(|_| {
                    bad(format!(
                        "{expected}, found a public key of another kind, or a damaged one"
                    ))
                }),
            Some(label) if label.ends_with(PRIVATE) => Err(bad(format!(
                "{expected}, found a private key, which should stay where the recordings are made; write its public part with: \
                 openssl pkey -in {} -pubout -out PUBLIC.pem",
                path.display()
            ))),
            Some(other) => Err(bad(format!("{expected}, found {other:?}"))),
            None => text
                .trim()
                .parse()
                .map_err(|()| bad(format!("{expected}, found neither"))),
        }
    }

    /// Whether the signature of these bytes was made with the private part.
    pub(crate) fn verifies(&self, bytes: &[u8], signature: &[u8; 64]) -> bool {
        VerifyingKey::from_bytes(&self.0).is_ok_and(|key| {
            key.verify_strict(bytes, &Signature::from_bytes(signature))
                .is_ok()
        })
    }

    pub(crate) fn as_bytes(&self) -> &[u8; 32] {
        &self.0
    }
}

impl fmt::Display for PublicKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&to_hex(&self.0))
    }
}

impl fmt::Debug for PublicKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PublicKey({self})")
    }
}

impl FromStr for PublicKey {
    type Err = ();

    /// Reads 64 hexadecimal digits.
    fn from_str(text: &str) -> Result<Self, ()> {
        from_hex(text).map(Self).ok_or(())
    }
}

/// Random bytes of the system.
pub(crate) fn random<const N: usize>() -> Result<[u8; N], RecordingError> {
    let mut bytes = [0; N];
    getrandom::fill(&mut bytes).map_err(|error| RecordingError::Random(error.to_string()))?;
    Ok(bytes)
}

fn read_text(path: &Path) -> std::io::Result<String> {
    let bytes = read_at_most(path, MAX_LENGTH).map_err(|error| match error.kind() {
        ErrorKind::InvalidData => {
            std::io::Error::other(format!("expected the file of a key: {error}"))
        }
        _ => error,
    })?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// What a text in PEM contains: `PRIVATE KEY`, for example.
fn label(text: &str) -> Option<&str> {
    let begin = text.lines().find(|line| line.starts_with("-----BEGIN "))?;
    begin
        .trim_end()
        .strip_prefix("-----BEGIN ")?
        .strip_suffix("-----")
}

/// A warning if other users can read the file.
#[cfg(unix)]
fn exposure(path: &Path) -> Option<String> {
    use std::os::unix::fs::PermissionsExt as _;
    const READABLE_BY_OTHERS: u32 = 0o004;
    let mode = fs::metadata(path).ok()?.permissions().mode();
    (mode & READABLE_BY_OTHERS != 0).then(|| {
        format!(
            "other users can read the private key {} (mode {:04o}), and could seal recordings with it; protect it with: chmod 600 {}",
            path.display(),
            mode & 0o7777,
            path.display()
        )
    })
}

#[cfg(not(unix))]
fn exposure(_: &Path) -> Option<String> {
    None
}
