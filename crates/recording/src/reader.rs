//! Reads recordings of this crate and of other writers, whole or cut off.

use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::Attachment;
use mcap::records::{Channel, Header, MessageHeader, Metadata, Record, SchemaHeader};

use crate::chain::Hash;
use crate::compression::ChunkCompression;
use crate::declared::{Keys, Schema, hash_of, text_length};
use crate::error::RecordingError;
use crate::files::files_of;
use crate::keys::QOS_KEY;
use crate::notes::{Notes, REPAIR, REPEATED_CHECKPOINT, START, UNREAD};
use crate::predecessor::{self, Predecessor};
use crate::records::{FileEnd, RecordReader};
use crate::reordering::{Blocks, MAX_OUT_OF_ORDER, Reordering};
use crate::seal::SEAL;
use crate::seal_check::{Seal, SealCheck};
use crate::topic::OfferedQos;
use crate::wholeness::Wholeness;

/// Maximum number of topics of a recording; MCAP numbers them with 16 bits.
const MAX_TOPICS: usize = 65_536;

/// Maximum size of all schemas and metadata together \[bytes\].
const MAX_TEXT: usize = 64 << 20;

/// A message of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Name of its topic.
    pub topic: Arc<str>,
    /// ROS name of its type.
    pub type_name: Arc<str>,
    /// Index of its topic in [`Reader::topics`].
    pub topic_index: usize,
    /// When it was recorded \[ns\].
    pub log_time: i64,
    /// When it was sent \[ns\].
    pub publish_time: i64,
    /// Its bytes on the wire: encapsulation header, then CDR.
    pub data: Vec<u8>,
}

/// A topic of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedTopic {
    /// Its name.
    pub name: Arc<str>,
    /// ROS name of its type; empty if the recording does not contain it.
    pub type_name: Arc<str>,
    /// Encoding of its messages, `cdr` in ROS 2.
    pub encoding: String,
    /// Encoding of its schema, `ros2msg` or `ros2idl` in ROS 2.
    pub schema_encoding: String,
    /// Definition of its type.
    pub schema: Arc<[u8]>,
    /// Further metadata.
    pub metadata: BTreeMap<String, String>,
    /// The quality of service that its publisher offered.
    pub qos: Option<OfferedQos>,
    /// Number of its messages.
    pub messages: u64,
}

/// What a pass over all files finds.
#[derive(Debug, Default)]
struct Contents {
    profile: String,
    library: String,
    topics: Vec<RecordedTopic>,
    schemas: HashMap<Hash, Arc<Schema>>,
    /// The topics of the declarations so far, by a hash of what they declare.
    declared: HashMap<Hash, TopicOfChannel>,
    /// Indices of the topics by a hash of name, type and encodings.
    indices: HashMap<Hash, usize>,
    notes: Notes,
    text: usize,
    messages: u64,
    /// Messages that the files have according to their statistics, and that were not read.
    unread: u64,
    span: Option<(u64, u64)>,
    /// Log time of the last message.
    last: u64,
    out_of_order: u64,
    bytes: u64,
    compression: Option<ChunkCompression>,
    wholeness: Wholeness,
}

/// A recording that was read once; its messages can be read any number of times.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    files: Vec<PathBuf>,
    contents: Contents,
    /// The seal of each file.
    seals: Vec<Option<Seal>>,
    /// Smallest time from each block of messages on.
    min_from: Arc<[u64]>,
}

impl Reader {
    /// Opens the directory of a recording, or an `.mcap` file, and reads all of it. A file that is cut off or damaged
    /// can be opened, too: see [`wholeness`](Self::wholeness).
    ///
    /// # Errors
    /// The path does not exist, or is not a recording.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        Self::open_files(path, files_of(path)?)
    }

    pub(crate) fn open_files(path: &Path, files: Vec<PathBuf>) -> Result<Self, RecordingError> {
        let (mut contents, mut blocks) = (Contents::default(), Blocks::default());
        let mut seals = Vec::with_capacity(files.len());
        for file in &files {
            let mut pass = Pass::open(file)?;
            pass.records.check_index();
            let mut check = SealCheck::new();
            let noted_before = contents.notes.records.len();
            let mut noted_and_sealed = noted_before;
            let read_before = contents.messages;
            contents.bytes += pass.records.length();
            loop {
                match pass.next(&mut contents) {
                    Ok(Some(Item::Message(topic, header, data))) => {
                        check.message(&topic.hash, &header, &data);
                        blocks.add(header.log_time, data.len());
                        contents.count(topic.index, header.log_time);
                    }
                    Ok(Some(Item::Metadata(record))) => {
                        if check.metadata(&record) {
                            noted_and_sealed = contents.notes.records.len();
                        }
                        // Of the seals there may be many; the check has all that is needed of them.
                        if record.name != SEAL {
                            contents.notes.records.push((record.name, record.metadata));
                        }
                    }
                    Ok(Some(Item::SealAttachment(attachment))) => {
                        check.attachment(&attachment.data)
                    }
                    Ok(None) => break,
                    Err(fault @ RecordingError::Damaged { .. }) => {
                        pass.records.note_unreadable(&fault);
                        contents.wholeness.note_damage(&fault)
                    }
                    Err(other) => return Err(other),
                }
                if check.is_unsealed() {
                    pass.records.drop_index_check();
                }
            }
            let is_repaired = contents.notes.records[noted_before..]
                .iter()
                .any(|(name, _)| name.ends_with(REPAIR));
            let end = pass.records.end();
            let is_ended = end == Some(FileEnd::Whole) && !is_repaired;
            let seal = check.finish(is_ended, pass.records.index_fault()?);
            if seal.is_some() {
                let noted = contents.notes.records.len();
                contents.notes.unsealed.push(noted_and_sealed..noted);
            }
            seals.push(seal);
            let read = contents.messages - read_before;
            let stated = pass.records.stated_messages().unwrap_or(read);
            contents.unread = contents.unread.saturating_add(stated.saturating_sub(read));
            contents.wholeness.note_end(file, end);
            contents.compression = pass.records.compression().or(contents.compression);
        }
        Ok(Self {
            path: path.to_path_buf(),
            files,
            contents,
            seals,
            min_from: blocks.finish().into(),
        })
    }

    /// The path that was opened.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The files, in the order in which they are read.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Size of all files \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.contents.bytes
    }

    /// All declared topics, also those without messages.
    #[must_use]
    pub fn topics(&self) -> &[RecordedTopic] {
        &self.contents.topics
    }

    /// Number of messages that can be read.
    #[must_use]
    pub fn message_count(&self) -> u64 {
        self.contents.messages
    }

    /// Number of messages that could not be read here, or when the recording was repaired, as far as the files tell.
    #[must_use]
    pub fn unread_messages(&self) -> u64 {
        let repaired = self.repair_notes();
        let left_out = repaired.and_then(|notes| notes.get(UNREAD)?.parse().ok());
        self.contents.unread.saturating_add(left_out.unwrap_or(0))
    }

    /// First and last time \[ns\]; `None` without messages.
    #[must_use]
    pub fn span(&self) -> Option<(i64, i64)> {
        self.contents
            .span
            .map(|(first, last)| (nanos(first), nanos(last)))
    }

    /// Number of messages that are recorded after one with a later log time.
    #[must_use]
    pub fn out_of_order(&self) -> u64 {
        self.contents.out_of_order
    }

    /// Whether the recording could not wait for a checkpoint: it begins with a copy of the last one, and an earlier recording
    /// has the messages that followed it.
    #[must_use]
    pub fn repeats_checkpoint(&self) -> bool {
        self.start_notes()
            .is_some_and(|notes| notes.contains_key(REPEATED_CHECKPOINT))
    }

    /// Number of damaged records that are left out here, or were left out when the recording was repaired. What a final seal
    /// covers was not damaged, whatever a note behind it says.
    #[must_use]
    pub fn damaged_records(&self) -> u64 {
        let is_proved = |it: &Option<Seal>| it.as_ref().is_some_and(|it| it.holds() && it.is_final);
        let repaired = self
            .repair_notes()
            .filter(|_| !self.seals.iter().all(is_proved));
        let left_out = repaired.and_then(|notes| notes.get("damaged_records")?.parse().ok());
        self.wholeness()
            .damaged
            .saturating_add(left_out.unwrap_or(0))
    }

    /// Profile of the first file; `ros2` for ROS 2.
    #[must_use]
    pub fn profile(&self) -> &str {
        &self.contents.profile
    }

    /// The library that wrote the first file.
    #[must_use]
    pub fn library(&self) -> &str {
        &self.contents.library
    }

    /// Compression of the chunks; if they differ, that of the last chunk.
    #[must_use]
    pub fn compression(&self) -> ChunkCompression {
        self.contents.compression.unwrap_or(ChunkCompression::None)
    }

    /// All metadata records, in their order.
    #[must_use]
    pub fn metadata(&self) -> &[(String, BTreeMap<String, String>)] {
        &self.contents.notes.records
    }

    /// Whether everything can be read.
    #[must_use]
    pub fn wholeness(&self) -> &Wholeness {
        &self.contents.wholeness
    }

    /// The seal of each of the [`files`](Self::files), with the result of its check; `None` for a file without a seal.
    #[must_use]
    pub fn seals(&self) -> &[Option<Seal>] {
        &self.seals
    }

    /// Looks for the recording before this one in the folder that contains the directory of this recording, and reads it;
    /// [`Predecessor::None`] without a seal that holds.
    #[must_use]
    pub fn predecessor(&self) -> Predecessor {
        match (self.files.first(), self.seals.first()) {
            (Some(file), Some(Some(seal))) if seal.holds() => predecessor::find(file, seal),
            _ => Predecessor::None,
        }
    }

    /// A recording in the same folder that continues one with the name of this one, but not this one, which was changed or put
    /// in its place; `None` without a seal that holds.
    #[must_use]
    pub fn contradicting_successor(&self) -> Option<PathBuf> {
        match (self.files.first(), self.seals.first()) {
            (Some(file), Some(Some(seal))) if seal.holds() => {
                predecessor::contradicting_successor(file, seal)
            }
            _ => None,
        }
    }

    /// Name of the program that wrote the recording with this crate; `None` for a recording of another writer.
    #[must_use]
    pub fn application(&self) -> Option<&str> {
        let names = self.contents.notes.records.iter().map(|(name, _)| name);
        names.filter_map(|name| name.strip_suffix(START)).next()
    }

    /// The notes that the program wrote at the beginning; `None` for a recording of another writer.
    #[must_use]
    pub fn start_notes(&self) -> Option<&BTreeMap<String, String>> {
        self.contents.notes.of_kind(START).next()
    }

    /// From what the recording was repaired, and why; `None` for one that was not repaired.
    #[must_use]
    pub fn repair_notes(&self) -> Option<&BTreeMap<String, String>> {
        self.contents.notes.of_kind(REPAIR).next()
    }

    /// The last count of messages that the recorder could not record; `None` if there is none: in a recording of
    /// another writer, or in one that was cut off before anything was lost. In a sealed file, only what the seal covers counts.
    #[must_use]
    pub fn lost_messages(&self) -> Option<u64> {
        self.contents.notes.lost_messages()
    }

    /// Why the recorder ended the recording: `stopped`, `rotated`, `no_room` or `repaired`; `None` if it did not end it. Behind
    /// its last seal, a file can only say that it was repaired.
    #[must_use]
    pub fn ended(&self) -> Option<&str> {
        self.contents.notes.ended()
    }

    /// Whether the recording was cut off before it was repaired, so that the number of lost messages is unknown.
    #[must_use]
    pub fn was_cut_off(&self) -> bool {
        self.contents.notes.was_cut_off()
    }

    /// All messages in the order of their log times; messages with equal times in the order in which they were written.
    #[must_use]
    pub fn messages(&self) -> Messages<'_> {
        Messages {
            reader: self,
            next_file: 0,
            pass: None,
            reordering: Reordering::new(Arc::clone(&self.min_from)),
            scratch: Contents::default(),
            ended: false,
        }
    }

    /// Passes all messages, metadata records and seals in the order in which they were written, without what is damaged.
    pub(crate) fn for_each_as_written(
        &self,
        mut receive: impl FnMut(Item) -> Result<(), RecordingError>,
    ) -> Result<(), RecordingError> {
        let mut scratch = Contents::default();
        for file in &self.files {
            let mut pass = Pass::open(file)?;
            loop {
                match pass.next(&mut scratch) {
                    Ok(Some(item)) => receive(item)?,
                    Ok(None) => break,
                    // It was counted when the recording was opened.
                    Err(RecordingError::Damaged { .. }) => {}
                    Err(error) => return Err(error),
                }
            }
        }
        Ok(())
    }
}

/// One pass over one file.
struct Pass {
    records: RecordReader,
    schemas: HashMap<u16, Arc<Schema>>,
    /// Topics of the channels.
    channels: HashMap<u16, TopicOfChannel>,
}

/// The topic of a channel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TopicOfChannel {
    /// Index among the topics.
    pub index: usize,
    /// What it contributes to the links of the chain.
    hash: Hash,
}

/// Something that a pass comes to.
pub(crate) enum Item {
    Message(TopicOfChannel, MessageHeader, Vec<u8>),
    /// A metadata record, or a seal.
    Metadata(Metadata),
    /// The attachment that repeats the final seal.
    SealAttachment(Attachment<'static>),
}

impl Pass {
    fn open(file: &Path) -> Result<Self, RecordingError> {
        Ok(Self {
            records: RecordReader::open(file)?,
            schemas: HashMap::new(),
            channels: HashMap::new(),
        })
    }

    /// The next message with its topic, or the next record about the recording; topics go into `contents`.
    fn next(&mut self, contents: &mut Contents) -> Result<Option<Item>, RecordingError> {
        while let Some(record) = self.records.next()? {
            let noted = match record {
                Record::Message { header, data } => match self.channels.get(&header.channel_id) {
                    Some(topic) => {
                        return Ok(Some(Item::Message(*topic, header, data.into_owned())));
                    }
                    None => Err(format!(
                        "a message has channel {}, which the file does not declare",
                        header.channel_id
                    )),
                },
                Record::Metadata(metadata) => match contents.add_metadata_text(&metadata) {
                    Ok(()) => return Ok(Some(Item::Metadata(metadata))),
                    Err(reason) => Err(reason),
                },
                Record::Attachment { header, data, .. } if header.name == SEAL => {
                    return Ok(Some(Item::SealAttachment(Attachment {
                        log_time: header.log_time,
                        create_time: header.create_time,
                        name: header.name,
                        media_type: header.media_type,
                        data,
                    })));
                }
                other => self.note(other, contents),
            };
            noted.map_err(|reason| self.records.damaged(reason))?;
        }
        Ok(None)
    }

    fn note(&mut self, record: Record<'_>, contents: &mut Contents) -> Result<(), String> {
        match record {
            Record::Header(header) => contents.note_header(header),
            Record::Schema { header, data } => {
                let id = header.id;
                let known = self.schemas.get(&id);
                // Some writers repeat the schemas in every chunk.
                let is_known = known.is_some_and(|known| known.is(&header, &data));
                if !is_known {
                    let schema = contents.schema_of(header, data.into_owned())?;
                    self.schemas.insert(id, schema);
                }
            }
            Record::Channel(channel) => {
                let id = channel.id;
                let schema = self.schemas.get(&channel.schema_id);
                let topic = contents.topic_of(channel, schema)?;
                self.channels.insert(id, topic);
            }
            _ => {}
        }
        Ok(())
    }
}

impl Contents {
    fn note_header(&mut self, header: Header) {
        if self.library.is_empty() && self.profile.is_empty() {
            self.profile = header.profile;
            self.library = header.library;
        }
    }

    /// Counts the text that is kept in memory.
    fn add_text(&mut self, bytes: usize) -> Result<(), String> {
        self.text += bytes;
        match self.text <= MAX_TEXT {
            true => Ok(()),
            false => Err(format!(
                "expected at most {} MiB of schemas and metadata, found more",
                MAX_TEXT >> 20
            )),
        }
    }

    /// Counts the text of a metadata record. Seals are not kept, and not counted.
    fn add_metadata_text(&mut self, record: &Metadata) -> Result<(), String> {
        match record.name.as_str() {
            SEAL => Ok(()),
            name => self.add_text(name.len() + text_length(&record.metadata)),
        }
    }

    /// A schema; equal schemas are kept once.
    fn schema_of(&mut self, header: SchemaHeader, data: Vec<u8>) -> Result<Arc<Schema>, String> {
        let schema = Schema::new(header, data);
        if let Some(known) = self.schemas.get(&schema.hash) {
            return Ok(Arc::clone(known));
        }
        self.add_text(schema.length())?;
        let schema = Arc::new(schema);
        self.schemas.insert(schema.hash, Arc::clone(&schema));
        Ok(schema)
    }

    /// The topic of a channel; channels with equal texts have the same topic.
    fn topic_of(
        &mut self,
        channel: Channel,
        schema: Option<&Arc<Schema>>,
    ) -> Result<TopicOfChannel, String> {
        let keys = Keys::of(&channel, schema);
        if let Some(topic) = self.declared.get(&keys.declaration) {
            return Ok(*topic);
        }
        if self.declared.len() >= MAX_TOPICS {
            return Err(format!("expected at most {MAX_TOPICS} topics, found more"));
        }
        let text = schema.map_or(0, |it| it.text.len());
        self.add_text(channel.topic.len() + text_length(&channel.metadata) + text)?;
        let hash = hash_of(&channel, schema);
        let index = match self.indices.get(&keys.topic) {
            Some(index) => *index,
            None => {
                self.topics.push(RecordedTopic {
                    type_name: schema.map_or("", |it| &it.name).into(),
                    schema_encoding: schema.map_or_else(String::new, |it| it.encoding.clone()),
                    schema: schema.map_or_else(|| [].into(), |it| Arc::clone(&it.text)),
                    qos: channel
                        .metadata
                        .get(QOS_KEY)
                        .and_then(|yaml| OfferedQos::from_yaml(yaml)),
                    name: channel.topic.into(),
                    encoding: channel.message_encoding,
                    metadata: channel.metadata,
                    messages: 0,
                });
                self.indices.insert(keys.topic, self.topics.len() - 1);
                self.topics.len() - 1
            }
        };
        let topic = TopicOfChannel { index, hash };
        self.declared.insert(keys.declaration, topic);
        Ok(topic)
    }

    fn count(&mut self, topic: usize, time: u64) {
        self.messages += 1;
        self.out_of_order += u64::from(time < self.last);
        self.last = time;
        if let Some(topic) = self.topics.get_mut(topic) {
            topic.messages += 1;
        }
        self.span = Some(self.span.map_or((time, time), |(first, last)| {
            (first.min(time), last.max(time))
        }));
    }
}

/// The messages of a recording, in order. After [damage](RecordingError::Damaged) the messages that follow can be read;
/// any other error ends the iteration.
pub struct Messages<'a> {
    reader: &'a Reader,
    next_file: usize,
    pass: Option<Pass>,
    reordering: Reordering<Message>,
    /// Collects what the first pass has found already.
    scratch: Contents,
    ended: bool,
}

impl Messages<'_> {
    /// Reads the next message, or reaches the end.
    fn read(&mut self) -> Result<(), RecordingError> {
        let Some(pass) = &mut self.pass else {
            let Some(file) = self.reader.files.get(self.next_file) else {
                self.ended = true;
                return Ok(());
            };
            self.next_file += 1;
            self.pass = Some(Pass::open(file)?);
            return Ok(());
        };
        let (topic_index, header, data) = match pass.next(&mut self.scratch)? {
            Some(Item::Message(topic, header, data)) => (topic.index, header, data),
            Some(Item::Metadata(_) | Item::SealAttachment(_)) => return Ok(()),
            None => {
                self.pass = None;
                return Ok(());
            }
        };
        let Some(topic) = self.reader.contents.topics.get(topic_index) else {
            return Err(RecordingError::Changed {
                path: self.reader.path.clone(),
            });
        };
        let message = Message {
            topic: Arc::clone(&topic.name),
            type_name: Arc::clone(&topic.type_name),
            topic_index,
            log_time: nanos(header.log_time),
            publish_time: nanos(header.publish_time),
            data,
        };
        self.reordering
            .push(header.log_time, message.data.len(), message);
        if self.reordering.held_bytes() > MAX_OUT_OF_ORDER {
            return Err(RecordingError::OutOfOrder {
                path: self.reader.path.clone(),
            });
        }
        Ok(())
    }
}

impl Iterator for Messages<'_> {
    type Item = Result<Message, RecordingError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if self.ended {
                return self.reordering.take().map(Ok);
            }
            if let Some(message) = self.reordering.pop() {
                return Some(Ok(message));
            }
            match self.read() {
                Ok(()) => {}
                Err(fault @ RecordingError::Damaged { .. }) => return Some(Err(fault)),
                Err(error) => {
                    // The messages that are held would not be complete.
                    self.ended = true;
                    while self.reordering.take().is_some() {}
                    return Some(Err(error));
                }
            }
        }
    }
}

impl fmt::Debug for Messages<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Messages")
            .field("of", &self.reader.path)
            .finish_non_exhaustive()
    }
}

/// Times after the year 2262 are cut off there.
fn nanos(time: u64) -> i64 {
    i64::try_from(time).unwrap_or(i64::MAX)
}
