//! The notation of a sender that may speak to the node.

use std::fmt;
use std::str::FromStr;

use printable::Hexadecimal;

/// Bytes of the prefix of a GUID, which identifies a participant on the network.
pub const GUID_PREFIX_BYTES: usize = 12;

/// Fewest bytes of a prefix: those that identify vendor and machine. Process and participant follow, and change at every start.
const MIN_BYTES: usize = 4;

/// A sender, as an element of the parameter `senders.allowed` names it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum AllowedSender {
    /// Participants whose GUID begins with these bytes.
    Guid(Vec<u8>),
    /// The participant with this enclave, e.g. `/garage/operator`: known only with DDS security.
    Enclave(String),
}

/// The text is neither the beginning of a GUID nor an enclave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("is neither the beginning of a GUID nor an enclave")]
pub struct NotASender;

impl AllowedSender {
    /// Whether the sender with this prefix, and with this enclave where it is known, is meant.
    #[must_use]
    pub fn is(&self, prefix: &[u8; GUID_PREFIX_BYTES], enclave: Option<&str>) -> bool {
        match self {
            Self::Guid(bytes) => prefix.starts_with(bytes),
            Self::Enclave(name) => enclave == Some(name),
        }
    }
}

impl FromStr for AllowedSender {
    type Err = NotASender;

    fn from_str(text: &str) -> Result<Self, NotASender> {
        let text = text.trim();
        if let Some(rest) = text.strip_prefix('/') {
            let is_named = !rest.is_empty() && !text.chars().any(|it| it.is_control() || it == ' ');
            return is_named
                .then(|| Self::Enclave(text.to_owned()))
                .ok_or(NotASender);
        }
        // As `ros2 topic info -v` separates the bytes.
        let digits: String = text.chars().filter(|it| !".:".contains(*it)).collect();
        let lengths = 2 * MIN_BYTES..=2 * GUID_PREFIX_BYTES;
        if !lengths.contains(&digits.len()) || !digits.len().is_multiple_of(2) || !digits.is_ascii()
        {
            return Err(NotASender);
        }
        let byte = |index| {
            let pair = digits.get(index..index + 2)?;
            // A sign would be a number, too.
            let is_hex = pair.bytes().all(|it| it.is_ascii_hexdigit());
            is_hex.then(|| u8::from_str_radix(pair, 16).ok())?
        };
        let bytes: Option<Vec<_>> = (0..digits.len()).step_by(2).map(byte).collect();
        bytes.map(Self::Guid).ok_or(NotASender)
    }
}

impl fmt::Display for AllowedSender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Guid(bytes) => Hexadecimal(bytes).fmt(f),
            Self::Enclave(name) => f.write_str(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn senders_are_beginnings_of_a_guid_or_enclaves() {
        let parsed = |text: &str| text.parse::<AllowedSender>();
        let guid = Ok(AllowedSender::Guid(vec![0x01, 0x0f, 0xab, 0x00]));
        for text in ["010fab00", " 010FAB00 ", "01.0f.ab.00", "01:0f:ab:00"] {
            assert_eq!(parsed(text), guid, "{text}");
        }
        assert_eq!(
            parsed("/a/b"),
            Ok(AllowedSender::Enclave("/a/b".to_owned()))
        );
        for bad in [
            "",
            "/",
            "010f",
            "010fab0",
            "010fabxy",
            "operator",
            "/a b",
            "+1+1+1+1",
            &"0".repeat(26),
        ] {
            assert_eq!(parsed(bad), Err(NotASender), "{bad}");
        }
        assert_eq!(guid.map(|it| it.to_string()), Ok("010fab00".to_owned()));
    }

    #[test]
    fn an_enclave_matches_only_a_participant_that_is_known() {
        let enclave = AllowedSender::Enclave("/a".to_owned());
        assert!(!enclave.is(&[0; 12], None));
        assert!(!enclave.is(&[0; 12], Some("/a/b")));
        assert!(enclave.is(&[0; 12], Some("/a")));
        let guid = AllowedSender::Guid(vec![1, 2]);
        assert!(guid.is(&[1, 2, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0], None));
        assert!(!guid.is(&[2; 12], Some("/a")));
    }
}
