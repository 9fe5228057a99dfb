//! Makes seals again for forged recordings, independently of the crate: by `docs/seal.md`.

use std::collections::BTreeMap;

use ed25519_dalek::{Signer as _, SigningKey};
use mcap::records::Channel;
use sha2::{Digest as _, Sha256};

use super::forging::{BEGIN, Kept, Parts, SEAL};

impl Parts {
    /// Computes all seals again for what is in the file now; without a key, the signatures stay as they are. The public key in
    /// the beginning stays as it is.
    pub fn seal_again(&mut self, key: Option<&SigningKey>) {
        let topics: BTreeMap<u16, Vec<u8>> = self
            .channels
            .iter()
            .map(|(id, it)| (*id, self.topic_hash(it)))
            .collect();
        let mut head = Sha256::digest(b"rosbag2_mcap chain 1\n").to_vec();
        let (mut messages, mut public_key) = (0_u64, String::new());
        let mut last = BTreeMap::new();
        for record in &mut self.records {
            match record {
                Kept::Message(header, data) => {
                    let mut hash = Sha256::new();
                    hash.update(&head);
                    hash.update([1]);
                    hash.update(&topics[&header.channel_id]);
                    hash.update(header.sequence.to_le_bytes());
                    hash.update(header.log_time.to_le_bytes());
                    hash.update(header.publish_time.to_le_bytes());
                    add_text(&mut hash, data);
                    head = hash.finalize().to_vec();
                    messages += 1;
                }
                Kept::Metadata(it) if it.name == SEAL => {
                    let entries = &mut it.metadata;
                    entries.insert("messages".to_owned(), messages.to_string());
                    entries.insert("head".to_owned(), hex(&head));
                    if let Some(key) = key {
                        let mut signed = b"rosbag2_mcap seal 1\n".to_vec();
                        signed.extend(key.verifying_key().to_bytes());
                        signed.push(u8::from(entries["final"] == "true"));
                        signed.extend(messages.to_le_bytes());
                        signed.extend(&head);
                        entries.insert("signature".to_owned(), hex(&key.sign(&signed).to_bytes()));
                    }
                    last = entries.clone();
                }
                Kept::Metadata(it) => {
                    if it.name == BEGIN {
                        public_key.clone_from(&it.metadata["public_key"]);
                    }
                    let mut hash = Sha256::new();
                    hash.update(&head);
                    hash.update([2]);
                    add_text(&mut hash, it.name.as_bytes());
                    add_map(&mut hash, &it.metadata);
                    head = hash.finalize().to_vec();
                }
                Kept::Attachment(_, content) => {
                    let mut text: serde_json::Value = serde_json::from_slice(content).unwrap();
                    for entry in ["head", "signature"] {
                        text[entry] = last[entry].clone().into();
                    }
                    text["messages"] = messages.into();
                    text["public_key"] = public_key.clone().into();
                    *content = format!("{text:#}\n").into_bytes();
                }
            }
        }
    }

    fn topic_hash(&self, channel: &Channel) -> Vec<u8> {
        let (schema, text) = &self.schemas[&channel.schema_id];
        let mut hash = Sha256::new();
        hash.update(b"rosbag2_mcap topic 1\n");
        for text in [
            channel.topic.as_bytes(),
            schema.name.as_bytes(),
            schema.encoding.as_bytes(),
            text,
            channel.message_encoding.as_bytes(),
        ] {
            add_text(&mut hash, text);
        }
        add_map(&mut hash, &channel.metadata);
        hash.finalize().to_vec()
    }
}

pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
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
