//! Signatures of webhooks, after Standard Webhooks (<https://www.standardwebhooks.com>): HMAC-SHA256 over id, time and
//! body, which libraries in most languages check.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use ring::hmac;

use crate::error::StartError;
use crate::secret::read_secret;

/// Shortest key \[bytes\] (Standard Webhooks).
const MIN_KEY: usize = 24;

/// The key of the signatures.
#[derive(Debug, Clone)]
pub(crate) struct SigningKey(hmac::Key);

impl SigningKey {
    /// Reads a key: `whsec_` and the key in Base64.
    pub fn read(path: &Path) -> Result<Self, StartError> {
        let content = |what: String| StartError::Content {
            path: path.to_owned(),
            what,
        };
        let text = read_secret(path)?;
        Self::parse(text.trim()).ok_or_else(|| {
            content(format!(
                "holds no key: expected whsec_ and at least {MIN_KEY} bytes in Base64; make one with \
                 `(umask 077; echo whsec_$(openssl rand -base64 32) > FILE)`"
            ))
        })
    }

    fn parse(text: &str) -> Option<Self> {
        let bytes = STANDARD.decode(text.strip_prefix("whsec_")?).ok()?;
        (bytes.len() >= MIN_KEY).then(|| Self(hmac::Key::new(hmac::HMAC_SHA256, &bytes)))
    }

    /// The value of the header `webhook-signature`.
    pub fn sign(&self, id: &str, unix_seconds: u64, body: &str) -> String {
        let tag = hmac::sign(&self.0, format!("{id}.{unix_seconds}.{body}").as_bytes());
        format!("v1,{}", STANDARD.encode(tag))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_signature_is_that_of_another_library() {
        // From the Python package standardwebhooks 1.0: `Webhook(key).sign(id, time, body)`.
        let key = SigningKey::parse("whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw").unwrap();
        let id = "msg_p5jXN8AQM9LWM0D4loKWxJek";
        let signature = key.sign(id, 1_614_265_330, r#"{"test": 2432232314}"#);
        assert_eq!(signature, "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=");
    }

    #[test]
    fn a_short_key_or_another_text_is_none() {
        for text in [
            "",
            "whsec_",
            "whsec_AAAA",
            "MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw",
            "whsec_%",
        ] {
            assert!(SigningKey::parse(text).is_none(), "{text}");
        }
    }
}
