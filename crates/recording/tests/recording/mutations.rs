//! Reading a damaged file never panics, uses bounded memory, and ends.

use std::fs;
use std::path::Path;

use rosbag2_mcap::{Decoder, Entry, Reader, RecordingError, Writer, WriterOptions};

use super::random_damage::{Random, mutate};
use super::sample::{self, COMPRESSIONS, MEASUREMENT, sample, text_entry, text_topics};

/// Inputs of the fast test.
const FEW: u64 = 10_000;

/// Inputs of the slow one.
const MANY: u64 = 1_000_000;

/// Small, so that most mutations hit something: each compression, one file without chunks, one with a nested type.
fn originals() -> Vec<Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let mut originals: Vec<Vec<u8>> = COMPRESSIONS
        .iter()
        .map(|compression| {
            let directory = folder.path().join(format!("{compression:?}"));
            let options = WriterOptions {
                compression: *compression,
                sync: false,
                ..WriterOptions::default()
            };
            let mut writer = Writer::create(&directory, &options, &text_topics()).unwrap();
            for time in [1, 3, 2] {
                writer
                    .write(&text_entry(0, time, "some text", false))
                    .unwrap();
                writer.flush().unwrap();
            }
            writer.finish().unwrap();
            fs::read(directory.join(format!("{compression:?}_0.mcap"))).unwrap()
        })
        .collect();
    let directory = folder.path().join("nested");
    let options = WriterOptions {
        sync: false,
        ..WriterOptions::default()
    };
    let mut writer = Writer::create(&directory, &options, &sample::topics()[..1]).unwrap();
    let measurement: Entry = sample(1).remove(1);
    writer.write(&measurement).unwrap();
    writer.finish().unwrap();
    originals.push(fs::read(directory.join("nested_0.mcap")).unwrap());
    let options = mcap::WriteOptions::new()
        .use_chunks(false)
        .compression(None);
    let mut writer = options.create(std::io::Cursor::new(Vec::new())).unwrap();
    let schema = writer
        .add_schema("a/msg/A", "ros2msg", b"string[] a\nfloat64[3] b\n")
        .unwrap();
    let channel = writer
        .add_channel(schema, "/a", "cdr", &Default::default())
        .unwrap();
    for time in [3, 1, 2] {
        let header = mcap::records::MessageHeader {
            channel_id: channel,
            sequence: 0,
            log_time: time,
            publish_time: 0,
        };
        let data = [
            &[0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, b'x', 0, 0, 0][..],
            &[0; 24],
        ]
        .concat();
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    let attachment = mcap::Attachment {
        log_time: 0,
        create_time: 0,
        name: "a".to_owned(),
        media_type: "text/plain".to_owned(),
        data: b"x".to_vec().into(),
    };
    writer.attach(&attachment).unwrap();
    writer.finish().unwrap();
    originals.push(writer.into_inner().into_inner());
    originals
}

/// Reads everything that can be read.
fn read_all(path: &Path) {
    let reader = match Reader::open(path) {
        Ok(reader) => reader,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    let decoders: Vec<_> = reader.topics().iter().map(Decoder::new).collect();
    let (mut read, mut last) = (0, i64::MIN);
    for message in reader.messages() {
        match message {
            Ok(message) => {
                read += 1;
                assert!(message.log_time >= last, "out of order");
                last = message.log_time;
                if let Some(Ok(decoder)) = decoders.get(message.topic_index) {
                    // Both results are fine; the test is that it ends.
                    let _ = decoder.decode(&message);
                }
            }
            Err(RecordingError::Damaged { .. }) => {}
            Err(error) => panic!("{error}"),
        }
    }
    assert_eq!(read, reader.message_count());
    for topic in reader.topics() {
        let _ = topic.check_definition(MEASUREMENT);
    }
}

/// A directory in memory, if possible, because a million small files are written.
fn folder() -> tempfile::TempDir {
    let memory = Path::new("/dev/shm");
    tempfile::tempdir_in(memory)
        .or_else(|_| tempfile::tempdir())
        .unwrap()
}

fn read_mutations(first: u64, count: u64) {
    let folder = folder();
    let path = folder.path().join("x.mcap");
    let originals = originals();
    for number in first..first + count {
        let mut random = Random(number);
        let original = &originals[random.below(originals.len())];
        fs::write(&path, mutate(original, &mut random)).unwrap();
        let outcome = std::panic::catch_unwind(|| read_all(&path));
        assert!(outcome.is_ok(), "mutation {number}");
    }
}

#[test]
fn mutated_files_are_read_or_rejected() {
    read_mutations(0, FEW);
}

#[test]
#[ignore = "slow: a million inputs, some minutes"]
fn a_million_mutated_files_are_read_or_rejected() {
    let threads = std::thread::available_parallelism().map_or(1, |it| it.get() as u64);
    let each = MANY.div_ceil(threads);
    std::thread::scope(|scope| {
        for thread in 0..threads {
            scope.spawn(move || read_mutations(FEW + thread * each, each));
        }
    });
}

/// Random data behind the magic bytes.
#[test]
fn noise_is_rejected_or_counted() {
    let folder = folder();
    let path = folder.path().join("x.mcap");
    let mut random = Random(1);
    for _ in 0..FEW / 10 {
        let length = random.below(3000);
        let mut bytes = b"\x89MCAP0\r\n".to_vec();
        bytes.extend((0..length).map(|_| random.next() as u8));
        fs::write(&path, bytes).unwrap();
        read_all(&path);
    }
}

/// A small chunk that unpacks to gigabytes.
#[test]
fn a_chunk_that_unpacks_to_gigabytes_needs_bounded_memory() {
    const MIB: usize = 1 << 20;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb.mcap");
    let zeros = vec![0; MIB];
    let mut packing = zstd::stream::write::Encoder::new(Vec::new(), 1).unwrap();
    for _ in 0..2048 {
        std::io::Write::write_all(&mut packing, &zeros).unwrap();
    }
    let packed = packing.finish().unwrap();
    for announced in [2048 * MIB as u64, 1000] {
        let mut chunk = Vec::new();
        chunk.extend([0; 16]);
        chunk.extend(announced.to_le_bytes());
        chunk.extend([0; 4]);
        chunk.extend(4_u32.to_le_bytes());
        chunk.extend(b"zstd");
        chunk.extend((packed.len() as u64).to_le_bytes());
        chunk.extend(&packed);
        let mut file = b"\x89MCAP0\r\n\x06".to_vec();
        file.extend((chunk.len() as u64).to_le_bytes());
        file.extend(chunk);
        fs::write(&path, file).unwrap();
        let before = resident_kib();
        let reader = Reader::open(&path).unwrap();
        assert_eq!((reader.message_count(), reader.wholeness().damaged), (0, 1));
        assert!(
            resident_kib() < before + 300 * 1024,
            "{} KiB before, {} now",
            before,
            resident_kib()
        );
    }
}

/// Peak memory of this process \[KiB\].
fn resident_kib() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))
        .unwrap_or("0");
    line.trim()
        .trim_end_matches(" kB")
        .trim()
        .parse()
        .unwrap_or(0)
}
