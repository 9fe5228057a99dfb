//! Writes the items of a fleet to a Rerun stream.

use std::collections::BTreeMap;
use std::sync::Arc;

use rerun::{RecordingStream, RecordingStreamResult, TextDocument, TextLog};

use super::item::{ColumnMark, FleetItem, ShownFleet};
use super::layout::{self, LOG};
use super::overview::{self, Geometry};
use super::panel::{self, PANEL};
use crate::parameters::{MAX_SELECTED_COLUMNS, Parameters};
use crate::twin::NoticeLevel;
use crate::viewer::blueprint::activate;
use crate::viewer::item::ViewerItem;
use crate::viewer::plots::Ranges;
use crate::viewer::rerun_types::{log_level, time_columns};
use crate::viewer::stream::{StreamOptions, ViewerStream};
use crate::viewer::timeline::{Moment, Timeline};

/// The place in the layout of the column that was hit last, unless it is selected; those of the selected columns are 1 and up.
const NEWEST_SLOT: u8 = MAX_SELECTED_COLUMNS as u8 + 1;

/// A column that is shown in full.
struct InFull {
    column: u32,
    slot: u8,
    stream: ViewerStream,
}

/// A Rerun stream to which the items of a fleet are written.
pub struct FleetStream {
    stream: RecordingStream,
    fleet: Arc<ShownFleet>,
    options: StreamOptions,
    geometry: Geometry,
    marks: Vec<ColumnMark>,
    newest: Option<u32>,
    /// The selected columns, and after them that of the newest impact.
    in_full: Vec<InFull>,
    /// Of which columns the plan shows that something is known.
    known: Vec<bool>,
    /// The latest moment that was shown.
    latest: Moment,
    /// The marks have changed since they were sent.
    has_new_marks: bool,
    has_new_layout: bool,
    /// The panel that was written last.
    told: String,
}

impl FleetStream {
    /// Writes the plan with these marks, and layout and static data of the selected columns.
    ///
    /// # Errors
    /// The stream rejects the data.
    pub fn new(
        stream: RecordingStream,
        fleet: Arc<ShownFleet>,
        marks: Vec<ColumnMark>,
        options: StreamOptions,
    ) -> RecordingStreamResult<Self> {
        let geometry = Geometry::of(&fleet);
        let mut shown = Self {
            latest: Timeline::new(1).before(0),
            stream,
            options,
            geometry,
            marks,
            newest: None,
            known: Vec::new(),
            in_full: Vec::new(),
            has_new_marks: true,
            has_new_layout: true,
            told: String::new(),
            fleet,
        };
        overview::send_statics(&shown.stream, &shown.fleet, &shown.geometry)?;
        let fleet = Arc::clone(&shown.fleet);
        for (slot, column) in (1..NEWEST_SLOT).zip(&fleet.selected) {
            let parameters = &fleet.parameters[*column as usize];
            shown.open(*column, slot, parameters)?;
        }
        shown.send_layout()?;
        Ok(shown)
    }

    /// The stream.
    #[must_use]
    pub fn stream(&self) -> &RecordingStream {
        &self.stream
    }

    /// Shows some items in their order.
    ///
    /// # Errors
    /// The stream rejects the data.
    pub fn show(
        &mut self,
        items: impl IntoIterator<Item = FleetItem>,
    ) -> RecordingStreamResult<()> {
        let mut of_columns: BTreeMap<u32, Vec<ViewerItem>> = BTreeMap::new();
        let mut lines = Vec::new();
        for item in items {
            match item {
                FleetItem::Column(column, item) => of_columns.entry(column).or_default().push(item),
                FleetItem::Mark {
                    column,
                    stamp,
                    mark,
                } => {
                    if let Some(known) = self.marks.get_mut(column as usize) {
                        self.has_new_marks |= *known != mark;
                        *known = mark;
                        self.latest.wall_clock = self.latest.wall_clock.max(stamp);
                    }
                }
                FleetItem::Newest { column, parameters } => {
                    self.show_columns(&mut of_columns)?;
                    self.follow(column, &parameters)?;
                }
                FleetItem::Line { stamp, level, text } => lines.push((stamp, level, text)),
            }
        }
        self.show_columns(&mut of_columns)?;
        for (stamp, level, text) in lines {
            self.line(stamp, level, text)?;
        }
        if std::mem::take(&mut self.has_new_marks) {
            self.send_marks()?;
        }
        let new_layouts = self.in_full.iter_mut();
        let new_layouts = new_layouts.filter_map(|it| it.stream.takes_new_layout().then_some(()));
        self.has_new_layout |= new_layouts.count() > 0;
        match self.has_new_layout {
            true => self.send_layout(),
            false => Ok(()),
        }
    }

    /// Shows what was gathered of the columns in full. Every stream is called, because it sends curves when nothing is new.
    fn show_columns(
        &mut self,
        of_columns: &mut BTreeMap<u32, Vec<ViewerItem>>,
    ) -> RecordingStreamResult<()> {
        for it in &mut self.in_full {
            let items = of_columns.remove(&it.column).unwrap_or_default();
            it.stream.continue_after(self.latest.impact_time);
            it.stream.show(items)?;
            let Moment {
                impact_time, step, ..
            } = it.stream.last_moment();
            if impact_time > self.latest.impact_time {
                self.latest.impact_time = impact_time;
                self.latest.step = step;
            }
        }
        of_columns.clear();
        Ok(())
    }

    /// Shows a column in full as that of the newest impact.
    fn follow(&mut self, column: u32, parameters: &Arc<Parameters>) -> RecordingStreamResult<()> {
        let is_known = (column as usize) < self.marks.len();
        if !is_known || self.newest.replace(column) == Some(column) {
            return Ok(());
        }
        self.has_new_marks = true;
        self.has_new_layout = true;
        if self.fleet.selected.contains(&column) {
            return Ok(());
        }
        self.in_full.retain(|it| it.slot != NEWEST_SLOT);
        self.open(column, NEWEST_SLOT, parameters)
    }

    fn open(
        &mut self,
        column: u32,
        slot: u8,
        parameters: &Arc<Parameters>,
    ) -> RecordingStreamResult<()> {
        let Some(name) = self.fleet.names.get(column as usize) else {
            return Ok(());
        };
        let mut options = self.options.clone();
        if options.ranges == Ranges::default() {
            options.ranges = Ranges::predicted(parameters, &parameters.impact());
        }
        let stream = ViewerStream::below(
            self.stream.clone(),
            name,
            Arc::clone(parameters),
            options,
            self.latest.impact_time,
        )?;
        self.in_full.push(InFull {
            column,
            slot,
            stream,
        });
        Ok(())
    }

    fn send_marks(&mut self) -> RecordingStreamResult<()> {
        overview::send(
            &self.stream,
            &self.fleet,
            &self.geometry,
            &self.marks,
            self.newest,
            &mut self.known,
            self.latest,
        )?;
        let told = panel::panel(&self.fleet, &self.marks, self.newest);
        if told == self.told {
            return Ok(());
        }
        let text = TextDocument::from_markdown(told.clone());
        self.told = told;
        let data = text.columns_of_unit_batches()?;
        self.stream
            .send_columns(PANEL, time_columns([self.latest]), data)
    }

    fn send_layout(&mut self) -> RecordingStreamResult<()> {
        self.has_new_layout = false;
        let mut in_full: Vec<_> = self.in_full.iter().collect();
        in_full.sort_by_key(|it| (self.newest != Some(it.column), it.slot));
        let in_full: Vec<_> = in_full
            .iter()
            .map(|it| (it.slot, it.stream.layout()))
            .collect();
        let columns = self.fleet.ids.len();
        let title = match self.fleet.plan.unplaced {
            0 => format!("Fleet of {columns} columns"),
            all if all == columns => {
                format!("Fleet of {columns} columns, in rows without positions")
            }
            some => {
                format!("Fleet of {columns} columns, {some} without positions below the others")
            }
        };
        let messages = layout::messages(&title, &self.geometry, &in_full, self.options.follows)?;
        activate(&self.stream, messages);
        Ok(())
    }

    fn line(&self, stamp: i64, level: NoticeLevel, text: String) -> RecordingStreamResult<()> {
        let moment = Moment {
            wall_clock: stamp,
            ..self.latest
        };
        let text = TextLog::new(text).with_level(log_level(level));
        let data = text.columns_of_unit_batches()?;
        self.stream.send_columns(LOG, time_columns([moment]), data)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assessment::Action;
    use crate::parameters::FleetColumn;
    use rerun::RecordingStreamBuilder;
    use rerun::external::re_log_types::LogMsg;
    use rerun::log::Chunk;

    fn fleet(columns: usize) -> Arc<ShownFleet> {
        let columns: Vec<_> = (0..columns)
            .map(|number| FleetColumn {
                name: format!("/hall/c{number}"),
                parameters: Arc::default(),
            })
            .collect();
        Arc::new(ShownFleet::new(&columns, Vec::new()))
    }

    /// The entities of the data in these messages, without what the viewer adds.
    fn entities(messages: &[LogMsg]) -> Vec<String> {
        let chunks = messages.iter().filter_map(|message| match message {
            LogMsg::ArrowMsg(_, data) => Chunk::from_arrow_msg(data).ok(),
            _ => None,
        });
        let paths = chunks.map(|it| it.entity_path().to_string());
        let mut paths: Vec<_> = paths
            .filter(|it| it.starts_with("/overview") || it.starts_with("/hall"))
            .collect();
        paths.sort();
        paths.dedup();
        paths
    }

    fn options() -> StreamOptions {
        StreamOptions {
            frame_period: 1_000_000,
            budget: None,
            curves_period: 0,
            follows: true,
            ranges: Ranges::default(),
        }
    }

    fn shown(columns: usize) -> (FleetStream, rerun::sink::MemorySinkStorage) {
        let (stream, storage) = RecordingStreamBuilder::new("test")
            .enabled(true)
            .memory()
            .expect("a stream");
        let marks = vec![ColumnMark::default(); columns];
        let shown = FleetStream::new(stream, fleet(columns), marks, options());
        (shown.expect("written"), storage)
    }

    fn taken(shown: &FleetStream, storage: &rerun::sink::MemorySinkStorage) -> Vec<LogMsg> {
        shown.stream().flush_blocking().expect("flushed");
        storage.take()
    }

    #[test]
    fn many_columns_are_as_few_entities_as_one() {
        let entities_of = |columns: usize| {
            let (mut shown, storage) = shown(columns);
            shown.show([]).expect("shown");
            entities(&taken(&shown, &storage))
        };
        let one = entities_of(1);
        assert!(
            one.contains(&"/overview/plan/columns".to_owned()),
            "{one:?}"
        );
        assert_eq!(one, entities_of(2_000));
    }

    #[test]
    fn nothing_is_sent_while_nothing_changes() {
        let (mut shown, storage) = shown(12);
        shown.show([]).expect("shown");
        taken(&shown, &storage);
        let mark = FleetItem::Mark {
            column: 3,
            stamp: 5,
            mark: ColumnMark {
                action: Some(Action::Shore),
                ..ColumnMark::default()
            },
        };
        shown.show([mark.clone()]).expect("shown");
        let sent = entities(&taken(&shown, &storage));
        assert!(
            sent.contains(&PANEL.replacen("overview", "/overview", 1)),
            "{sent:?}"
        );
        shown.show([mark]).expect("shown");
        shown.show([]).expect("shown");
        assert_eq!(entities(&taken(&shown, &storage)), Vec::<String>::new());
    }

    #[test]
    fn the_column_of_the_newest_impact_has_the_place_of_the_one_before() {
        let (mut shown, storage) = shown(12);
        let newest = |column| FleetItem::Newest {
            column,
            parameters: Arc::default(),
        };
        shown.show([newest(3)]).expect("shown");
        let has =
            |messages: &[LogMsg], entity: &str| entities(messages).iter().any(|it| it == entity);
        assert!(has(&taken(&shown, &storage), "/hall/c3/ghost"));
        shown.show([newest(5)]).expect("shown");
        assert!(has(&taken(&shown, &storage), "/hall/c5/ghost"));
        let columns: Vec<_> = shown
            .in_full
            .iter()
            .map(|it| (it.column, it.slot))
            .collect();
        assert_eq!(columns, [(5, NEWEST_SLOT)]);
        shown.show([newest(5)]).expect("shown");
        assert!(!has(&taken(&shown, &storage), "/hall/c5/ghost"));
        // A column that the fleet does not have.
        shown.show([newest(12)]).expect("ignored");
    }
}
