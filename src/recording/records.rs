//! The records of an MCAP file, one after the other (<https://mcap.dev/spec>). Trusts nothing: no length is believed beyond
//! what the file holds, no index is looked at.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::error::RecordingError;
use crate::parameters::Compression;

/// Most bytes of a record, and of a chunk once it is unpacked; what is longer is refused.
pub const MAX_CHUNK: usize = 256 << 20;

/// What an MCAP file begins and ends with.
pub(super) const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', 0x30, b'\r', b'\n'];

const READ_BUFFER: usize = 1 << 20;

/// Length of a record's opcode and length \[bytes\].
const HEAD: usize = 9;

const HEADER: u8 = 0x01;
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
const METADATA: u8 = 0x0c;
const DATA_END: u8 = 0x0f;

/// A schema as it stands in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct SchemaRecord {
    pub id: u16,
    pub name: String,
    pub encoding: String,
    pub data: Vec<u8>,
}

/// A channel as it stands in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ChannelRecord {
    pub id: u16,
    pub schema: u16,
    pub topic: String,
    pub encoding: String,
    pub metadata: BTreeMap<String, String>,
}

/// A message as it stands in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct MessageRecord<'a> {
    pub channel: u16,
    pub log_time: u64,
    pub publish_time: u64,
    pub data: &'a [u8],
}

/// What matters of a file besides its messages. Records in a chunk come as if there were no chunks.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Record {
    Header {
        profile: String,
        library: String,
    },
    Schema(SchemaRecord),
    Channel(ChannelRecord),
    Metadata {
        name: String,
        entries: BTreeMap<String, String>,
    },
    /// Nothing of use.
    Other,
}

/// How a file ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FileEnd {
    /// As it should.
    Whole,
    /// Behind a whole record at this byte, but without its end: its writer was stopped.
    CutOff(u64),
    /// In the middle of a record, which begins at this byte.
    InRecord(u64),
}

/// Reads a file from its beginning to its end.
pub(super) struct RecordReader {
    path: PathBuf,
    file: BufReader<File>,
    /// Length of the file when it was opened.
    length: u64,
    /// Where the next record of the file begins.
    position: u64,
    /// The current record of the file, if it is not a chunk.
    body: Vec<u8>,
    chunk: Chunk,
    /// Whether the end of the data was seen: what follows is index.
    past_data: bool,
    end: Option<FileEnd>,
}

/// The records of the current chunk.
#[derive(Default)]
struct Chunk {
    bytes: Vec<u8>,
    /// What is still to be read of them.
    rest: Range<usize>,
    /// Where the chunk begins in the file.
    begins: u64,
    compression: Option<Compression>,
}

/// A record to which the reader went.
pub(super) struct Place {
    opcode: u8,
    /// Where it begins in the file, or the chunk that it is in.
    pub begins: u64,
    body: Body,
}

impl Place {
    pub fn is_message(&self) -> bool {
        self.opcode == MESSAGE
    }
}

/// Where the body of a record is.
enum Body {
    OfFile,
    InChunk(Range<usize>),
}

impl RecordReader {
    /// Opens a file and looks at its beginning.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let io = |source| RecordingError::io("read", path, source);
        let file = File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        if length == 0 {
            return Err(RecordingError::Empty {
                path: path.to_path_buf(),
            });
        }
        let mut file = BufReader::with_capacity(READ_BUFFER, file);
        let mut begin = Vec::new();
        (&mut file)
            .take(MAGIC.len() as u64 * 2)
            .read_to_end(&mut begin)
            .map_err(io)?;
        if !begin.starts_with(&MAGIC) {
            return Err(not_mcap(path, &begin));
        }
        file.seek(SeekFrom::Start(MAGIC.len() as u64)).map_err(io)?;
        Ok(Self {
            path: path.to_path_buf(),
            file,
            length,
            position: MAGIC.len() as u64,
            body: Vec::new(),
            chunk: Chunk::default(),
            past_data: false,
            end: None,
        })
    }

    /// Length of the file \[bytes\].
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Compression of the last chunk.
    pub fn compression(&self) -> Option<Compression> {
        self.chunk.compression
    }

    /// How the file ends, once there is no record any more.
    pub fn end(&self) -> Option<FileEnd> {
        self.end
    }

    /// Goes to the next record that matters; `None` at the end of the file, however it ends.
    ///
    /// # Errors
    /// The file cannot be read, or a record or chunk is damaged. The next call goes on behind it.
    pub fn advance(&mut self) -> Result<Option<Place>, RecordingError> {
        loop {
            if !self.chunk.rest.is_empty() {
                let begins = self.chunk.begins;
                let next = self.chunk.next();
                let (opcode, range) = next.map_err(|reason| self.damaged(begins, reason))?;
                if matters(opcode) && opcode != DATA_END {
                    let body = Body::InChunk(range);
                    return Ok(Some(Place {
                        opcode,
                        begins,
                        body,
                    }));
                }
                continue;
            }
            if self.end.is_some() {
                return Ok(None);
            }
            let begins = self.position;
            let Some((opcode, length)) = self.read_head()? else {
                return Ok(None);
            };
            match opcode {
                FOOTER => self.read_end(begins, length)?,
                CHUNK if !self.past_data => {
                    self.read_body(begins, length)?;
                    let unpacked = self.chunk.unpack(&mut self.body, begins);
                    unpacked.map_err(|reason| self.damaged(begins, reason))?;
                }
                opcode if matters(opcode) && !self.past_data => {
                    self.read_body(begins, length)?;
                    self.past_data = opcode == DATA_END;
                    let body = Body::OfFile;
                    return Ok(Some(Place {
                        opcode,
                        begins,
                        body,
                    }));
                }
                _ => self.skip(length)?,
            }
        }
    }

    /// The record at a place to which the reader just went.
    ///
    /// # Errors
    /// It does not hold what it should.
    pub fn record(&self, place: &Place) -> Result<Record, RecordingError> {
        let bytes = self.bytes(place);
        parse(place.opcode, bytes).ok_or_else(|| self.malformed(place))
    }

    /// The message at a place to which the reader just went.
    ///
    /// # Errors
    /// It does not hold what it should.
    pub fn message(&self, place: &Place) -> Result<MessageRecord<'_>, RecordingError> {
        parse_message(self.bytes(place)).ok_or_else(|| self.malformed(place))
    }

    fn bytes(&self, place: &Place) -> &[u8] {
        match &place.body {
            Body::OfFile => &self.body,
            Body::InChunk(range) => &self.chunk.bytes[range.clone()],
        }
    }

    fn malformed(&self, place: &Place) -> RecordingError {
        let reason = format!(
            "a record of kind {:#04x} does not hold what it should in its {} bytes",
            place.opcode,
            self.bytes(place).len()
        );
        self.damaged(place.begins, reason)
    }

    /// Something is wrong at this byte of the file.
    pub fn damaged(&self, offset: u64, reason: String) -> RecordingError {
        RecordingError::Damaged {
            path: self.path.clone(),
            offset,
            reason,
        }
    }

    /// Opcode and length of the next record of the file, which is all there; `None` at the end.
    fn read_head(&mut self) -> Result<Option<(u8, u64)>, RecordingError> {
        let remaining = self.length - self.position;
        if remaining < HEAD as u64 {
            self.end = Some(if remaining == 0 {
                FileEnd::CutOff(self.position)
            } else {
                FileEnd::InRecord(self.position)
            });
            return Ok(None);
        }
        let mut head = [0; HEAD];
        self.read_exact(&mut head)?;
        let [opcode, length @ ..] = head;
        let length = u64::from_le_bytes(length);
        // No record is of kind 0: zeros are what a loss of power leaves of a file.
        if opcode == 0 || length > remaining - HEAD as u64 {
            self.end = Some(FileEnd::InRecord(self.position));
            return Ok(None);
        }
        self.position += HEAD as u64 + length;
        Ok(Some((opcode, length)))
    }

    fn read_body(&mut self, begins: u64, length: u64) -> Result<(), RecordingError> {
        if length > MAX_CHUNK as u64 {
            self.skip(length)?;
            return Err(self.damaged(
                begins,
                format!(
                    "expected records of at most {} MiB, found one of {length} bytes",
                    MAX_CHUNK >> 20
                ),
            ));
        }
        let length = usize::try_from(length).unwrap_or(MAX_CHUNK);
        // The file is that long.
        self.body.resize(length, 0);
        let mut body = std::mem::take(&mut self.body);
        let read = self.read_exact(&mut body);
        self.body = body;
        read
    }

    /// The footer, and the magic bytes behind it.
    fn read_end(&mut self, begins: u64, length: u64) -> Result<(), RecordingError> {
        self.skip(length)?;
        let mut magic = [0; MAGIC.len()];
        let is_there = self.length - self.position >= MAGIC.len() as u64;
        if is_there {
            self.read_exact(&mut magic)?;
        }
        self.end = Some(match magic == MAGIC {
            true => FileEnd::Whole,
            false => FileEnd::InRecord(begins),
        });
        Ok(())
    }

    fn skip(&mut self, length: u64) -> Result<(), RecordingError> {
        let length = i64::try_from(length).unwrap_or(i64::MAX);
        self.file
            .seek_relative(length)
            .map_err(|source| RecordingError::io("read", &self.path, source))
    }

    fn read_exact(&mut self, bytes: &mut [u8]) -> Result<(), RecordingError> {
        self.file
            .read_exact(bytes)
            .map_err(|source| match source.kind() {
                io::ErrorKind::UnexpectedEof => RecordingError::Changed {
                    path: self.path.clone(),
                },
                _ => RecordingError::io("read", &self.path, source),
            })
    }
}

impl Chunk {
    /// Takes the records out of a chunk; what `body` held is gone.
    fn unpack(&mut self, body: &mut Vec<u8>, begins: u64) -> Result<(), String> {
        self.rest = 0..0;
        self.begins = begins;
        let mut fields = Fields(body);
        let head = chunk_head(&mut fields).ok_or("the chunk's head is cut off")?;
        let (unpacked, crc) = (head.unpacked, head.crc);
        let there = fields.0.len();
        let packed = fields.take(head.packed).ok_or_else(|| {
            format!(
                "expected {} bytes of records in the chunk, found {there}",
                head.packed
            )
        })?;
        if unpacked > MAX_CHUNK as u64 {
            return Err(format!(
                "expected chunks of at most {} MiB, found one of {unpacked} bytes",
                MAX_CHUNK >> 20
            ));
        }
        self.rest = match head.compression {
            "" => {
                self.compression = Some(Compression::None);
                let begin = body.len() - there;
                let range = begin..begin + packed.len();
                std::mem::swap(&mut self.bytes, body);
                range
            }
            "zstd" => {
                self.compression = Some(Compression::Zstd);
                let unpacking = zstd::stream::read::Decoder::with_buffer(packed);
                read_all(&mut self.bytes, unpacking, unpacked)?
            }
            "lz4" => {
                self.compression = Some(Compression::Lz4);
                read_all(&mut self.bytes, lz4::Decoder::new(packed), unpacked)?
            }
            other => {
                return Err(format!(
                    "expected compression lz4, zstd or none, found {other:?}"
                ));
            }
        };
        let found = self.rest.len() as u64;
        let found_crc = crc32fast::hash(&self.bytes[self.rest.clone()]);
        let fault = if found != unpacked {
            Some(format!(
                "expected a chunk of {unpacked} bytes, found {found}"
            ))
        } else if crc != 0 && crc != found_crc {
            Some(format!(
                "expected a chunk with checksum {crc:08x}, found {found_crc:08x}"
            ))
        } else {
            None
        };
        fault.map_or(Ok(()), |fault| {
            self.rest = 0..0;
            Err(fault)
        })
    }

    /// The next record: its opcode and where its body is.
    fn next(&mut self) -> Result<(u8, Range<usize>), String> {
        let rest = &self.bytes[self.rest.clone()];
        let mut fields = Fields(rest);
        let record = fields
            .u8()
            .zip(fields.u64())
            .filter(|(_, length)| *length <= fields.0.len() as u64);
        let Some((opcode, length)) = record else {
            self.rest = 0..0;
            return Err("a record is longer than the chunk that it is in".to_owned());
        };
        let begin = self.rest.start + HEAD;
        let end = begin + usize::try_from(length).unwrap_or(0);
        self.rest.start = end;
        Ok((opcode, begin..end))
    }
}

struct ChunkHead<'a> {
    unpacked: u64,
    crc: u32,
    compression: &'a str,
    packed: u64,
}

fn chunk_head<'a>(fields: &mut Fields<'a>) -> Option<ChunkHead<'a>> {
    // First and last time; those of the messages themselves count.
    fields.take(16)?;
    Some(ChunkHead {
        unpacked: fields.u64()?,
        crc: fields.u32()?,
        compression: fields.text()?,
        packed: fields.u64()?,
    })
}

/// Reads one byte more than is expected at the most.
fn read_all<E: std::fmt::Display>(
    bytes: &mut Vec<u8>,
    source: Result<impl Read, E>,
    expected: u64,
) -> Result<Range<usize>, String> {
    bytes.clear();
    let source = source.map_err(|error| format!("the chunk cannot be unpacked: {error}"))?;
    source
        .take(expected + 1)
        .read_to_end(bytes)
        .map_err(|error| format!("the chunk cannot be unpacked: {error}"))?;
    Ok(0..bytes.len())
}

/// Whether a record of that kind is of use here.
fn matters(opcode: u8) -> bool {
    matches!(
        opcode,
        HEADER | SCHEMA | CHANNEL | MESSAGE | METADATA | DATA_END
    )
}

fn parse(opcode: u8, body: &[u8]) -> Option<Record> {
    let mut fields = Fields(body);
    Some(match opcode {
        HEADER => Record::Header {
            profile: fields.text()?.to_owned(),
            library: fields.text()?.to_owned(),
        },
        SCHEMA => Record::Schema(SchemaRecord {
            id: fields.u16()?,
            name: fields.text()?.to_owned(),
            encoding: fields.text()?.to_owned(),
            data: {
                let length = fields.u32()?;
                fields.take(u64::from(length))?.to_vec()
            },
        }),
        CHANNEL => Record::Channel(ChannelRecord {
            id: fields.u16()?,
            schema: fields.u16()?,
            topic: fields.text()?.to_owned(),
            encoding: fields.text()?.to_owned(),
            metadata: fields.map()?,
        }),
        METADATA => Record::Metadata {
            name: fields.text()?.to_owned(),
            entries: fields.map()?,
        },
        _ => Record::Other,
    })
}

fn parse_message(body: &[u8]) -> Option<MessageRecord<'_>> {
    let mut fields = Fields(body);
    let channel = fields.u16()?;
    fields.u32()?; // the sequence number, which need not be one
    Some(MessageRecord {
        channel,
        log_time: fields.u64()?,
        publish_time: fields.u64()?,
        data: fields.0,
    })
}

/// What is left of a record.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take(&mut self, length: u64) -> Option<&'a [u8]> {
        let length = usize::try_from(length).ok()?;
        let (taken, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    fn u8(&mut self) -> Option<u8> {
        self.array().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Option<&'a str> {
        let length = self.u32()?;
        std::str::from_utf8(self.take(u64::from(length))?).ok()
    }

    fn map(&mut self) -> Option<BTreeMap<String, String>> {
        let length = self.u32()?;
        let mut entries = Fields(self.take(u64::from(length))?);
        let mut map = BTreeMap::new();
        while !entries.0.is_empty() {
            map.insert(entries.text()?.to_owned(), entries.text()?.to_owned());
        }
        Some(map)
    }
}

/// What else it is, where that can be seen.
fn not_mcap(path: &Path, begin: &[u8]) -> RecordingError {
    let hint = if MAGIC.starts_with(begin) {
        ": it is cut off in its first bytes, nothing was recorded in it"
    } else if begin.starts_with(b"#ROSBAG V") {
        ": it is a bag of ROS 1; convert it with: rosbags-convert --src IN.bag --dst OUT --dst-storage mcap"
    } else if begin.starts_with(b"SQLite format 3") {
        ": it is a bag of rosbag2 in SQLite; convert it with: ros2 bag convert"
    } else if begin.starts_with(&[0x28, 0xb5, 0x2f, 0xfd]) {
        ": it is compressed by zstd; unpack it with: zstd -d FILE"
    } else {
        "; give the directory of a recording, or its .mcap file"
    };
    let found: Vec<String> = begin
        .iter()
        .take(MAGIC.len())
        .map(|byte| format!("{byte:02x}"))
        .collect();
    RecordingError::NotMcap {
        path: path.to_path_buf(),
        found: found.join(" "),
        hint,
    }
}
