//! Certificates and keys of an enclave.

use jiff::Timestamp;
use openssl::error::ErrorStack;
use openssl::nid::Nid;
use openssl::pkey::{HasPublic, Id, PKey, PKeyRef, Private};
use openssl::x509::{X509, X509Ref};

use super::dates;
use super::fault::{EnclaveFault, EnclaveFile};

/// A certificate and what the checks need of it.
#[derive(Debug)]
pub(super) struct Certificate {
    pub file: EnclaveFile,
    pub x509: X509,
    /// Its subject, such as `CN=/talker`.
    pub subject: String,
    pub not_before: Timestamp,
    pub not_after: Timestamp,
}

impl Certificate {
    pub fn read(file: EnclaveFile, pem: &[u8]) -> Result<Self, EnclaveFault> {
        Self::parse(file, pem).map_err(|error| EnclaveFault::NotPem {
            file,
            expected: "an X.509 certificate",
            reason: reason(&error),
        })
    }

    fn parse(file: EnclaveFile, pem: &[u8]) -> Result<Self, ErrorStack> {
        let x509 = X509::from_pem(pem)?;
        Ok(Self {
            file,
            subject: subject(&x509),
            not_before: dates::of_certificate(x509.not_before())?,
            not_after: dates::of_certificate(x509.not_after())?,
            x509,
        })
    }

    /// Its algorithm and its dates, which RustDDS does not look at.
    pub fn check(&self, now: Timestamp, faults: &mut Vec<EnclaveFault>) {
        let algorithm = self.x509.public_key().ok().and_then(|it| unsupported(&it));
        if let Some(found) = algorithm {
            faults.push(EnclaveFault::Algorithm {
                file: self.file,
                found,
            });
        }
        if now < self.not_before {
            faults.push(EnclaveFault::CertificateNotYetValid {
                file: self.file,
                subject: self.subject.clone(),
                from: self.not_before,
                now,
            });
        }
        if now > self.not_after {
            faults.push(EnclaveFault::CertificateExpired {
                file: self.file,
                subject: self.subject.clone(),
                until: self.not_after,
                now,
            });
        }
    }

    /// Whether `authority` issued it.
    pub fn check_issued_by(&self, authority: &Self, faults: &mut Vec<EnclaveFault>) {
        let key = authority.x509.public_key();
        let is_issued = key.and_then(|key| self.x509.verify(&key));
        if !is_issued.unwrap_or(false) {
            faults.push(EnclaveFault::ForeignCertificate {
                subject: self.subject.clone(),
                issuer: name(self.x509.issuer_name()),
                authority: authority.subject.clone(),
            });
        }
    }

    /// Whether it belongs to this private key. RustDDS starts with any, and every peer then rejects it.
    pub fn check_key(&self, key: &PKeyRef<Private>, faults: &mut Vec<EnclaveFault>) {
        let public = self.x509.public_key();
        if !public.is_ok_and(|public| public.public_eq(key)) {
            faults.push(EnclaveFault::ForeignKey {
                subject: self.subject.clone(),
            });
        }
    }
}

/// Reads a private key without a password: RustDDS ignores passwords.
pub(super) fn private_key(pem: &[u8]) -> Result<PKey<Private>, EnclaveFault> {
    // Without the callback, OpenSSL would ask for a password on the terminal.
    let key = PKey::private_key_from_pem_callback(pem, |_| Ok(0));
    let text = String::from_utf8_lossy(pem);
    if key.is_ok() && !text.contains("-----BEGIN PRIVATE KEY-----") {
        return Err(EnclaveFault::NotPkcs8);
    }
    key.map_err(|error| {
        if text.contains("ENCRYPTED") {
            EnclaveFault::EncryptedKey
        } else {
            EnclaveFault::NotPem {
                file: EnclaveFile::Key,
                expected: "a private key",
                reason: reason(&error),
            }
        }
    })
}

/// The algorithm of a key that RustDDS does not support.
fn unsupported(key: &PKeyRef<impl HasPublic>) -> Option<String> {
    match key.id() {
        Id::EC => {
            let curve = key.ec_key().ok().and_then(|it| it.group().curve_name());
            let name = curve.and_then(|it| it.short_name().ok());
            (curve != Some(Nid::X9_62_PRIME256V1))
                .then(|| format!("the elliptic curve {}", name.unwrap_or("without a name")))
        }
        Id::RSA if key.bits() == 2048 => None,
        Id::RSA => Some(format!("RSA with {} bits", key.bits())),
        Id::ED25519 => Some("Ed25519".to_owned()),
        other => Some(format!("algorithm {}", other.as_raw())),
    }
}

/// The subject as `CN=/talker,O=garage`, in the order of the certificate.
fn subject(x509: &X509Ref) -> String {
    name(x509.subject_name())
}

fn name(name: &openssl::x509::X509NameRef) -> String {
    let parts: Vec<_> = name
        .entries()
        .map(|entry| {
            let key = entry.object().nid().short_name().unwrap_or("?").to_owned();
            let value = entry.data().to_string();
            format!("{key}={}", value.unwrap_or_default())
        })
        .collect();
    parts.join(",")
}

/// The first error of OpenSSL, in its own words.
pub(super) fn reason(error: &ErrorStack) -> String {
    let first = error.errors().first();
    first
        .and_then(openssl::error::Error::reason)
        .unwrap_or("OpenSSL gives no reason")
        .to_owned()
}
