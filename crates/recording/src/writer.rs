//! Writes one recording.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, WriteOptions, Writer as McapWriter};

use crate::bag_metadata::{BagMetadata, BagSummary, METADATA_FILE, TopicSummary};
use crate::chain::Hash;
use crate::compression::ChunkCompression;
use crate::described::{Described, check_topics};
use crate::error::RecordingError;
use crate::keys::{QOS_KEY, TYPE_HASH_KEY};
use crate::notes::{LOSSES, REPAIRED, START, record, record_name};
use crate::seal::{Beginning, SEAL_AT_END, SEAL_LENGTH, Sealer};
use crate::seal_key::SealKey;
use crate::storage::{FileIdentity, Storage, Unsynced, sync_directory};
use crate::topic::TopicInfo;

/// A killed program loses at most the messages of this time before the kill.
pub const FLUSH_WITHIN: Duration = Duration::from_millis(50);

/// Name of the recording program if none is given.
pub(crate) const APPLICATION: &str = "recording";

/// Size at which a chunk ends, before compression \[bytes\].
const CHUNK_SIZE: u64 = 1 << 20;

/// Size of the buffer for small records \[bytes\].
const WRITE_BUFFER: usize = 256 << 10;

/// Space that a message needs besides its bytes: head of the record and index entry \[bytes\].
const MESSAGE_OVERHEAD: u64 = 31 + 16;

/// Space that a chunk needs for its head and at the end of the file, besides that of each topic \[bytes\].
const CHUNK_OVERHEAD: u64 = 512;

/// Space that each topic needs for each chunk: message index and entry in the chunk index \[bytes\].
const TOPIC_IN_CHUNK: u64 = 32;

/// Space that each topic needs at the end of the file besides its schema: twice its metadata \[bytes\].
const TOPIC_AT_END: u64 = 4096;

/// Further space for the end of the file and `metadata.yaml` \[bytes\].
const END: u64 = 64 << 10;

/// A message to be recorded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// Index of the topic among the declared topics.
    pub topic: usize,
    /// When it was received or sent \[ns since 1970\]; not negative.
    pub log_time: i64,
    /// When its publisher sent it \[ns since 1970\]; not negative.
    pub publish_time: i64,
    /// Its bytes on the wire: encapsulation header, then CDR.
    pub data: Arc<[u8]>,
    /// Whether a recording may begin with this message, because the messages that follow need no earlier ones.
    pub checkpoint: bool,
}

/// Options of a writer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WriterOptions {
    /// Compression of the chunks.
    pub compression: ChunkCompression,
    /// Whether [`Writer::flush`] waits until the data would survive a loss of power.
    pub sync: bool,
    /// Name of the recording program; the names of its metadata records begin with it.
    pub application: String,
    /// Notes of the recording program, written at the beginning: its version, for example.
    pub notes: BTreeMap<String, String>,
    /// The key with which the recording is sealed at every flush and at its end; `None`: it is not sealed.
    pub seal: Option<SealKey>,
}

impl Default for WriterOptions {
    fn default() -> Self {
        Self {
            compression: ChunkCompression::None,
            sync: true,
            application: APPLICATION.to_owned(),
            notes: BTreeMap::new(),
            seal: None,
        }
    }
}

/// A recording that was finished.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finished {
    /// Its directory.
    pub directory: PathBuf,
    /// Number of its messages.
    pub messages: u64,
    /// Size of its file \[bytes\].
    pub bytes: u64,
    /// Number of messages that were lost.
    pub lost: u64,
    /// What its seal has signed, if it is sealed.
    pub(crate) signed: Option<Hash>,
}

/// Messages that are only in memory; they are lost if the file ends here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Unsaved {
    /// Their number.
    pub messages: u64,
    /// Their size \[bytes\].
    pub bytes: u64,
}

/// Why a recording ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum EndReason {
    /// The recorder was stopped, or the writer was finished.
    Stopped,
    /// The recording reached its limits.
    Rotated,
    /// The disk was full.
    NoRoom,
    /// The recording is the result of a repair.
    Repaired,
}

impl EndReason {
    fn word(self) -> &'static str {
        match self {
            Self::Stopped => "stopped",
            Self::Rotated => "rotated",
            Self::NoRoom => "no_room",
            Self::Repaired => REPAIRED,
        }
    }
}

/// Writes one recording: a directory with `metadata.yaml` and one MCAP file. It has to be [finished](Self::finish); if it is
/// dropped before, it ends the file if possible, ignores errors, and writes no `metadata.yaml`.
pub struct Writer {
    inner: McapWriter<BufWriter<Storage>>,
    storage: Storage,
    directory: PathBuf,
    path: PathBuf,
    topics: Vec<Topic>,
    application: String,
    sync: bool,
    span: Option<(u64, u64)>,
    messages: u64,
    lost: u64,
    /// Whether more may have been lost than is known: the original of a repair was cut off before it told.
    is_loss_unknown: bool,
    /// Maximum size of the open chunk and its index \[bytes\].
    open_chunk: u64,
    /// The messages of the open chunk.
    unsaved: Unsaved,
    chunks: u64,
    /// Space that the end of the file needs, besides that of each chunk \[bytes\].
    end: u64,
    sealer: Option<Sealer>,
    /// What the last seal in the file has signed.
    signed: Option<Hash>,
    /// Length of the part of the file that consists of whole records \[bytes\].
    whole: u64,
    /// Length of the part of the file that was synced, or handed out to be synced \[bytes\].
    synced: u64,
}

struct Topic {
    info: Described,
    /// What it contributes to the links of the chain.
    hash: Hash,
    channel: u16,
    messages: u64,
}

impl Writer {
    /// Begins the recording `directory`, which must not exist or must be empty.
    ///
    /// # Errors
    /// The directory is not empty or cannot be created, a topic is declared twice, or there is no room.
    pub fn create(
        directory: &Path,
        options: &WriterOptions,
        topics: &[TopicInfo],
    ) -> Result<Self, RecordingError> {
        let beginning = options.seal.as_ref().map(Beginning::new).transpose()?;
        Self::create_with_room(directory, options, topics, beginning, 0)
    }

    /// As [`create`](Self::create), with this beginning of the seal, and requires this much free space \[bytes\].
    pub(crate) fn create_with_room(
        directory: &Path,
        options: &WriterOptions,
        topics: &[TopicInfo],
        beginning: Option<Beginning>,
        room: u64,
    ) -> Result<Self, RecordingError> {
        check_topics(topics)?;
        let described = topics
            .iter()
            .map(Described::new)
            .collect::<Result<_, _>>()?;
        let start = Metadata {
            name: record_name(&options.application, START),
            metadata: options.notes.clone(),
        };
        let mut writer = Self::create_with(directory, options, described, room)?;
        if let Some((key, beginning)) = options.seal.clone().zip(beginning) {
            let (sealer, record) = Sealer::new(key, beginning);
            writer.write_record(&record)?;
            writer.signed = Some(sealer.signed());
            writer.sealer = Some(sealer);
        }
        writer.write_record(&start)?;
        // From now on the file can be recognised.
        writer.end_chunk()?;
        Ok(writer)
    }

    /// As [`create`](Self::create), with topics of any encoding, and without notes and seal.
    pub(crate) fn create_with(
        directory: &Path,
        options: &WriterOptions,
        topics: Vec<Described>,
        room: u64,
    ) -> Result<Self, RecordingError> {
        make_directory(directory)?;
        let path = directory.join(file_name(directory));
        let storage =
            Storage::create(&path).map_err(|source| RecordingError::io("create", &path, source))?;
        let texts: u64 = topics.iter().map(Described::length).sum();
        let end = END + 2 * texts + topics.len() as u64 * TOPIC_AT_END;
        storage
            .reserve(end + texts + END + room)
            .map_err(|source| RecordingError::io("write", &path, source))?;
        let write = |error| RecordingError::write(&path, error);
        let mut inner = McapWriter::with_options(
            BufWriter::with_capacity(WRITE_BUFFER, storage.clone()),
            write_options(options.compression),
        )
        .map_err(write)?;
        let mut channels = Vec::with_capacity(topics.len());
        for info in topics {
            let schema = if info.has_schema() {
                inner
                    .add_schema(&info.type_name, &info.schema_encoding, &info.schema)
                    .map_err(write)?
            } else {
                0
            };
            let channel = inner
                .add_channel(schema, &info.name, &info.message_encoding, &info.metadata)
                .map_err(write)?;
            channels.push(Topic {
                hash: info.hash(),
                info,
                channel,
                messages: 0,
            });
        }
        Ok(Self {
            inner,
            storage,
            directory: directory.to_path_buf(),
            path: path.clone(),
            topics: channels,
            application: options.application.clone(),
            sync: options.sync,
            span: None,
            messages: 0,
            lost: 0,
            is_loss_unknown: false,
            open_chunk: 0,
            unsaved: Unsaved::default(),
            chunks: 1,
            end,
            sealer: None,
            signed: None,
            whole: 0,
            synced: 0,
        })
    }

    /// Writes a message.
    ///
    /// # Errors
    /// The topic was not declared, or writing fails. If there is no room, the message is not in the file, and the file can
    /// still be [finished](Self::finish).
    pub fn write(&mut self, entry: &Entry) -> Result<(), RecordingError> {
        let time = |nanos: i64| u64::try_from(nanos).unwrap_or(0);
        self.write_message(
            entry.topic,
            time(entry.log_time),
            time(entry.publish_time),
            &entry.data,
        )
    }

    pub(crate) fn write_message(
        &mut self,
        topic: usize,
        log_time: u64,
        publish_time: u64,
        data: &[u8],
    ) -> Result<(), RecordingError> {
        let topics = self.topics.len();
        let room = self.open_chunk + data.len() as u64 + MESSAGE_OVERHEAD;
        self.reserve(room)?;
        let Some(topic) = self.topics.get_mut(topic) else {
            return Err(RecordingError::UndeclaredTopic {
                index: topic,
                topics,
            });
        };
        let header = MessageHeader {
            channel_id: topic.channel,
            sequence: u32::try_from(topic.messages & u64::from(u32::MAX)).unwrap_or(0),
            log_time,
            publish_time,
        };
        self.inner
            .write_to_known_channel(&header, data)
            .map_err(|error| RecordingError::write(&self.path, error))?;
        if let Some(sealer) = &mut self.sealer {
            sealer.chain().add_message(&topic.hash, &header, data);
        }
        topic.messages += 1;
        self.messages += 1;
        self.open_chunk = room;
        self.span = Some(self.span.map_or((log_time, log_time), |(first, last)| {
            (first.min(log_time), last.max(log_time))
        }));
        if self.open_chunk > CHUNK_SIZE {
            return self.end_chunk();
        }
        self.unsaved.messages += 1;
        self.unsaved.bytes += data.len() as u64;
        Ok(())
    }

    /// Reserves space for a chunk of this size \[bytes\] and for the end of the file.
    fn reserve(&self, chunk: u64) -> Result<(), RecordingError> {
        // Compression makes incompressible data a little longer.
        let mut chunk = chunk + chunk / 128 + CHUNK_OVERHEAD;
        let mut per_chunk = CHUNK_OVERHEAD + TOPIC_IN_CHUNK * self.topics.len() as u64;
        if self.sealer.is_some() {
            chunk += SEAL_LENGTH;
            per_chunk += SEAL_AT_END;
        }
        let end = self.whole + chunk + self.end + (self.chunks + 1) * per_chunk;
        self.storage
            .reserve(end)
            .map_err(|source| RecordingError::io("write", &self.path, source))
    }

    /// Hands all messages to the operating system, so that they survive the end of this program; with the option `sync` it
    /// waits for the disk, so that they survive a loss of power.
    ///
    /// # Errors
    /// Writing fails.
    pub fn flush(&mut self) -> Result<(), RecordingError> {
        self.seal_and_end_chunk()?;
        self.unsynced().map_or(Ok(()), |unsynced| unsynced.sync())
    }

    /// Hands all messages to the operating system; returns what the caller has to sync.
    pub(crate) fn hand_over(&mut self) -> Result<Option<Unsynced>, RecordingError> {
        self.seal_and_end_chunk()?;
        Ok(self.unsynced())
    }

    /// Ends the chunk with a seal behind it, which reaches the file together with it.
    fn seal_and_end_chunk(&mut self) -> Result<(), RecordingError> {
        if let Some(seal) = self.sealer.as_mut().and_then(Sealer::seal) {
            self.reserve(self.open_chunk)?;
            self.write_raw(&seal)?;
        }
        self.end_chunk()?;
        self.signed = self.sealer.as_ref().map(Sealer::signed);
        Ok(())
    }

    fn unsynced(&mut self) -> Option<Unsynced> {
        if !self.sync || self.synced >= self.whole {
            return None;
        }
        let is_new = self.synced == 0;
        self.synced = self.whole;
        Some(Unsynced {
            storage: self.storage.clone(),
            path: self.path.clone(),
            directory: is_new.then(|| self.directory.clone()),
        })
    }

    fn end_chunk(&mut self) -> Result<(), RecordingError> {
        self.inner
            .flush()
            .map_err(|error| RecordingError::write(&self.path, error))?;
        self.chunks += u64::from(self.open_chunk > 0);
        self.open_chunk = 0;
        self.unsaved = Unsaved::default();
        self.whole = self.storage.position();
        Ok(())
    }

    /// Counts messages that were lost.
    pub fn add_lost(&mut self, messages: u64) {
        self.lost += messages;
    }

    /// Leaves out the number of lost messages at the end.
    pub(crate) fn forget_losses(&mut self) {
        self.is_loss_unknown = true;
    }

    /// Writes the count of lost messages before the end of the recording.
    ///
    /// # Errors
    /// Writing fails.
    pub fn note_lost(&mut self) -> Result<(), RecordingError> {
        self.reserve(self.open_chunk + CHUNK_OVERHEAD)?;
        self.write_record(&self.losses_record(None))?;
        self.end += CHUNK_OVERHEAD;
        self.end_chunk()
    }

    fn losses_record(&self, ended: Option<EndReason>) -> Metadata {
        let name = record_name(&self.application, LOSSES);
        let mut losses = record(name, [("lost_messages", self.lost.to_string())]);
        if self.is_loss_unknown {
            losses.metadata.clear();
        }
        let ended = ended.map(|reason| ("ended".to_owned(), reason.word().to_owned()));
        losses.metadata.extend(ended);
        losses
    }

    /// Writes a metadata record, which the next seal will cover.
    fn write_record(&mut self, record: &Metadata) -> Result<(), RecordingError> {
        self.write_raw(record)?;
        if let Some(sealer) = &mut self.sealer {
            sealer.chain().add_metadata(record);
        }
        Ok(())
    }

    fn write_raw(&mut self, record: &Metadata) -> Result<(), RecordingError> {
        self.inner
            .write_metadata(record)
            .map_err(|error| RecordingError::write(&self.path, error))
    }

    /// Copies a metadata record of another recording.
    pub(crate) fn copy_metadata(&mut self, record: &Metadata) -> Result<(), RecordingError> {
        let entries: usize = record
            .metadata
            .iter()
            .map(|(key, value)| 8 + key.len() + value.len())
            .sum();
        let name = record.name.len() as u64;
        self.reserve(self.open_chunk + name + entries as u64 + CHUNK_OVERHEAD)?;
        self.write_record(record)?;
        self.end += SEAL_AT_END + name;
        self.end_chunk()
    }

    /// Copies an attachment of another recording.
    pub(crate) fn copy_attachment(
        &mut self,
        attachment: &Attachment,
    ) -> Result<(), RecordingError> {
        self.reserve(self.open_chunk + attachment.data.len() as u64 + CHUNK_OVERHEAD)?;
        self.attach(attachment)?;
        self.end += CHUNK_OVERHEAD;
        self.end_chunk()
    }

    fn attach(&mut self, attachment: &Attachment) -> Result<(), RecordingError> {
        self.inner
            .attach(attachment)
            .map_err(|error| RecordingError::write(&self.path, error))
    }

    /// Directory of the recording.
    #[must_use]
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    pub(crate) fn file(&self) -> FileIdentity {
        self.storage.identity()
    }

    /// What the last seal in the file has signed; `None` without a seal.
    pub(crate) fn signed(&self) -> Option<Hash> {
        self.signed
    }

    /// Number of messages so far.
    #[must_use]
    pub fn messages(&self) -> u64 {
        self.messages
    }

    /// Size of the file so far, with the open chunk before its compression \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.whole + self.open_chunk
    }

    /// Number of chunks so far; each needs memory until the end of the recording.
    pub(crate) fn chunks(&self) -> u64 {
        self.chunks
    }

    /// Ends the file and writes `metadata.yaml`.
    ///
    /// # Errors
    /// Writing fails. The file then ends with the last whole record and can be [repaired](fn@crate::repair).
    pub fn finish(self) -> Result<Finished, RecordingError> {
        self.finish_because(EndReason::Stopped)
            .map_err(|(error, _)| error)
    }

    /// As [`finish`](Self::finish), with the reason; an error comes with the messages that did not reach the file.
    pub(crate) fn finish_because(
        mut self,
        reason: EndReason,
    ) -> Result<Finished, (RecordingError, Unsaved)> {
        let done = self.end_file(reason);
        // An incomplete record at the end would count as damage.
        done.map_err(|error| (error, self.abandon()))
    }

    /// # Errors
    /// The file was removed, and with it all messages.
    pub(crate) fn check_in_place(&self) -> Result<(), RecordingError> {
        match self.storage.is_at(&self.path) {
            true => Ok(()),
            false => Err(RecordingError::Removed {
                path: self.path.clone(),
            }),
        }
    }

    /// Truncates the file to its last whole record and closes it. Returns the messages that are lost.
    pub(crate) fn abandon(self) -> Unsaved {
        // If the file is gone, there is nothing to truncate.
        let _ = self.storage.close_at(self.whole);
        self.unsaved
    }

    /// Makes every further write fail.
    #[cfg(test)]
    pub(crate) fn break_disk(&self) {
        self.storage.close_at(self.whole).unwrap();
    }

    fn end_file(&mut self, reason: EndReason) -> Result<Finished, RecordingError> {
        let path = &self.path;
        let unwritable = |error: serde_yaml_ng::Error| RecordingError::WriteMetadata {
            path: path.clone(),
            reason: error.to_string(),
        };
        let metadata = self.metadata();
        let document = metadata.document().map_err(unwritable)?;
        let serialized = metadata.record().map_err(unwritable)?;
        self.write_record(&self.losses_record(Some(reason)))?;
        self.write_record(&record(
            "rosbag2".to_owned(),
            [("serialized_metadata", serialized)],
        ))?;
        let time = self.span.map_or(0, |(_, last)| last);
        if let Some((seal, attachment)) = self.sealer.as_mut().map(|it| it.last(time)) {
            self.write_raw(&seal)?;
            self.attach(&attachment)?;
        }
        self.inner
            .finish()
            .map_err(|error| RecordingError::write(&self.path, error))?;
        self.unsaved = Unsaved::default();
        self.whole = self.storage.position();
        self.signed = self.sealer.as_ref().map(Sealer::signed);
        let told = |source| RecordingError::io("end", &self.path, source);
        // The rest of the reserved space is for metadata.yaml.
        self.storage.release().map_err(told)?;
        if self.sync {
            self.storage.sync_all().map_err(told)?;
        }
        let yaml = self.directory.join(METADATA_FILE);
        write_whole(&yaml, document.as_bytes())
            .map_err(|source| RecordingError::io("write", &yaml, source))?;
        if self.sync {
            sync_directory(&self.directory)?;
        }
        Ok(Finished {
            directory: self.directory.clone(),
            messages: self.messages,
            bytes: self.whole,
            lost: self.lost,
            signed: self.signed,
        })
    }

    fn metadata(&self) -> BagMetadata {
        let topics = self.topics.iter().map(|topic| TopicSummary {
            name: topic.info.name.clone(),
            type_name: topic.info.type_name.clone(),
            encoding: topic.info.message_encoding.clone(),
            qos: topic
                .info
                .metadata
                .get(QOS_KEY)
                .cloned()
                .unwrap_or_default(),
            type_hash: topic
                .info
                .metadata
                .get(TYPE_HASH_KEY)
                .cloned()
                .unwrap_or_default(),
            messages: topic.messages,
        });
        BagMetadata::from(BagSummary {
            application: self.application.clone(),
            file: file_name(&self.directory),
            span: self.span,
            topics: topics.collect(),
        })
    }
}

impl std::fmt::Debug for Writer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Writer")
            .field("directory", &self.directory)
            .field("messages", &self.messages)
            .finish_non_exhaustive()
    }
}

/// The name of the MCAP file of a recording, which follows from that of its directory.
pub(crate) fn file_name(directory: &Path) -> String {
    let name = directory
        .file_name()
        .map_or_else(|| "recording".into(), |name| name.to_string_lossy());
    format!("{name}_0.mcap")
}

/// The options of the mcap crate, all of them explicit.
fn write_options(compression: ChunkCompression) -> WriteOptions {
    WriteOptions::new()
        .profile("ros2")
        .library(concat!("rosbag2_mcap ", env!("CARGO_PKG_VERSION")))
        .compression(compression.into())
        // The default is the number of cores.
        .compression_threads(0)
        .compression_level(0)
        // This writer ends the chunks, after it has reserved space for them.
        .chunk_size(None)
        .use_chunks(true)
        // A complete chunk is written at once, so that a kill loses only the open chunk.
        .disable_seeking(true)
        .emit_summary_records(true)
        .emit_summary_offsets(true)
        .emit_message_indexes(true)
        .calculate_chunk_crcs(true)
        .calculate_data_section_crc(true)
        .calculate_summary_section_crc(true)
}

fn make_directory(directory: &Path) -> Result<(), RecordingError> {
    let made = fs::create_dir_all(directory);
    made.map_err(|source| RecordingError::io("create the directory", directory, source))?;
    let mut entries =
        fs::read_dir(directory).map_err(|source| RecordingError::io("read", directory, source))?;
    match entries.next() {
        None => Ok(()),
        Some(_) => Err(RecordingError::Exists {
            path: directory.to_path_buf(),
        }),
    }
}

/// Writes a file that gets its name when it is complete, with the permissions of any new file.
fn write_whole(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(path.parent().unwrap_or(Path::new(".")))?;
    file.write_all(content)?;
    file.persist(path)?;
    Ok(())
}
