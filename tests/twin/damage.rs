//! Damage accumulates over impacts and survives restarts, until a reset.

use std::path::Path;

use column_twin::column::{ImpactSpecification, Outcome};
use column_twin::parameters::Value;
use column_twin::state_home;
use column_twin::twin::state_file::{self, Loaded};
use column_twin::twin::{ImpactCommand, Output, SavedState, TwinPhase};

use crate::{Bench, MS, START, event, fatal, light, parameters};

fn hit_and_rest(bench: &mut Bench, event: ImpactCommand) {
    bench.hit(event);
    bench.rest();
}

#[test]
fn damage_accumulates_over_impacts_until_a_reset() {
    let mut bench = Bench::new(&[]);
    let mut residuals = vec![0.0];
    let mut works = vec![0.0];
    for id in ["a", "b", "c"] {
        let stamp = bench.now;
        hit_and_rest(&mut bench, event(id, stamp));
        let status = bench.status();
        residuals.push(status.residual_v1);
        works.push(status.plastic_work_since_reset);
        assert_eq!(
            bench.reports().last().expect("one").report.outcome,
            Outcome::Plastic
        );
    }
    assert!(
        residuals.windows(2).all(|pair| pair[0] < pair[1]),
        "{residuals:?}"
    );
    assert!(works.windows(2).all(|pair| pair[0] < pair[1]), "{works:?}");
    let reports: f64 = bench
        .reports()
        .iter()
        .map(|it| it.report.plastic_work)
        .sum();
    assert!((works[3] - reports).abs() < 1e-9 * reports);
    bench.reset();
    let undamaged = Bench::new(&[]).status();
    let status = bench.status();
    assert_eq!(status.plastic_rotation, [0.0; 4]);
    assert_eq!(
        (status.residual_u2, status.impacts_since_reset),
        (undamaged.residual_u2, 0)
    );
    let stamp = bench.now;
    hit_and_rest(&mut bench, event("a", stamp));
    let reports = bench.reports();
    assert_eq!(reports[3].report, reports[0].report);
}

fn restarted(bench: &Bench) -> Bench {
    let text = bench
        .saved()
        .last()
        .expect("saved")
        .to_json()
        .expect("JSON");
    let saved = SavedState::from_json(&text, bench.twin.parameters()).expect("its own");
    assert_eq!(saved, ***bench.saved().last().expect("saved"));
    let mut again = Bench::with((**bench.twin.parameters()).clone(), Some(&saved));
    again.now = bench.now;
    again
}

/// Bit for bit: the next impact has the same samples with and without a restart.
#[test]
fn damage_survives_a_restart() {
    let mut bench = Bench::new(&[]);
    hit_and_rest(&mut bench, event("a", START));
    let mut again = restarted(&bench);
    assert_eq!(
        again.status().plastic_rotation,
        bench.status().plastic_rotation
    );
    assert_eq!(again.status().residual_v1, bench.status().residual_v1);
    assert_eq!(&*again.status().event_id, "a");
    let stamp = bench.now;
    hit_and_rest(&mut bench, event("b", stamp));
    hit_and_rest(&mut again, event("b", stamp));
    assert_eq!(bench.reports()[1].report, again.reports()[0].report);
    again.hit(event("a", again.now));
    assert!(
        again.rejections()[0]
            .rejection
            .reason
            .contains("accepted before")
    );
}

/// The forecast saves the expected damage, in case the machine stops during the response.
#[test]
fn the_damage_of_an_interrupted_response_is_saved_with_the_forecast() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.go_on(3 * MS);
    let again = restarted(&bench);
    bench.rest();
    let (kept, real) = (again.status(), bench.status());
    assert_eq!(kept.plastic_rotation, real.plastic_rotation);
    assert_eq!(kept.residual_v1, real.residual_v1);
    assert_eq!(kept.plastic_work_since_reset, real.plastic_work_since_reset);
}

#[test]
fn a_collapse_survives_a_restart() {
    let mut bench = Bench::new(&[("top.load", 2.0e6.into())]);
    hit_and_rest(&mut bench, fatal("a", START));
    let mut again = restarted(&bench);
    assert_eq!(again.status().phase, TwinPhase::Collapsed);
    again.hit(event("b", again.now));
    assert_eq!(again.rejections().len(), 1);
}

#[test]
fn a_new_load_leads_to_a_new_equilibrium() {
    let mut bench = Bench::new(&[]);
    hit_and_rest(&mut bench, event("a", START));
    let saved = bench.saved().last().expect("saved").as_ref().clone();
    let again = Bench::with(parameters(&[("top.load", 6e5.into())]), Some(&saved));
    assert!(again.status().residual_v1 > bench.status().residual_v1);
    assert_eq!(
        again.status().plastic_rotation,
        bench.status().plastic_rotation
    );
    let mut crushed = Bench::with(parameters(&[("top.load", 2.9e6.into())]), Some(&saved));
    assert_eq!(crushed.status().phase, TwinPhase::Faulted);
    assert!(crushed.status().fault.contains("no equilibrium"));
    crushed.hit(event("b", crushed.now));
    assert!(
        crushed.rejections()[0]
            .rejection
            .reason
            .contains("reset it first")
    );
    crushed.reset();
    assert_eq!(crushed.status().phase, TwinPhase::Idle);
}

fn damaged() -> SavedState {
    let mut bench = Bench::new(&[]);
    hit_and_rest(&mut bench, event("a", START));
    bench.twin.saved_state(bench.now)
}

fn in_folder(test: impl FnOnce(&Path)) {
    let folder = tempfile::tempdir().expect("a folder");
    test(folder.path());
}

fn rejection(path: &Path, changes: &[(&str, Value)]) -> String {
    match state_file::load(path, &parameters(changes)).expect("loads") {
        Loaded::Rejected { reason, kept_as } => {
            assert!(!path.exists() && kept_as.exists());
            reason
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_state_file_reads_back_unchanged() {
    in_folder(|folder| {
        let path = folder.join("deeper").join("column.json");
        assert_eq!(
            state_file::load(&path, &parameters(&[])).expect("none"),
            Loaded::Absent
        );
        let saved = damaged();
        for _ in 0..2 {
            state_file::store(&path, &saved).expect("written");
        }
        let loaded = state_file::load(&path, &parameters(&[])).expect("read");
        assert_eq!(loaded, Loaded::Damage(Box::new(saved)));
        let files = std::fs::read_dir(path.parent().expect("a folder")).expect("readable");
        assert_eq!(files.count(), 1, "no other file is left");
    });
}

/// Truncated at any length, or with any changed character, and without a panic.
#[test]
fn a_damaged_state_file_is_rejected_and_kept() {
    let saved = damaged();
    let text = saved.to_json().expect("JSON");
    let expected = parameters(&[]);
    for end in (0..text.len()).step_by(7) {
        assert!(
            SavedState::from_json(&text[..end], &expected).is_err(),
            "cut at {end}"
        );
    }
    for place in (0..text.len()).step_by(5) {
        let mut bytes = text.clone().into_bytes();
        bytes[place] = if bytes[place] == b'7' { b'8' } else { b'7' };
        if let Ok(edited) = String::from_utf8(bytes) {
            // Changes of white space, and of digits beyond the precision of a number, have no effect.
            if let Ok(read) = SavedState::from_json(&edited, &expected) {
                assert_eq!(read, saved, "at {place}");
            }
        }
    }
    in_folder(|folder| {
        let path = folder.join("column.json");
        for (content, expected) in [
            (&text.as_bytes()[..text.len() / 2], "truncated"),
            (b"", "truncated"),
            (
                b"{\"format\": \"other\", \"version\": 7}",
                "format \"other\", version 7; expected",
            ),
            (b"\xff\xfe\x00", "UTF-8"),
            (b"{}", "not a state file"),
        ] {
            std::fs::write(&path, content).expect("written");
            let reason = rejection(&path, &[]);
            assert!(reason.contains(expected), "{reason}");
        }
        let aside = std::fs::read_dir(folder).expect("readable").count();
        assert_eq!(aside, 5, "each is kept under its own name");
        std::fs::write(
            &path,
            vec![b' '; state_file::MAX_STATE_FILE_BYTES as usize + 1],
        )
        .expect("written");
        assert!(rejection(&path, &[]).contains("larger than"));
    });
}

#[test]
fn a_state_file_of_another_column_is_rejected_and_kept() {
    in_folder(|folder| {
        let path = folder.join("column.json");
        let saved = damaged();
        for (changes, expected) in [
            (
                ("column_id", Value::from("A3")),
                "it belongs to column \"column\", but this is the twin of column \"A3\"",
            ),
            (
                ("section.name", "HEB300".into()),
                "differ from those with which it was damaged",
            ),
            (
                ("geometry.length_below", 1.5.into()),
                "differ from those with which it was damaged",
            ),
        ] {
            state_file::store(&path, &saved).expect("written");
            let reason = rejection(&path, &[changes]);
            assert!(reason.contains(expected), "{reason}");
        }
        state_file::store(&path, &saved).expect("written");
        let other_load = parameters(&[("top.load", 4e5.into()), ("solver.dt", 2e-5.into())]);
        assert!(matches!(
            state_file::load(&path, &other_load),
            Ok(Loaded::Damage(_))
        ));
    });
}

/// Of 30 programs that were killed, one had lost the impact whose forecast it had just given out: the forecast came before the damage
/// was written, and a file that was complete, but not renamed yet, was not read.
#[test]
fn damage_is_saved_before_its_forecast_and_survives_a_kill_before_the_rename() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.twin.run_ahead(u64::MAX, bench.now, &mut bench.out);
    let place = |is_it: fn(&Output) -> bool| bench.out.iter().position(is_it).expect("given out");
    let saved = place(|it| matches!(it, Output::Save(_)));
    assert!(saved < place(|it| matches!(it, Output::Forecast(_))));
    in_folder(|folder| {
        let (path, new) = (folder.join("column.json"), folder.join("column.json.new"));
        let before = Bench::new(&[]).twin.saved_state(START);
        let saved = damaged();
        let load = || state_file::load(&path, &parameters(&[])).expect("read");
        state_file::store(&path, &before).expect("written");
        let text = saved.to_json().expect("text");
        // It was killed while it wrote.
        std::fs::write(&new, &text[..text.len() / 2]).expect("written");
        assert_eq!(load(), Loaded::Damage(Box::new(before)));
        // It was killed before it renamed the file.
        std::fs::write(&new, &text).expect("written");
        assert_eq!(load(), Loaded::Damage(Box::new(saved.clone())));
        assert!(!new.exists());
        // What was put into the place of the file since counts more than what was interrupted before.
        let older = std::time::SystemTime::now() - std::time::Duration::from_secs(60);
        std::fs::write(
            &new,
            Bench::new(&[])
                .twin
                .saved_state(START)
                .to_json()
                .expect("text"),
        )
        .expect("written");
        let file = std::fs::File::options()
            .write(true)
            .open(&new)
            .expect("a file");
        file.set_modified(older).expect("ours");
        assert_eq!(load(), Loaded::Damage(Box::new(saved)));
    });
}

#[test]
fn a_state_file_that_cannot_be_written_is_an_error() {
    in_folder(|folder| {
        let occupied = folder.join("file");
        std::fs::write(&occupied, "").expect("written");
        let error =
            state_file::store(&occupied.join("column.json"), &damaged()).expect_err("no folder");
        assert!(error.to_string().contains("cannot be written"));
        let error = state_file::load(folder, &parameters(&[])).expect_err("a folder");
        assert!(error.to_string().contains("cannot be read"));
    });
}

#[test]
fn the_path_of_the_state_file_follows_from_the_parameters() {
    let of = |changes: &[(&str, Value)]| state_file::path(&parameters(changes));
    // In whichever state folder these tests run.
    let default = state_home::resolve("$XDG_STATE_HOME/column_twin/state");
    assert_eq!(of(&[]), Some(default.join("column.json")));
    assert_eq!(of(&[("state.directory", "".into())]), None);
    let names = [
        ("column_id", "a/b".into()),
        ("state.directory", "/var/x".into()),
    ];
    assert_eq!(of(&names).as_deref(), Some(Path::new("/var/x/a%2Fb.json")));
}

/// Hinges 1a and 1b are at the height of the impact.
#[test]
fn another_height_needs_an_undamaged_joint() {
    let at = |height, id: &str, stamp| ImpactCommand {
        impact: ImpactSpecification {
            height: Some(height),
            ..event(id, stamp).impact
        },
        ..event(id, stamp)
    };
    let mut bench = Bench::new(&[]);
    // While they are elastic, the hinges can move to another height and back.
    bench.hit(ImpactCommand {
        impact: ImpactSpecification {
            height: Some(0.6),
            ..light("a", START).impact
        },
        ..light("a", START)
    });
    bench.rest();
    hit_and_rest(&mut bench, light("b", START + 500 * MS));
    assert_eq!((bench.rejections().len(), bench.reports().len()), (0, 2));
    // Plastic hinges remain at 0.6 m, even after a restart.
    let stamp = bench.now;
    hit_and_rest(&mut bench, at(0.6, "c", stamp));
    let lower = Bench::new(&[
        ("geometry.length_below", 0.6.into()),
        ("geometry.length_above", 3.4.into()),
    ]);
    let mut lower = lower;
    hit_and_rest(&mut lower, event("c", START));
    let (here, there) = (bench.reports()[2].report, lower.reports()[0].report);
    assert!((here.max_v1 - there.max_v1).abs() < 1e-12 && here.outcome == Outcome::Plastic);
    let mut again = restarted(&bench);
    for bench in [&mut bench, &mut again] {
        let before = bench.rejections().len();
        bench.hit(event("d", bench.now));
        bench.hit(at(1.2, "e", bench.now));
        let rejections = bench.rejections();
        assert_eq!(rejections.len(), before + 2);
        assert!(
            rejections[before]
                .rejection
                .reason
                .contains("where they are damaged"),
            "{rejections:?}"
        );
        let stamp = bench.now;
        hit_and_rest(bench, at(0.6004, "f", stamp));
        assert_eq!(
            bench.reports().last().expect("one").report.outcome,
            Outcome::Plastic
        );
    }
    bench.reset();
    let stamp = bench.now;
    hit_and_rest(&mut bench, event("g", stamp));
    assert_eq!(&*bench.reports().last().expect("one").event_id, "g");
}

#[test]
fn another_height_is_rejected_while_the_column_responds() {
    let mut bench = Bench::new(&[]);
    bench.hit(light("a", START));
    bench.go_on(MS);
    bench.hit(ImpactCommand {
        impact: ImpactSpecification {
            height: Some(2.0),
            ..light("b", bench.now).impact
        },
        ..light("b", bench.now)
    });
    assert!(
        bench.rejections()[0]
            .rejection
            .reason
            .contains("while the column is responding")
    );
}

/// Names have changed since version 2: such a file is no damaged one, and its reader has to know what to do.
#[test]
fn a_state_file_of_an_earlier_version_is_rejected_with_what_to_do() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.rest();
    let text = bench.twin.saved_state(bench.now).to_json().expect("JSON");
    let parameters = bench.twin.parameters().clone();
    let reason = |version: u32| {
        let other = text.replacen("\"version\": 4", &format!("\"version\": {version}"), 1);
        let other = other.replacen("\"content\": {", "\"content\": { \"an_old_name\": 1,", 1);
        assert_ne!(other, text);
        let read = SavedState::from_json(&other, &parameters);
        read.expect_err("another version").to_string()
    };
    for version in [1, 2, 3] {
        let said = reason(version);
        assert!(
            said.starts_with(&format!(
                "an earlier version of column_twin wrote it (format version {version};"
            )),
            "{said}"
        );
        assert!(
            said.contains(
                "examine the column and call ~/reset if it is undamaged, or go on with the program"
            ),
            "{said}"
        );
    }
    let later = reason(5);
    assert!(
        later.contains("version 5; expected \"column_twin state\", version 4"),
        "{later}"
    );
}
