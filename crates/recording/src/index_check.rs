//! Checks that a sealed file leads every reader to the sealed messages and to nothing else.
//!
//! A seal is about messages and metadata records in the order of the file. Other programs find messages through the index: the
//! message indexes behind each chunk, and the summary at the end with schemas, channels, statistics, offsets and checksums. All
//! of this follows from the data, so that this check computes it again while the file is read, and compares it byte by byte. A
//! record that the writer of this crate never writes is a fault, too: a private record or an attachment could hide a chunk.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read};

use binrw::{BinWrite, BinWriterExt as _};
use crc32fast::Hasher;
use mcap::MAGIC;
use mcap::records::{
    AttachmentIndex, ChunkHeader, ChunkIndex, Footer, MessageIndex, MessageIndexEntry,
    MetadataIndex, Record, Statistics, SummaryOffset, op,
};

use crate::compression::Unpacked;
use crate::records::{HEAD, attachment};
use crate::seal::SEAL;

/// Maximum size of the index of a file \[bytes\].
const MAX_INDEX: usize = 256 << 20;

/// How much of a compressed chunk is decompressed at a time \[bytes\].
const PIECE: usize = 64 << 10;

/// Follows all records of a file.
#[derive(Default)]
pub(crate) struct IndexCheck {
    /// Where the next record of the file begins.
    position: u64,
    /// Checksum of everything before it.
    crc: Hasher,
    /// Content of the schemas and channels by their numbers.
    schemas: BTreeMap<u16, Vec<u8>>,
    channels: BTreeMap<u16, Vec<u8>>,
    chunk: Option<OpenChunk>,
    unpacked: Unpacked,
    statistics: Statistics,
    times: Times,
    chunk_indexes: Vec<u8>,
    attachment_indexes: Vec<u8>,
    metadata_indexes: Vec<u8>,
    /// What has to follow: the message indexes of a chunk, or everything behind the data.
    expected: Expected,
    is_past_data: bool,
    fault: Option<String>,
}

/// First and last log time.
#[derive(Default)]
struct Times(Option<(u64, u64)>);

impl Times {
    fn add(&mut self, time: u64) {
        self.0 = Some(self.0.map_or((time, time), |(first, last)| {
            (first.min(time), last.max(time))
        }));
    }

    /// As MCAP states them: zeros without a message.
    fn bounds(&self) -> (u64, u64) {
        self.0.unwrap_or((0, 0))
    }
}

/// A chunk whose records are being read.
struct OpenChunk {
    header: ChunkHeader,
    /// Where it begins, and its length \[bytes\].
    offset: u64,
    length: u64,
    /// Length of its records so far, decompressed \[bytes\].
    records: u64,
    times: Times,
    indexes: BTreeMap<u16, Vec<MessageIndexEntry>>,
}

/// Records as they have to follow.
#[derive(Default)]
struct Expected {
    bytes: Vec<u8>,
    at: usize,
}

impl Expected {
    fn is_over(&self) -> bool {
        self.at == self.bytes.len()
    }

    /// Compares the next record.
    fn take(&mut self, opcode: u8, content: &[u8]) -> Result<(), String> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let Some((wanted, wanted_content)) = first_record(rest) else {
            return Err(format!(
                "expected nothing more, found {}",
                described(opcode, content)
            ));
        };
        if (wanted, wanted_content) != (opcode, content) {
            let (expected, found) = (
                described(wanted, wanted_content),
                described(opcode, content),
            );
            return Err(match expected == found {
                false => format!("expected {expected}, found {found}"),
                true => {
                    let pairs = wanted_content.iter().zip(content);
                    let equal = pairs.take_while(|(one, other)| one == other).count();
                    format!(
                        "expected {expected} as it follows from the data, found one that differs from byte {} of its content on",
                        equal
                    )
                }
            });
        }
        self.at += rest.len().min(content.len() + head_length());
        Ok(())
    }
}

fn head_length() -> usize {
    usize::try_from(HEAD).unwrap_or(usize::MAX)
}

fn first_record(bytes: &[u8]) -> Option<(u8, &[u8])> {
    let (opcode, rest) = bytes.split_first()?;
    let (length, rest) = rest.split_first_chunk()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    Some((*opcode, rest.get(..length)?))
}

/// A record in words.
fn described(opcode: u8, content: &[u8]) -> String {
    match (opcode, mcap::parse_record(opcode, content)) {
        (op::CHUNK_INDEX, Ok(Record::ChunkIndex(it))) => {
            format!("the index of a chunk at byte {}", it.chunk_start_offset)
        }
        (op::MESSAGE_INDEX, Ok(Record::MessageIndex(it))) => format!(
            "the index of {} messages of channel {}",
            it.records.len(),
            it.channel_id
        ),
        (op::METADATA_INDEX, Ok(Record::MetadataIndex(it))) => {
            format!("the index of a metadata record at byte {}", it.offset)
        }
        (op::ATTACHMENT_INDEX, _) => "the index of an attachment".to_owned(),
        (op::STATISTICS, _) => "the statistics".to_owned(),
        (op::SUMMARY_OFFSET, _) => "an offset in the summary".to_owned(),
        (op::HEADER, _) => "the header".to_owned(),
        (op::FOOTER, _) => "the footer".to_owned(),
        (op::DATA_END, _) => "the end of the data".to_owned(),
        (op::SCHEMA, _) => "a schema".to_owned(),
        (op::CHANNEL, _) => "a channel".to_owned(),
        (op::MESSAGE, _) => "a message".to_owned(),
        (op::CHUNK, _) => "a chunk".to_owned(),
        (op::METADATA, _) => "a metadata record".to_owned(),
        (op::ATTACHMENT, _) => "an attachment".to_owned(),
        (0x80.., _) => format!("a private record of kind {opcode:#04x}"),
        _ => format!("a record of kind {opcode:#04x}"),
    }
}

impl IndexCheck {
    pub fn new() -> Self {
        let mut crc = Hasher::new();
        crc.update(MAGIC);
        Self {
            position: MAGIC.len() as u64,
            crc,
            ..Self::default()
        }
    }

    /// The next record of the file itself.
    pub fn record(&mut self, opcode: u8, content: &[u8]) {
        // Zeros are what a loss of power leaves: reading ends there, and what follows is checked then.
        if self.fault.is_some() || opcode == 0 {
            return;
        }
        if let Err(reason) = self.follow(opcode, content) {
            self.note(self.position, &reason);
        }
        self.crc.update(&head(opcode, content.len()));
        self.crc.update(content);
        self.position += HEAD + content.len() as u64;
    }

    /// The next record within the chunk that came last.
    pub fn record_in_chunk(&mut self, opcode: u8, content: &[u8]) {
        let Some(chunk) = self.chunk.as_mut().filter(|_| self.fault.is_none()) else {
            return;
        };
        let begins = chunk.offset;
        let declared = match opcode {
            op::SCHEMA => declare(&mut self.schemas, content),
            op::CHANNEL => declare(&mut self.channels, content),
            op::MESSAGE => match mcap::parse_record(opcode, content) {
                Ok(Record::Message { header, .. }) => {
                    let entry = MessageIndexEntry {
                        log_time: header.log_time,
                        offset: chunk.records,
                    };
                    let entries = chunk.indexes.entry(header.channel_id).or_default();
                    entries.push(entry);
                    chunk.times.add(header.log_time);
                    self.times.add(header.log_time);
                    let counts = &mut self.statistics.channel_message_counts;
                    *counts.entry(header.channel_id).or_default() += 1;
                    self.statistics.message_count += 1;
                    Ok(())
                }
                _ => Err("expected a message, found a malformed one".to_owned()),
            },
            _ => Err(format!(
                "expected schemas, channels and messages in a chunk, found {}",
                described(opcode, content)
            )),
        };
        chunk.records += HEAD + content.len() as u64;
        if let Err(reason) = declared {
            self.note(begins, &reason);
        }
    }

    /// Notes the first fault and forgets everything else.
    pub fn note(&mut self, offset: u64, reason: &str) {
        let first = || format!("at byte {offset}: {reason}");
        let fault = self.fault.take().unwrap_or_else(first);
        *self = Self {
            fault: Some(fault),
            ..Self::default()
        };
    }

    /// Why other readers may find something else than the sealed messages, once the file was read.
    pub fn finish(mut self) -> Option<String> {
        if let Err(reason) = self.close_chunk() {
            self.note(self.position, &reason);
        }
        self.fault
    }

    fn follow(&mut self, opcode: u8, content: &[u8]) -> Result<(), String> {
        self.close_chunk()?;
        if self.is_past_data || !self.expected.is_over() {
            return self.expected.take(opcode, content);
        }
        let is_first = self.position == MAGIC.len() as u64;
        match opcode {
            op::HEADER if is_first => Ok(()),
            op::CHUNK if !is_first => self.open_chunk(content),
            op::METADATA if !is_first => self.metadata(content),
            op::ATTACHMENT if !is_first => self.attachment(content),
            op::DATA_END if !is_first => self.end_data(content),
            _ => Err(format!(
                "expected {}, found {}",
                match is_first {
                    true => "the header",
                    false => "a chunk, a metadata record or the end of the data",
                },
                described(opcode, content)
            )),
        }
    }

    fn open_chunk(&mut self, content: &[u8]) -> Result<(), String> {
        let Ok(Record::Chunk { header, data }) = mcap::parse_record(op::CHUNK, content) else {
            return Err("expected a chunk, found a malformed one".to_owned());
        };
        if data.len() as u64 != header.compressed_size {
            return Err(format!(
                "expected a chunk with {} bytes of records, found {}",
                header.compressed_size,
                data.len()
            ));
        }
        if !header.compression.is_empty() {
            let end = self.position + HEAD + content.len() as u64;
            self.unpacked.add(end, header.uncompressed_size)?;
        }
        check_compressed(&header, &data)?;
        self.chunk = Some(OpenChunk {
            header,
            offset: self.position,
            length: HEAD + content.len() as u64,
            records: 0,
            times: Times::default(),
            indexes: BTreeMap::new(),
        });
        Ok(())
    }

    /// Computes the indexes of the chunk that has ended.
    fn close_chunk(&mut self) -> Result<(), String> {
        let Some(chunk) = self.chunk.take() else {
            return Ok(());
        };
        let OpenChunk { header, times, .. } = chunk;
        let (message_start_time, message_end_time) = times.bounds();
        let stated = (header.message_start_time, header.message_end_time);
        if (stated, header.uncompressed_size)
            != ((message_start_time, message_end_time), chunk.records)
        {
            return Err(format!(
                "expected the chunk at byte {} to state the times {message_start_time} to {message_end_time} and {} bytes, found {} to {} and {}",
                chunk.offset, chunk.records, stated.0, stated.1, header.uncompressed_size
            ));
        }
        let (mut bytes, mut message_index_offsets) = (Vec::new(), BTreeMap::new());
        for (channel_id, records) in chunk.indexes {
            message_index_offsets.insert(channel_id, self.position + bytes.len() as u64);
            let index = MessageIndex {
                channel_id,
                records,
            };
            put(&mut bytes, op::MESSAGE_INDEX, &index)?;
        }
        let index = ChunkIndex {
            message_start_time,
            message_end_time,
            chunk_start_offset: chunk.offset,
            chunk_length: chunk.length,
            message_index_offsets,
            message_index_length: bytes.len() as u64,
            compression: header.compression,
            compressed_size: header.compressed_size,
            uncompressed_size: header.uncompressed_size,
        };
        put(&mut self.chunk_indexes, op::CHUNK_INDEX, &index)?;
        self.statistics.chunk_count += 1;
        self.expected = Expected { bytes, at: 0 };
        self.check_size()
    }

    fn metadata(&mut self, content: &[u8]) -> Result<(), String> {
        let Ok(Record::Metadata(metadata)) = mcap::parse_record(op::METADATA, content) else {
            return Err("expected a metadata record, found a malformed one".to_owned());
        };
        let index = MetadataIndex {
            offset: self.position,
            length: HEAD + content.len() as u64,
            name: metadata.name,
        };
        put(&mut self.metadata_indexes, op::METADATA_INDEX, &index)?;
        self.statistics.metadata_count += 1;
        self.check_size()
    }

    fn attachment(&mut self, content: &[u8]) -> Result<(), String> {
        let Some(Record::Attachment { header, data, .. }) = attachment(content)
            .filter(|it| matches!(it, Record::Attachment { header, .. } if header.name == SEAL))
        else {
            return Err(
                "expected no attachment but the one of the last seal, found another one".to_owned(),
            );
        };
        let index = AttachmentIndex {
            offset: self.position,
            length: HEAD + content.len() as u64,
            log_time: header.log_time,
            create_time: header.create_time,
            data_size: data.len() as u64,
            name: header.name,
            media_type: header.media_type,
        };
        put(&mut self.attachment_indexes, op::ATTACHMENT_INDEX, &index)?;
        self.statistics.attachment_count += 1;
        self.check_size()
    }

    fn check_size(&self) -> Result<(), String> {
        let parts = [
            &self.chunk_indexes,
            &self.attachment_indexes,
            &self.metadata_indexes,
        ];
        match parts.map(Vec::len).iter().sum::<usize>() <= MAX_INDEX {
            true => Ok(()),
            false => Err(format!(
                "expected an index of at most {} MiB, found a larger one",
                MAX_INDEX >> 20
            )),
        }
    }

    /// Computes everything that has to follow the data.
    fn end_data(&mut self, content: &[u8]) -> Result<(), String> {
        if content != self.crc.clone().finalize().to_le_bytes() {
            return Err("expected the checksum of the data, found another one".to_owned());
        }
        let begins = self.position + HEAD + content.len() as u64;
        let mut bytes = Vec::new();
        let mut offsets = Vec::new();
        let (message_start_time, message_end_time) = self.times.bounds();
        let statistics = Statistics {
            schema_count: u16::try_from(self.schemas.len()).unwrap_or(u16::MAX),
            channel_count: u32::try_from(self.channels.len()).unwrap_or(u32::MAX),
            message_start_time,
            message_end_time,
            ..std::mem::take(&mut self.statistics)
        };
        let mut statistics_record = Vec::new();
        put(&mut statistics_record, op::STATISTICS, &statistics)?;
        for (group_opcode, group) in [
            (op::SCHEMA, repeated(op::SCHEMA, &self.schemas)),
            (op::CHANNEL, repeated(op::CHANNEL, &self.channels)),
            (op::STATISTICS, statistics_record),
            (op::CHUNK_INDEX, std::mem::take(&mut self.chunk_indexes)),
            (
                op::ATTACHMENT_INDEX,
                std::mem::take(&mut self.attachment_indexes),
            ),
            (
                op::METADATA_INDEX,
                std::mem::take(&mut self.metadata_indexes),
            ),
        ] {
            if !group.is_empty() {
                offsets.push(SummaryOffset {
                    group_opcode,
                    group_start: begins + bytes.len() as u64,
                    group_length: group.len() as u64,
                });
                bytes.extend(group);
            }
        }
        let mut footer = Footer {
            summary_start: begins,
            summary_offset_start: begins + bytes.len() as u64,
            summary_crc: 0,
        };
        for offset in offsets {
            put(&mut bytes, op::SUMMARY_OFFSET, &offset)?;
        }
        put(&mut bytes, op::FOOTER, &footer)?;
        // The checksum is the last field of the footer, and about everything before it.
        bytes.truncate(bytes.len() - size_of_val(&footer.summary_crc));
        footer.summary_crc = crc32fast::hash(&bytes);
        bytes.extend(footer.summary_crc.to_le_bytes());
        self.expected = Expected { bytes, at: 0 };
        self.is_past_data = true;
        Ok(())
    }
}

/// Keeps the content of a schema or channel; a repetition must be equal.
fn declare(known: &mut BTreeMap<u16, Vec<u8>>, content: &[u8]) -> Result<(), String> {
    let Some(id) = content.first_chunk().map(|it| u16::from_le_bytes(*it)) else {
        return Err("expected a schema or channel, found a malformed one".to_owned());
    };
    match known.get(&id) {
        Some(before) if before == content => Ok(()),
        Some(_) => Err(format!(
            "expected one schema or channel of number {id}, found a second one"
        )),
        None => {
            known.insert(id, content.to_vec());
            Ok(())
        }
    }
}

fn repeated(opcode: u8, contents: &BTreeMap<u16, Vec<u8>>) -> Vec<u8> {
    let mut bytes = Vec::new();
    for content in contents.values() {
        bytes.extend(head(opcode, content.len()));
        bytes.extend(content);
    }
    bytes
}

/// The opcode and the length in front of a record.
fn head(opcode: u8, length: usize) -> [u8; 9] {
    let mut head = [opcode; 9];
    head[1..].copy_from_slice(&(length as u64).to_le_bytes());
    head
}

/// Appends a record.
fn put<T>(bytes: &mut Vec<u8>, opcode: u8, record: &T) -> Result<(), String>
where
    for<'a> T: BinWrite<Args<'a> = ()>,
{
    let mut content = Cursor::new(Vec::new());
    let written = content.write_le(record);
    written.map_err(|error| format!("expected a record that can be written: {error}"))?;
    let content = content.into_inner();
    bytes.extend(head(opcode, content.len()));
    bytes.extend(content);
    Ok(())
}

/// The compressed records of a chunk must be one frame, which ends with the chunk and is as long as the chunk states: readers
/// differ in what they do with more.
fn check_compressed(header: &ChunkHeader, data: &[u8]) -> Result<(), String> {
    let length = |counted: io::Result<u64>| {
        counted.map_err(|error| {
            format!("expected a compressed chunk, found one that cannot be decompressed: {error}")
        })
    };
    let limit = header.uncompressed_size.saturating_add(1);
    let (found, left) = match header.compression.as_str() {
        "zstd" => {
            let decoder =
                zstd::stream::read::Decoder::with_buffer(data).map(|it| it.single_frame());
            let mut decoder = decoder.map_err(|error| error.to_string())?;
            let found = length(count(&mut decoder, limit))?;
            (found, decoder.finish().len())
        }
        "lz4" => {
            let mut decoder = lz4::Decoder::new(data).map_err(|error| error.to_string())?;
            let found = length(count(&mut decoder, limit))?;
            (found, decoder.finish().0.len())
        }
        _ => (data.len() as u64, 0),
    };
    match (found == header.uncompressed_size, left) {
        (true, 0) => Ok(()),
        (false, _) => Err(format!(
            "expected a chunk with {} bytes of decompressed records, found another number",
            header.uncompressed_size
        )),
        (true, left) => Err(format!(
            "expected the end of the chunk behind its compressed records, found {left} bytes"
        )),
    }
}

/// Number of bytes that can be read, up to this limit.
fn count(source: &mut impl Read, limit: u64) -> io::Result<u64> {
    let (mut piece, mut found) = (vec![0; PIECE], 0);
    while found < limit {
        match source.read(&mut piece)? {
            0 => break,
            more => found += more as u64,
        }
    }
    Ok(found)
}
