//! What the messages of a recording show.

use std::collections::HashMap;
use std::sync::Arc;

use super::item::{Announcement, Item};
use crate::messages::column_twin::{ColumnState, HingeForces, ImpactEvent, ImpactReport};
use crate::parameters::Parameters;
use crate::shape::Lengths;

/// One thing that a recording tells.
#[derive(Debug, Clone)]
#[expect(
    clippy::large_enum_variant,
    reason = "nearly all are states, which are not to be allocated one by one"
)]
pub enum RecordedMessage {
    /// The column at one instant: two messages of the same stamp.
    State(ColumnState, HingeForces),
    /// A forecast or a result.
    Report(Box<ImpactReport>),
    /// What hit the column, and where.
    Event(Box<ImpactEvent>),
    /// Which column it is from here on.
    Column(Arc<Parameters>),
}

/// What a recording of the column with these `parameters` shows, in the order of its states. A report stands before the first
/// state of its impact if it is a forecast, and after the last one if it is a result; a report without states is left out.
#[must_use]
pub fn from_messages(parameters: &Arc<Parameters>, told: Vec<RecordedMessage>) -> Vec<Item> {
    let mut forecasts = HashMap::new();
    let mut results = HashMap::new();
    let mut heights = HashMap::new();
    for told in &told {
        match told {
            RecordedMessage::Report(report) => {
                let of_kind = match report.kind {
                    ImpactReport::FORECAST => &mut forecasts,
                    ImpactReport::RESULT => &mut results,
                    _ => continue,
                };
                of_kind.insert(report.event_id.clone(), report.clone());
            }
            // A repeat of its identifier was refused.
            RecordedMessage::Event(event) if event.column_id == parameters.settings().column_id => {
                heights
                    .entry(event.event_id.clone())
                    .or_insert(event.height);
            }
            RecordedMessage::Event(_) | RecordedMessage::State(..) | RecordedMessage::Column(_) => {
            }
        }
    }
    let mut parameters = Arc::clone(parameters);
    let mut items = Vec::new();
    let mut going: Option<String> = None;
    let mut lengths = None;
    for told in told {
        match told {
            RecordedMessage::State(state, forces) => {
                if going.as_ref() != Some(&state.event_id) {
                    let ended = going.replace(state.event_id.clone());
                    let result = ended.and_then(|event_id| results.remove(&event_id));
                    items.extend(result.map(|it| Item::Result(announcement(*it))));
                    let forecast = forecasts.remove(&state.event_id);
                    items.extend(forecast.map(|it| Item::Forecast(announcement(*it))));
                    let height = heights.get(&state.event_id).filter(|it| it.is_finite());
                    lengths = height.map(|below| {
                        let total = Lengths::from(&*parameters).total();
                        Lengths {
                            below: *below,
                            above: total - below,
                        }
                    });
                }
                items.push(Item::of_messages(&state, &forces, lengths));
            }
            RecordedMessage::Column(other) if *other != *parameters => {
                let result = going.take().and_then(|event_id| results.remove(&event_id));
                items.extend(result.map(|it| Item::Result(announcement(*it))));
                items.push(Item::Parameters(Arc::clone(&other)));
                parameters = other;
            }
            RecordedMessage::Column(_) | RecordedMessage::Report(_) | RecordedMessage::Event(_) => {
            }
        }
    }
    let result = going.and_then(|event_id| results.remove(&event_id));
    items.extend(result.map(|it| Item::Result(announcement(*it))));
    items
}

fn announcement(report: ImpactReport) -> Announcement {
    Announcement {
        stamp: report.header.stamp.to_nanos().unwrap_or_default(),
        event_id: report.event_id.as_str().into(),
        report: Box::new(report),
    }
}
