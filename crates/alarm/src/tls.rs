//! Certificates and keys, for both ways of delivery.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rustls::crypto::CryptoProvider;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::{ClientConfig, RootCertStore};

use crate::error::StartError;
use crate::secret::{read_public, read_secret};

/// The files of TLS. All in PEM.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TlsFiles {
    /// Certificates of the authorities that are trusted; those of the system if none is given.
    pub authorities: Option<PathBuf>,
    /// The client's certificate and its chain.
    pub certificate: Option<PathBuf>,
    /// Its key, which only the owner may read (mode 0600).
    pub key: Option<PathBuf>,
}

impl TlsFiles {
    pub(crate) fn are_given(&self) -> bool {
        [&self.authorities, &self.certificate, &self.key]
            .iter()
            .any(|it| it.is_some())
    }
}

/// What the files hold.
pub(crate) struct Identity {
    pub authorities: Vec<CertificateDer<'static>>,
    pub client: Option<Client>,
}

/// The client's certificate.
pub(crate) struct Client {
    pub chain: Vec<CertificateDer<'static>>,
    key: PrivateKeyDer<'static>,
    /// The same key as ureq takes it.
    pub key_pem: String,
}

/// The one provider of cryptography.
pub(crate) fn provider() -> Arc<CryptoProvider> {
    Arc::new(rustls::crypto::ring::default_provider())
}

impl Identity {
    pub fn read(files: &TlsFiles) -> Result<Self, StartError> {
        let authorities = match &files.authorities {
            Some(path) => certificates(path)?,
            None => {
                let found = rustls_native_certs::load_native_certs();
                if found.certs.is_empty() {
                    let why = "the system has no certificate authorities; install ca-certificates, or give their file";
                    return Err(StartError::Tls(why.to_owned()));
                }
                found.certs
            }
        };
        let client = match (&files.certificate, &files.key) {
            (None, None) => None,
            (Some(certificate), Some(key)) => {
                let text = read_secret(key)?;
                let parsed = PrivateKeyDer::from_pem_slice(text.as_bytes());
                let parsed = parsed.map_err(|fault| StartError::Content {
                    path: key.clone(),
                    what: format!("holds no private key in PEM: {fault}"),
                })?;
                Some(Client {
                    chain: certificates(certificate)?,
                    key: parsed,
                    key_pem: text,
                })
            }
            _ => return Err(StartError::HalfAnIdentity),
        };
        let identity = Self {
            authorities,
            client,
        };
        // Finds a key that does not belong to its certificate at the start, whoever uses the identity.
        identity.config()?;
        Ok(identity)
    }

    /// The same for rustls.
    pub fn config(&self) -> Result<ClientConfig, StartError> {
        let fault = |fault: rustls::Error| StartError::Tls(fault.to_string());
        let mut roots = RootCertStore::empty();
        let (added, _) = roots.add_parsable_certificates(self.authorities.iter().cloned());
        if added == 0 {
            let why = "none of the certificate authorities can be used";
            return Err(StartError::Tls(why.to_owned()));
        }
        let builder = ClientConfig::builder_with_provider(provider())
            .with_safe_default_protocol_versions()
            .map_err(fault)?
            .with_root_certificates(roots);
        match &self.client {
            None => Ok(builder.with_no_client_auth()),
            Some(client) => builder
                .with_client_auth_cert(client.chain.clone(), client.key.clone_key())
                .map_err(fault),
        }
    }
}

fn certificates(path: &Path) -> Result<Vec<CertificateDer<'static>>, StartError> {
    let text = read_public(path)?;
    let content = |what| StartError::Content {
        path: path.to_owned(),
        what,
    };
    let found: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(text.as_bytes()).collect();
    let found = found.map_err(|fault| content(format!("holds no certificate in PEM: {fault}")))?;
    if found.is_empty() {
        return Err(content("holds no certificate in PEM".to_owned()));
    }
    Ok(found)
}
