//! A file for the viewer, of a simulation or of what a recording has told.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use rerun::RecordingStreamBuilder;

use super::ViewerError;
use super::blueprint::APPLICATION;
use super::film::{Film, FilmOptions};
use super::item::{Announcement, Item};
use super::plots::Ranges;
use crate::column::{Outcome, Phase, Report, Sample};
use crate::parameters::Parameters;
use crate::twin::{StateOutput, TwinPhase};

/// Shortest time between two pictures of the scene \[ns\].
const PICTURE_PERIOD: i64 = 500_000;

/// Most pictures of the scene that one impact is worth.
const MAX_PICTURES: i64 = 600;

/// Time between two pictures of an approach \[s\].
const APPROACH_PERIOD: f64 = 1e-3;

/// Longest wait for the disk.
const WRITTEN_WITHIN: Duration = Duration::from_secs(60);

/// A simulation takes an approach to a column at rest in one stride: the vehicle moves on evenly, and so it is shown.
fn with_the_whole_approach(samples: impl IntoIterator<Item = Sample>) -> Vec<Sample> {
    let mut whole: Vec<Sample> = Vec::new();
    for sample in samples {
        let from = whole
            .last()
            .copied()
            .filter(|it| it.phase == Phase::Approach);
        if let Some(from) = from {
            let pictures = ((sample.time - from.time) / APPROACH_PERIOD).ceil();
            let pictures = pictures.clamp(0.0, MAX_PICTURES as f64) as i64;
            whole.extend((1..pictures).map(|picture| {
                let part = picture as f64 / pictures as f64;
                approaching(from, part * (sample.time - from.time))
            }));
        }
        whole.push(sample);
    }
    whole
}

/// The same `elapsed` seconds later, when nothing but the vehicle has moved.
fn approaching(mut sample: Sample, elapsed: f64) -> Sample {
    let way = sample.impactor_velocity * elapsed;
    sample.time += elapsed;
    sample.impactor_position += way;
    sample.gap = (sample.gap - way).max(0.0);
    sample
}

/// What a simulation shows, with its outcome before and after; `stamp` dates the event.
pub fn from_samples(
    event_id: &str,
    stamp: i64,
    samples: impl IntoIterator<Item = Sample>,
    report: &Report,
) -> Vec<Item> {
    let event_id: Arc<str> = event_id.into();
    let announcement = || Announcement::new(stamp, Arc::clone(&event_id), report);
    let mut items = vec![Item::Forecast(announcement())];
    let samples = with_the_whole_approach(samples);
    items.extend(samples.into_iter().map(|sample| {
        Item::State(StateOutput {
            stamp: stamp.saturating_add(super::timeline::nanos(sample.time)),
            event_id: Arc::clone(&event_id),
            phase: TwinPhase::from(sample.phase),
            sample,
            lengths: None,
        })
    }));
    if let (Some(Item::State(last)), Outcome::Elastic | Outcome::Plastic) =
        (items.last_mut(), report.outcome)
    {
        last.phase = TwinPhase::Rest;
    }
    items.push(Item::Result(announcement()));
    items
}

/// How a whole film is made: its axes hold all of it from the start.
pub(super) fn options(items: &[Item], follows: bool) -> FilmOptions {
    let mut ranges = Ranges::default();
    let mut longest = 0.0_f64;
    for item in items {
        match item {
            Item::State(state) => {
                ranges.reach(&state.sample);
                longest = longest.max(state.sample.time);
            }
            Item::Forecast(it) | Item::Result(it) => ranges.reach_report(&it.report),
            Item::Rest { .. } | Item::Line { .. } | Item::Parameters(_) => {}
        }
    }
    let spaced = super::timeline::nanos(longest) / MAX_PICTURES;
    FilmOptions {
        picture_period: PICTURE_PERIOD.max(spaced),
        budget: None,
        curves_period: 0,
        follows,
        ranges,
    }
}

/// Writes a file that the viewer opens. It appears under its name when it is complete.
///
/// The viewer shows the first moment and plays on slowly, or the last one where it `follows`.
///
/// # Errors
/// The file cannot be written.
pub fn write_rrd(
    path: &Path,
    parameters: &Arc<Parameters>,
    items: Vec<Item>,
    follows: bool,
) -> Result<(), ViewerError> {
    let fault = |reason: String| ViewerError::File {
        path: path.to_owned(),
        reason,
    };
    let unfinished = unfinished(path);
    let written = || -> Result<(), String> {
        let stream = RecordingStreamBuilder::new(APPLICATION)
            .enabled(true)
            .save(&unfinished)
            .map_err(|error| error.to_string())?;
        let mut film = Film::new(stream, Arc::clone(parameters), options(&items, follows))
            .map_err(|error| error.to_string())?;
        film.show(items).map_err(|error| error.to_string())?;
        film.stream()
            .flush_with_timeout(WRITTEN_WITHIN)
            .map_err(|error| error.to_string())
    };
    // The film ends with the stream and the file's footer in it, before the file has its name.
    let outcome =
        written().and_then(|()| fs::rename(&unfinished, path).map_err(|error| error.to_string()));
    if outcome.is_err() {
        let _ = fs::remove_file(&unfinished); // it may not even be there
    }
    outcome.map_err(fault)
}

/// The name of a file until it is complete.
fn unfinished(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".unfinished");
    name.into()
}
