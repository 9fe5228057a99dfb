//! The index of a sealed file leads to the sealed messages and to nothing else. Each forgery leaves every sealed message as it
//! was, and is shown to deceive a reader that uses the index.

use std::fs;
use std::io::Write as _;

use mcap::Summary;
use mcap::records::{ChunkHeader, MessageIndex, Record, op};
use rosbag2_mcap::{ChunkCompression, Reader, repair};

use super::index_forging::{
    RawFile, as_record, attachment, content, find, forged_chunk, put, replace,
};
use super::sample::{COMPRESSIONS, sample};
use super::seal::{Sealed, opened, write};

/// What is recorded, and what the forger wants others to read.
const TRUE: &[u8] = b"measurement 46,";
const FALSE: &[u8] = b"measurement 09,";

/// Where the content of a private record, and a chunk in it, begins.
const HEAD: u64 = 9;

struct Forgery {
    sealed: Sealed,
    file: RawFile,
    /// Position of the chunk with the message that is to be replaced, and where it begins.
    chunk: usize,
    offset: u64,
    forged: Vec<u8>,
}

impl Forgery {
    fn new() -> Self {
        let sealed = Sealed::new();
        let bytes = fs::read(&sealed.file).unwrap();
        let file = RawFile::read(&bytes);
        assert_eq!(file.bytes(), bytes, "the forger writes files as they are");
        let chunk = file.chunk_with(TRUE);
        Self {
            offset: file.offsets()[chunk],
            forged: forged_chunk(&file.data[chunk].1, TRUE, FALSE),
            sealed,
            chunk,
            file,
        }
    }

    /// Where a record begins that is added to the data.
    fn next(&self) -> u64 {
        *self.file.offsets().last().unwrap()
    }

    fn bytes(&self) -> Vec<u8> {
        self.file.bytes()
    }

    /// Demands that this crate still reads every sealed message, and finds the forgery; returns what it says.
    fn assert_found(&self, bytes: &[u8], expected: &str) {
        let path = self.sealed.folder.path().join("forged.mcap");
        fs::write(&path, bytes).unwrap();
        let seal = opened(&path);
        assert_eq!((seal.covered, seal.uncovered), (136, 0), "{seal:?}");
        let fault = seal.fault.unwrap_or_else(|| panic!("not noticed"));
        assert!(
            fault.contains("other readers may find something else") && fault.contains(expected),
            "{fault}"
        );
    }
}

/// The messages that a reader finds by the index: their topics and contents.
fn found_by_index(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let summary = Summary::read(bytes).unwrap().expect("a summary");
    let mut found = Vec::new();
    for index in &summary.chunk_indexes {
        for message in summary.stream_chunk(bytes, index).unwrap() {
            let message = message.unwrap();
            found.push((message.channel.topic.clone(), message.data.to_vec()));
        }
    }
    found
}

fn shows(bytes: &[u8], text: &[u8]) -> bool {
    let found = found_by_index(bytes);
    found.iter().any(|(_, data)| find(data, text).is_some())
}

/// The reader that uses the index shows the false message and not the true one.
fn assert_deceives(bytes: &[u8]) {
    assert!(
        shows(bytes, FALSE) && !shows(bytes, TRUE),
        "this deceives nobody"
    );
}

#[test]
fn what_is_not_forged_deceives_nobody() {
    let forgery = Forgery::new();
    let bytes = forgery.bytes();
    assert!(shows(&bytes, TRUE) && !shows(&bytes, FALSE));
    assert_eq!(found_by_index(&bytes).len(), 136);
}

#[test]
fn a_forged_chunk_in_an_attachment_is_found() {
    let mut forgery = Forgery::new();
    for name in ["note", super::forging::SEAL] {
        let mut file = forgery.file.clone();
        let (record, begins) = attachment(name, &as_record(&forgery.forged));
        file.redirect(forgery.offset, forgery.next() + HEAD + begins as u64);
        file.data.push((op::ATTACHMENT, record));
        let before = std::mem::replace(&mut forgery.file, file);
        assert_deceives(&forgery.bytes());
        let path = forgery.sealed.folder.path().join("forged.mcap");
        fs::write(&path, forgery.bytes()).unwrap();
        match name {
            "note" => forgery.assert_found(
                &forgery.bytes(),
                "no attachment but the one of the last seal",
            ),
            _ => assert!(opened(&path).fault.unwrap().contains("attachment")),
        }
        forgery.file = before;
    }
}

#[test]
fn a_forged_chunk_in_a_private_record_is_found() {
    let mut forgery = Forgery::new();
    let at = forgery.next() + HEAD;
    forgery.file.redirect(forgery.offset, at);
    let record = as_record(&forgery.forged);
    forgery.file.data.push((0x80, record));
    assert_deceives(&forgery.bytes());
    forgery.assert_found(&forgery.bytes(), "a private record of kind 0x80");
}

#[test]
fn a_forged_chunk_behind_the_end_of_the_data_is_found() {
    let mut forgery = Forgery::new();
    let behind = forgery.next() + HEAD + 4;
    forgery.file.redirect(forgery.offset, behind);
    let forged = forgery.forged.clone();
    forgery.file.behind_data.push((op::CHUNK, forged));
    assert_deceives(&forgery.bytes());
    forgery.assert_found(&forgery.bytes(), "expected a schema, found a chunk");
}

#[test]
fn a_forged_chunk_behind_the_end_of_the_file_is_found() {
    let mut forgery = Forgery::new();
    let mut bytes = forgery.bytes();
    forgery.file.redirect(forgery.offset, bytes.len() as u64);
    put(&mut bytes, op::CHUNK, &forgery.forged);
    let end = forgery.file.end(bytes.len());
    bytes.extend(end);
    assert_deceives(&bytes);
    forgery.assert_found(&bytes, "expected the end of the file");
}

/// Reading ends where a loss of power has left zeros, but a footer at the end leads others to what is behind them.
#[test]
fn a_forged_chunk_behind_zeros_is_found() {
    let mut forgery = Forgery::new();
    let at = forgery.next() + 2 * HEAD;
    forgery.file.redirect(forgery.offset, at - HEAD);
    let forged = forgery.forged.clone();
    forgery.file.data.push((0, Vec::new()));
    forgery.file.data.push((op::CHUNK, forged));
    assert_deceives(&forgery.bytes());
    forgery.assert_found(&forgery.bytes(), "no footer in a file that is cut off");
    // Without an end, others read it from its beginning.
    let bytes = forgery.bytes();
    let end = usize::try_from(forgery.next()).unwrap();
    forgery.assert_found(&bytes[..end], "expected only zeros");
}

#[test]
fn zeros_that_a_loss_of_power_leaves_are_no_forgery() {
    let forgery = Forgery::new();
    let mut bytes = forgery.bytes()[..usize::try_from(forgery.next()).unwrap()].to_vec();
    bytes.resize(bytes.len() + 5000, 0);
    let path = forgery.sealed.folder.path().join("zeros.mcap");
    fs::write(&path, bytes).unwrap();
    let seal = opened(&path);
    assert_eq!((seal.fault, seal.covered), (None, 136));
}

/// Its checksum is wrong, which not every reader looks at; this crate leaves such a chunk out.
#[test]
fn a_forged_chunk_that_this_crate_does_not_read_is_found() {
    let mut forgery = Forgery::new();
    let at = forgery.next();
    forgery.file.redirect(forgery.offset, at);
    let mut forged = forgery.forged.clone();
    forged[24] ^= 1;
    forgery.file.data.push((op::CHUNK, forged));
    forgery.assert_found(&forgery.bytes(), "CRC");
}

#[test]
fn an_index_entry_that_was_left_out_is_found() {
    let mut forgery = Forgery::new();
    let offset = forgery.offset;
    forgery.file.summary.retain(
        |(opcode, record)| match mcap::parse_record(*opcode, record) {
            Ok(Record::ChunkIndex(index)) => index.chunk_start_offset != offset,
            _ => true,
        },
    );
    assert!(!shows(&forgery.bytes(), TRUE));
    let expected = format!("expected the index of a chunk at byte {offset}, found");
    forgery.assert_found(&forgery.bytes(), &expected);
}

#[test]
fn an_index_entry_that_leads_to_another_chunk_is_found() {
    let mut forgery = Forgery::new();
    let (length, other) = {
        let offsets = forgery.file.offsets();
        let other = forgery.file.chunk_with(b"measurement 30,");
        (offsets[other + 1] - offsets[other], offsets[other])
    };
    let offset = forgery.offset;
    forgery.file.change_chunk_indexes(|index| {
        if index.chunk_start_offset == offset {
            (index.chunk_start_offset, index.chunk_length) = (other, length);
        }
    });
    assert!(!shows(&forgery.bytes(), TRUE));
    let expected = format!(
        "expected the index of a chunk at byte {offset}, found the index of a chunk at byte {other}"
    );
    forgery.assert_found(&forgery.bytes(), &expected);
}

/// By other times in the index, readers of a part of the time leave the chunk out; by other channels, those of some topics.
#[test]
fn an_index_entry_with_other_times_or_channels_is_found() {
    let mut forgery = Forgery::new();
    let (original, offset) = (forgery.file.clone(), forgery.offset);
    for kind in 0..2 {
        forgery.file = original.clone();
        forgery.file.change_chunk_indexes(|index| {
            if index.chunk_start_offset == offset {
                match kind {
                    0 => index.message_end_time = index.message_start_time,
                    _ => drop(index.message_index_offsets.pop_first().unwrap()),
                }
            }
        });
        assert!(forgery.bytes() != original.bytes());
        forgery.assert_found(&forgery.bytes(), "as it follows from the data");
    }
}

#[test]
fn message_indexes_that_lead_elsewhere_or_are_left_out_are_found() {
    let mut forgery = Forgery::new();
    let (original, chunk) = (forgery.file.clone(), forgery.chunk);
    let (opcode, record) = &original.data[chunk + 1];
    let Ok(Record::MessageIndex(index)) = mcap::parse_record(*opcode, record) else {
        panic!("no message index behind the chunk");
    };
    // The first message is hidden behind the second, or left out, or there is no index at all.
    let (mut hidden, mut left_out): (MessageIndex, MessageIndex) = (index.clone(), index);
    hidden.records[0].offset = hidden.records[1].offset;
    forgery.file.data[chunk + 1].1 = content(&hidden);
    let bytes = forgery.bytes();
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let at = summary
        .chunk_indexes
        .iter()
        .find(|it| it.chunk_start_offset == forgery.offset)
        .unwrap();
    let channel = &summary.channels[&hidden.channel_id];
    let entries = summary.read_message_indexes(&bytes, at).unwrap();
    assert!(entries[channel][0].offset == entries[channel][1].offset);
    forgery.assert_found(&bytes, "as it follows from the data");
    left_out.records.remove(0);
    forgery.file.data[chunk + 1].1 = content(&left_out);
    forgery.assert_found(&forgery.bytes(), "expected the index of ");
    forgery.file.data.remove(chunk + 1);
    forgery.assert_found(&forgery.bytes(), "expected the index of ");
}

#[test]
fn a_summary_that_differs_from_the_data_is_found() {
    let mut forgery = Forgery::new();
    let original = forgery.file.clone();
    // Messages of another topic and another type, for readers that take them from the summary.
    replace(forgery.file.in_summary(op::CHANNEL), b"/fast", b"/last");
    let bytes = forgery.bytes();
    assert!(found_by_index(&bytes).iter().any(|it| it.0 == "/last"));
    forgery.assert_found(&bytes, "expected a channel as it follows from the data");
    forgery.file = original.clone();
    replace(forgery.file.in_summary(op::SCHEMA), b"float64", b"int64  ");
    forgery.assert_found(&forgery.bytes(), "expected a schema as it follows");
    // A number of messages.
    forgery.file = original.clone();
    forgery.file.in_summary(op::STATISTICS)[0] ^= 1;
    let stats = Summary::read(&forgery.bytes()).unwrap().unwrap().stats;
    assert_eq!(stats.unwrap().message_count, 136 ^ 1);
    forgery.assert_found(&forgery.bytes(), "expected the statistics as it follows");
    // Metadata records and attachments that are elsewhere, or not there.
    for opcode in [op::METADATA_INDEX, op::ATTACHMENT_INDEX] {
        forgery.file = original.clone();
        forgery.file.in_summary(opcode)[0] ^= 1;
        forgery.assert_found(&forgery.bytes(), "expected the index of a");
        forgery.file = original.clone();
        let first = forgery.file.summary.iter().position(|it| it.0 == opcode);
        forgery.file.summary.remove(first.unwrap());
        forgery.assert_found(&forgery.bytes(), "expected the index of a");
    }
    // A private record within the summary, and one in front of it.
    forgery.file = original.clone();
    forgery.file.summary.push((0x80, vec![7]));
    forgery.assert_found(&forgery.bytes(), "a private record");
    forgery.file = original;
    forgery.file.behind_data.push((0x80, vec![7]));
    forgery.assert_found(&forgery.bytes(), "a private record");
}

/// The offsets of the groups and the footer lead to the summary; the checksums say that nobody has changed it.
#[test]
fn forged_offsets_and_checksums_are_found() {
    let forgery = Forgery::new();
    let original = forgery.bytes();
    let footer = original.len() - 8 - 20;
    let group = footer - 9 - 17;
    let end_of_data = usize::try_from(forgery.next()).unwrap() + 9;
    for (at, expected) in [
        (group + 1, "expected an offset in the summary as it follows"),
        (group + 9, "expected an offset in the summary as it follows"),
        (footer + 8, "expected the footer as it follows"),
        (footer + 16, "expected the footer as it follows"),
        (end_of_data, "expected the checksum of the data"),
    ] {
        let mut bytes = original.clone();
        bytes[at] ^= 1;
        forgery.assert_found(&bytes, expected);
    }
}

#[test]
fn a_second_meaning_of_a_channel_is_found() {
    let mut forgery = Forgery::new();
    // A chunk without messages, which is counted in the summary as it should be.
    let mut channel = forgery.file.in_summary(op::CHANNEL).clone();
    replace(&mut channel, b"/fast", b"/last");
    let mut records = Vec::new();
    put(&mut records, op::CHANNEL, &channel);
    let header = ChunkHeader {
        message_start_time: 0,
        message_end_time: 0,
        uncompressed_size: records.len() as u64,
        uncompressed_crc: crc32fast::hash(&records),
        compression: String::new(),
        compressed_size: records.len() as u64,
    };
    let mut chunk = content(&header);
    chunk.extend(&records);
    forgery.file.data.push((op::CHUNK, chunk));
    forgery.assert_found(&forgery.bytes(), "found a second one");
}

/// Decompressors differ in what they do with a chunk whose records go on behind what it states, or that has a second frame.
#[test]
fn more_records_in_a_compressed_chunk_than_it_states_are_found() {
    let sealed = Sealed::new();
    for compression in [ChunkCompression::Lz4, ChunkCompression::Zstd] {
        let name = format!("{compression:?}");
        let messages = sample(100);
        let directory = write(
            sealed.folder.path(),
            &name,
            &sealed.key,
            compression,
            &messages,
        );
        let path = directory.join(format!("{name}_0.mcap"));
        let original = RawFile::read(&fs::read(&path).unwrap());
        let position = original
            .data
            .iter()
            .rposition(|it| it.0 == op::CHUNK)
            .unwrap();
        let (opcode, record) = &original.data[position];
        let Ok(Record::Chunk { mut header, data }) = mcap::parse_record(*opcode, record) else {
            unreachable!()
        };
        let stated = usize::try_from(header.uncompressed_size).unwrap();
        let compressed = |bytes: &[u8]| match compression {
            ChunkCompression::Zstd => zstd::encode_all(bytes, 0).unwrap(),
            _ => {
                let mut encoder = lz4::EncoderBuilder::new().build(Vec::new()).unwrap();
                encoder.write_all(bytes).unwrap();
                encoder.finish().0
            }
        };
        let plain = match compression {
            ChunkCompression::Zstd => zstd::decode_all(&data[..]).unwrap(),
            _ => {
                let mut plain = Vec::new();
                std::io::copy(&mut lz4::Decoder::new(&data[..]).unwrap(), &mut plain).unwrap();
                plain
            }
        };
        assert_eq!(plain.len(), stated);
        let again = [plain.clone(), plain.clone()].concat();
        let second_frame = [data.to_vec(), compressed(&plain)].concat();
        for (forged, expected) in [
            (compressed(&again), "found another number"),
            (second_frame, "behind its compressed records"),
        ] {
            header.compressed_size = forged.len() as u64;
            let mut file = original.clone();
            file.data[position].1 = [content(&header), forged].concat();
            let forged = sealed.folder.path().join("forged.mcap");
            fs::write(&forged, file.bytes()).unwrap();
            let seal = opened(&forged);
            assert_eq!((seal.covered, seal.uncovered), (136, 0), "{seal:?}");
            let fault = seal.fault.expect("not noticed");
            assert!(fault.contains(expected), "{fault}");
        }
    }
}

/// A repair writes a new index for what is sealed, so that the forgery is gone.
#[test]
fn a_repair_of_a_forged_index_leads_to_the_sealed_messages() {
    let mut forgery = Forgery::new();
    let at = forgery.next() + HEAD;
    forgery.file.redirect(forgery.offset, at);
    let record = as_record(&forgery.forged);
    forgery.file.data.push((0x80, record));
    fs::write(&forgery.sealed.file, forgery.bytes()).unwrap();
    let directory = forgery.sealed.file.parent().unwrap();
    fs::remove_file(directory.join("metadata.yaml")).unwrap();
    let repaired = repair(directory, None).unwrap().unwrap();
    let file = Reader::open(&repaired.directory).unwrap().files()[0].clone();
    let seal = opened(&file);
    assert!(seal.holds() && seal.uncovered == 0, "{seal:?}");
    let bytes = fs::read(file).unwrap();
    assert!(shows(&bytes, TRUE) && !shows(&bytes, FALSE));
}

#[test]
fn untouched_recordings_of_every_compression_hold() {
    let sealed = Sealed::new();
    for compression in COMPRESSIONS {
        for count in [0, 1, 7, 2000] {
            let name = format!("{compression:?}{count}");
            let messages = sample(count);
            let directory = write(
                sealed.folder.path(),
                &name,
                &sealed.key,
                compression,
                &messages,
            );
            let seal = opened(&directory);
            assert_eq!(seal.fault, None, "{name}");
            assert_eq!(seal.covered, messages.len() as u64);
        }
    }
}
