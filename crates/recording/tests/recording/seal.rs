//! Sealed recordings: every change of a message is found, whoever has made it, as long as the key is not his.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use ed25519_dalek::SigningKey;
use rosbag2_mcap::{
    ChunkCompression, Entry, Predecessor, Reader, Recorder, RecorderOptions, Seal, SealKey, Writer,
    WriterOptions,
};
use tempfile::TempDir;

use super::forging::{BEGIN, KINDS, Kept, Parts, SEAL};
use super::random_damage::{Random, mutate};
use super::recorder::recordings;
use super::sample::{self, COMPRESSIONS, sample, text_entry, text_topics, topics};

/// Number of random changes.
const CHANGES: u64 = 1120;

/// Messages between two flushes.
pub const FLUSHED: usize = 20;

/// Writes a sealed recording, and returns its directory.
pub fn write(
    folder: &Path,
    name: &str,
    key: &SealKey,
    compression: ChunkCompression,
    messages: &[Entry],
) -> PathBuf {
    let directory = folder.join(name);
    let options = WriterOptions {
        compression,
        sync: false,
        seal: Some(key.clone()),
        ..WriterOptions::default()
    };
    let mut writer = Writer::create(&directory, &options, &topics()).unwrap();
    for (index, message) in messages.iter().enumerate() {
        writer.write(message).unwrap();
        if index % FLUSHED == FLUSHED - 1 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
    directory
}

/// A sealed recording.
pub struct Sealed {
    pub folder: TempDir,
    pub key: SealKey,
    pub file: PathBuf,
}

impl Sealed {
    pub fn new() -> Self {
        let folder = TempDir::new().unwrap();
        let key = SealKey::fresh().unwrap();
        let directory = write(
            folder.path(),
            "bag",
            &key,
            ChunkCompression::None,
            &sample(100),
        );
        Self {
            file: directory.join("bag_0.mcap"),
            folder,
            key,
        }
    }

    fn parts(&self) -> Parts {
        Parts::read(&self.file)
    }

    /// The seal of a forged file.
    fn judged(&self, parts: &Parts) -> Option<Seal> {
        let path = self.folder.path().join("forged.mcap");
        parts.write(&path);
        let reader = Reader::open(&path).unwrap();
        assert!(reader.wholeness().is_whole(), "the forger made a mistake");
        assert_eq!(reader.message_count() as usize, parts.contents().len());
        seal_of(&reader)
    }

    /// The fault of a forged file.
    fn fault(&self, parts: &Parts) -> String {
        let seal = self.judged(parts).expect("the seal is still there");
        seal.fault.unwrap_or_else(|| panic!("not noticed"))
    }
}

pub fn seal_of(reader: &Reader) -> Option<Seal> {
    assert_eq!(reader.seals().len(), 1);
    reader.seals()[0].clone()
}

pub fn opened(path: &Path) -> Seal {
    seal_of(&Reader::open(path).unwrap()).expect("a seal")
}

#[test]
fn a_sealed_recording_holds_and_covers_every_message() {
    let messages = sample(300);
    let folder = TempDir::new().unwrap();
    let key = SealKey::fresh().unwrap();
    for compression in COMPRESSIONS {
        let directory = write(
            folder.path(),
            &format!("{compression:?}"),
            &key,
            compression,
            &messages,
        );
        let reader = Reader::open(&directory).unwrap();
        sample::assert_reads_back(&reader, &messages);
        let seal = seal_of(&reader).unwrap();
        assert_eq!(seal.fault, None);
        assert_eq!((seal.covered, seal.uncovered), (messages.len() as u64, 0));
        assert_eq!(seal.covered_until, reader.span().map(|it| it.1));
        assert_eq!(seal.public_key, Some(key.public_key()));
        assert!(seal.is_final && seal.fresh_key && seal.previous.is_none());
        assert_eq!(reader.predecessor(), Predecessor::None);
        // Seals are no notes.
        assert!(reader.metadata().iter().all(|(name, _)| name != SEAL));
    }
    // Each recording of a writer is a session of its own.
    let sessions: Vec<String> = COMPRESSIONS
        .iter()
        .map(|it| opened(&folder.path().join(format!("{it:?}"))).session)
        .collect();
    assert!(sessions[0] != sessions[1] && sessions[1] != sessions[2]);
}

#[test]
fn a_recording_without_a_key_is_not_sealed() {
    let folder = TempDir::new().unwrap();
    let directory = folder.path().join("bag");
    sample::write(&directory, ChunkCompression::None, &sample(10));
    let reader = Reader::open(&directory).unwrap();
    assert_eq!(
        (seal_of(&reader), reader.predecessor()),
        (None, Predecessor::None)
    );
}

/// A seal is not about bytes of the file but about its content; else the tests below would prove nothing.
#[test]
fn a_copy_with_other_chunks_and_the_same_records_holds() {
    let sealed = Sealed::new();
    let parts = sealed.parts();
    assert_eq!(sealed.judged(&parts), Some(opened(&sealed.file)));
    let mut again = parts.clone();
    again.seal_again(None);
    assert_eq!(
        again.records, parts.records,
        "the independent chain is the same"
    );
}

#[test]
fn of_1120_random_single_changes_every_one_is_noticed() {
    let sealed = Sealed::new();
    let original = sealed.parts();
    let mut kinds = [0; KINDS];
    for number in 0..CHANGES {
        let mut random = Random(number);
        let mut parts = original.clone();
        let kind = random.below(kinds.len());
        parts.change_one(kind, &mut random);
        if parts == original {
            continue; // equal neighbours have changed places
        }
        kinds[kind] += 1;
        let seal = sealed.judged(&parts).expect("the seal is still there");
        assert!(
            !seal.holds(),
            "change {number} of kind {kind} was not noticed"
        );
        // What the seal proves nevertheless is what was recorded.
        let covered = usize::try_from(seal.covered).unwrap();
        assert_eq!(parts.contents()[..covered], original.contents()[..covered]);
    }
    assert!(kinds.iter().all(|it| *it > 50), "{kinds:?}");
}

#[test]
fn all_times_shifted_by_one_second_are_noticed() {
    let sealed = Sealed::new();
    let mut parts = sealed.parts();
    for index in 0..parts.messages().len() {
        let (header, _) = parts.message(index);
        header.log_time += 1_000_000_000;
        header.publish_time += 1_000_000_000;
    }
    assert!(sealed.fault(&parts).contains("was changed"));
}

/// The notes of the recorder, and its count of lost messages, are sealed, too.
#[test]
fn changed_notes_are_noticed() {
    let sealed = Sealed::new();
    for name in ["recording_start", "recording_losses", "rosbag2"] {
        let mut parts = sealed.parts();
        for record in &mut parts.records {
            if let Kept::Metadata(it) = record
                && it.name == name
            {
                it.metadata
                    .insert("lost_messages".to_owned(), "7".to_owned());
            }
        }
        assert!(parts.records != sealed.parts().records, "{name}");
        assert!(sealed.fault(&parts).contains("was changed"), "{name}");
    }
}

/// Somebody without the key recomputes the chain: the signatures do not follow.
#[test]
fn a_chain_computed_again_without_the_key_is_noticed() {
    let sealed = Sealed::new();
    let mut parts = sealed.parts();
    let flushed = FLUSHED as u64;
    parts.message(70).1[10] ^= 1;
    parts.seal_again(None);
    let seal = sealed.judged(&parts).unwrap();
    let fault = seal.fault.unwrap();
    assert!(fault.contains("signature"), "{fault}");
    // The seals before the change are still those of the key.
    assert_eq!(seal.covered, 70 / flushed * flushed);
}

/// Signed with a key of his own, but in the name of the original key.
#[test]
fn a_seal_made_with_another_key_is_noticed() {
    let sealed = Sealed::new();
    let mut parts = sealed.parts();
    parts.message(70).1[10] ^= 1;
    parts.seal_again(Some(&SigningKey::from_bytes(&[7; 32])));
    let seal = sealed.judged(&parts).unwrap();
    assert!(seal.fault.unwrap().contains("signature"));
    assert_eq!(seal.covered, 0);
}

/// Only whoever knows the right key can tell such a recording from a genuine one: its seal holds, but it is another's.
#[test]
fn a_replaced_key_is_named() {
    let sealed = Sealed::new();
    let mut parts = sealed.parts();
    let other = SigningKey::from_bytes(&[7; 32]);
    let public = super::resealing::hex(&other.verifying_key().to_bytes());
    parts.message(70).1[10] ^= 1;
    for record in &mut parts.records {
        if let Kept::Metadata(it) = record
            && it.name == BEGIN
        {
            it.metadata.insert("public_key".to_owned(), public.clone());
        }
    }
    assert!(
        sealed.fault(&parts).contains("was changed"),
        "without new seals"
    );
    parts.seal_again(Some(&other));
    let seal = sealed.judged(&parts).unwrap();
    assert_eq!(seal.fault, None);
    assert_eq!(seal.public_key.map(|it| it.to_string()), Some(public));
    assert!(seal.public_key != Some(sealed.key.public_key()));
}

#[test]
fn a_seal_of_another_recording_is_noticed() {
    let sealed = Sealed::new();
    // Of the same length, with the same key.
    let mut entries = sample(100);
    for entry in &mut entries {
        entry.publish_time += 1;
    }
    let other = write(
        sealed.folder.path(),
        "other",
        &sealed.key,
        ChunkCompression::None,
        &entries,
    );
    let other = Parts::read(&other.join("other_0.mcap"));
    let mut parts = sealed.parts();
    assert_eq!(parts.records.len(), other.records.len());
    for (record, seal) in parts.records.iter_mut().zip(&other.records) {
        if seal.is_seal() {
            *record = seal.clone();
        }
    }
    assert!(sealed.fault(&parts).contains("was changed"));
}

#[test]
fn a_removed_seal_is_noticed() {
    let sealed = Sealed::new();
    let without = |remove: &dyn Fn(&Kept) -> bool| {
        let mut parts = sealed.parts();
        parts.records.retain(|it| !remove(it));
        sealed.judged(&parts)
    };
    let named = |it: &Kept, wanted: &str| matches!(it, Kept::Metadata(it) if it.name == wanted);
    // Everything: whoever wants a sealed recording has to ask for it.
    assert_eq!(without(&Kept::is_seal), None);
    let fault = |seal: Option<Seal>| seal.unwrap().fault.unwrap();
    let no_beginning = fault(without(&|it| named(it, BEGIN)));
    assert!(no_beginning.contains("does not begin"), "{no_beginning}");
    let no_seals = fault(without(&|it| named(it, SEAL)));
    assert!(no_seals.contains("attachment"), "{no_seals}");
    let is_last = |it: &Kept| {
        matches!(it, Kept::Metadata(it) if it.name == SEAL && it.metadata["final"] == "true")
            || matches!(it, Kept::Attachment(..))
    };
    let no_last = fault(without(&is_last));
    assert!(no_last.contains("last seal is missing"), "{no_last}");
}

#[test]
fn what_follows_the_last_seal_is_noticed() {
    let sealed = Sealed::new();
    let mut parts = sealed.parts();
    let last = parts.contents().pop().unwrap().clone();
    parts.records.push(last);
    let seal = sealed.judged(&parts).unwrap();
    assert!(seal.fault.unwrap().contains("messages follow"));
    assert_eq!((seal.covered, seal.uncovered), (136, 1));
    let mut parts = sealed.parts();
    let seals: Vec<Kept> = parts
        .records
        .iter()
        .filter(|it| it.is_seal())
        .cloned()
        .collect();
    parts.records.push(seals[2].clone());
    assert!(sealed.fault(&parts).contains("a seal follows"));
}

#[test]
fn damaged_seals_are_noticed() {
    let sealed = Sealed::new();
    let last = sealed
        .parts()
        .records
        .iter()
        .filter(|it| it.is_seal())
        .count()
        - 3;
    for (entry, wrong) in [
        ("version", "2"),
        ("messages", "-1"),
        ("messages", "135"),
        ("head", "00"),
        ("final", "maybe"),
        ("final", "false"),
        ("signature", "xyz"),
    ] {
        let mut parts = sealed.parts();
        parts.seal(last).insert(entry.to_owned(), wrong.to_owned());
        assert!(!sealed.fault(&parts).is_empty(), "{entry}");
    }
    for entry in ["version", "public_key", "key", "session", "recording"] {
        for wrong in [Some("x"), None] {
            let mut parts = sealed.parts();
            for record in &mut parts.records {
                if let Kept::Metadata(it) = record
                    && it.name == BEGIN
                {
                    it.metadata.remove(entry);
                    it.metadata
                        .extend(wrong.map(|it| (entry.to_owned(), it.to_owned())));
                }
            }
            let fault = sealed.fault(&parts);
            assert!(
                fault.contains("beginning of the seal cannot be read"),
                "{fault}"
            );
        }
    }
    let mut parts = sealed.parts();
    for record in &mut parts.records {
        if let Kept::Attachment(_, content) = record {
            content[100] ^= 1;
        }
    }
    assert!(sealed.fault(&parts).contains("attachment"));
}

/// Damage is not always noticed as a change: a file may end early. But what a seal claims to cover is what was recorded.
#[test]
fn whatever_is_damaged_a_seal_never_covers_a_changed_message() {
    let sealed = Sealed::new();
    let bytes = fs::read(&sealed.file).unwrap();
    let original = sealed.parts();
    let path = sealed.folder.path().join("damaged.mcap");
    let (mut holding, mut broken) = (0, 0);
    for number in 0..3000 {
        fs::write(&path, mutate(&bytes, &mut Random(number))).unwrap();
        let Ok(reader) = Reader::open(&path) else {
            continue;
        };
        let Some(seal) = seal_of(&reader) else {
            continue;
        };
        match seal.holds() {
            true => holding += 1,
            false => broken += 1,
        }
        let found: Vec<_> = reader
            .messages()
            .filter_map(Result::ok)
            .map(|it| (it.log_time, it.publish_time, it.data))
            .collect();
        let covered = usize::try_from(seal.covered).unwrap();
        for expected in &original.contents()[..covered] {
            let Kept::Message(header, data) = expected else {
                unreachable!()
            };
            let is_it = |(log_time, publish_time, found): &(i64, i64, Vec<u8>)| {
                (*log_time as u64, *publish_time as u64) == (header.log_time, header.publish_time)
                    && found == data
            };
            assert!(found.iter().any(is_it), "damage {number}");
        }
        assert_eq!(
            seal.covered + seal.uncovered,
            reader.message_count(),
            "damage {number}"
        );
    }
    assert!(
        holding > 100 && broken > 100,
        "{holding} hold, {broken} do not"
    );
}

/// A recorder seals within the time after which nothing is lost any more.
#[test]
fn a_running_recording_is_sealed_at_every_flush() {
    let folder = TempDir::new().unwrap();
    let mut options = RecorderOptions::new(folder.path(), SystemTime::UNIX_EPOCH);
    let key = SealKey::fresh().unwrap();
    options.seal = Some(key.clone());
    let recorder = Recorder::start(options, text_topics()).unwrap();
    let begin = std::time::Instant::now();
    let sealed = |wanted: u64| loop {
        assert!(
            begin.elapsed() < Duration::from_secs(60),
            "no seal of {wanted} messages"
        );
        let files = recordings(folder.path())
            .into_iter()
            .flat_map(|it| recordings(&it));
        let seal = files
            .last()
            .and_then(|file| seal_of(&Reader::open(&file).ok()?));
        if let Some(seal) = seal.filter(|it| it.covered == wanted) {
            return seal;
        }
        std::thread::sleep(Duration::from_millis(1));
    };
    for index in 0..5 {
        assert!(recorder.record(text_entry(0, index, "text", index == 0)));
        let seal = sealed(index as u64 + 1);
        assert_eq!((seal.fault, seal.is_final), (None, false));
        assert_eq!(seal.covered_until, Some(index));
    }
    assert_eq!(recorder.stop().lost, 0);
    assert!(sealed(5).is_final);
}
