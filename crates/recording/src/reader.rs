//! Reads recordings: ours and those of others, whole or cut off.

use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::records::{Channel, Header, MessageHeader, Record, SchemaHeader};

use crate::bag_metadata::{METADATA_FILE, read_file_names};
use crate::compression::ChunkCompression;
use crate::error::RecordingError;
use crate::records::{FileEnd, RecordReader};
use crate::reordering::{Blocks, Reordering};
use crate::retention::mcap_files;
use crate::storage::is_being_written;
use crate::topic::OfferedQos;
use crate::writer::{LOSSES, QOS_KEY, REPAIR, START};

/// Most bytes of messages that are held to put them in order.
pub const MAX_OUT_OF_ORDER: usize = 256 << 20;

/// Most topics of a recording; MCAP numbers them with 16 bits.
const MAX_TOPICS: usize = 65_536;

/// Most bytes of all schemas and metadata together.
const MAX_TEXT: usize = 64 << 20;

/// Most faults of which the words are kept; all are counted.
const MAX_FAULTS: usize = 20;

/// A message of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Name of its topic.
    pub topic: Arc<str>,
    /// ROS name of its type.
    pub type_name: Arc<str>,
    /// Its place in [`Reader::topics`].
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
    /// ROS name of its type; empty where the recording does not say it.
    pub type_name: Arc<str>,
    /// Encoding of its messages, `cdr` in ROS 2.
    pub encoding: String,
    /// Encoding of its schema, `ros2msg` or `ros2idl` in ROS 2.
    pub schema_encoding: String,
    /// Definition of its type.
    pub schema: Arc<[u8]>,
    /// What the recording says of it besides.
    pub metadata: BTreeMap<String, String>,
    /// What its publisher offered.
    pub qos: Option<OfferedQos>,
    /// Number of its messages.
    pub messages: u64,
}

/// Whether all that was written to a recording is there and unharmed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Wholeness {
    /// Files without an end: name, and what they end with.
    pub cut_off: Vec<String>,
    /// Whether one of these ends in the middle of a record.
    pub ends_in_record: bool,
    /// Records and chunks that are damaged, and are left out.
    pub damaged: u64,
    /// What is wrong with the first of them.
    pub faults: Vec<String>,
}

impl Wholeness {
    /// Whether nothing is missing.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.cut_off.is_empty() && self.damaged == 0
    }
}

impl fmt::Display for Wholeness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_whole() {
            return f.write_str("whole");
        }
        f.write_str("not whole")?;
        for line in &self.cut_off {
            write!(f, "; {line}")?;
        }
        match (self.damaged, self.faults.first()) {
            (0, _) | (_, None) => Ok(()),
            (1, Some(fault)) => write!(f, "; {fault}"),
            (more, Some(first)) => write!(f, "; {more} records are damaged, the first: {first}"),
        }
    }
}

/// Messages and what is missing, counted.
#[derive(Debug, Default)]
struct Contents {
    profile: String,
    library: String,
    topics: Vec<RecordedTopic>,
    metadata: Vec<(String, BTreeMap<String, String>)>,
    text: usize,
    messages: u64,
    span: Option<(u64, u64)>,
    bytes: u64,
    compression: Option<ChunkCompression>,
    wholeness: Wholeness,
}

/// A recording that was looked through once; its messages can be read as often as wanted.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    files: Vec<PathBuf>,
    contents: Contents,
    /// Smallest time from each block of messages on.
    least_from: Arc<[u64]>,
}

impl Reader {
    /// Opens the directory of a recording, or an `.mcap` file, and reads it through. A file that is cut off or damaged is
    /// opened all the same: see [`wholeness`](Self::wholeness).
    ///
    /// # Errors
    /// There is nothing, or nothing that is a recording.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        Self::open_files(path, files_of(path)?)
    }

    pub(crate) fn open_files(path: &Path, files: Vec<PathBuf>) -> Result<Self, RecordingError> {
        let (mut contents, mut blocks) = (Contents::default(), Blocks::default());
        for file in &files {
            let mut pass = Pass::open(file)?;
            contents.bytes += pass.records.length();
            loop {
                match pass.next(&mut contents) {
                    Ok(Some((topic, header, data))) => {
                        blocks.add(header.log_time, data.len());
                        contents.count(topic, header.log_time);
                    }
                    Ok(None) => break,
                    Err(fault @ RecordingError::Damaged { .. }) => contents.note_damage(&fault),
                    Err(other) => return Err(other),
                }
            }
            contents.note_end(file, pass.records.end());
            contents.compression = pass.records.compression().or(contents.compression);
        }
        Ok(Self {
            path: path.to_path_buf(),
            files,
            contents,
            least_from: blocks.finish().into(),
        })
    }

    /// What was opened.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The files, in the order in which they are read.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Bytes of all files.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.contents.bytes
    }

    /// Every topic that is declared, also without messages.
    #[must_use]
    pub fn topics(&self) -> &[RecordedTopic] {
        &self.contents.topics
    }

    /// Number of messages that can be read.
    #[must_use]
    pub fn message_count(&self) -> u64 {
        self.contents.messages
    }

    /// First and last time \[ns\]; `None` without messages.
    #[must_use]
    pub fn span(&self) -> Option<(i64, i64)> {
        self.contents
            .span
            .map(|(first, last)| (nanos(first), nanos(last)))
    }

    /// Profile of the first file; `ros2` for ROS 2.
    #[must_use]
    pub fn profile(&self) -> &str {
        &self.contents.profile
    }

    /// Which library wrote the first file.
    #[must_use]
    pub fn library(&self) -> &str {
        &self.contents.library
    }

    /// ChunkCompression of its chunks; that of the last where they differ.
    #[must_use]
    pub fn compression(&self) -> ChunkCompression {
        self.contents.compression.unwrap_or(ChunkCompression::None)
    }

    /// All metadata records, in their order.
    #[must_use]
    pub fn metadata(&self) -> &[(String, BTreeMap<String, String>)] {
        &self.contents.metadata
    }

    /// Whether everything is there.
    #[must_use]
    pub fn wholeness(&self) -> &Wholeness {
        &self.contents.wholeness
    }

    /// Name of the program that wrote the recording with this crate; `None` for a recording of another writer.
    #[must_use]
    pub fn application(&self) -> Option<&str> {
        let names = self.contents.metadata.iter().map(|(name, _)| name);
        names.filter_map(|name| name.strip_suffix(START)).next()
    }

    /// The notes that the program wrote at the beginning; `None` for a recording of another writer.
    #[must_use]
    pub fn start_notes(&self) -> Option<&BTreeMap<String, String>> {
        self.notes(START).next()
    }

    /// From what the recording was repaired, and why; `None` for one that was not repaired.
    #[must_use]
    pub fn repair_notes(&self) -> Option<&BTreeMap<String, String>> {
        self.notes(REPAIR).next()
    }

    /// The last count of messages that the recorder could not record; `None` if there is none: in a recording of
    /// another writer, or in one that was cut off before anything was lost.
    #[must_use]
    pub fn lost_messages(&self) -> Option<u64> {
        let counts = self.notes(LOSSES);
        counts
            .filter_map(|entries| entries.get("lost_messages")?.parse().ok())
            .next_back()
    }

    /// Why the recorder ended the recording: `stopped`, `rotated`, `no_room` or `repaired`; `None` if it did not end it.
    #[must_use]
    pub fn ended(&self) -> Option<&str> {
        let last = self.notes(LOSSES).next_back()?;
        last.get("ended").map(String::as_str)
    }

    /// The metadata records of this kind.
    fn notes(&self, kind: &str) -> impl DoubleEndedIterator<Item = &BTreeMap<String, String>> {
        let records = self.contents.metadata.iter();
        records
            .filter(move |(name, _)| name.ends_with(kind))
            .map(|(_, entries)| entries)
    }

    /// All messages in the order of their log times; those of equal time in the order in which they were written.
    #[must_use]
    pub fn messages(&self) -> Messages<'_> {
        Messages {
            reader: self,
            next_file: 0,
            pass: None,
            reordering: Reordering::new(Arc::clone(&self.least_from)),
            scratch: Contents::default(),
            ended: false,
        }
    }

    /// All messages in the order in which they were written.
    pub(crate) fn messages_as_written(&self) -> Messages<'_> {
        Messages {
            // Nothing is waited for.
            reordering: Reordering::new([].into()),
            ..self.messages()
        }
    }
}

/// The files of what `path` names.
fn files_of(path: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    if !path.exists() {
        return Err(RecordingError::Missing {
            path: path.to_path_buf(),
        });
    }
    if !path.is_dir() {
        return Ok(vec![path.to_path_buf()]);
    }
    let metadata = path.join(METADATA_FILE);
    if !metadata.exists() {
        return Err(no_metadata(path)?);
    }
    let names = read_file_names(&metadata)?;
    names
        .into_iter()
        .map(|name| {
            let file = path.join(&name);
            match file.is_file() {
                true => Ok(file),
                false => Err(RecordingError::MissingFile {
                    path: metadata.clone(),
                    name,
                }),
            }
        })
        .collect()
}

fn no_metadata(path: &Path) -> Result<RecordingError, RecordingError> {
    let files = mcap_files(path).map_err(|source| RecordingError::io("read", path, source))?;
    if files.iter().any(|file| is_being_written(file)) {
        return Ok(RecordingError::BeingWritten {
            path: path.to_path_buf(),
        });
    }
    let advice = match files.first() {
        Some(file) => format!(
            "what its writer left can be read from {}, or written anew with: column-twin repair {}",
            file.display(),
            path.display()
        ),
        None => "there is no .mcap file in it either; give the directory of a recording, or its .mcap file".to_owned(),
    };
    Ok(RecordingError::NoMetadata {
        path: path.to_path_buf(),
        advice,
    })
}

/// One reading of one file.
struct Pass {
    records: RecordReader,
    schemas: HashMap<u16, (SchemaHeader, Vec<u8>)>,
    /// Topics of the channels.
    channels: HashMap<u16, usize>,
}

impl Pass {
    fn open(file: &Path) -> Result<Self, RecordingError> {
        Ok(Self {
            records: RecordReader::open(file)?,
            schemas: HashMap::new(),
            channels: HashMap::new(),
        })
    }

    /// The next message with its topic; everything else goes into `contents`.
    fn next(
        &mut self,
        contents: &mut Contents,
    ) -> Result<Option<(usize, MessageHeader, Vec<u8>)>, RecordingError> {
        while let Some(record) = self.records.next()? {
            let noted = match record {
                Record::Message { header, data } => match self.channels.get(&header.channel_id) {
                    Some(topic) => return Ok(Some((*topic, header, data.into_owned()))),
                    None => Err(format!(
                        "a message is of channel {}, which the file does not declare",
                        header.channel_id
                    )),
                },
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
                let (id, schema) = (header.id, (header, data.into_owned()));
                // Some writers repeat it in every chunk.
                if self.schemas.get(&id) != Some(&schema) {
                    contents.add_text(schema.1.len() + schema.0.name.len())?;
                    self.schemas.insert(id, schema);
                }
            }
            Record::Channel(channel) => {
                let id = channel.id;
                let schema = self.schemas.get(&channel.schema_id);
                let topic = contents.topic_of(channel, schema)?;
                self.channels.insert(id, topic);
            }
            Record::Metadata(metadata) => {
                contents.add_text(metadata.name.len() + text_length(&metadata.metadata))?;
                contents.metadata.push((metadata.name, metadata.metadata));
            }
            _ => {}
        }
        Ok(())
    }
}

fn text_length(entries: &BTreeMap<String, String>) -> usize {
    entries
        .iter()
        .map(|(key, value)| key.len() + value.len())
        .sum()
}

impl Contents {
    fn note_header(&mut self, header: Header) {
        if self.library.is_empty() && self.profile.is_empty() {
            self.profile = header.profile;
            self.library = header.library;
        }
    }

    /// Counts text that is kept in memory.
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

    /// The topic of a channel; one and the same for channels that say the same.
    fn topic_of(
        &mut self,
        channel: Channel,
        schema: Option<&(SchemaHeader, Vec<u8>)>,
    ) -> Result<usize, String> {
        let (type_name, encoding, text) = schema.map_or(("", "", &[][..]), |(it, data)| {
            (&it.name, &it.encoding, data)
        });
        let same = |it: &RecordedTopic| {
            *it.name == *channel.topic
                && *it.type_name == *type_name
                && it.encoding == channel.message_encoding
                && it.schema_encoding == encoding
                && *it.schema == *text
        };
        if let Some(index) = self.topics.iter().position(same) {
            return Ok(index);
        }
        if self.topics.len() >= MAX_TOPICS {
            return Err(format!("expected at most {MAX_TOPICS} topics, found more"));
        }
        self.add_text(channel.topic.len() + text_length(&channel.metadata) + text.len())?;
        self.topics.push(RecordedTopic {
            name: channel.topic.into(),
            type_name: type_name.into(),
            encoding: channel.message_encoding,
            schema_encoding: encoding.to_owned(),
            schema: text.into(),
            qos: channel
                .metadata
                .get(QOS_KEY)
                .and_then(|yaml| OfferedQos::from_yaml(yaml)),
            metadata: channel.metadata,
            messages: 0,
        });
        Ok(self.topics.len() - 1)
    }

    fn count(&mut self, topic: usize, time: u64) {
        self.messages += 1;
        if let Some(topic) = self.topics.get_mut(topic) {
            topic.messages += 1;
        }
        self.span = Some(self.span.map_or((time, time), |(first, last)| {
            (first.min(time), last.max(time))
        }));
    }

    fn note_damage(&mut self, fault: &RecordingError) {
        self.wholeness.damaged += 1;
        if self.wholeness.faults.len() < MAX_FAULTS
            && let RecordingError::Damaged { offset, reason, .. } = fault
        {
            self.wholeness
                .faults
                .push(format!("at byte {offset}: {reason}"));
        }
    }

    fn note_end(&mut self, file: &Path, end: Option<FileEnd>) {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        match end {
            Some(FileEnd::Whole) => {}
            Some(FileEnd::InRecord(at)) => {
                self.wholeness.ends_in_record = true;
                self.wholeness.cut_off.push(format!(
                    "{name} is cut off in the record that begins at byte {at}"
                ));
            }
            Some(FileEnd::CutOff(at)) => {
                self.wholeness.cut_off.push(format!(
                    "{name} has no end, its last whole record ends at byte {at}"
                ));
            }
            None => self
                .wholeness
                .cut_off
                .push(format!("{name} was not read to its end")),
        }
    }
}

/// The messages of a recording, in order. After an error it goes on with what follows; only an error that is no
/// [damage](RecordingError::Damaged) is the last.
pub struct Messages<'a> {
    reader: &'a Reader,
    next_file: usize,
    pass: Option<Pass>,
    reordering: Reordering<Message>,
    /// What was found on the way is known again from the beginning.
    scratch: Contents,
    ended: bool,
}

impl Messages<'_> {
    /// Reads one message, or comes to the end.
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
        let Some((topic_index, header, data)) = pass.next(&mut self.scratch)? else {
            self.pass = None;
            return Ok(());
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
                    // Nothing follows: what is held is incomplete.
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

/// Times beyond the year 2262 do not fit.
fn nanos(time: u64) -> i64 {
    i64::try_from(time).unwrap_or(i64::MAX)
}
