//! Forges recordings record by record, with everything else kept: the tools of somebody who wants to change evidence.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use mcap::records::{Channel, MessageHeader, Metadata, Record, SchemaHeader};
use mcap::sans_io::{LinearReadEvent, LinearReader};
use mcap::{Attachment, WriteOptions};

use super::random_damage::Random;

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

/// Number of kinds of [changes](Parts::change_one).
pub const KINDS: usize = 8;

/// A file, taken apart.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Parts {
    pub schemas: BTreeMap<u16, (SchemaHeader, Vec<u8>)>,
    pub channels: BTreeMap<u16, Channel>,
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

    /// The channels of messages.
    fn used_channels(&self) -> Vec<u16> {
        let used = |id: &u16| {
            let is_of_it =
                |it: &Kept| matches!(it, Kept::Message(header, _) if header.channel_id == *id);
            self.records.iter().any(is_of_it)
        };
        self.channels.keys().copied().filter(used).collect()
    }

    fn channel(&mut self, id: u16) -> &mut Channel {
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

    /// One change of one message, or of the definition of its topic.
    pub fn change_one(&mut self, kind: usize, random: &mut Random) {
        let positions = self.messages();
        let index = random.below(positions.len());
        let position = positions[index];
        let step = 1 + random.next() % 1_000_000_000;
        match kind {
            0 => {
                let (_, data) = self.message(index);
                let at = random.below(data.len());
                data[at] ^= 1 << random.below(8);
            }
            1 => {
                self.records.remove(position);
            }
            2 => {
                let twice = self.records[position].clone();
                let to = positions[random.below(positions.len())];
                self.records.insert(to, twice);
            }
            3 => {
                let moved = self.records.remove(position);
                let to = self.messages()[random.below(positions.len() - 1)];
                self.records.insert(to, moved);
            }
            4 => self.message(index).0.log_time += step,
            5 => self.message(index).0.publish_time -= step,
            6 => {
                let (header, data) = self.message(index);
                match random.below(3) {
                    0 => header.sequence ^= 1 << random.below(32),
                    1 => data.push(0),
                    _ => data.truncate(data.len() - 1),
                }
            }
            _ => {
                let ids = self.used_channels();
                let channel = self.channel(ids[random.below(ids.len())]);
                match random.below(4) {
                    0 => channel.topic.push('x'),
                    1 => channel.message_encoding.push('x'),
                    2 => channel
                        .metadata
                        .insert("note".to_owned(), "x".to_owned())
                        .map_or((), |_| ()),
                    _ => channel.metadata.clear(),
                }
            }
        }
    }
}
