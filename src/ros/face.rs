//! The two faces of a node. A single twin shows its column under the names of the node, without a further name. The columns of a
//! fleet share topics and services, and messages, parameters and lines of the log name the column. All else is the same for both.

use std::collections::HashMap;
use std::sync::Arc;

use crate::endpoints::NodeKind;
use crate::twin::{Rejection, RejectionCode};

/// The columns of a node, and how others tell them apart.
#[derive(Debug)]
pub struct Face {
    kind: NodeKind,
    ids: Vec<Arc<str>>,
    names: Vec<Arc<str>>,
    by_id: HashMap<Arc<str>, u32>,
}

impl Face {
    /// The face of a single twin.
    pub(super) fn of_one(column_id: &str) -> Self {
        let id: Arc<str> = column_id.into();
        Self::new(NodeKind::Single, vec![Arc::clone(&id)], vec![id])
    }

    /// The face of a fleet, of which these are the identifiers and the full names.
    pub(super) fn of_many(ids: Vec<Arc<str>>, names: Vec<Arc<str>>) -> Self {
        Self::new(NodeKind::Fleet, ids, names)
    }

    fn new(kind: NodeKind, ids: Vec<Arc<str>>, names: Vec<Arc<str>>) -> Self {
        Self {
            kind,
            by_id: ids.iter().map(Arc::clone).zip(0..).collect(),
            ids,
            names,
        }
    }

    /// What the node shows of its columns.
    pub(super) fn kind(&self) -> NodeKind {
        self.kind
    }

    /// Whether the columns share topics.
    pub(super) fn is_fleet(&self) -> bool {
        self.kind == NodeKind::Fleet
    }

    /// What the node is, in a sentence.
    pub(super) fn noun(&self) -> &'static str {
        match self.is_fleet() {
            true => "fleet",
            false => "twin",
        }
    }

    /// The identifiers of the columns, by their indices.
    #[must_use]
    pub fn ids(&self) -> &[Arc<str>] {
        &self.ids
    }

    /// The full names of the columns of a fleet, such as `/garage/a3`, by their indices.
    #[must_use]
    pub fn names(&self) -> &[Arc<str>] {
        &self.names
    }

    /// The identifier of a column; empty if there is no such column.
    #[must_use]
    pub fn id(&self, column: u32) -> &str {
        self.ids.get(column as usize).map_or("", |it| it)
    }

    /// The index of a column; `None` if it is elsewhere.
    #[must_use]
    pub fn index_of(&self, column_id: &str) -> Option<u32> {
        self.by_id.get(column_id).copied()
    }

    /// The column that takes a message; `None` if the message is to be ignored. A single twin takes all of them, and rejects by itself
    /// what is for another column.
    pub(super) fn addressed(&self, column_id: &str) -> Option<u32> {
        match self.is_fleet() {
            true => self.index_of(column_id),
            false => Some(0),
        }
    }

    /// The column of a request, whose client waits for an answer: one that is elsewhere is rejected. A request to a single twin need not
    /// name the column.
    pub(super) fn requested(&self, column_id: &str) -> Result<u32, Rejection> {
        if let Some(column) = self.index_of(column_id) {
            return Ok(column);
        }
        let reason = match self.is_fleet() {
            false if column_id.is_empty() => return Ok(0),
            false => format!(
                "the request is for column {column_id:?}, but this is the twin of column {:?}",
                self.id(0)
            ),
            true => format!(
                "column {column_id:?} is not in this fleet of {} columns; give the column_id of one of them, see fleet_status",
                self.ids.len()
            ),
        };
        Err(Rejection::new(RejectionCode::OtherColumn, reason))
    }

    /// The column as a recording names it, see [`RecordingTap`](crate::outgoing::RecordingTap).
    pub(super) fn recorded(&self, column: u32) -> Option<&str> {
        self.is_fleet().then(|| self.id(column))
    }

    /// Names the column in a line of the log, after a preposition such as "of"; empty for a single twin.
    pub(super) fn words(&self, preposition: &str, column: u32) -> String {
        match self.is_fleet() {
            true => format!(" {preposition} column {:?}", self.id(column)),
            false => String::new(),
        }
    }

    /// The name of a topic that the parameters of a column name: a relative one belongs to the namespace of the node or, in a fleet, to
    /// that of the column.
    pub(super) fn topic_of(&self, column: u32, topic: &str) -> String {
        let name = self.names.get(column as usize);
        match name.filter(|_| self.is_fleet() && !topic.starts_with(['/', '~'])) {
            Some(namespace) => format!("{namespace}/{topic}"),
            None => topic.to_owned(),
        }
    }

    /// How the full name of a parameter of a column begins.
    pub(super) fn parameter_prefix(&self, column: u32) -> String {
        match self.is_fleet() {
            true => format!("{}.", self.id(column)),
            false => String::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fleet() -> Face {
        let ids = ["a3", "a4"].map(Arc::from).to_vec();
        let names = ["/garage/a3", "/garage/a4"].map(Arc::from).to_vec();
        Face::of_many(ids, names)
    }

    #[test]
    fn a_fleet_ignores_messages_for_other_columns_and_rejects_requests_about_them() {
        let face = fleet();
        assert_eq!(face.addressed("a4"), Some(1));
        assert_eq!(face.addressed("b1"), None);
        assert_eq!(face.requested("a4"), Ok(1));
        for other in ["b1", ""] {
            let rejection = face.requested(other).expect_err("another column");
            assert_eq!(rejection.code, RejectionCode::OtherColumn);
        }
    }

    /// It rejects messages for other columns itself, so that its journal has them.
    #[test]
    fn a_single_twin_takes_every_message_and_rejects_requests_about_other_columns() {
        let face = Face::of_one("a3");
        assert_eq!(face.addressed("b1"), Some(0));
        assert_eq!(face.requested(""), Ok(0));
        assert_eq!(face.requested("a3"), Ok(0));
        let rejection = face.requested("b1").expect_err("another column");
        assert_eq!(rejection.code, RejectionCode::OtherColumn);
    }

    #[test]
    fn only_a_fleet_names_its_columns() {
        let (one, many) = (Face::of_one("a3"), fleet());
        assert_eq!(one.words("of", 0), "");
        assert_eq!(many.words("of", 1), " of column \"a4\"");
        assert_eq!([one.recorded(0), many.recorded(1)], [None, Some("a4")]);
        assert_eq!(one.parameter_prefix(0), "");
        assert_eq!(many.parameter_prefix(1), "a4.");
        assert_eq!(one.topic_of(0, "imu"), "imu");
        assert_eq!(many.topic_of(1, "imu"), "/garage/a4/imu");
        assert_eq!(many.topic_of(1, "/imu"), "/imu");
    }
}
