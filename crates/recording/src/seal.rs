//! Seals: what a writer adds to a recording so that later changes can be detected. `docs/seal.md` specifies the same bytes.
//!
//! The metadata record [`BEGIN`] is the first metadata record of a sealed recording, before every message. The metadata records
//! [`SEAL`] that follow each sign the head of the [chain](crate::chain) over everything before them. The last one, at the end of
//! the recording, is repeated as an attachment of the same name for people and other tools.

use std::collections::BTreeMap;

use mcap::Attachment;
use mcap::records::Metadata;
use serde_json::{Value as Json, json};

use crate::chain::{Chain, Hash, from_hex, to_hex};
use crate::error::RecordingError;
use crate::seal_key::{PublicKey, SealKey, random};

/// Name of the metadata record with which a sealed recording begins.
pub(crate) const BEGIN: &str = "rosbag2_mcap/seal_begin";

/// Name of the seals: metadata records, and the attachment at the end.
pub(crate) const SEAL: &str = "rosbag2_mcap/seal";

/// Version of the chain, of the seals and of what they sign.
const VERSION: &str = "1";

/// What precedes everything that a seal signs, so that the signature cannot be one of something else.
const DOMAIN: &[u8] = b"rosbag2_mcap seal 1\n";

/// Space that a seal needs in the data of a file \[bytes\].
pub(crate) const SEAL_LENGTH: u64 = 384;

/// Space that a seal needs in the index at the end of a file \[bytes\].
pub(crate) const SEAL_AT_END: u64 = 64;

/// The recording before this one in the same session.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PreviousRecording {
    /// Name of its directory.
    pub name: String,
    /// What its last seal has signed.
    pub(crate) head: Hash,
}

/// The beginning of a sealed recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Beginning {
    pub public_key: PublicKey,
    /// Whether the key was made for this session.
    pub fresh_key: bool,
    /// Identifies all recordings of one run of a recorder.
    pub session: [u8; 16],
    /// Number of recordings of the session before this one.
    pub recording: u64,
    pub previous: Option<PreviousRecording>,
}

impl Beginning {
    /// The first recording of a new session.
    pub fn new(key: &SealKey) -> Result<Self, RecordingError> {
        Ok(Self {
            public_key: key.public_key(),
            fresh_key: key.is_fresh(),
            session: random()?,
            recording: 0,
            previous: None,
        })
    }

    pub fn to_record(&self) -> Metadata {
        let mut entries: BTreeMap<String, String> = [
            ("version", VERSION.to_owned()),
            ("public_key", self.public_key.to_string()),
            (
                "key",
                if self.fresh_key { "fresh" } else { "given" }.to_owned(),
            ),
            ("session", to_hex(&self.session)),
            ("recording", self.recording.to_string()),
        ]
        .map(|(key, value)| (key.to_owned(), value))
        .into();
        if let Some(PreviousRecording { name, head }) = &self.previous {
            entries.insert("previous".to_owned(), name.clone());
            entries.insert("previous_head".to_owned(), head.to_string());
        }
        Metadata {
            name: BEGIN.to_owned(),
            metadata: entries,
        }
    }

    /// Reads a record; the error says what is wrong with it.
    pub fn parse(entries: &BTreeMap<String, String>) -> Result<Self, String> {
        let get = |key: &str| entries.get(key).map(String::as_str);
        check_version(get("version"))?;
        let wrong = |key: &str, expected: &str| {
            format!(
                "its {key} is not {expected}: {:?}",
                get(key).unwrap_or_default()
            )
        };
        let digits = "hexadecimal digits";
        let previous = match (get("previous"), get("previous_head")) {
            (None, None) => None,
            (Some(name), Some(head)) => Some(PreviousRecording {
                name: name.to_owned(),
                head: Hash(from_hex(head).ok_or_else(|| wrong("previous_head", digits))?),
            }),
            _ => {
                return Err(
                    "only one of its entries previous and previous_head is there".to_owned(),
                );
            }
        };
        Ok(Self {
            public_key: get("public_key")
                .and_then(|it| it.parse().ok())
                .ok_or_else(|| wrong("public_key", digits))?,
            fresh_key: match get("key") {
                Some("fresh") => true,
                Some("given") => false,
                _ => return Err(wrong("key", "fresh or given")),
            },
            session: get("session")
                .and_then(from_hex)
                .ok_or_else(|| wrong("session", digits))?,
            recording: get("recording")
                .and_then(|it| it.parse().ok())
                .ok_or_else(|| wrong("recording", "a number"))?,
            previous,
        })
    }
}

/// A version that this program can read.
fn check_version(found: Option<&str>) -> Result<(), String> {
    match found {
        Some(VERSION) => Ok(()),
        found => Err(format!(
            "its version is {:?}, expected {VERSION}; use the version of the program that wrote it",
            found.unwrap_or_default()
        )),
    }
}

/// A signature of everything before it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct SealRecord {
    /// Number of messages before it.
    pub messages: u64,
    /// Head of the chain before it.
    pub head: Hash,
    /// Whether the recording ends with it.
    pub is_final: bool,
    pub signature: [u8; 64],
}

impl SealRecord {
    fn new(chain: &Chain, key: &SealKey, is_final: bool) -> Self {
        let mut seal = Self {
            messages: chain.messages(),
            head: chain.head(),
            is_final,
            signature: [0; 64],
        };
        seal.signature = key.sign(&seal.signed_bytes(&key.public_key()));
        seal
    }

    /// The bytes that are signed: domain, public key (32 bytes), `01` for the final seal and `00` for another, number of
    /// messages (8 bytes, little endian), head of the chain (32 bytes).
    fn signed_bytes(&self, key: &PublicKey) -> Vec<u8> {
        let mut bytes = DOMAIN.to_vec();
        bytes.extend(key.as_bytes());
        bytes.push(u8::from(self.is_final));
        bytes.extend(self.messages.to_le_bytes());
        bytes.extend(self.head.0);
        bytes
    }

    /// Whether it was signed with this key.
    pub fn is_signed_by(&self, key: &PublicKey) -> bool {
        key.verifies(&self.signed_bytes(key), &self.signature)
    }

    fn to_record(&self) -> Metadata {
        let entries = [
            ("version", VERSION.to_owned()),
            ("messages", self.messages.to_string()),
            ("head", self.head.to_string()),
            ("final", self.is_final.to_string()),
            ("signature", to_hex(&self.signature)),
        ];
        Metadata {
            name: SEAL.to_owned(),
            metadata: entries.map(|(key, value)| (key.to_owned(), value)).into(),
        }
    }

    /// Reads a record; the error says what is wrong with it.
    pub fn parse(entries: &BTreeMap<String, String>) -> Result<Self, String> {
        let get = |key: &str| entries.get(key).map(String::as_str);
        check_version(get("version"))?;
        let parsed = || {
            Some(Self {
                messages: get("messages")?.parse().ok()?,
                head: Hash(from_hex(get("head")?)?),
                is_final: get("final")?.parse().ok()?,
                signature: from_hex(get("signature")?)?,
            })
        };
        parsed().ok_or_else(|| {
            "it has not the entries messages, head, final and signature of a seal".to_owned()
        })
    }

    /// The content of the attachment that repeats the final seal.
    pub fn to_json(&self, beginning: &Beginning) -> Json {
        let previous = beginning.previous.as_ref();
        json!({
            "format": SEAL,
            "version": VERSION,
            "public_key": beginning.public_key.to_string(),
            "key": if beginning.fresh_key { "fresh" } else { "given" },
            "session": to_hex(&beginning.session),
            "recording": beginning.recording,
            "previous": previous.map(|it| &it.name),
            "previous_head": previous.map(|it| it.head.to_string()),
            "messages": self.messages,
            "head": self.head.to_string(),
            "final": self.is_final,
            "signature": to_hex(&self.signature),
        })
    }
}

/// Seals a recording while it is written.
#[derive(Debug)]
pub(crate) struct Sealer {
    key: SealKey,
    beginning: Beginning,
    chain: Chain,
    /// What the last seal that was made has signed, or the head after the beginning.
    signed: Hash,
}

impl Sealer {
    /// Also returns the first metadata record of the recording.
    pub fn new(key: SealKey, beginning: Beginning) -> (Self, Metadata) {
        let record = beginning.to_record();
        let mut chain = Chain::new();
        chain.add_metadata(&record);
        let sealer = Self {
            key,
            beginning,
            signed: chain.head(),
            chain,
        };
        (sealer, record)
    }

    /// The chain over what was written.
    pub fn chain(&mut self) -> &mut Chain {
        &mut self.chain
    }

    /// What the last seal has signed.
    pub fn signed(&self) -> Hash {
        self.signed
    }

    /// A seal of what was written since the last one; `None` if nothing was.
    pub fn seal(&mut self) -> Option<Metadata> {
        (self.signed != self.chain.head()).then(|| self.make(false).to_record())
    }

    /// The last seal, and the attachment that repeats it; `time` is that of the last message \[ns\].
    pub fn last(&mut self, time: u64) -> (Metadata, Attachment<'static>) {
        let seal = self.make(true);
        let attachment = Attachment {
            log_time: time,
            create_time: time,
            name: SEAL.to_owned(),
            media_type: "application/json".to_owned(),
            data: format!("{:#}\n", seal.to_json(&self.beginning))
                .into_bytes()
                .into(),
        };
        (seal.to_record(), attachment)
    }

    fn make(&mut self, is_final: bool) -> SealRecord {
        self.signed = self.chain.head();
        SealRecord::new(&self.chain, &self.key, is_final)
    }
}
