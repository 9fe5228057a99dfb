//! The hash chain over the content of a recording, in the order of the file. `docs/seal.md` specifies the same bytes.
//!
//! The numbers are little endian. `text` is a length of 8 bytes and the bytes of the text, `map` is a number of entries of
//! 8 bytes and, in the order of the keys, the `text` of each key and value.
//!
//! - The head of an empty chain is SHA-256 of `rosbag2_mcap chain 1\n`.
//! - A message makes it SHA-256 of: head (32 bytes), `01`, hash of its topic (32 bytes), sequence (4 bytes), log time (8 bytes),
//!   publish time (8 bytes), length of the data (8 bytes), data.
//! - A metadata record makes it SHA-256 of: head (32 bytes), `02`, `text` of its name, `map` of its entries.
//! - The hash of a topic is SHA-256 of: `rosbag2_mcap topic 1\n`, then the `text` of its name, of the name of its type, of the
//!   encoding of the schema, of the schema and of the encoding of the messages, then the `map` of the channel's metadata.
//!
//! Seals are not part of the chain.

use std::collections::BTreeMap;
use std::fmt;

use mcap::records::{MessageHeader, Metadata};
use sha2::{Digest as _, Sha256};

const CHAIN: &[u8] = b"rosbag2_mcap chain 1\n";
const TOPIC: &[u8] = b"rosbag2_mcap topic 1\n";
const MESSAGE: u8 = 1;
const METADATA: u8 = 2;

/// A SHA-256.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Hash(pub [u8; 32]);

impl fmt::Display for Hash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&to_hex(&self.0))
    }
}

impl fmt::Debug for Hash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// Hexadecimal digits.
pub(crate) fn to_hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let digit = |nibble: u8| char::from(DIGITS[usize::from(nibble)]);
    bytes
        .iter()
        .flat_map(|byte| [digit(byte >> 4), digit(byte & 15)])
        .collect()
}

/// Bytes from exactly twice as many hexadecimal digits.
pub(crate) fn from_hex<const N: usize>(text: &str) -> Option<[u8; N]> {
    let digits = text.as_bytes();
    if digits.len() != 2 * N {
        return None;
    }
    let value = |digit: u8| char::from(digit).to_digit(16);
    let mut bytes = [0; N];
    for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
        *byte = u8::try_from(16 * value(pair[0])? + value(pair[1])?).ok()?;
    }
    Some(bytes)
}

/// The chain up to some record.
#[derive(Debug, Clone)]
pub(crate) struct Chain {
    head: Hash,
    messages: u64,
}

impl Chain {
    pub fn new() -> Self {
        Self {
            head: finish(Sha256::new().chain_update(CHAIN)),
            messages: 0,
        }
    }

    /// The last link.
    pub fn head(&self) -> Hash {
        self.head
    }

    /// Number of messages in the chain.
    pub fn messages(&self) -> u64 {
        self.messages
    }

    /// Adds a message of the topic with this hash.
    pub fn add_message(&mut self, topic: &Hash, header: &MessageHeader, data: &[u8]) {
        let mut fixed = [0; 32 + 1 + 32 + 4 + 8 + 8 + 8];
        let mut at = 0;
        let mut put = |bytes: &[u8]| {
            fixed[at..at + bytes.len()].copy_from_slice(bytes);
            at += bytes.len();
        };
        put(&self.head.0);
        put(&[MESSAGE]);
        put(&topic.0);
        put(&header.sequence.to_le_bytes());
        put(&header.log_time.to_le_bytes());
        put(&header.publish_time.to_le_bytes());
        put(&(data.len() as u64).to_le_bytes());
        self.head = finish(Sha256::new().chain_update(fixed).chain_update(data));
        self.messages += 1;
    }

    /// Adds a metadata record.
    pub fn add_metadata(&mut self, metadata: &Metadata) {
        let mut hash = Sha256::new();
        hash.update(self.head.0);
        hash.update([METADATA]);
        add_text(&mut hash, metadata.name.as_bytes());
        add_map(&mut hash, &metadata.metadata);
        self.head = finish(hash);
    }
}

/// What a topic contributes to the links of its messages: its name, type, encodings and metadata.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TopicTexts<'a> {
    pub name: &'a str,
    pub type_name: &'a str,
    pub schema_encoding: &'a str,
    pub schema: &'a [u8],
    pub message_encoding: &'a str,
    pub metadata: &'a BTreeMap<String, String>,
}

impl Default for TopicTexts<'_> {
    fn default() -> Self {
        static NOTHING: BTreeMap<String, String> = BTreeMap::new();
        Self {
            name: "",
            type_name: "",
            schema_encoding: "",
            schema: &[],
            message_encoding: "",
            metadata: &NOTHING,
        }
    }
}

impl TopicTexts<'_> {
    pub fn hash(&self) -> Hash {
        let mut hash = Sha256::new();
        hash.update(TOPIC);
        add_text(&mut hash, self.name.as_bytes());
        add_text(&mut hash, self.type_name.as_bytes());
        add_text(&mut hash, self.schema_encoding.as_bytes());
        add_text(&mut hash, self.schema);
        add_text(&mut hash, self.message_encoding.as_bytes());
        add_map(&mut hash, self.metadata);
        finish(hash)
    }
}

fn add_text(hash: &mut Sha256, text: &[u8]) {
    hash.update((text.len() as u64).to_le_bytes());
    hash.update(text);
}

fn add_map(hash: &mut Sha256, map: &BTreeMap<String, String>) {
    hash.update((map.len() as u64).to_le_bytes());
    for (key, value) in map {
        add_text(hash, key.as_bytes());
        add_text(hash, value.as_bytes());
    }
}

fn finish(hash: Sha256) -> Hash {
    Hash(hash.finalize().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_read_back() {
        let bytes: [u8; 4] = [0, 1, 0xab, 0xff];
        assert_eq!(to_hex(&bytes), "0001abff");
        assert_eq!(from_hex(&to_hex(&bytes)), Some(bytes));
        assert_eq!(from_hex("0001ABFF"), Some(bytes));
        for wrong in [
            "",
            "0001abf",
            "0001abff0",
            "0001abfg",
            "+001abff",
            "000 abff",
        ] {
            assert_eq!(from_hex::<4>(wrong), None, "{wrong:?}");
        }
    }

    /// Computed with hashlib of Python from the specification.
    #[test]
    fn the_links_are_as_specified() {
        let metadata = [
            ("b".to_owned(), "2".to_owned()),
            ("a".to_owned(), "1".to_owned()),
        ]
        .into();
        let topic = TopicTexts {
            name: "/text",
            type_name: "std_msgs/msg/String",
            schema_encoding: "ros2msg",
            schema: b"string data\n",
            message_encoding: "cdr",
            metadata: &metadata,
        };
        let header = MessageHeader {
            channel_id: 7,
            sequence: 3,
            log_time: 1_000,
            publish_time: 999,
        };
        let mut chain = Chain::new();
        let start = chain.head().to_string();
        chain.add_metadata(&Metadata {
            name: "name".to_owned(),
            metadata: metadata.clone(),
        });
        let noted = chain.head().to_string();
        chain.add_message(&topic.hash(), &header, b"\x00\x01\x00\x00data");
        let found = [
            start,
            noted,
            topic.hash().to_string(),
            chain.head().to_string(),
        ];
        assert_eq!(found, EXPECTED);
        assert_eq!(chain.messages(), 1);
    }

    const EXPECTED: [&str; 4] = [
        "cab7a006303336a1db463dac02dfe1d9ee0b3d1bf0f03db9c4da56d1a3ee95d7",
        "41a5b6dadaaf1beb96553cc778e8f358ec012b283a9b0f86069869092513c8f5",
        "e60f5c73da94f1324a006ebf51caa6014962db1da352164a4e48d41ecc4a222a",
        "375001c83dffd929a6ab17b60a0cca65020f9296e3ba7551effbda5b6ffba950",
    ];
}
