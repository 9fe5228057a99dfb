//! Sealed recordings: every change of a message is found, whoever has made it, as long as the key is not his.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use ed25519_dalek::SigningKey;
use rosbag2_mcap::{
    ChunkCompression, Entry, Predecessor, Reader, Recorder, RecorderOptions, Seal, SealKey, Writer,
    WriterOptions, repair,
};
use tempfile::TempDir;

use super::forging::{BEGIN, Kept, Parts, SEAL};
use super::random_damage::{Random, mutate};
use super::recorder::recordings;
use super::sample::{self, COMPRESSIONS, sample, text_entry, text_topics, topics};

/// Number of random changes.
const CHANGES: u64 = 1000;

/// Messages between two flushes.
const FLUSHED: usize = 20;

/// Writes a sealed recording, and returns its directory.
fn write(
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

struct Sealed {
    folder: TempDir,
    key: SealKey,
    file: PathBuf,
}

impl Sealed {
    fn new() -> Self {
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

fn seal_of(reader: &Reader) -> Option<Seal> {
    assert_eq!(reader.seals().len(), 1);
    reader.seals()[0].clone()
}

fn opened(path: &Path) -> Seal {
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
fn one_thousand_random_single_changes_are_all_noticed() {
    let sealed = Sealed::new();
    let original = sealed.parts();
    let mut kinds = [0; 8];
    for number in 0..CHANGES {
        let mut random = Random(number);
        let mut parts = original.clone();
        let kind = random.below(kinds.len());
        change(&mut parts, kind, &mut random);
        if parts.contents() == original.contents() && kind != 7 {
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

/// One change of one message, or of the definition of its topic.
fn change(parts: &mut Parts, kind: usize, random: &mut Random) {
    let positions = parts.messages();
    let index = random.below(positions.len());
    let position = positions[index];
    let step = 1 + random.next() % 1_000_000_000;
    match kind {
        0 => {
            let (_, data) = parts.message(index);
            let at = random.below(data.len());
            data[at] ^= 1 << random.below(8);
        }
        1 => {
            parts.records.remove(position);
        }
        2 => {
            let twice = parts.records[position].clone();
            let to = positions[random.below(positions.len())];
            parts.records.insert(to, twice);
        }
        3 => {
            let moved = parts.records.remove(position);
            let to = parts.messages()[random.below(positions.len() - 1)];
            parts.records.insert(to, moved);
        }
        4 => parts.message(index).0.log_time += step,
        5 => parts.message(index).0.publish_time -= step,
        6 => {
            let (header, data) = parts.message(index);
            match random.below(3) {
                0 => header.sequence ^= 1 << random.below(32),
                1 => data.push(0),
                _ => data.truncate(data.len() - 1),
            }
        }
        _ => {
            let ids = parts.channel_ids();
            let channel = parts.channel(ids[random.below(ids.len() - 1)]);
            match random.below(4) {
                0 => channel.topic.push('x'),
                1 => channel.message_encoding.push('x'),
                2 => channel
                    .metadata
                    .insert("note".to_owned(), "x".to_owned())
                    .map_or((), |_| ()),
                _ => channel.metadata.clear(),
            }
        }
    }
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

/// Cut off at any byte: what precedes the last seal is proved, and a repair keeps that.
#[test]
fn a_cut_off_recording_is_sealed_up_to_the_last_flush_and_stays_so_when_repaired() {
    let sealed = Sealed::new();
    let bytes = fs::read(&sealed.file).unwrap();
    let directory = sealed.folder.path().join("cut");
    let file = directory.join("cut_0.mcap");
    fs::create_dir(&directory).unwrap();
    let mut most_uncovered = 0;
    for (round, length) in (2000..bytes.len()).step_by(997).enumerate() {
        fs::write(&file, &bytes[..length]).unwrap();
        let reader = Reader::open(&file).unwrap();
        let Some(seal) = seal_of(&reader) else {
            continue;
        };
        assert_eq!(seal.fault, None, "{length} bytes");
        assert!(seal.covered % FLUSHED as u64 == 0 || seal.covered == 136);
        assert_eq!(seal.covered + seal.uncovered, reader.message_count());
        most_uncovered = most_uncovered.max(seal.uncovered);
        let to = sealed.folder.path().join(format!("repaired_{round}"));
        let repaired = repair(&file, Some(&to)).unwrap().unwrap();
        assert_eq!(repaired.seal.as_ref(), Some(&seal));
        let kept = Reader::open(&to).unwrap();
        assert!(kept.wholeness().is_whole() && kept.repair_notes().is_some());
        assert_eq!(seal_of(&kept), Some(seal.clone()), "{length} bytes");
        assert_eq!(kept.ended(), Some("repaired"));
        let covers = format!("{} messages", seal.covered);
        assert!(repaired.to_string().contains(&covers), "{repaired}");
    }
    // A seal follows its messages at once; a cut between the two leaves them uncovered.
    assert!(most_uncovered <= FLUSHED as u64, "{most_uncovered}");
}

/// Only metadata.yaml is missing.
#[test]
fn a_repair_of_a_whole_file_keeps_the_last_seal() {
    let sealed = Sealed::new();
    let directory = sealed.file.parent().unwrap();
    fs::remove_file(directory.join("metadata.yaml")).unwrap();
    let repaired = repair(directory, None).unwrap().unwrap();
    let seal = opened(&repaired.directory);
    assert_eq!(Some(&seal), repaired.seal.as_ref());
    assert!(
        seal.holds() && seal.is_final && seal.uncovered == 0,
        "{seal:?}"
    );
    let text = repaired.to_string();
    assert!(text.contains("covers all of the 136 messages"), "{text}");
    // The repaired recording is found by readers that use its metadata.yaml.
    sample::assert_reads_back(&Reader::open(&repaired.directory).unwrap(), &sample(100));
}

/// A chunk in the middle is damaged: what precedes it is still proved, and the repair says what is not.
#[test]
fn a_repair_that_leaves_out_a_chunk_says_what_its_seal_still_covers() {
    let sealed = Sealed::new();
    let mut bytes = fs::read(&sealed.file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&sealed.file, &bytes).unwrap();
    let repaired = repair(sealed.file.parent().unwrap(), None)
        .unwrap()
        .unwrap();
    assert_eq!(repaired.left_out, 1);
    let seal = opened(&repaired.directory);
    assert_eq!(Some(&seal), repaired.seal.as_ref());
    assert!(
        !seal.holds() && seal.covered > 0 && seal.uncovered > 0,
        "{seal:?}"
    );
    let text = repaired.to_string();
    let expected = format!(
        "covers the first {} messages only, and does not hold",
        seal.covered
    );
    assert!(text.contains(&expected), "{text}");
}

#[test]
fn a_repair_of_several_files_says_that_their_seals_are_lost() {
    let folder = TempDir::new().unwrap();
    let key = SealKey::fresh().unwrap();
    let [first, second] =
        ["a", "b"].map(|it| write(folder.path(), it, &key, ChunkCompression::None, &sample(10)));
    fs::rename(second.join("b_0.mcap"), first.join("a_1.mcap")).unwrap();
    fs::remove_file(first.join("metadata.yaml")).unwrap();
    let repaired = repair(&first, None).unwrap().unwrap();
    assert!(repaired.seals_lost && repaired.seal.is_none());
    assert!(
        repaired.to_string().contains("seals were lost"),
        "{repaired}"
    );
    let reader = Reader::open(&repaired.directory).unwrap();
    assert_eq!(seal_of(&reader), None);
    assert_eq!(reader.message_count(), 2 * sample(10).len() as u64);
}

/// Three recordings of one session.
fn session(folder: &Path) -> Vec<PathBuf> {
    let mut options = RecorderOptions::new(folder, SystemTime::UNIX_EPOCH);
    options.max_file_size = 100_000;
    options.seal = Some(SealKey::fresh().unwrap());
    let recorder = Recorder::start(options, text_topics()).unwrap();
    let text = "x".repeat(10_000);
    for index in 0..30 {
        assert!(recorder.record(text_entry(0, index, &text, index % 11 == 0)));
    }
    let statistics = recorder.stop();
    assert_eq!((statistics.finished, statistics.lost), (3, 0));
    let mut found = recordings(folder);
    found.sort_by_key(|it| opened(it).recording);
    found
}

#[test]
fn the_recordings_of_a_session_follow_one_another() {
    let folder = TempDir::new().unwrap();
    let found = session(folder.path());
    for (number, directory) in found.iter().enumerate() {
        let reader = Reader::open(directory).unwrap();
        let seal = seal_of(&reader).unwrap();
        assert!(
            seal.holds() && seal.is_final && seal.uncovered == 0,
            "{seal:?}"
        );
        assert_eq!(
            (seal.recording, &seal.session),
            (number as u64, &opened(&found[0]).session)
        );
        let expected = match number {
            0 => Predecessor::None,
            _ => Predecessor::Found(fs::canonicalize(&found[number - 1]).unwrap()),
        };
        assert_eq!(reader.predecessor(), expected);
        assert!(!reader.predecessor().is_fault());
    }
}

#[test]
fn a_recording_removed_from_the_middle_of_a_session_is_noticed() {
    let folder = TempDir::new().unwrap();
    let found = session(folder.path());
    fs::remove_dir_all(&found[1]).unwrap();
    let reader = Reader::open(&found[2]).unwrap();
    assert!(seal_of(&reader).unwrap().holds());
    let missing = Predecessor::Missing {
        name: found[1].file_name().unwrap().to_string_lossy().into_owned(),
        earlier: fs::canonicalize(&found[0]).unwrap(),
    };
    assert_eq!(reader.predecessor(), missing);
    assert!(missing.is_fault());
    // The limits of a recorder delete the oldest recordings first.
    fs::remove_dir_all(&found[0]).unwrap();
    let gone = reader.predecessor();
    assert!(
        matches!(&gone, Predecessor::Gone { .. }) && !gone.is_fault(),
        "{gone:?}"
    );
}

#[test]
fn a_recording_that_was_changed_or_replaced_in_a_session_is_noticed() {
    let folder = TempDir::new().unwrap();
    let found = session(folder.path());
    let last = Reader::open(&found[2]).unwrap();
    let before = recordings(&found[1])
        .into_iter()
        .find(|it| it.extension().unwrap() == "mcap");
    let before = before.unwrap();
    let original = fs::read(&before).unwrap();
    let mut parts = Parts::read(&before);
    parts.message(3).1[50] ^= 1;
    parts.write(&before);
    assert!(matches!(last.predecessor(), Predecessor::Changed(_)));
    // Shortened to an earlier seal, as if it had been cut off.
    let mut parts = Parts::read(&before);
    parts.message(3).1[50] ^= 1;
    let last_seals = parts.records.iter().rposition(|it| !it.is_seal()).unwrap();
    parts.records.truncate(last_seals.min(parts.messages()[5]));
    parts.write(&before);
    assert!(matches!(last.predecessor(), Predecessor::Changed(_)));
    // Under another name it is still the same.
    fs::write(&before, original).unwrap();
    let renamed = folder.path().join("renamed");
    fs::rename(&found[1], &renamed).unwrap();
    let expected = Predecessor::Found(fs::canonicalize(&renamed).unwrap());
    assert_eq!(last.predecessor(), expected);
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
