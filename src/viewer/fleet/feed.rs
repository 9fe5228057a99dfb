//! Decides what of a fleet is shown: the marks of all columns, and everything of those in full.

use std::sync::Arc;

use super::item::{ColumnMark, FleetItem, ShownFleet, action_of};
use crate::parameters::Parameters;
use crate::twin::{NoticeLevel, Output};
use crate::viewer::events::summary;
use crate::viewer::item::{Announcement, ViewerItem};
use printable::Printable;

/// Something that a column has given out.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant)] // most are states, which shall not be allocated one by one
pub enum Fact {
    /// Something that is shown of a column in full.
    Item(ViewerItem),
    /// What the plan shows of it from now on, with its time \[ns since the epoch\].
    Mark(i64, ColumnMark),
}

impl Fact {
    /// What an output of a column contains.
    pub fn of_output(output: Output) -> impl Iterator<Item = Self> {
        let mark = match &output {
            Output::Status(status) => Some(Self::Mark(status.stamp, ColumnMark::from(status))),
            _ => None,
        };
        mark.into_iter()
            .chain(ViewerItem::of_twin(output).map(Self::Item))
    }
}

/// What has to be shown of a column when it is shown in full.
#[derive(Debug, Clone, Default)]
struct Known {
    mark: ColumnMark,
    /// The impact whose states it gives out.
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
}

impl FleetFeed {
    /// For a fleet of which nothing is known yet.
    #[must_use]
    pub fn new(fleet: Arc<ShownFleet>) -> Self {
        Self {
            known: vec![Known::default(); fleet.ids.len()],
            newest: None,
            fleet,
        }
    }

    /// What is to be shown of these facts, which are in their order. If several columns are hit in one call, the last one becomes
    /// that of the newest impact.
    pub fn take(&mut self, facts: Vec<(u32, Fact)>) -> Vec<FleetItem> {
        let begins: Vec<bool> = facts
            .iter()
            .map(|(column, fact)| self.begins(*column, fact))
            .collect();
        let last = begins.iter().rposition(|it| *it);
        let mut items = Vec::with_capacity(facts.len());
        for (index, (column, fact)) in facts.into_iter().enumerate() {
            if column as usize >= self.known.len() {
                continue;
            }
            if Some(index) == last && self.newest != Some(column) {
                self.becomes_newest(column, &mut items);
            }
            match fact {
                Fact::Mark(stamp, mark) => self.mark(column, stamp, mark, &mut items),
                Fact::Item(item) => self.item(column, item, &mut items),
            }
        }
        items
    }

    /// Whether this is the first state of an impact.
    fn begins(&mut self, column: u32, fact: &Fact) -> bool {
        let (Fact::Item(ViewerItem::State(state)), Some(known)) =
            (fact, self.known.get_mut(column as usize))
        else {
            return false;
        };
        let is_same = known.event_id.as_ref() == Some(&state.event_id);
        if !is_same {
            known.event_id = Some(Arc::clone(&state.event_id));
        }
        !is_same
    }

    fn is_in_full(&self, column: u32) -> bool {
        self.newest == Some(column) || self.fleet.selected.contains(&column)
    }

    fn becomes_newest(&mut self, column: u32, items: &mut Vec<FleetItem>) {
        let known = &self.known[column as usize];
        let initial = &self.fleet.parameters[column as usize];
        items.push(FleetItem::Newest {
            column,
            parameters: Arc::clone(known.parameters.as_ref().unwrap_or(initial)),
        });
        // A selected column has been told before.
        if !self.fleet.selected.contains(&column) {
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
        let in_full = self.is_in_full(column);
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
            ViewerItem::State(_) | ViewerItem::Detected(_) | ViewerItem::Beam { .. } => {}
        }
        if in_full {
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
        FleetFeed::new(Arc::new(ShownFleet::new(&columns, selected)))
    }

    fn state(column: u32, event_id: &str) -> (u32, Fact) {
        let state = StateOutput {
            stamp: 0,
            event_id: event_id.into(),
            phase: TwinPhase::Contact,
            sample: Sample::default(),
            lengths: None,
            vehicle: None,
        };
        (column, Fact::Item(ViewerItem::State(state)))
    }

    fn forecast(column: u32, event_id: &str, action: u8) -> (u32, Fact) {
        let announcement = Announcement {
            stamp: 7,
            event_id: event_id.into(),
            report: Box::new(ImpactReport {
                action,
                ..ImpactReport::default()
            }),
        };
        (column, Fact::Item(ViewerItem::Forecast(announcement)))
    }

    fn mark(column: u32, phase: TwinPhase) -> (u32, Fact) {
        let mark = ColumnMark {
            action: Some(Action::None),
            phase,
            ..ColumnMark::default()
        };
        (column, Fact::Mark(7, mark))
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
        let items = feed.take(vec![forecast(1, "a", TwinStatus::ACTION_SHORE)]);
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
        assert_eq!(
            kinds(&feed.take(vec![mark(1, TwinPhase::Idle)])),
            [("mark", 1)]
        );
        assert_eq!(kinds(&feed.take(vec![mark(1, TwinPhase::Idle)])), []);
        let items = feed.take(vec![
            mark(1, TwinPhase::Contact),
            forecast(1, "a", TwinStatus::ACTION_SHORE),
            mark(1, TwinPhase::Free),
        ]);
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
        let items = feed.take(vec![mark(1, TwinPhase::Idle)]);
        let [FleetItem::Mark { mark, .. }] = &items[..] else {
            panic!("{items:?}");
        };
        assert_eq!((mark.predicted, mark.is_notable()), (None, false));
    }

    #[test]
    fn columns_that_do_not_exist_are_ignored() {
        let mut feed = feed(2, Vec::new());
        let items = feed.take(vec![state(2, "a"), mark(9, TwinPhase::Idle)]);
        assert!(items.is_empty());
    }
}
