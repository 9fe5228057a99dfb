//! Decides what of a fleet is shown: the marks of all columns, and everything of those in full.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::item::{ColumnMark, FleetItem, ShownFleet, action_of};
use crate::live::FleetMeasurements;
use crate::messages::words::estimate_line;
use crate::parameters::Parameters;
use crate::twin::{NoticeLevel, Output};
use crate::viewer::events::summary;
use crate::viewer::item::{Announcement, ViewerItem};
use crate::viewer::live_items::LiveItems;
use crate::viewer::timeline::nanos;
use printable::Printable;

/// What has to be shown of a column when it is shown in full.
#[derive(Debug, Clone, Default)]
struct Known {
    mark: ColumnMark,
    /// The impact whose states it gives out, or that its sensors have detected.
    event_id: Option<Arc<str>>,
    rest: Option<ViewerItem>,
    forecast: Option<Announcement>,
    parameters: Option<Arc<Parameters>>,
}

/// Makes items of what the columns give out.
#[derive(Debug)]
pub struct FleetFeed {
    fleet: Arc<ShownFleet>,
    known: Vec<Known>,
    newest: Option<u32>,
    /// The columns that are shown in full: the selected ones, and the newest.
    in_full: BTreeMap<u32, LiveItems>,
    measurements: Option<FleetMeasurements>,
}

impl FleetFeed {
    /// For a fleet of which nothing is known yet. The measurements are those of its sensors.
    #[must_use]
    pub fn new(fleet: Arc<ShownFleet>, measurements: Option<FleetMeasurements>) -> Self {
        let mut feed = Self {
            known: vec![Known::default(); fleet.ids.len()],
            newest: None,
            in_full: BTreeMap::new(),
            measurements,
            fleet,
        };
        let fleet = Arc::clone(&feed.fleet);
        fleet.selected.iter().for_each(|it| feed.open(*it));
        feed
    }

    /// What is to be shown of these outputs of columns, which are in their order. If several columns are hit in one call, the last one
    /// becomes that of the newest impact.
    pub fn take(&mut self, outputs: Vec<(u32, Output)>) -> Vec<FleetItem> {
        let begins: Vec<bool> = outputs
            .iter()
            .map(|(column, output)| self.begins(*column, output))
            .collect();
        let last = begins.iter().rposition(|it| *it);
        let mut items = Vec::with_capacity(outputs.len());
        for (index, (column, output)) in outputs.into_iter().enumerate() {
            if column as usize >= self.known.len() {
                continue;
            }
            if Some(index) == last && self.newest != Some(column) {
                self.becomes_newest(column, &mut items);
            }
            if let Output::Status(status) = &output {
                self.mark(column, status.stamp, ColumnMark::from(status), &mut items);
            }
            let item = match self.in_full.get_mut(&column) {
                Some(it) => it.of_output(output),
                None => ViewerItem::of_twin(output),
            };
            if let Some(item) = item {
                self.item(column, item, &mut items);
            }
        }
        items
    }

    /// Whether this is the first state or the first estimate of an impact.
    fn begins(&mut self, column: u32, output: &Output) -> bool {
        let event_id = match output {
            Output::State(state) => &state.event_id,
            // A later one may be of an impact before the present one.
            Output::Estimate(it) if it.record.update == 0 => {
                it.merged_event_id.as_ref().unwrap_or(&it.record.event_id)
            }
            _ => return false,
        };
        let Some(known) = self.known.get_mut(column as usize) else {
            return false;
        };
        let is_same = known.event_id.as_ref() == Some(event_id);
        if !is_same {
            known.event_id = Some(Arc::clone(event_id));
        }
        !is_same
    }

    /// Shows a column in full from now on.
    fn open(&mut self, column: u32) {
        let parameters = self.parameters(column);
        let items = LiveItems::new(column, parameters, self.measurements.clone());
        self.in_full.insert(column, items);
    }

    fn parameters(&self, column: u32) -> Arc<Parameters> {
        let column = column as usize;
        let changed = self.known[column].parameters.as_ref();
        Arc::clone(changed.unwrap_or(&self.fleet.parameters[column]))
    }

    fn becomes_newest(&mut self, column: u32, items: &mut Vec<FleetItem>) {
        items.push(FleetItem::Newest {
            column,
            parameters: self.parameters(column),
        });
        let selected = &self.fleet.selected;
        self.in_full.retain(|it, _| selected.contains(it));
        // A selected column has been told before.
        if !selected.contains(&column) {
            self.open(column);
            let known = &self.known[column as usize];
            let forecast = known.forecast.clone().map(ViewerItem::Forecast);
            let before = known.rest.clone().into_iter().chain(forecast);
            items.extend(before.map(|it| FleetItem::Column(column, it)));
        }
        self.newest = Some(column);
    }

    fn mark(&mut self, column: u32, stamp: i64, mark: ColumnMark, items: &mut Vec<FleetItem>) {
        let known = &mut self.known[column as usize];
        let predicted = known.mark.predicted.filter(|_| mark.is_responding());
        let mark = ColumnMark { predicted, ..mark };
        if known.mark != mark {
            known.mark = mark;
            items.push(FleetItem::Mark {
                column,
                stamp,
                mark,
            });
        }
    }

    fn item(&mut self, column: u32, item: ViewerItem, items: &mut Vec<FleetItem>) {
        let line = |stamp: i64, level, text: String| FleetItem::Line {
            stamp,
            level,
            text: format!("{}: {text}", Printable(self.fleet.id(column))),
        };
        let known = &mut self.known[column as usize];
        match &item {
            ViewerItem::Forecast(it) => {
                let text = format!("forecast of {}: {}", it.event_id, summary(&it.report));
                items.push(line(it.stamp, NoticeLevel::Info, text));
                let predicted = action_of(it.report.action);
                if known.mark.is_responding() && known.mark.predicted != predicted {
                    known.mark.predicted = predicted;
                    let (stamp, mark) = (it.stamp, known.mark);
                    items.push(FleetItem::Mark {
                        column,
                        stamp,
                        mark,
                    });
                }
                known.forecast = Some(it.clone());
            }
            ViewerItem::Result(it) => {
                let text = format!("result of {}: {}", it.event_id, summary(&it.report));
                items.push(line(it.stamp, NoticeLevel::Info, text));
                known.forecast = None;
            }
            ViewerItem::Line { stamp, level, text } => {
                items.push(line(*stamp, *level, text.clone()));
            }
            ViewerItem::Rest { .. } => known.rest = Some(item.clone()),
            ViewerItem::Parameters(it) => known.parameters = Some(Arc::clone(it)),
            ViewerItem::Detected(it) => {
                let stamp = it.stamp.saturating_add(nanos(it.until));
                items.push(line(stamp, NoticeLevel::Info, estimate_line(&it.estimate)));
            }
            ViewerItem::State(_) | ViewerItem::Beam { .. } => {}
        }
        if self.in_full.contains_key(&column) {
            items.push(FleetItem::Column(column, item));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assessment::Action;
    use crate::column::Sample;
    use crate::messages::column_twin_msgs::{ImpactReport, TwinStatus};
    use crate::parameters::FleetColumn;
    use crate::twin::{StateOutput, TwinPhase};

    fn feed(columns: usize, selected: Vec<u32>) -> FleetFeed {
        let columns: Vec<_> = (0..columns)
            .map(|number| FleetColumn {
                name: format!("/hall/c{number}"),
                parameters: Arc::new(
                    Parameters::from_values([("column_id", format!("c{number}").as_str().into())])
                        .expect("admissible"),
                ),
            })
            .collect();
        FleetFeed::new(Arc::new(ShownFleet::new(&columns, selected)), None)
    }

    fn state(column: u32, event_id: &str) -> (u32, Output) {
        let state = StateOutput {
            stamp: 0,
            event_id: event_id.into(),
            phase: TwinPhase::Contact,
            sample: Sample::default(),
            lengths: None,
            vehicle: None,
        };
        (column, Output::State(state))
    }

    /// What is shown of a forecast.
    fn forecast(feed: &mut FleetFeed, column: u32, event_id: &str, action: u8) -> Vec<FleetItem> {
        let announcement = Announcement {
            stamp: 7,
            event_id: event_id.into(),
            report: Box::new(ImpactReport {
                action,
                ..ImpactReport::default()
            }),
        };
        let mut items = Vec::new();
        feed.item(column, ViewerItem::Forecast(announcement), &mut items);
        items
    }

    /// What is shown of a status.
    fn mark(feed: &mut FleetFeed, column: u32, phase: TwinPhase) -> Vec<FleetItem> {
        let mark = ColumnMark {
            action: Some(Action::None),
            phase,
            ..ColumnMark::default()
        };
        let mut items = Vec::new();
        feed.mark(column, 7, mark, &mut items);
        items
    }

    /// What kinds of items there are, with their columns.
    fn kinds(items: &[FleetItem]) -> Vec<(&'static str, u32)> {
        let kind = |item: &FleetItem| match item {
            FleetItem::Mark { column, .. } => ("mark", *column),
            FleetItem::Newest { column, .. } => ("newest", *column),
            FleetItem::Column(column, ViewerItem::State(_)) => ("state", *column),
            FleetItem::Column(column, ViewerItem::Forecast(_)) => ("forecast", *column),
            FleetItem::Column(column, _) => ("other", *column),
            FleetItem::Line { .. } => ("line", 0),
        };
        items.iter().map(kind).collect()
    }

    #[test]
    fn the_last_column_that_is_hit_is_shown_and_a_selected_one() {
        let mut feed = feed(5, vec![4]);
        let items = feed.take(vec![
            state(1, "a"),
            state(2, "b"),
            state(1, "a"),
            state(4, "c"),
        ]);
        // All are hit at once: the last one counts, and only selected columns are shown besides.
        assert_eq!(kinds(&items), [("newest", 4), ("state", 4)]);
        let items = feed.take(vec![state(2, "b"), state(4, "c")]);
        assert_eq!(kinds(&items), [("state", 4)], "these responses go on");
        let items = feed.take(vec![state(2, "d"), state(1, "a"), state(2, "d")]);
        assert_eq!(kinds(&items), [("newest", 2), ("state", 2), ("state", 2)]);
    }

    #[test]
    fn a_column_that_becomes_the_newest_is_told_what_it_missed() {
        let mut feed = feed(3, Vec::new());
        let items = forecast(&mut feed, 1, "a", TwinStatus::ACTION_SHORE);
        assert_eq!(kinds(&items), [("line", 0)]);
        let items = feed.take(vec![state(1, "a")]);
        assert_eq!(
            kinds(&items),
            [("newest", 1), ("forecast", 1), ("state", 1)]
        );
    }

    #[test]
    fn a_mark_comes_when_it_changes_and_predicts_the_action_of_a_response() {
        let mut feed = feed(3, Vec::new());
        assert_eq!(kinds(&mark(&mut feed, 1, TwinPhase::Idle)), [("mark", 1)]);
        assert_eq!(kinds(&mark(&mut feed, 1, TwinPhase::Idle)), []);
        let mut items = mark(&mut feed, 1, TwinPhase::Contact);
        items.extend(forecast(&mut feed, 1, "a", TwinStatus::ACTION_SHORE));
        items.extend(mark(&mut feed, 1, TwinPhase::Free));
        let predicted: Vec<_> = items
            .iter()
            .filter_map(|it| match it {
                FleetItem::Mark { mark, .. } => Some((mark.worst(), mark.is_notable())),
                _ => None,
            })
            .collect();
        let shore = Some(Action::Shore);
        assert_eq!(
            predicted,
            [(Some(Action::None), true), (shore, true), (shore, true)]
        );
        let items = mark(&mut feed, 1, TwinPhase::Idle);
        let [FleetItem::Mark { mark, .. }] = &items[..] else {
            panic!("{items:?}");
        };
        assert_eq!((mark.predicted, mark.is_notable()), (None, false));
    }

    #[test]
    fn columns_that_do_not_exist_are_ignored() {
        let mut feed = feed(2, Vec::new());
        let items = feed.take(vec![state(2, "a"), state(9, "b")]);
        assert!(items.is_empty());
    }
}
