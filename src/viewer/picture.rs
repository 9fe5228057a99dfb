//! What a stream shows: one column, or a fleet.

use std::sync::Arc;

use rerun::{RecordingStream, RecordingStreamResult};

use super::fleet::{ColumnMark, FleetItem, FleetStream, ShownFleet};
use super::item::ViewerItem;
use super::stream::{StreamOptions, ViewerStream};
use crate::parameters::Parameters;

/// A Rerun stream with what it shows.
pub trait Picture: Sized {
    /// What can be shown.
    type Item: Clone + Send;
    /// What is shown before the first item.
    type Subject;

    /// Begins to show a subject.
    ///
    /// # Errors
    /// The stream rejects the data.
    fn open(
        stream: RecordingStream,
        subject: &Self::Subject,
        options: StreamOptions,
    ) -> RecordingStreamResult<Self>;

    /// Shows some items in their order.
    ///
    /// # Errors
    /// The stream rejects the data.
    fn show_items(&mut self, items: Vec<Self::Item>) -> RecordingStreamResult<()>;

    /// Whether an item shows nothing that the one before has not shown.
    fn repeats(last: &Self::Item, item: &Self::Item) -> bool;

    /// Takes what has to be known of an item that will not be shown again into the subject.
    fn absorb(subject: &mut Self::Subject, item: Self::Item);
}

impl Picture for ViewerStream {
    type Item = ViewerItem;
    type Subject = Arc<Parameters>;

    fn open(
        stream: RecordingStream,
        parameters: &Arc<Parameters>,
        options: StreamOptions,
    ) -> RecordingStreamResult<Self> {
        Self::new(stream, Arc::clone(parameters), options)
    }

    fn show_items(&mut self, items: Vec<ViewerItem>) -> RecordingStreamResult<()> {
        self.show(items)
    }

    /// A twin at rest reports its state every second.
    fn repeats(last: &ViewerItem, item: &ViewerItem) -> bool {
        matches!((last, item),
            (
                ViewerItem::Rest { v1, u2, critical_velocities, .. },
                ViewerItem::Rest { v1: next_v1, u2: next_u2, critical_velocities: next, .. },
            ) if v1 == next_v1 && u2 == next_u2 && critical_velocities == next)
    }

    fn absorb(subject: &mut Arc<Parameters>, item: ViewerItem) {
        if let ViewerItem::Parameters(parameters) = item {
            *subject = parameters;
        }
    }
}

/// A fleet, and what its plan shows first.
#[derive(Debug, Clone)]
pub struct FleetSubject {
    /// The columns.
    pub fleet: Arc<ShownFleet>,
    /// The marks of the columns, by their indices.
    pub marks: Vec<ColumnMark>,
    /// The column of the newest impact, with its parameters.
    pub newest: Option<(u32, Arc<Parameters>)>,
}

impl FleetSubject {
    /// A fleet of whose columns nothing is known yet.
    #[must_use]
    pub fn new(fleet: Arc<ShownFleet>) -> Self {
        Self {
            marks: vec![ColumnMark::default(); fleet.ids.len()],
            newest: None,
            fleet,
        }
    }
}

impl Picture for FleetStream {
    type Item = FleetItem;
    type Subject = FleetSubject;

    fn open(
        stream: RecordingStream,
        subject: &FleetSubject,
        options: StreamOptions,
    ) -> RecordingStreamResult<Self> {
        let FleetSubject {
            fleet,
            marks,
            newest,
        } = subject;
        let mut shown = Self::new(stream, Arc::clone(fleet), marks.clone(), options)?;
        let newest = newest.clone();
        let newest = newest.map(|(column, parameters)| FleetItem::Newest { column, parameters });
        shown.show(newest)?;
        Ok(shown)
    }

    fn show_items(&mut self, items: Vec<FleetItem>) -> RecordingStreamResult<()> {
        self.show(items)
    }

    fn repeats(last: &FleetItem, item: &FleetItem) -> bool {
        match (last, item) {
            (FleetItem::Column(one, last), FleetItem::Column(other, item)) => {
                one == other && ViewerStream::repeats(last, item)
            }
            _ => false,
        }
    }

    fn absorb(subject: &mut FleetSubject, item: FleetItem) {
        match item {
            FleetItem::Mark { column, mark, .. } => {
                if let Some(known) = subject.marks.get_mut(column as usize) {
                    *known = mark;
                }
            }
            FleetItem::Newest { column, parameters } => {
                subject.newest = Some((column, parameters));
            }
            FleetItem::Column(column, ViewerItem::Parameters(changed)) => {
                let fleet = Arc::make_mut(&mut subject.fleet);
                if let Some(known) = fleet.parameters.get_mut(column as usize) {
                    known.clone_from(&changed);
                }
                if let Some((newest, known)) = &mut subject.newest
                    && *newest == column
                {
                    *known = changed;
                }
            }
            FleetItem::Column(..) | FleetItem::Line { .. } => {}
        }
    }
}
