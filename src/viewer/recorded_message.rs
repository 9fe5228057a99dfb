//! Converts the messages of a recording to items for the viewer.

use std::collections::HashMap;
use std::sync::Arc;

use super::detected::DetectedUpdate;
use super::item::{Announcement, ViewerItem};
use crate::messages::column_twin_msgs::{ColumnState, HingeForces, ImpactEvent, ImpactReport};
use crate::parameters::Parameters;
use crate::shape::Lengths;

/// A message of a recording, or a pair of messages that belong together.
#[derive(Debug, Clone)]
#[expect(
    clippy::large_enum_variant,
    reason = "nearly all are states, which should not be allocated one by one"
)]
pub enum RecordedMessage {
    /// The column at one instant: two messages with the same stamp.
    State(ColumnState, HingeForces),
    /// A forecast or a result.
    Report(Box<ImpactReport>),
    /// The impact event.
    Event(Box<ImpactEvent>),
    /// What the sensors say about an impact.
    Detected(Box<DetectedUpdate>),
    /// The parameters of the column from here on.
    Column(Arc<Parameters>),
}

/// The items of a recording of the column with these `parameters`, in the order of its states. A forecast comes before the
/// first state of its impact, a result after the last one; a report without states is left out.
#[must_use]
pub fn from_messages(
    parameters: &Arc<Parameters>,
    messages: Vec<RecordedMessage>,
) -> Vec<ViewerItem> {
    let mut forecasts = HashMap::new();
    let mut results = HashMap::new();
    let mut heights = HashMap::new();
    for message in &messages {
        match message {
            RecordedMessage::Report(report) => {
                let of_kind = match report.kind {
                    ImpactReport::FORECAST => &mut forecasts,
                    ImpactReport::RESULT => &mut results,
                    _ => continue,
                };
                of_kind.insert(report.event_id.clone(), report.clone());
            }
            // A repeated identifier was rejected, so that the first event counts.
            RecordedMessage::Event(event) if event.column_id == parameters.settings().column_id => {
                heights
                    .entry(event.event_id.clone())
                    .or_insert(event.height);
            }
            RecordedMessage::Event(_)
            | RecordedMessage::State(..)
            | RecordedMessage::Detected(_)
            | RecordedMessage::Column(_) => {}
        }
    }
    let mut parameters = Arc::clone(parameters);
    let mut items = Vec::new();
    let mut current: Option<String> = None;
    let mut lengths = None;
    for message in messages {
        match message {
            RecordedMessage::State(state, forces) => {
                if current.as_ref() != Some(&state.event_id) {
                    let ended = current.replace(state.event_id.clone());
                    let result = ended.and_then(|event_id| results.remove(&event_id));
                    items.extend(result.map(|it| ViewerItem::Result(announcement(*it))));
                    let forecast = forecasts.remove(&state.event_id);
                    items.extend(forecast.map(|it| ViewerItem::Forecast(announcement(*it))));
                    let height = heights.get(&state.event_id).filter(|it| it.is_finite());
                    lengths = height.map(|below| {
                        let whole = Lengths::from(&*parameters);
                        Lengths {
                            below: *below,
                            above: whole.total() - below,
                            ..whole
                        }
                    });
                }
                items.push(ViewerItem::of_messages(&state, &forces, lengths));
            }
            RecordedMessage::Detected(update) => {
                let ended = current.take_if(|current| *current != *update.impact());
                let result = ended.and_then(|event_id| results.remove(&event_id));
                items.extend(result.map(|it| ViewerItem::Result(announcement(*it))));
                items.push(ViewerItem::Detected(update));
            }
            RecordedMessage::Column(other) if *other != *parameters => {
                let result = current
                    .take()
                    .and_then(|event_id| results.remove(&event_id));
                items.extend(result.map(|it| ViewerItem::Result(announcement(*it))));
                items.push(ViewerItem::Parameters(Arc::clone(&other)));
                parameters = other;
            }
            RecordedMessage::Column(_) | RecordedMessage::Report(_) | RecordedMessage::Event(_) => {
            }
        }
    }
    let result = current.and_then(|event_id| results.remove(&event_id));
    items.extend(result.map(|it| ViewerItem::Result(announcement(*it))));
    items
}

fn announcement(report: ImpactReport) -> Announcement {
    Announcement {
        stamp: report.header.stamp.to_nanos().unwrap_or_default(),
        event_id: report.event_id.as_str().into(),
        report: Box::new(report),
    }
}
