//! Delivery by HTTPS POST.

use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use ureq::Agent;
use ureq::http::Uri;
use ureq::tls::{Certificate, ClientCert, PrivateKey, RootCerts, TlsConfig};

use crate::error::StartError;
use crate::message::Message;
use crate::rules::Rules;
use crate::sender::{LEAST_WAIT, Pulse, SendFault, Sender, Turns, time_of_day};
use crate::signature::SigningKey;
use crate::tls::{Identity, TlsFiles, provider};

/// Longest time for a request, its answer included.
const TIMEOUT: Duration = Duration::from_secs(10);
/// The longest wait that a receiver may ask for.
const LONGEST_ASKED: Duration = Duration::from_secs(3600);

/// Where and how to POST.
#[derive(Debug, Clone, Default)]
pub struct WebhookSettings {
    /// `https://HOST/PATH`; `http://` for this machine only.
    pub url: String,
    /// The file with the key of the signatures, `whsec_` and Base64, mode 0600.
    pub key_file: PathBuf,
    /// The files of TLS.
    pub tls: TlsFiles,
    /// What is delivered.
    pub rules: Rules,
}

/// A receiver of webhooks.
pub(crate) struct Webhook {
    agent: Agent,
    url: String,
    key: SigningKey,
}

impl Webhook {
    pub fn new(settings: &WebhookSettings) -> Result<Self, StartError> {
        let url = &settings.url;
        if let Some(host) = host_behind_a_user(url) {
            return Err(StartError::UserInUrl(host.to_owned()));
        }
        let bad = || StartError::Url(url.clone());
        let uri: Uri = url.parse().map_err(|_| bad())?;
        let host = uri.host().filter(|host| !host.is_empty()).ok_or_else(bad)?;
        let mut config = Agent::config_builder()
            .timeout_global(Some(TIMEOUT))
            .max_redirects(0)
            .max_redirects_will_error(false)
            .http_status_as_error(false)
            // A proxy in the environment of whoever starts the node must not decide where alarms go.
            .proxy(None)
            .user_agent(concat!("column_alarm/", env!("CARGO_PKG_VERSION")));
        match uri.scheme_str() {
            Some("https") => {
                let identity = Identity::read(&settings.tls)?;
                config = config.https_only(true).tls_config(tls_config(&identity));
            }
            Some("http") if is_this_machine(host) => {}
            Some("http") => return Err(StartError::Unencrypted(url.clone())),
            _ => return Err(bad()),
        }
        Ok(Self {
            agent: config.build().new_agent(),
            url: url.clone(),
            key: SigningKey::read(&settings.key_file)?,
        })
    }

    /// Delivers one message.
    pub fn post(&self, message: &Message, now: SystemTime) -> Result<(), SendFault> {
        let body = message.json();
        let seconds = now.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
        let answer = self
            .agent
            .post(&self.url)
            .header("content-type", "application/json")
            .header("webhook-id", &message.id)
            .header("webhook-timestamp", seconds.to_string())
            .header(
                "webhook-signature",
                self.key.sign(&message.id, seconds, &body),
            )
            .send(body.as_str());
        let answer = answer.map_err(|fault| SendFault::Away(in_words(&fault), None))?;
        let status = answer.status();
        let why = format!("{} answered {status}", self.url);
        match status.as_u16() {
            200..=299 => Ok(()),
            300..=399 => Err(SendFault::Away(
                format!("{why}; redirects are not followed, give the address that it leads to"),
                None,
            )),
            // The whole receiver is not ready, or does not know this node: every message would fare alike.
            401 | 403 | 404 | 407 | 408 | 425 | 429 | 500..=599 => {
                let asked = answer.headers().get("retry-after");
                let asked = asked.and_then(|it| it.to_str().ok()?.parse().ok());
                let asked = asked.map(|it| Duration::from_secs(it).min(LONGEST_ASKED));
                Err(SendFault::Away(why, asked))
            }
            _ => Err(SendFault::Rejected(why)),
        }
    }

    /// Delivers until the end.
    pub fn run(&self, sender: &Sender) {
        let mut turns = Turns::new();
        let mut pulse = Pulse::new(sender.heartbeat);
        let mut rung = false;
        loop {
            let now = sender.now();
            let mut send = |message: &Message| self.post(message, time_of_day());
            let mut next = turns.turn(&sender.channel, now, rung, &mut send);
            if pulse.is_due(now, sender.signs_of_life.load(Ordering::Relaxed)) {
                self.beat(sender);
            }
            if let Some(beat) = pulse.next() {
                next = next.min(beat);
            }
            if sender.ends() {
                let waits = sender.channel().statistics().waiting;
                if waits == 0 || turns.is_waiting(sender.now()) {
                    return;
                }
                next = next.min(now + LEAST_WAIT);
            }
            let wait = next.saturating_sub(sender.now());
            rung = !wait.is_zero() && sender.bell.wait(wait);
        }
    }

    fn beat(&self, sender: &Sender) {
        let message = sender.channel().heartbeat(time_of_day());
        match self.post(&message, time_of_day()) {
            Ok(()) => {
                let mut channel = sender.channel();
                channel.heartbeat_sent();
                channel.works();
            }
            Err(SendFault::Away(why, _) | SendFault::Rejected(why)) => {
                sender
                    .channel()
                    .failed(&why, sender.heartbeat.unwrap_or_default());
            }
        }
    }
}

fn tls_config(identity: &Identity) -> TlsConfig {
    let roots: Vec<Certificate<'static>> = identity
        .authorities
        .iter()
        .map(|it| Certificate::from_der(it.as_ref()).to_owned())
        .collect();
    let client = identity.client.as_ref().and_then(|client| {
        let chain: Vec<Certificate<'static>> = client
            .chain
            .iter()
            .map(|it| Certificate::from_der(it.as_ref()).to_owned())
            .collect();
        let key = PrivateKey::from_pem(client.key_pem.as_bytes()).ok()?;
        Some(ClientCert::new_with_certs(&chain, key))
    });
    TlsConfig::builder()
        .root_certs(RootCerts::Specific(Arc::new(roots)))
        .client_cert(client)
        .unversioned_rustls_crypto_provider(provider())
        .build()
}

/// The whole chain of causes, because the last one says what to do.
pub(crate) fn in_words(fault: &dyn std::error::Error) -> String {
    let mut text = fault.to_string();
    let mut cause = fault.source();
    while let Some(it) = cause {
        let more = it.to_string();
        if !text.contains(&more) {
            text.push_str(": ");
            text.push_str(&more);
        }
        cause = it.source();
    }
    text
}

/// The host of a URL that has a user, with or without a password, before it. Errors about it must not repeat the password.
fn host_behind_a_user(url: &str) -> Option<&str> {
    let authority = url.split_once("://").map_or(url, |(_, rest)| rest);
    let authority = authority.split(['/', '?', '#']).next()?;
    authority.rsplit_once('@').map(|(_, host)| host)
}

/// Whether a host is this machine, without asking anybody.
pub(crate) fn is_this_machine(host: &str) -> bool {
    let address = host.trim_start_matches('[').trim_end_matches(']');
    host == "localhost" || address.parse::<IpAddr>().is_ok_and(|it| it.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Such an address was published and recorded with all parameters.
    #[test]
    fn an_address_with_a_password_is_rejected_without_repeating_it() {
        for url in [
            "https://user:secret@receiver.example/column",
            "https://secret@receiver.example",
            "http://user:secret@receiver.example/?to=a@b",
            "ftp://user:secret@receiver.example/",
        ] {
            let settings = WebhookSettings {
                url: url.to_owned(),
                ..Default::default()
            };
            let fault = Webhook::new(&settings).err().expect("is rejected");
            let said = fault.to_string();
            assert!(matches!(fault, StartError::UserInUrl(_)), "{said}");
            assert!(
                said.contains("@receiver.example;") && !said.contains("secret"),
                "{said}"
            );
        }
        assert_eq!(host_behind_a_user("https://receiver.example/?to=a@b"), None);
    }
}
