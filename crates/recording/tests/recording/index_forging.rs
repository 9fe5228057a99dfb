//! Forges the ways by which other readers find messages, and leaves the sealed messages as they are: the tools.

use binrw::{BinWrite, BinWriterExt as _};
use mcap::MAGIC;
use mcap::records::{ChunkIndex, Footer, Record, SummaryOffset, op};

/// Length of the opcode and the length in front of each record \[bytes\].
const HEAD: usize = 9;

/// Where the checksum and the records are in the content of a chunk that is not compressed.
const CHUNK_CRC: usize = 24;
const CHUNK_RECORDS: usize = 40;

pub type RawRecord = (u8, Vec<u8>);

/// A file, taken apart into the records of the data, what is behind the data, and the summary without its offsets.
#[derive(Clone)]
pub struct RawFile {
    pub data: Vec<RawRecord>,
    pub behind_data: Vec<RawRecord>,
    pub summary: Vec<RawRecord>,
}

impl RawFile {
    pub fn read(bytes: &[u8]) -> Self {
        let mut all = Vec::new();
        let mut rest = &bytes[MAGIC.len()..bytes.len() - MAGIC.len()];
        while let Some((opcode, after)) = rest.split_first() {
            let (length, after) = after.split_first_chunk().unwrap();
            let length = usize::try_from(u64::from_le_bytes(*length)).unwrap();
            all.push((*opcode, after[..length].to_vec()));
            rest = &after[length..];
        }
        let end = all.iter().position(|it| it.0 == op::DATA_END).unwrap();
        let mut summary = all.split_off(end + 1);
        all.truncate(end);
        summary.retain(|it| ![op::SUMMARY_OFFSET, op::FOOTER].contains(&it.0));
        Self {
            data: all,
            behind_data: Vec::new(),
            summary,
        }
    }

    /// Where each record of the data begins, and behind them where the data end.
    pub fn offsets(&self) -> Vec<u64> {
        let mut at = MAGIC.len();
        let mut offsets = vec![at as u64];
        for (_, content) in &self.data {
            at += HEAD + content.len();
            offsets.push(at as u64);
        }
        offsets
    }

    /// The file with correct checksums, and correct offsets of the groups in the summary.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        put_all(&mut bytes, &self.data);
        let crc = crc32fast::hash(&bytes).to_le_bytes();
        put(&mut bytes, op::DATA_END, &crc);
        put_all(&mut bytes, &self.behind_data);
        let summary = self.end(bytes.len());
        bytes.extend(summary);
        bytes
    }

    /// Summary, footer and magic bytes, for a file in which they begin here.
    pub fn end(&self, begins: usize) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut offsets: Vec<SummaryOffset> = Vec::new();
        for record in &self.summary {
            let group_start = (begins + bytes.len()) as u64;
            put(&mut bytes, record.0, &record.1);
            let group_length = (HEAD + record.1.len()) as u64;
            match offsets.last_mut().filter(|it| it.group_opcode == record.0) {
                Some(group) => group.group_length += group_length,
                None => offsets.push(SummaryOffset {
                    group_opcode: record.0,
                    group_start,
                    group_length,
                }),
            }
        }
        let mut footer = Footer {
            summary_start: begins as u64,
            summary_offset_start: (begins + bytes.len()) as u64,
            summary_crc: 0,
        };
        for offset in &offsets {
            put(&mut bytes, op::SUMMARY_OFFSET, &content(offset));
        }
        put(&mut bytes, op::FOOTER, &content(&footer));
        bytes.truncate(bytes.len() - 4);
        footer.summary_crc = crc32fast::hash(&bytes);
        bytes.extend(footer.summary_crc.to_le_bytes());
        bytes.extend(MAGIC);
        bytes
    }

    /// Position of the first chunk that contains this text.
    pub fn chunk_with(&self, text: &[u8]) -> usize {
        let is_it = |it: &RawRecord| it.0 == op::CHUNK && find(&it.1, text).is_some();
        self.data.iter().position(is_it).expect("a chunk with it")
    }

    /// Changes the chunk indexes.
    pub fn change_chunk_indexes(&mut self, mut change: impl FnMut(&mut ChunkIndex)) {
        for (opcode, record) in &mut self.summary {
            if let Ok(Record::ChunkIndex(mut index)) = mcap::parse_record(*opcode, record) {
                change(&mut index);
                *record = content(&index);
            }
        }
    }

    /// Lets the index of the chunk at this offset lead somewhere else.
    pub fn redirect(&mut self, from: u64, to: u64) {
        let mut redirected = 0;
        self.change_chunk_indexes(|index| {
            if index.chunk_start_offset == from {
                index.chunk_start_offset = to;
                redirected += 1;
            }
        });
        assert_eq!(redirected, 1);
    }

    /// The record of this kind in the summary.
    pub fn in_summary(&mut self, opcode: u8) -> &mut Vec<u8> {
        let mut records = self.summary.iter_mut();
        &mut records.find(|it| it.0 == opcode).unwrap().1
    }
}

/// Content of a record.
pub fn content(record: &impl for<'a> BinWrite<Args<'a> = ()>) -> Vec<u8> {
    let mut content = std::io::Cursor::new(Vec::new());
    content.write_le(record).unwrap();
    content.into_inner()
}

pub fn put(bytes: &mut Vec<u8>, opcode: u8, content: &[u8]) {
    bytes.push(opcode);
    bytes.extend((content.len() as u64).to_le_bytes());
    bytes.extend(content);
}

fn put_all(bytes: &mut Vec<u8>, records: &[RawRecord]) {
    for (opcode, content) in records {
        put(bytes, *opcode, content);
    }
}

pub fn find(bytes: &[u8], text: &[u8]) -> Option<usize> {
    bytes.windows(text.len()).position(|it| it == text)
}

/// Replaces a text by one of the same length.
pub fn replace(bytes: &mut [u8], from: &[u8], to: &[u8]) {
    let at = find(bytes, from).expect("the text");
    bytes[at..at + from.len()].copy_from_slice(to);
}

/// A chunk with another text, and with a checksum that is correct.
pub fn forged_chunk(chunk: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let mut forged = chunk.to_vec();
    replace(&mut forged, from, to);
    let crc = crc32fast::hash(&forged[CHUNK_RECORDS..]);
    forged[CHUNK_CRC..CHUNK_CRC + 4].copy_from_slice(&crc.to_le_bytes());
    forged
}

/// A chunk as a whole record.
pub fn as_record(chunk: &[u8]) -> Vec<u8> {
    let mut record = Vec::new();
    put(&mut record, op::CHUNK, chunk);
    record
}

/// An attachment, and where in its content the data begin.
pub fn attachment(name: &str, data: &[u8]) -> (Vec<u8>, usize) {
    let mut record = vec![0; 16];
    for text in [name, "application/octet-stream"] {
        record.extend(u32::try_from(text.len()).unwrap().to_le_bytes());
        record.extend(text.as_bytes());
    }
    record.extend((data.len() as u64).to_le_bytes());
    let begins = record.len();
    record.extend(data);
    let crc = crc32fast::hash(&record);
    record.extend(crc.to_le_bytes());
    (record, begins)
}
