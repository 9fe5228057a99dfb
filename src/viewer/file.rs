//! A file for the viewer, from a simulation or a recording.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use rerun::RecordingStreamBuilder;

use super::blueprint::APPLICATION;
use super::error::ViewerError;
use super::item::{Announcement, ViewerItem};
use super::plots::Ranges;
use super::stream::{StreamOptions, ViewerStream};
use super::timeline::nanos;
use crate::column::{Phase, Sample};
use crate::messages::column_twin_msgs::ImpactReport;
use crate::parameters::Parameters;
use crate::twin::{StateOutput, TwinPhase};

/// Minimum time between two frames of the scene \[ns\].
const FRAME_PERIOD: i64 = 500_000;

/// Approximate maximum number of frames of one impact.
const MAX_FRAMES: i64 = 600;

/// Time between two frames of an approach \[s\].
const APPROACH_PERIOD: f64 = 1e-3;

/// Maximum wait for the disk.
pub(super) const WRITE_TIMEOUT: Duration = Duration::from_secs(60);

/// Fills in the approach. A simulation takes it in one step if the column is at rest; the vehicle moves at constant
/// velocity.
fn with_the_whole_approach(samples: impl IntoIterator<Item = Sample>) -> Vec<Sample> {
    let mut whole: Vec<Sample> = Vec::new();
    for sample in samples {
        let from = whole
            .last()
            .copied()
            .filter(|it| it.phase == Phase::Approach);
        if let Some(from) = from {
            let frames = ((sample.time - from.time) / APPROACH_PERIOD).ceil();
            let frames = frames.clamp(0.0, MAX_FRAMES as f64) as i64;
            whole.extend((1..frames).map(|frame| {
                let part = frame as f64 / frames as f64;
                approaching(from, part * (sample.time - from.time))
            }));
        }
        whole.push(sample);
    }
    whole
}

/// The sample `elapsed` seconds later, when only the vehicle has moved.
fn approaching(mut sample: Sample, elapsed: f64) -> Sample {
    let way = sample.impactor_velocity * elapsed;
    sample.time += elapsed;
    sample.impactor_position += way;
    sample.gap = (sample.gap - way).max(0.0);
    sample
}

/// The items of a simulation, with its outcome before and after the states; `stamp` dates the event.
pub fn from_samples(
    event_id: &str,
    stamp: i64,
    samples: impl IntoIterator<Item = Sample>,
    report: &ImpactReport,
) -> Vec<ViewerItem> {
    let event_id: Arc<str> = event_id.into();
    let announcement = || Announcement {
        stamp,
        event_id: Arc::clone(&event_id),
        report: Box::new(report.clone()),
    };
    let mut items = vec![ViewerItem::Forecast(announcement())];
    let samples = with_the_whole_approach(samples);
    items.extend(samples.into_iter().map(|sample| {
        ViewerItem::State(StateOutput {
            stamp: stamp.saturating_add(nanos(sample.time)),
            event_id: Arc::clone(&event_id),
            phase: TwinPhase::from(sample.phase),
            sample,
            lengths: None,
            vehicle: None,
        })
    }));
    if let (Some(ViewerItem::State(last)), ImpactReport::ELASTIC | ImpactReport::PLASTIC) =
        (items.last_mut(), report.outcome)
    {
        last.phase = TwinPhase::Rest;
    }
    items.push(ViewerItem::Result(announcement()));
    items
}

/// Options for items that are all known: the axes cover all of them from the start.
pub(super) fn options(items: &[ViewerItem], follows: bool) -> StreamOptions {
    let mut ranges = Ranges::default();
    let mut longest = 0.0_f64;
    for item in items {
        match item {
            ViewerItem::State(state) => {
                ranges.include(&state.sample);
                longest = longest.max(state.sample.time);
            }
            ViewerItem::Forecast(it) | ViewerItem::Result(it) => ranges.include_report(&it.report),
            ViewerItem::Detected(_)
            | ViewerItem::Beam { .. }
            | ViewerItem::Rest { .. }
            | ViewerItem::Line { .. }
            | ViewerItem::Parameters(_) => {}
        }
    }
    let spaced = nanos(longest) / MAX_FRAMES;
    StreamOptions {
        frame_period: FRAME_PERIOD.max(spaced),
        budget: None,
        curves_period: 0,
        follows,
        ranges,
    }
}

/// Writes a file for the viewer, which gets its name when it is complete.
///
/// The viewer plays it slowly from the beginning, or shows the last moment if it `follows`.
///
/// # Errors
/// The file cannot be written.
pub fn write_rrd(
    path: &Path,
    parameters: &Arc<Parameters>,
    items: Vec<ViewerItem>,
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
        let mut shown = ViewerStream::new(stream, Arc::clone(parameters), options(&items, follows))
            .map_err(|error| error.to_string())?;
        shown.show(items).map_err(|error| error.to_string())?;
        shown
            .stream()
            .flush_with_timeout(WRITE_TIMEOUT)
            .map_err(|error| error.to_string())
    };
    // `written` drops the stream, which writes the footer of the file, before the file gets its name.
    let outcome =
        written().and_then(|()| fs::rename(&unfinished, path).map_err(|error| error.to_string()));
    if outcome.is_err() {
        let _ = fs::remove_file(&unfinished); // it may not exist
    }
    outcome.map_err(fault)
}

/// The temporary name of a file until it is complete.
pub(super) fn unfinished(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".unfinished");
    name.into()
}
