//! Keystores as SROS 2 lays them out, made with OpenSSL alone.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use openssl::asn1::Asn1Time;
use openssl::bn::BigNum;
use openssl::ec::{EcGroup, EcKey};
use openssl::hash::MessageDigest;
use openssl::nid::Nid;
use openssl::pkcs7::{Pkcs7, Pkcs7Flags};
use openssl::pkey::{PKey, Private};
use openssl::stack::Stack;
use openssl::x509::extension::BasicConstraints;
use openssl::x509::{X509, X509Builder, X509NameBuilder};
use tempfile::TempDir;

const DAY: i64 = 86_400;

/// Seconds since 1970.
pub fn now() -> i64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    i64::try_from(since.unwrap().as_secs()).unwrap()
}

/// A key with its certificate.
pub struct Identity {
    pub key: PKey<Private>,
    pub certificate: X509,
}

impl Identity {
    /// An authority that signs itself.
    pub fn authority(name: &str) -> Self {
        Self::new(name, None, -1..3650)
    }

    /// An identity that this authority issues; valid from and until so many days from now.
    pub fn issue(&self, name: &str, days: std::ops::Range<i64>) -> Self {
        Self::new(name, Some(self), days)
    }

    fn new(name: &str, issuer: Option<&Self>, days: std::ops::Range<i64>) -> Self {
        let group = EcGroup::from_curve_name(Nid::X9_62_PRIME256V1).unwrap();
        let key = PKey::from_ec_key(EcKey::generate(&group).unwrap()).unwrap();
        let mut subject = X509NameBuilder::new().unwrap();
        subject.append_entry_by_nid(Nid::COMMONNAME, name).unwrap();
        let subject = subject.build();
        let mut builder = X509Builder::new().unwrap();
        builder.set_version(2).unwrap();
        let serial = BigNum::from_u32(rand(name)).unwrap();
        builder
            .set_serial_number(&serial.to_asn1_integer().unwrap())
            .unwrap();
        builder.set_subject_name(&subject).unwrap();
        builder
            .set_issuer_name(issuer.map_or(&subject, |it| it.certificate.subject_name()))
            .unwrap();
        builder.set_pubkey(&key).unwrap();
        let at = |days: i64| Asn1Time::from_unix(now() + days * DAY).unwrap();
        builder.set_not_before(&at(days.start)).unwrap();
        builder.set_not_after(&at(days.end)).unwrap();
        if issuer.is_none() {
            let constraints = BasicConstraints::new().critical().ca().build().unwrap();
            builder.append_extension(constraints).unwrap();
        }
        builder
            .sign(issuer.map_or(&key, |it| &it.key), MessageDigest::sha256())
            .unwrap();
        Self {
            certificate: builder.build(),
            key,
        }
    }

    /// Signs a document as `openssl smime -sign -text` does.
    pub fn sign(&self, document: &str) -> Vec<u8> {
        let flags = Pkcs7Flags::TEXT | Pkcs7Flags::DETACHED;
        let others = Stack::new().unwrap();
        let text = document.as_bytes();
        let signed = Pkcs7::sign(&self.certificate, &self.key, &others, text, flags).unwrap();
        signed.to_smime(text, flags).unwrap()
    }

    fn certificate_pem(&self) -> Vec<u8> {
        self.certificate.to_pem().unwrap()
    }

    fn key_pem(&self) -> Vec<u8> {
        self.key.private_key_to_pem_pkcs8().unwrap()
    }
}

/// A serial number that differs by name.
fn rand(name: &str) -> u32 {
    name.bytes()
        .fold(7, |sum, byte| sum.wrapping_mul(31) ^ u32::from(byte))
}

/// The protection of a domain.
#[derive(Clone, Copy)]
pub struct Governance<'a> {
    pub domains: &'a str,
    pub metadata: &'a str,
    pub data: &'a str,
    pub access_control: bool,
}

/// What the documentation recommends: everything is encrypted, by submessage.
pub const RECOMMENDED: Governance<'_> = Governance {
    domains: ALL_DOMAINS,
    metadata: "ENCRYPT",
    data: "NONE",
    access_control: true,
};

/// What `ros2 security` writes.
pub const SROS_DEFAULT: Governance<'_> = Governance {
    data: "ENCRYPT",
    ..RECOMMENDED
};

pub const ALL_DOMAINS: &str = "<id_range><min>0</min><max>232</max></id_range>";

impl Governance<'_> {
    pub fn xml(&self) -> String {
        let Self {
            domains,
            metadata,
            data,
            access_control,
        } = self;
        format!(
            r#"<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains>{domains}</domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>{access_control}</enable_read_access_control>
          <enable_write_access_control>{access_control}</enable_write_access_control>
          <metadata_protection_kind>{metadata}</metadata_protection_kind>
          <data_protection_kind>{data}</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
"#
        )
    }
}

/// What a subject may do.
#[derive(Clone)]
pub struct Permissions<'a> {
    pub subject: String,
    pub domains: &'a str,
    pub days: std::ops::Range<i64>,
    pub publish: &'a [&'a str],
    pub subscribe: &'a [&'a str],
}

/// What every node needs.
pub const NODE: [&str; 3] = ["ros_discovery_info", "rt/parameter_events", "rt/rosout"];

impl Permissions<'_> {
    pub fn xml(&self) -> String {
        let topics = |topics: &[&str]| -> String {
            let topics = topics.iter().map(|it| format!("<topic>{it}</topic>"));
            topics.collect()
        };
        let date = |days: i64| {
            let seconds = now() + days * DAY;
            jiff::Timestamp::from_second(seconds)
                .unwrap()
                .to_string()
                .trim_end_matches('Z')
                .to_owned()
        };
        let Self {
            subject,
            domains,
            days,
            publish,
            subscribe,
        } = self;
        let (from, until) = (date(days.start), date(days.end));
        let (publish, subscribe) = (topics(publish), topics(subscribe));
        format!(
            r#"<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name="{subject}">
      <subject_name>{subject}</subject_name>
      <validity><not_before>{from}</not_before><not_after>{until}</not_after></validity>
      <allow_rule>
        <domains>{domains}</domains>
        <publish><topics>{publish}</topics></publish>
        <subscribe><topics>{subscribe}</topics></subscribe>
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
"#
        )
    }
}

/// The files of one enclave before they are written.
#[derive(Clone)]
pub struct Enclave {
    name: String,
    pub identity_ca: Vec<u8>,
    pub certificate: Vec<u8>,
    pub key: Vec<u8>,
    pub permissions_ca: Vec<u8>,
    pub governance: Vec<u8>,
    pub permissions: Vec<u8>,
}

impl Enclave {
    /// Of an identity, with everything signed by one authority.
    pub fn of(
        authority: &Identity,
        identity: &Identity,
        governance: &Governance<'_>,
        permissions: &Permissions<'_>,
    ) -> Self {
        let name = permissions.subject.trim_start_matches("CN=").to_owned();
        Self {
            name,
            identity_ca: authority.certificate_pem(),
            certificate: identity.certificate_pem(),
            key: identity.key_pem(),
            permissions_ca: authority.certificate_pem(),
            governance: authority.sign(&governance.xml()),
            permissions: authority.sign(&permissions.xml()),
        }
    }

    /// Writes the files, and returns their folder.
    pub fn write_to(&self, folder: &Path) -> PathBuf {
        fs::create_dir_all(folder).unwrap();
        for (name, content) in [
            ("identity_ca.cert.pem", &self.identity_ca),
            ("cert.pem", &self.certificate),
            ("key.pem", &self.key),
            ("permissions_ca.cert.pem", &self.permissions_ca),
            ("governance.p7s", &self.governance),
            ("permissions.p7s", &self.permissions),
        ] {
            fs::write(folder.join(name), content).unwrap();
        }
        let private = fs::Permissions::from_mode(0o600);
        fs::set_permissions(folder.join("key.pem"), private).unwrap();
        folder.to_owned()
    }

    /// With permissions and governance of another authority.
    pub fn with_permissions_of(
        mut self,
        authority: &Identity,
        governance: &Governance<'_>,
        permissions: &Permissions<'_>,
    ) -> Self {
        self.permissions_ca = authority.certificate_pem();
        self.governance = authority.sign(&governance.xml());
        self.permissions = authority.sign(&permissions.xml());
        self
    }
}

/// A keystore in a temporary folder.
pub struct Keystore {
    pub authority: Identity,
    folder: TempDir,
}

impl Keystore {
    pub fn new() -> Self {
        Self {
            authority: Identity::authority("sros2CA"),
            folder: tempfile::tempdir().unwrap(),
        }
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// An enclave that may do everything.
    pub fn unrestricted(&self, name: &str, governance: &Governance<'_>) -> Enclave {
        let identity = self.authority.issue(name, -1..365);
        Enclave::of(&self.authority, &identity, governance, &everything(name))
    }

    /// Writes an enclave, and returns its folder.
    pub fn write(&self, enclave: &Enclave) -> PathBuf {
        let relative = enclave.name.trim_start_matches('/');
        enclave.write_to(&self.folder.path().join("enclaves").join(relative))
    }
}

/// Permissions for all topics in all domains.
pub fn everything(name: &str) -> Permissions<'static> {
    Permissions {
        subject: format!("CN={name}"),
        domains: ALL_DOMAINS,
        days: -1..365,
        publish: &["*"],
        subscribe: &["*"],
    }
}
