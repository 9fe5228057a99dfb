//! Keys, certificates and signatures, all by OpenSSL: elliptic curve P-256 and SHA-256, which DDS Security 1.1 asks for and SROS 2
//! uses.

use openssl::asn1::{Asn1Integer, Asn1Time};
use openssl::bn::{BigNum, MsbOption};
use openssl::ec::{EcGroup, EcKey};
use openssl::error::ErrorStack;
use openssl::hash::MessageDigest;
use openssl::nid::Nid;
use openssl::pkcs7::{Pkcs7, Pkcs7Flags};
use openssl::pkey::{HasPublic, PKey, PKeyRef, Private};
use openssl::stack::Stack;
use openssl::x509::extension::BasicConstraints;
use openssl::x509::{X509, X509Name, X509NameRef};

use crate::documents::Validity;

/// Bits of a serial number: as many as RFC 5280 allows in a positive number of 20 bytes.
const SERIAL_BITS: i32 = 159;

/// Version 3 of certificates, which counts from 0.
const X509_VERSION_3: i32 = 2;

/// A certificate with its key: signs identities and documents.
pub(super) struct Authority {
    pub certificate: X509,
    pub key: PKey<Private>,
}

impl Authority {
    /// A new authority.
    pub fn new(common_name: &str, validity: Validity) -> Result<Self, ErrorStack> {
        let key = new_key()?;
        let name = common_name_of(common_name)?;
        let certificate = self_signed(&name, &key, validity)?;
        Ok(Self { certificate, key })
    }

    /// The same authority, valid at another time.
    pub fn renewed(&self, validity: Validity) -> Result<Self, ErrorStack> {
        let certificate = self_signed(self.certificate.subject_name(), &self.key, validity)?;
        Ok(Self {
            certificate,
            key: self.key.clone(),
        })
    }

    /// The certificate of an enclave.
    pub fn issue(
        &self,
        common_name: &str,
        key: &PKeyRef<impl HasPublic>,
        validity: Validity,
    ) -> Result<X509, ErrorStack> {
        let subject = common_name_of(common_name)?;
        let issuer = self.certificate.subject_name();
        certificate(&subject, issuer, key, &self.key, validity, false)
    }

    /// A document as signed S/MIME text. The signature stands beside the text and is marked as that of a plain text, as SROS 2
    /// does it and the DDS implementations expect it.
    pub fn sign(&self, document: &str) -> Result<Vec<u8>, ErrorStack> {
        let flags = Pkcs7Flags::DETACHED | Pkcs7Flags::TEXT;
        let none = Stack::new()?;
        let text = document.as_bytes();
        Pkcs7::sign(&self.certificate, &self.key, &none, text, flags)?.to_smime(text, flags)
    }
}

/// A new private key.
pub(super) fn new_key() -> Result<PKey<Private>, ErrorStack> {
    let curve = EcGroup::from_curve_name(Nid::X9_62_PRIME256V1)?;
    PKey::from_ec_key(EcKey::generate(&curve)?)
}

fn self_signed(
    name: &X509NameRef,
    key: &PKey<Private>,
    validity: Validity,
) -> Result<X509, ErrorStack> {
    certificate(name, name, key, key, validity, true)
}

fn common_name_of(text: &str) -> Result<X509Name, ErrorStack> {
    let mut name = X509Name::builder()?;
    name.append_entry_by_nid(Nid::COMMONNAME, text)?;
    Ok(name.build())
}

fn certificate(
    subject: &X509NameRef,
    issuer: &X509NameRef,
    key: &PKeyRef<impl HasPublic>,
    issuer_key: &PKey<Private>,
    validity: Validity,
    is_authority: bool,
) -> Result<X509, ErrorStack> {
    let mut serial = BigNum::new()?;
    serial.rand(SERIAL_BITS, MsbOption::MAYBE_ZERO, false)?;
    let mut constraints = BasicConstraints::new();
    if is_authority {
        constraints.critical().ca().pathlen(1);
    }
    let mut builder = X509::builder()?;
    builder.set_version(X509_VERSION_3)?;
    builder.set_serial_number(Asn1Integer::from_bn(&serial)?.as_ref())?;
    builder.set_subject_name(subject)?;
    builder.set_issuer_name(issuer)?;
    builder.set_not_before(Asn1Time::from_unix(validity.from)?.as_ref())?;
    builder.set_not_after(Asn1Time::from_unix(validity.until)?.as_ref())?;
    builder.set_pubkey(key)?;
    builder.append_extension(constraints.build()?)?;
    builder.sign(issuer_key, MessageDigest::sha256())?;
    Ok(builder.build())
}
