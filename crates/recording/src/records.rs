//! The records of an MCAP file, one after the other (<https://mcap.dev/spec>), also of a damaged one: a record or chunk that
//! cannot be read is reported and left out, and reading goes on behind it. No length is trusted beyond the end of the
//! file, and no index is used.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use mcap::records::{AttachmentHeader, Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError, McapResult};

use crate::compression::{ChunkCompression, Unpacked};
use crate::error::RecordingError;
use crate::index_check::IndexCheck;

/// Maximum length of a record, and of a chunk before and after decompression \[bytes\].
pub const MAX_CHUNK: usize = 256 << 20;

/// Maximum length of an attachment that is read \[bytes\].
const MAX_ATTACHMENT: usize = 64 << 10;

const READ_BUFFER: usize = 1 << 20;

/// Length of the opcode and the length in front of each record \[bytes\].
pub(crate) const HEAD: u64 = 9;

/// Length of the footer and the magic bytes behind it \[bytes\].
const FOOTER: u64 = HEAD + 20 + MAGIC.len() as u64;

/// How a file ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FileEnd {
    /// With the end of an MCAP file.
    Whole,
    /// With a whole record, which ends at this byte, but without the end of an MCAP file: its writer was stopped.
    CutOff(u64),
    /// In the middle of a record, which begins at this byte.
    InRecord(u64),
}

/// Reads a file from its beginning to its end.
pub(crate) struct RecordReader {
    path: PathBuf,
    file: BufReader<File>,
    /// Length of the file when it was opened.
    length: u64,
    /// Bytes of the file that were not read yet.
    left: u64,
    /// Divides the file into records and chunks.
    records: LinearReader,
    /// The chunk that is being read.
    chunk: Option<Chunk>,
    /// Where the current record begins, or the chunk that contains it.
    begins: u64,
    /// Where the next record of the file begins.
    position: u64,
    compression: Option<ChunkCompression>,
    unpacked: Unpacked,
    /// The end of the data was reached; a summary follows.
    past_data: bool,
    /// Number of messages according to the statistics at the end of the file.
    stated_messages: Option<u64>,
    end: Option<FileEnd>,
    /// Compares the index with what it is about.
    index: Option<IndexCheck>,
}

/// What a reader of the mcap crate comes to.
enum Found {
    Record(Record<'static>),
    Chunk(Vec<u8>),
    /// A record that does not have the content that its opcode demands.
    Malformed {
        opcode: u8,
        length: usize,
        error: McapError,
    },
    /// A record without use here.
    Other(u8),
}

impl Found {
    fn new(opcode: u8, data: &[u8]) -> Self {
        match opcode {
            op::CHUNK => Self::Chunk(data.to_vec()),
            op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA | op::STATISTICS => {
                match mcap::parse_record(opcode, data) {
                    Ok(record) => Self::Record(record.into_owned()),
                    Err(error) => Self::Malformed {
                        opcode,
                        length: data.len(),
                        error,
                    },
                }
            }
            // Attachments that other programs have written may be large, and are not read.
            op::ATTACHMENT if data.len() <= MAX_ATTACHMENT => {
                attachment(data).map_or(Self::Other(opcode), Self::Record)
            }
            _ => Self::Other(opcode),
        }
    }
}

/// Parses an attachment; `None` if it is malformed. `parse_record` of the mcap crate 0.26.0 panics if the length of its data is
/// greater than what is there.
pub(crate) fn attachment(record: &[u8]) -> Option<Record<'static>> {
    let mut rest = record;
    let mut take = |length: usize| {
        let (taken, left) = rest.split_at_checked(length)?;
        rest = left;
        Some(taken)
    };
    let log_time = u64::from_le_bytes(take(8)?.try_into().ok()?);
    let create_time = u64::from_le_bytes(take(8)?.try_into().ok()?);
    let mut texts = [String::new(), String::new()];
    for text in &mut texts {
        let length = u32::from_le_bytes(take(4)?.try_into().ok()?);
        *text = str::from_utf8(take(length.try_into().ok()?)?)
            .ok()?
            .to_owned();
    }
    let length = u64::from_le_bytes(take(8)?.try_into().ok()?);
    let data = take(length.try_into().ok()?)?.to_vec().into();
    let crc = u32::from_le_bytes(take(4)?.try_into().ok()?);
    let [name, media_type] = texts;
    let header = AttachmentHeader {
        log_time,
        create_time,
        name,
        media_type,
    };
    Some(Record::Attachment { header, data, crc })
}

impl RecordReader {
    /// Opens a file and checks its first bytes.
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
        if !begin.starts_with(MAGIC) {
            return Err(not_mcap(path, &begin));
        }
        let position = MAGIC.len() as u64;
        file.seek(SeekFrom::Start(position)).map_err(io)?;
        Ok(Self {
            path: path.to_path_buf(),
            file,
            length,
            left: length - position,
            records: file_reader(),
            chunk: None,
            begins: position,
            position,
            compression: None,
            unpacked: Unpacked::default(),
            past_data: false,
            stated_messages: None,
            end: None,
            index: None,
        })
    }

    /// Length of the file \[bytes\].
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Compression of the last chunk.
    pub fn compression(&self) -> Option<ChunkCompression> {
        self.compression
    }

    /// Number of messages that the file has according to its statistics, once its end is reached.
    pub fn stated_messages(&self) -> Option<u64> {
        self.stated_messages
    }

    /// How the file ends, once its end is reached.
    pub fn end(&self) -> Option<FileEnd> {
        self.end
    }

    /// Compares the index with what it is about while the file is read; to be called before anything is read.
    pub fn check_index(&mut self) {
        self.index = Some(IndexCheck::new());
    }

    /// Ends the [check](Self::check_index) without a result.
    pub fn drop_index_check(&mut self) {
        self.index = None;
    }

    /// Notes something that cannot be read, which other readers may read.
    pub fn note_unreadable(&mut self, fault: &RecordingError) {
        if let (Some(index), RecordingError::Damaged { offset, reason, .. }) =
            (&mut self.index, fault)
        {
            index.note(*offset, reason);
        }
    }

    /// Why other readers may find something else in the file than this one has found, once its end is reached; `None` if they
    /// cannot, or if that is not [checked](Self::check_index).
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn index_fault(&mut self) -> Result<Option<String>, RecordingError> {
        let Some(mut index) = self.index.take() else {
            return Ok(None);
        };
        match self.end {
            Some(FileEnd::Whole) if self.left == 0 => {}
            Some(FileEnd::Whole) => index.note(
                self.length - self.left,
                &format!(
                    "expected the end of the file, found {} further bytes",
                    self.left
                ),
            ),
            _ => self.check_tail(&mut index)?,
        }
        Ok(index.finish())
    }

    /// A file that was cut off must not end with a footer, by which others find an index; and behind zeros, where reading
    /// ends, there is nothing.
    fn check_tail(&mut self, index: &mut IndexCheck) -> Result<(), RecordingError> {
        let io = |source| RecordingError::io("read", &self.path, source);
        let mut read = |from: u64, receive: &mut dyn FnMut(&[u8])| {
            self.file.seek(SeekFrom::Start(from))?;
            let mut rest = (&mut self.file).take(self.length - from);
            let mut piece = vec![0; READ_BUFFER];
            loop {
                match rest.read(&mut piece)? {
                    0 => return Ok(()),
                    length => receive(&piece[..length]),
                }
            }
        };
        let mut last = Vec::new();
        let from = self.length.saturating_sub(FOOTER);
        read(from, &mut |piece| last.extend(piece)).map_err(io)?;
        if last.ends_with(MAGIC)
            || (last.len() as u64 == FOOTER && last.first() == Some(&op::FOOTER))
        {
            index.note(
                from,
                "expected no footer in a file that is cut off or damaged before, found one",
            );
        }
        let mut first = None;
        let mut is_zero = true;
        read(self.begins, &mut |piece| {
            first = first.or(piece.first().copied());
            is_zero &= piece.iter().all(|byte| *byte == 0);
        })
        .map_err(io)?;
        if first == Some(0) && !is_zero {
            index.note(
                self.begins,
                "expected only zeros up to the end of the file, found other bytes",
            );
        }
        Ok(())
    }

    /// Reads the next record that matters: header, schema, channel, message or metadata, also from within chunks;
    /// `None` at the end of the file, however it ends.
    ///
    /// # Errors
    /// The file cannot be read, or a record or chunk is damaged. The next call goes on behind it.
    pub fn next(&mut self) -> Result<Option<Record<'static>>, RecordingError> {
        loop {
            let found = match &mut self.chunk {
                Some(chunk) => chunk.next(self.index.as_mut()),
                None if self.end.is_some() => return Ok(None),
                None => self.next_in_file()?,
            };
            match found {
                Ok(Some(Found::Record(Record::Statistics(it)))) => {
                    self.stated_messages = Some(it.message_count);
                }
                Ok(Some(Found::Record(record))) if !self.past_data => return Ok(Some(record)),
                Ok(Some(Found::Malformed {
                    opcode,
                    length,
                    error,
                })) if !self.past_data => {
                    return Err(self.damaged(format!(
                        "a record of kind {opcode:#04x} with {length} bytes cannot be parsed: {error}"
                    )));
                }
                Ok(Some(Found::Chunk(bytes))) if self.chunk.is_none() && !self.past_data => {
                    let opened = Chunk::open(bytes, self.position, &mut self.unpacked);
                    let (chunk, compression) = opened.map_err(|reason| self.damaged(reason))?;
                    self.compression = Some(compression);
                    self.chunk = Some(chunk);
                }
                Ok(Some(_)) => {}
                Ok(None) => self.chunk = None,
                Err(error) => {
                    self.chunk = None;
                    return Err(self.damaged(format!("the chunk cannot be read: {error}")));
                }
            }
        }
    }

    /// Something is wrong with the current record.
    pub fn damaged(&self, reason: String) -> RecordingError {
        RecordingError::Damaged {
            path: self.path.clone(),
            offset: self.begins,
            reason,
        }
    }

    /// The next record of the file itself; `None` at its end.
    fn next_in_file(&mut self) -> Result<McapResult<Option<Found>>, RecordingError> {
        self.begins = self.position;
        match self.read_file()? {
            Ok(Some((Found::Other(op::FOOTER), _))) => {
                let is_whole = matches!(self.read_file()?, Ok(None));
                self.end = Some(match is_whole {
                    true => FileEnd::Whole,
                    false => FileEnd::InRecord(self.begins),
                });
            }
            // A loss of power leaves zeros at the end of a file.
            Ok(Some((Found::Other(0), _))) => self.end = Some(FileEnd::InRecord(self.begins)),
            Ok(Some((found, length))) => {
                self.position += HEAD + length as u64;
                self.past_data |= matches!(found, Found::Other(op::DATA_END));
                return Ok(Ok(Some(found)));
            }
            Err(McapError::RecordTooLarge { opcode, len }) if opcode != 0 && len <= self.left => {
                return self.skip(len);
            }
            Err(McapError::UnexpectedEof) if self.begins == self.length => {
                self.end = Some(FileEnd::CutOff(self.begins));
            }
            Ok(None) | Err(_) => self.end = Some(FileEnd::InRecord(self.begins)),
        }
        Ok(Ok(None))
    }

    fn read_file(&mut self) -> Result<McapResult<Option<(Found, usize)>>, RecordingError> {
        let index = &mut self.index;
        let read = advance(
            &mut self.records,
            &mut self.file,
            &mut self.left,
            |opcode, content| {
                if let Some(index) = index {
                    index.record(opcode, content);
                }
            },
        );
        read.map_err(|source| match source.kind() {
            io::ErrorKind::UnexpectedEof => RecordingError::Changed {
                path: self.path.clone(),
            },
            _ => RecordingError::io("read", &self.path, source),
        })
    }

    /// Leaves out a record that is too large, of which the head was read.
    fn skip<T>(&mut self, length: u64) -> Result<T, RecordingError> {
        let offset = i64::try_from(length).unwrap_or(i64::MAX);
        self.file
            .seek_relative(offset)
            .map_err(|source| RecordingError::io("read", &self.path, source))?;
        self.left -= length;
        self.position += HEAD + length;
        self.records = file_reader();
        Err(self.damaged(format!(
            "expected records of at most {} MiB, found one of {length} bytes",
            MAX_CHUNK >> 20
        )))
    }
}

/// The records in a chunk.
struct Chunk {
    records: LinearReader,
    bytes: io::Cursor<Vec<u8>>,
    /// How many of the bytes were not read yet.
    left: u64,
}

impl Chunk {
    /// Opens the chunk that ends at the byte `end` of its file.
    fn open(
        mut bytes: Vec<u8>,
        end: u64,
        unpacked: &mut Unpacked,
    ) -> Result<(Self, ChunkCompression), String> {
        let header = match mcap::parse_record(op::CHUNK, &bytes) {
            Ok(Record::Chunk { header, .. }) => header,
            Ok(_) => return Err("expected a chunk".to_owned()),
            Err(error) => return Err(format!("the head of the chunk cannot be read: {error}")),
        };
        let compression = match header.compression.as_str() {
            "" => ChunkCompression::None,
            "lz4" => ChunkCompression::Lz4,
            "zstd" => ChunkCompression::Zstd,
            other => {
                return Err(format!(
                    "expected compression lz4, zstd or none, found {other:?}"
                ));
            }
        };
        if header.uncompressed_size > MAX_CHUNK as u64 {
            return Err(format!(
                "expected chunks of at most {} MiB, found one of {} bytes",
                MAX_CHUNK >> 20,
                header.uncompressed_size
            ));
        }
        if compression != ChunkCompression::None {
            unpacked.add(end, header.uncompressed_size)?;
        }
        // Bytes behind the compressed records are not part of them, and the mcap crate could read a record beyond its end.
        let head = 8 + 8 + 8 + 4 + 4 + header.compression.len() + 8;
        bytes.truncate(head + usize::try_from(header.compressed_size).unwrap_or(0));
        let left = bytes.len() as u64;
        let mut records = LinearReader::new_with_options(
            options()
                .with_skip_end_magic(true)
                .with_prevalidate_chunk_crcs(true),
        );
        let start = records.insert(9);
        start[0] = op::CHUNK;
        start[1..9].copy_from_slice(&left.to_le_bytes());
        records.notify_read(9);
        let bytes = io::Cursor::new(bytes);
        let chunk = Self {
            records,
            bytes,
            left,
        };
        Ok((chunk, compression))
    }

    /// The next record; `None` at the end of the chunk.
    fn next(&mut self, index: Option<&mut IndexCheck>) -> McapResult<Option<Found>> {
        let mut index = index;
        let found = advance(
            &mut self.records,
            &mut self.bytes,
            &mut self.left,
            |opcode, content| {
                if let Some(index) = &mut index {
                    index.record_in_chunk(opcode, content);
                }
            },
        )??;
        Ok(found.map(|(found, _)| found))
    }
}

/// Lets `reader` read from `source`, in which `left` bytes are left, until it comes to a record or to the end.
/// Of a record comes its length, too \[bytes\]; `see` gets its opcode and content.
fn advance(
    reader: &mut LinearReader,
    source: &mut impl Read,
    left: &mut u64,
    mut see: impl FnMut(u8, &[u8]),
) -> io::Result<McapResult<Option<(Found, usize)>>> {
    loop {
        let wanted = match reader.next_event() {
            None => return Ok(Ok(None)),
            Some(Err(error)) => return Ok(Err(error)),
            Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                see(opcode, data);
                return Ok(Ok(Some((Found::new(opcode, data), data.len()))));
            }
            Some(Ok(LinearReadEvent::ReadRequest(wanted))) => wanted,
        };
        let available = if wanted as u64 <= *left { wanted } else { 0 };
        // Nothing read tells the reader that there is no more.
        source.read_exact(reader.insert(available))?;
        reader.notify_read(available);
        *left -= available as u64;
    }
}

fn file_reader() -> LinearReader {
    LinearReader::new_with_options(options().with_emit_chunks(true))
}

/// Options of all readers; the magic bytes at the beginning are checked here.
fn options() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_record_length_limit(MAX_CHUNK)
}

/// The error for a file that is not MCAP, with what it is instead, if that can be recognised.
fn not_mcap(path: &Path, begin: &[u8]) -> RecordingError {
    let hint = if MAGIC.starts_with(begin) {
        ": it is cut off in its first bytes, nothing was recorded in it"
    } else if begin.starts_with(b"#ROSBAG V") {
        ": it is a bag of ROS 1; convert it with: rosbags-convert --src IN.bag --dst OUT --dst-storage mcap"
    } else if begin.starts_with(b"SQLite format 3") {
        ": it is a bag of rosbag2 in SQLite; convert it with: ros2 bag convert"
    } else if begin.starts_with(&[0x28, 0xb5, 0x2f, 0xfd]) {
        ": it is compressed with zstd; decompress it with: zstd -d FILE"
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
