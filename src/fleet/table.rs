//! A fleet as a table that fits a terminal: the worst columns first.

use crate::messages::column_twin_msgs::{ColumnStatus, FleetStatus, TwinStatus};
use crate::messages::words::{action_word, phase_word};
use printable::Printable;

/// Size of a terminal in characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableSize {
    /// Characters in a line.
    pub width: usize,
    /// Lines.
    pub height: usize,
}

/// Lines that are no rows of columns: the summary, the heading, and how many columns are not shown.
const OTHER_LINES: usize = 3;

/// The title of a field, its greatest width, and its text for a column.
type Field = (&'static str, usize, fn(&ColumnStatus) -> String);

/// The fields of a row, each as wide as its longest text; the last one takes the rest of the line.
const FIELDS: [Field; 7] = [
    ("column", 24, |it| Printable(&it.column_id).to_string()),
    ("phase", 9, |it| phase_word(it.phase).to_owned()),
    ("action", 8, |it| action_word(it.action).to_owned()),
    ("v1 mm", 9, |it| format!("{:.2}", 1e3 * it.residual_v1)),
    ("reserve", 8, |it| match it.reserve.is_finite() {
        true => format!("{:.2}", it.reserve),
        false => "?".to_owned(),
    }),
    ("hits", 7, |it| it.impacts_since_reset.to_string()),
    ("last event, reason", usize::MAX, |it| {
        let text = match (&it.fault, &it.last_rejection_reason) {
            (fault, _) if !fault.is_empty() => fault,
            (_, rejection) if !rejection.is_empty() && it.events_rejected > 0 => rejection,
            // That nothing is to be done needs no reason.
            _ if it.action == TwinStatus::ACTION_NONE => "",
            _ => &it.action_reason,
        };
        let event: String = it.event_id.chars().take(EVENT_CHARS).collect();
        let left_out = if event.len() < it.event_id.len() {
            "~"
        } else {
            ""
        };
        Printable(format!("{event}{left_out} {text}").trim()).to_string()
    }),
];

/// Characters of the identifier of an event: a reason is to fit beside it.
const EVENT_CHARS: usize = 14;

/// The lines of a table: a summary, a heading, and the columns, the worst first, as many as fit.
#[must_use]
pub fn table(fleet: &FleetStatus, columns: &[ColumnStatus], size: TableSize) -> Vec<String> {
    let cut = |line: &str| line.chars().take(size.width).collect::<String>();
    let mut order: Vec<&ColumnStatus> = columns.iter().collect();
    order.sort_by(|a, b| {
        rank(b)
            .cmp(&rank(a))
            .then(b.residual_v1.abs().total_cmp(&a.residual_v1.abs()))
            .then_with(|| a.column_id.cmp(&b.column_id))
    });
    let count = |is: fn(&&&ColumnStatus) -> bool| order.iter().filter(is).count();
    let FleetStatus {
        columns_total,
        columns_active,
        ignored,
        dropped_inputs,
        dropped_states,
        dropped_outputs,
        ..
    } = fleet;
    let lost = dropped_inputs + dropped_states + dropped_outputs;
    let known = match columns.len() as u64 == u64::from(*columns_total) {
        true => String::new(),
        false => format!(", {} known", columns.len()),
    };
    // What matters most is left in a narrow terminal.
    let mut lines = vec![cut(&format!(
        "{columns_total} columns{known}: {} out of service, {} with an action, {} hit, {lost} lost, {columns_active} active, {ignored} for others",
        count(|it| it.is_out_of_service()),
        count(|it| it.action != TwinStatus::ACTION_NONE),
        count(|it| it.impacts_since_reset > 0),
    ))];
    let room = size.height.saturating_sub(OTHER_LINES);
    let shown = order.len().min(room);
    let mut rows = vec![FIELDS.map(|(title, ..)| title.to_owned())];
    rows.extend(
        order[..shown]
            .iter()
            .map(|it| FIELDS.map(|(_, _, text)| text(it))),
    );
    let mut widths = FIELDS.map(|_| 0);
    for row in &rows {
        for ((width, text), (_, most, _)) in widths.iter_mut().zip(row).zip(&FIELDS) {
            *width = text.chars().count().min(*most).max(*width);
        }
    }
    lines.extend(rows.iter().map(|row| {
        let fields = row.iter().zip(&widths).zip(&FIELDS);
        let fields = fields.map(|((text, &width), (_, most, _))| match *most {
            // A text from outside may be longer than any padding.
            usize::MAX => text.clone(),
            _ => {
                let text: String = text.chars().take(width).collect();
                format!("{text:width$}")
            }
        });
        cut(fields.collect::<Vec<_>>().join(" ").trim_end())
    }));
    if shown < order.len() {
        lines.push(cut(&format!("and {} more columns", order.len() - shown)));
    }
    lines.truncate(size.height);
    lines
}

fn is_moving(column: &ColumnStatus) -> bool {
    matches!(
        column.phase,
        TwinStatus::APPROACH | TwinStatus::CONTACT | TwinStatus::FREE
    )
}

/// How much a column matters: out of service, then by action, then in motion.
fn rank(column: &ColumnStatus) -> (bool, u8, bool) {
    (column.is_out_of_service(), column.action, is_moving(column))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(number: usize, phase: u8, action: u8) -> ColumnStatus {
        ColumnStatus {
            column_id: format!("c{number:04}"),
            phase,
            action,
            action_reason: "a long reason ".repeat(20),
            ..ColumnStatus::default()
        }
    }

    #[test]
    fn the_table_fits_the_terminal_and_shows_the_worst_first() {
        let mut columns: Vec<_> = (0..2000)
            .map(|it| column(it, TwinStatus::IDLE, 0))
            .collect();
        columns[1500] = column(1500, TwinStatus::COLLAPSED, TwinStatus::ACTION_EVACUATE);
        columns[700] = column(700, TwinStatus::IDLE, TwinStatus::ACTION_INSPECT);
        columns[900] = column(900, TwinStatus::FREE, 0);
        let fleet = FleetStatus {
            columns_total: 2000,
            ..FleetStatus::default()
        };
        for (width, height) in [(80, 24), (40, 10), (200, 60), (10, 3), (1, 1), (0, 0)] {
            let lines = table(&fleet, &columns, TableSize { width, height });
            assert!(lines.len() <= height);
            assert!(lines.iter().all(|it| it.chars().count() <= width));
        }
        let lines = table(
            &fleet,
            &columns,
            TableSize {
                width: 80,
                height: 24,
            },
        );
        assert_eq!(lines.len(), 24);
        assert!(lines[0].contains("1 out of service, 2 with an action, 0 hit, 0 lost"));
        // In a terminal of 80 characters there is room for the beginning of a reason.
        assert!(
            lines[2].contains("a long reason a long reason"),
            "{}",
            lines[2]
        );
        for (line, name) in lines[2..].iter().zip(["c1500", "c0700", "c0900", "c0000"]) {
            assert!(line.starts_with(name), "{line}");
        }
        assert_eq!(lines[23], "and 1979 more columns");
    }

    #[test]
    fn names_from_outside_do_not_change_the_terminal() {
        let bad = ColumnStatus {
            column_id: "a\u{1b}[2J".to_owned(),
            event_id: "e\u{202e}".to_owned(),
            ..ColumnStatus::default()
        };
        let size = TableSize {
            width: 120,
            height: 9,
        };
        let lines = table(&FleetStatus::default(), &[bad], size);
        assert!(lines.iter().all(|it| !it.contains(['\u{1b}', '\u{202e}'])));
    }
}
