//! Seals as a user meets them: keys, `simulate --record`, `run`, `verify`, `info`, `report`.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use column_twin::parameters::RecordMode;
use column_twin::recording::{Predecessor, PublicKey, Reader, RecorderOptions};
use tempfile::TempDir;

use super::commands::typed;
use super::forging::{KINDS, Kept, Parts};
use super::node;
use super::random_damage::Random;
use super::recorded_twin::{MS, RecordedTwin, event, parameters};
use super::scenarios::size_of_one_impact;

/// `openssl genpkey -algorithm ed25519`
const PRIVATE: &str = "\
-----BEGIN PRIVATE KEY-----
MC4CAQAwBQYDK2VwBCIEIDrPH5Vf8dPBLAs/MW1DwsfvtEZ4TLyMyh8kLDUbQIUR
-----END PRIVATE KEY-----
";

/// `openssl pkey -in PRIVATE -pubout`
const PUBLIC: &str = "\
-----BEGIN PUBLIC KEY-----
MCowBQYDK2VwAyEAwQR2jcvsFnSaY/C+nCGKmyrxL1s7FlR9WQsKWfRbzCA=
-----END PUBLIC KEY-----
";

const DIGITS: &str = "c104768dcbec16749a63f0be9c218a9b2af12f5b3b16547d590b0a59f45bcc20";

const OTHER: &str = "00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff";

/// A folder with the key in `key.pem` and its public part in `public.pem`.
fn folder_with_keys() -> TempDir {
    let folder = TempDir::new().unwrap();
    let private = folder.path().join("key.pem");
    fs::write(&private, PRIVATE).unwrap();
    fs::set_permissions(&private, fs::Permissions::from_mode(0o600)).unwrap();
    fs::write(folder.path().join("public.pem"), PUBLIC).unwrap();
    folder
}

/// Runs a command that must end with this code; its output and errors.
fn ends_with(code: i32, folder: &TempDir, line: &str) -> (String, String) {
    let (found, stdout, stderr) = typed(folder.path(), line);
    assert_eq!(found, code, "{line}: {stdout}{stderr}");
    (stdout, stderr)
}

#[test]
fn a_recording_is_sealed_with_a_fresh_key_that_is_printed() {
    let folder = TempDir::new().unwrap();
    let (printed, _) = ends_with(0, &folder, "simulate --record bag");
    let line = printed
        .lines()
        .find_map(|line| line.strip_prefix("Sealed by  "))
        .expect("a line about the seal");
    let (key, rest) = line.split_once(", ").unwrap();
    assert_eq!(rest, "a key made for this run only");
    assert!(key.parse::<PublicKey>().is_ok(), "{key}");
    let (text, _) = ends_with(0, &folder, "verify bag");
    assert!(
        text.contains(&format!(
            "Seal: sealed by the key {key}, made for that run only\n"
        )),
        "{text}"
    );
    assert!(text.contains("it holds: all "), "{text}");
    assert!(
        text.contains("but not who has recorded: compare the key with the recorder's log"),
        "{text}"
    );
    // With the key that was printed, it does.
    let (text, _) = ends_with(0, &folder, &format!("verify bag --trusted-key {key}"));
    assert!(
        text.contains(&format!("sealed by the trusted key {key}\n")),
        "{text}"
    );
    assert!(!text.contains("not who has recorded"), "{text}");
    let (text, _) = ends_with(0, &folder, "info bag");
    assert!(
        text.contains(&format!("Seal        sealed by the key {key}")),
        "{text}"
    );
    let (text, _) = ends_with(0, &folder, "info bag --json");
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    let seal = &summary["seals"][0];
    assert_eq!(
        (
            &seal["public_key"],
            &seal["holds"],
            &seal["final"],
            &seal["fresh_key"]
        ),
        (&key.into(), &true.into(), &true.into(), &true.into())
    );
    assert_eq!(seal["covered_messages"], summary["messages"]);
    // Another run has another key.
    let (again, _) = ends_with(0, &folder, "simulate --record other");
    assert!(!again.contains(key), "{again}");
    // The key is not lost where only JSON is printed.
    let (json, told) = ends_with(0, &folder, "simulate --json --record third");
    assert!(serde_json::from_str::<serde_json::Value>(&json).is_ok());
    assert!(told.contains("a key made for this run only"), "{told}");
}

#[test]
fn a_recording_is_sealed_with_the_given_key() {
    let folder = folder_with_keys();
    let (text, _) = ends_with(
        0,
        &folder,
        "simulate --record bag -p record.seal_key:=key.pem",
    );
    let expected = format!("Sealed by  {DIGITS}, the key of key.pem\n");
    assert!(
        text.contains(&expected) && !text.contains("warning"),
        "{text}"
    );
    for trusted in ["public.pem", DIGITS] {
        let line =
            format!("verify bag --require-seal --trusted-key {OTHER} --trusted-key {trusted}");
        let (text, _) = ends_with(0, &folder, &line);
        assert!(text.contains("sealed by the trusted key"), "{text}");
    }
    let (_, fault) = ends_with(1, &folder, &format!("verify bag --trusted-key {OTHER}"));
    let expected = format!("sealed by the key {DIGITS}, which is not a trusted key");
    assert!(fault.contains(&expected), "{fault}");
    let path = folder.path().join("key.pem");
    fs::set_permissions(path, fs::Permissions::from_mode(0o644)).unwrap();
    let (text, _) = ends_with(
        0,
        &folder,
        "simulate --record other -p record.seal_key:=key.pem",
    );
    assert!(
        text.contains("warning: other users can read the private key"),
        "{text}"
    );
}

#[test]
fn a_recording_without_a_seal_is_no_error_unless_a_seal_is_required() {
    let folder = folder_with_keys();
    let (text, _) = ends_with(0, &folder, "simulate --record bag -p record.seal:=false");
    assert!(!text.contains("Sealed"), "{text}");
    let (text, _) = ends_with(0, &folder, "verify bag");
    assert!(text.contains("Seal: not sealed\n"), "{text}");
    let (text, _) = ends_with(0, &folder, "info bag");
    assert!(text.contains("Seal        not sealed\n"), "{text}");
    let (text, _) = ends_with(0, &folder, "info bag --json");
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(summary["seals"], serde_json::json!([null]));
    for option in ["--require-seal", "--trusted-key public.pem"] {
        let (_, fault) = ends_with(1, &folder, &format!("verify bag {option}"));
        assert!(
            fault.contains("is not sealed, but a seal is required"),
            "{fault}"
        );
    }
}

#[test]
fn a_key_that_cannot_be_used_ends_with_code_2_and_what_to_do() {
    let folder = folder_with_keys();
    for (key, advice) in [
        (
            "nothing.pem",
            "openssl genpkey -algorithm ed25519 -out nothing.pem",
        ),
        ("public.pem", "give the file of the private key"),
    ] {
        let line = format!("simulate --record bag -p record.seal_key:={key}");
        let (_, fault) = ends_with(2, &folder, &line);
        assert!(fault.contains(advice), "{fault}");
        assert!(!folder.path().join("bag").exists());
        // The node does not start.
        let line = format!(
            "run --ros-args -p record.mode:=always -p record.directory:=recordings -p state.directory:='' -p record.seal_key:={key}"
        );
        let (_, fault) = ends_with(2, &folder, &line);
        assert!(
            fault.contains(advice) && fault.contains("record.seal_key"),
            "{fault}"
        );
    }
    ends_with(0, &folder, "simulate --record bag");
    for (key, advice) in [
        ("nothing.pem", "cannot use the key nothing.pem"),
        ("key.pem", "openssl pkey -in key.pem -pubout"),
        (&OTHER[1..], "cannot use the key"),
    ] {
        let (_, fault) = ends_with(2, &folder, &format!("verify bag --trusted-key {key}"));
        assert!(fault.contains(advice), "{fault}");
    }
}

/// The recording as a file, and a changed copy of it.
fn forge(folder: &TempDir, bag: &str, forged: &str, change: impl FnOnce(&mut Parts)) {
    let file = folder.path().join(format!("{bag}/{bag}_0.mcap"));
    let mut parts = Parts::read(&file);
    change(&mut parts);
    parts.write(&folder.path().join(forged));
}

/// What the recomputation cannot know: how long the node took to compute, and what its recorder noted.
#[test]
fn a_change_that_the_recomputation_cannot_notice_breaks_the_seal() {
    let folder = TempDir::new().unwrap();
    ends_with(0, &folder, "simulate --record bag");
    forge(&folder, "bag", "same.mcap", |_| {});
    let (text, _) = ends_with(0, &folder, "verify same.mcap --require-seal");
    assert!(text.contains("it holds: all "), "{text}");
    forge(&folder, "bag", "forged.mcap", |parts| {
        for record in &mut parts.records {
            if let Kept::Metadata(it) = record
                && it.name == "column_twin_start"
            {
                it.metadata.insert("version".to_owned(), "9.9.9".to_owned());
            }
        }
    });
    let (text, fault) = ends_with(1, &folder, "verify forged.mcap");
    assert!(
        text.contains("Equal: ") && text.contains("it does NOT hold"),
        "{text}"
    );
    assert!(
        fault.contains("the seal of forged.mcap does not hold"),
        "{fault}"
    );
    let (_, fault) = ends_with(1, &folder, "report forged.mcap -o report.html");
    assert!(fault.contains("does not hold"), "{fault}");
    let html = fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(html.contains("The seal shows that this recording was changed"));
    let (text, _) = ends_with(0, &folder, "info forged.mcap");
    assert!(text.contains("it does NOT hold"), "{text}");
}

/// Other readers find messages by the index at the end of the file: its entry of the chunk with the event leads to another one.
#[test]
fn an_index_that_hides_an_event_from_other_readers_breaks_the_seal() {
    let folder = folder_with_keys();
    ends_with(
        0,
        &folder,
        "simulate --record bag -p record.seal_key:=key.pem",
    );
    let bytes = fs::read(folder.path().join("bag/bag_0.mcap")).unwrap();
    let events = |bytes: &[u8]| {
        let summary = mcap::Summary::read(bytes).unwrap().unwrap();
        let chunks = summary.chunk_indexes.iter();
        let messages = chunks.flat_map(|it| summary.stream_chunk(bytes, it).unwrap());
        let topics = messages.map(|it| it.unwrap().channel.topic.clone());
        topics.filter(|it| it.ends_with("/impact_event")).count()
    };
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let has_event = |it: &&mcap::records::ChunkIndex| {
        let mut messages = summary.stream_chunk(&bytes, it).unwrap();
        messages.any(|it| it.unwrap().channel.topic.ends_with("/impact_event"))
    };
    let chunk = summary.chunk_indexes.iter().find(has_event).unwrap();
    let chunks = summary.chunk_indexes.iter();
    let other = chunks.clone().find(|it| !has_event(it)).unwrap();
    let place = |it: &mcap::records::ChunkIndex| {
        [it.chunk_start_offset, it.chunk_length]
            .map(u64::to_le_bytes)
            .concat()
    };
    let mut forged = bytes.clone();
    let length = forged.len();
    let at = bytes
        .windows(16)
        .rposition(|it| it == place(chunk))
        .unwrap();
    forged[at..at + 16].copy_from_slice(&place(other));
    // A checksum of zero is one that was not computed.
    forged[length - 12..length - 8].fill(0);
    assert_eq!((events(&bytes), events(&forged)), (1, 0));
    fs::write(folder.path().join("forged.mcap"), forged).unwrap();
    for line in [
        "verify forged.mcap",
        "verify forged.mcap --require-seal --trusted-key public.pem",
    ] {
        let (text, fault) = ends_with(1, &folder, line);
        assert!(text.contains("Equal: "), "{text}");
        let expected = format!(
            "the seal of forged.mcap does not hold: other readers may find something else in the file than the sealed messages: at byte {}: expected the index of a chunk at byte {}, found the index of a chunk at byte {}",
            at - 25,
            chunk.chunk_start_offset,
            other.chunk_start_offset
        );
        assert!(fault.contains(&expected), "{fault}");
    }
    let (text, _) = ends_with(0, &folder, "info forged.mcap");
    assert!(
        text.contains("it does NOT hold: other readers may find something else"),
        "{text}"
    );
}

/// Changes of which the recomputation notices only those that change a value or a count.
#[test]
fn of_1120_random_single_changes_of_a_sealed_recording_every_one_is_noticed() {
    let mut twin = RecordedTwin::new(parameters());
    for id in ["a", "b"] {
        twin.hit(event(id, twin.now));
        twin.until_rest();
        twin.advance(100 * MS);
    }
    let finished = twin.finish();
    let reader = Reader::open(&finished.path()).unwrap();
    let original = Parts::read(&reader.files()[0]);
    let folder = TempDir::new().unwrap();
    let forged = folder.path().join("forged.mcap");
    let seal_of = |parts: &Parts| {
        parts.write(&forged);
        Reader::open(&forged).unwrap().seals()[0].clone().unwrap()
    };
    assert!(seal_of(&original).holds());
    for number in 0..1120 {
        let mut parts = original.clone();
        let mut random = Random(number);
        let kind = random.below(KINDS);
        parts.change_one(kind, &mut random);
        if parts != original {
            let seal = seal_of(&parts);
            assert!(
                !seal.holds(),
                "change {number} of kind {kind} was not noticed"
            );
        }
    }
}

#[test]
fn the_report_names_the_key_of_the_seal() {
    let folder = folder_with_keys();
    ends_with(
        0,
        &folder,
        "simulate --record bag -p record.seal_key:=key.pem",
    );
    ends_with(0, &folder, "report bag -o report.html");
    let html = fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(html.contains(&format!("sealed by the key {DIGITS}")));
    assert!(html.contains("it holds: all "));
}

/// The seal of a recording that was cut off says up to where it holds.
#[test]
fn a_cut_off_recording_is_verified_up_to_its_last_seal() {
    let folder = TempDir::new().unwrap();
    let recordings = TempDir::new().unwrap();
    let mut twin = RecordedTwin::new(parameters());
    twin.hit(event("a", twin.now));
    twin.until_rest();
    let directory = twin.directory();
    // Until it is sealed by a flush, which the recorder does by its own clock.
    let begin = std::time::Instant::now();
    let file = loop {
        assert!(begin.elapsed() < super::domain::PATIENCE, "no seal");
        let bag = fs::read_dir(directory).unwrap().next();
        let file = bag.and_then(|bag| fs::read_dir(bag.ok()?.path()).ok()?.next()?.ok());
        let sealed = file.as_ref().and_then(|it| Reader::open(&it.path()).ok());
        let seal = sealed.and_then(|it| it.seals()[0].clone());
        if let Some(file) = file.filter(|_| seal.is_some_and(|it| it.covered > 60)) {
            break file.path();
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    };
    let cut = recordings.path().join("cut.mcap");
    fs::copy(file, &cut).unwrap();
    drop(twin.finish());
    let line = format!("repair {} -o kept", cut.display());
    let (_, stdout, _) = typed(folder.path(), &line);
    assert!(stdout.contains("Its seal covers "), "{stdout}");
    let (text, _) = ends_with(0, &folder, "verify kept");
    assert!(
        text.contains("Seal: sealed by the key") && text.contains("it holds"),
        "{text}"
    );
    assert!(
        text.contains("it has no final seal: the recording was cut off"),
        "{text}"
    );
}

/// The recordings of one session, of which the last continues the one before it.
#[test]
fn a_recording_removed_from_the_middle_is_reported_with_the_next_one() {
    let max_file_size = size_of_one_impact() * 6 / 10;
    let limited = |options| RecorderOptions {
        // No impact exceeds it twice, where a recording would have to end during a response.
        max_file_size,
        ..options
    };
    let mut twin = RecordedTwin::with_options(parameters(), RecordMode::Always, limited);
    for id in ["a", "b", "c", "d", "e"] {
        twin.hit(event(id, twin.now));
        twin.until_rest();
        twin.advance(100 * MS);
    }
    let finished = twin.finish();
    let mut paths = finished.paths();
    let number = |path: &PathBuf| {
        Reader::open(path).unwrap().seals()[0]
            .as_ref()
            .unwrap()
            .recording
    };
    paths.sort_by_key(number);
    assert!(paths.len() >= 3, "{paths:?}");
    let [first, middle, last] = [&paths[0], &paths[1], &paths[2]];
    assert_eq!(
        Reader::open(first).unwrap().predecessor(),
        Predecessor::None
    );
    let folder = TempDir::new().unwrap();
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    let line = format!("verify {}", last.display());
    let (code, text, fault) = typed(folder.path(), &line);
    assert!(
        text.contains(&format!("it continues {}", name(middle))),
        "{code} {text}{fault}"
    );
    fs::remove_dir_all(middle).unwrap();
    let (text, fault) = ends_with(1, &folder, &line);
    let expected = format!(
        "the recording before it, {}, is missing from this folder",
        name(middle)
    );
    assert!(
        text.contains(&expected) && fault.contains(&expected),
        "{text}{fault}"
    );
    // After the oldest recordings were deleted, nothing is wrong.
    fs::remove_dir_all(first).unwrap();
    let (text, _) = ends_with(0, &folder, &line);
    assert!(
        text.contains("neither that recording nor an earlier one"),
        "{text}"
    );
}

/// A node logs its key at the start and seals with it.
#[test]
fn a_node_logs_the_key_of_its_seals() {
    let folder = folder_with_keys();
    let domain = super::domain::Domain::fresh();
    for (key, expected) in [
        (
            "key.pem",
            format!("recordings are sealed with the key {DIGITS} (private part: key.pem)"),
        ),
        (
            "''",
            "made for this run only; keep this line apart from the recordings".to_owned(),
        ),
    ] {
        let directory = format!("recordings_{}", key.len());
        let mut node = node::command(&domain, Path::new(&directory))
            .current_dir(folder.path())
            .args(["-p", &format!("record.seal_key:={key}")])
            .spawn()
            .unwrap();
        // Its stderr stays open until it ends; the recording begins with the first checkpoint.
        let recordings = folder.path().join(&directory);
        let begin = std::time::Instant::now();
        while fs::read_dir(&recordings).map_or(0, Iterator::count) == 0 {
            assert!(begin.elapsed() < super::domain::PATIENCE, "no recording");
            assert!(node.try_wait().unwrap().is_none(), "the node has ended");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let (code, log) = node::stopped(node);
        assert_eq!(code, Some(0), "{log}");
        assert!(log.contains(&expected), "{log}");
        let bag = super::recorded_twin::the_one_recording(&recordings);
        let reader = Reader::open(&bag).unwrap();
        let seal = reader.seals()[0].as_ref().unwrap();
        assert!(
            seal.holds() && seal.is_final && seal.uncovered == 0,
            "{seal:?}"
        );
        assert!(log.contains(&seal.public_key.unwrap().to_string()), "{log}");
    }
}
