//! Forges recordings record by record, with everything else kept: the tools of somebody who wants to change evidence.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use ed25519_dalek::{Signer as _, SigningKey};
use mcap::records::{Channel, MessageHeader, Metadata, Record, SchemaHeader};
use mcap::sans_io::{LinearReadEvent, LinearReader};
use mcap::{Attachment, WriteOptions};
use sha2::{Digest as _, Sha256};

pub const BEGIN: &str = "rosbag2_mcap/seal_begin";
pub const SEAL: &str = "rosbag2_mcap/seal";

/// A record of the data of a file.
#[derive(Debug, Clone, PartialEq)]
pub enum Kept {
    Message(MessageHeader, Vec<u8>),
    Metadata(Metadata),
    Attachment(String, Vec<u8>),
}

impl Kept {
    pub fn is_message(&self) -> bool {
        matches!(self, Self::Message(..))
    }

    pub fn is_seal(&self) -> bool {
        match self {
            Self::Message(..) => false,
            Self::Metadata(it) => it.name == SEAL || it.name == BEGIN,
            Self::Attachment(name, _) => name == SEAL,
        }
    }
}

/// A file, taken apart.
#[derive(Debug, Clone, Default)]
pub struct Parts {
    schemas: BTreeMap<u16, (SchemaHeader, Vec<u8>)>,
    channels: BTreeMap<u16, Channel>,
    pub records: Vec<Kept>,
}

impl Parts {
    pub fn read(path: &Path) -> Self {
        let bytes = fs::read(path).unwrap();
        let mut source = &bytes[..];
        let mut reader = LinearReader::new();
        let mut parts = Self::default();
        while let Some(event) = reader.next_event() {
            match event.unwrap() {
                LinearReadEvent::ReadRequest(wanted) => {
                    let wanted = wanted.min(source.len());
                    reader.insert(wanted).copy_from_slice(&source[..wanted]);
                    reader.notify_read(wanted);
                    source = &source[wanted..];
                }
                LinearReadEvent::Record { opcode, data } => {
                    match mcap::parse_record(opcode, data).unwrap().into_owned() {
                        Record::DataEnd(_) => break,
                        Record::Schema { header, data } => {
                            parts.schemas.insert(header.id, (header, data.into_owned()));
                        }
                        Record::Channel(channel) => {
                            parts.channels.insert(channel.id, channel);
                        }
                        Record::Message { header, data } => {
                            parts.records.push(Kept::Message(header, data.into_owned()));
                        }
                        Record::Metadata(it) => parts.records.push(Kept::Metadata(it)),
                        Record::Attachment { header, data, .. } => {
                            let kept = Kept::Attachment(header.name, data.into_owned());
                            parts.records.push(kept);
                        }
                        _ => {}
                    }
                }
            }
        }
        parts
    }

    /// Writes a file with correct checksums, indexes and statistics.
    pub fn write(&self, path: &Path) {
        let mut writer = WriteOptions::new()
            .profile("ros2")
            .compression(None)
            .create(std::io::Cursor::new(Vec::new()))
            .unwrap();
        for (id, (header, data)) in &self.schemas {
            writer
                .add_schema_with_id(*id, &header.name, &header.encoding, data)
                .unwrap();
        }
        for (id, it) in &self.channels {
            writer
                .add_channel_with_id(
                    *id,
                    it.schema_id,
                    &it.topic,
                    &it.message_encoding,
                    &it.metadata,
                )
                .unwrap();
        }
        for record in &self.records {
            match record {
                Kept::Message(header, data) => writer.write_to_known_channel(header, data).unwrap(),
                Kept::Metadata(it) => writer.write_metadata(it).unwrap(),
                Kept::Attachment(name, data) => writer
                    .attach(&Attachment {
                        log_time: 0,
                        create_time: 0,
                        name: name.clone(),
                        media_type: "application/json".to_owned(),
                        data: data.clone().into(),
                    })
                    .unwrap(),
            }
        }
        writer.finish().unwrap();
        fs::write(path, writer.into_inner().into_inner()).unwrap();
    }

    /// Positions of the messages.
    pub fn messages(&self) -> Vec<usize> {
        let records = self.records.iter().enumerate();
        records
            .filter(|(_, it)| it.is_message())
            .map(|(index, _)| index)
            .collect()
    }

    /// The contents of the messages.
    pub fn contents(&self) -> Vec<&Kept> {
        self.records.iter().filter(|it| it.is_message()).collect()
    }

    pub fn message(&mut self, index: usize) -> (&mut MessageHeader, &mut Vec<u8>) {
        let position = self.messages()[index];
        match &mut self.records[position] {
            Kept::Message(header, data) => (header, data),
            _ => unreachable!(),
        }
    }

    pub fn channel_ids(&self) -> Vec<u16> {
        self.channels.keys().copied().collect()
    }

    pub fn channel(&mut self, id: u16) -> &mut Channel {
        self.channels.get_mut(&id).unwrap()
    }

    /// The entries of the `index`-th seal.
    pub fn seal(&mut self, index: usize) -> &mut BTreeMap<String, String> {
        let mut seals = self.records.iter_mut().filter_map(|it| match it {
            Kept::Metadata(it) if it.name == SEAL => Some(&mut it.metadata),
            _ => None,
        });
        seals.nth(index).unwrap()
    }

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
