//! The panel below the plan, as Markdown: how many columns need somebody, and which ones first.

use super::item::{ColumnMark, ShownFleet};
use crate::assessment::Action;
use crate::messages::column_twin_msgs::TwinStatus;
use crate::messages::words::{action_word, phase_word};
use crate::outgoing::{action_code, phase_code};
use crate::twin::TwinPhase;
use crate::viewer::panel::escaped;

/// The entity of the panel.
pub(super) const PANEL: &str = "overview/panel";

/// Columns that the panel lists: more do not fit.
const MAX_LISTED: usize = 12;

/// Characters of an identifier that are shown.
const MAX_CHARACTERS: usize = 24;

/// The indices of the columns that somebody has to look at, the worst first.
#[must_use]
pub(super) fn worst_first(marks: &[ColumnMark]) -> Vec<usize> {
    let mut notable: Vec<usize> = (0..marks.len())
        .filter(|index| marks[*index].is_notable())
        .collect();
    let rank = |index: &usize| {
        let mark = &marks[*index];
        (mark.is_out_of_service(), mark.worst(), mark.is_responding())
    };
    notable.sort_by(|a, b| {
        let damage = |index: &usize| marks[*index].residual_v1.abs();
        rank(b)
            .cmp(&rank(a))
            .then(damage(b).total_cmp(&damage(a)))
            .then(a.cmp(b))
    });
    notable
}

/// An identifier as it fits a label.
#[must_use]
pub(super) fn short(id: &str) -> String {
    let cut: String = id.chars().take(MAX_CHARACTERS).collect();
    match cut.len() < id.len() {
        true => format!("{cut}~"),
        false => cut,
    }
}

/// The word for what has to be done about a column.
#[must_use]
pub(super) fn word(action: Option<Action>) -> &'static str {
    action_word(action.map_or(TwinStatus::ACTION_UNKNOWN, action_code))
}

/// A length in m as it is shown.
fn millimetres(length: f64) -> String {
    format!("{:.1} mm", 1e3 * length)
}

/// The whole panel.
#[must_use]
pub(super) fn panel(fleet: &ShownFleet, marks: &[ColumnMark], newest: Option<u32>) -> String {
    let count = |is: &dyn Fn(&ColumnMark) -> bool| marks.iter().filter(|it| is(it)).count();
    let notable = worst_first(marks);
    let columns = marks.len();
    let mut text = match notable.len() {
        0 => format!("## {columns} columns, none with a warning\n\n"),
        some => format!("## {some} of {columns} columns need attention\n\n"),
    };
    let unknown = count(&|it| it.action.is_none() && !it.is_responding());
    text.push_str(&format!(
        "{} responding, {} hit, {} out of service{}.",
        count(&ColumnMark::is_responding),
        count(&|it| it.impacts > 0),
        count(&ColumnMark::is_out_of_service),
        match unknown {
            0 => String::new(),
            unknown => format!(", {unknown} of which nothing is known yet"),
        }
    ));
    if let Some(newest) = newest {
        let id = escaped(&short(fleet.id(newest)));
        text.push_str(&format!(" The newest impact was on **{id}**."));
    }
    if !notable.is_empty() {
        text.push_str("\n\n| column | action | residual v1 | reserve | |\n|---|---|---|---|---|\n");
    }
    for index in notable.iter().take(MAX_LISTED) {
        let mark = &marks[*index];
        let predicted = match mark.predicted > mark.action {
            true => " predicted",
            false => "",
        };
        let reserve = mark.reserve.map_or("?".to_owned(), |it| format!("{it:.2}"));
        let phase = phase_word(phase_code(mark.phase));
        // The displacement at which the response of such a column ended is not one that remains.
        let [residual, state] = match mark.phase {
            TwinPhase::Collapsed | TwinPhase::Fractured => [phase.to_owned(), String::new()],
            TwinPhase::Idle | TwinPhase::Rest => [millimetres(mark.residual_v1), String::new()],
            _ => [millimetres(mark.residual_v1), phase.to_owned()],
        };
        text.push_str(&format!(
            "| {} | {}{predicted} | {residual} | {reserve} | {state} |\n",
            escaped(&short(&fleet.ids[*index])),
            word(mark.worst()),
        ));
    }
    if notable.len() > MAX_LISTED {
        let more = notable.len() - MAX_LISTED;
        text.push_str(&format!("\nand {more} more columns\n"));
    }
    if let Some(about) = fleet.plan.about_unplaced() {
        text.push_str(&format!("\n\n*{}*\n", escaped(&about)));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::FleetColumn;
    use std::sync::Arc;

    /// The panel once gave a fractured column a residual displacement of 127.3 mm.
    #[test]
    fn a_fractured_column_has_its_state_and_no_residual_displacement() {
        let column = FleetColumn {
            name: "/c0".into(),
            parameters: Arc::default(),
        };
        let mut fleet = ShownFleet::new(&[column], Vec::new());
        fleet.ids[0] = "c0".into();
        for (phase, shown) in [
            (TwinPhase::Fractured, "| FRACTURED | ? |  |"),
            (TwinPhase::Collapsed, "| COLLAPSED | ? |  |"),
            (TwinPhase::Faulted, "| 127.3 mm | ? | FAULTED |"),
        ] {
            let mark = ColumnMark {
                action: Some(Action::Evacuate),
                phase,
                impacts: 1,
                residual_v1: 0.1273,
                ..ColumnMark::default()
            };
            let text = panel(&fleet, &[mark], None);
            assert!(text.contains(&format!("| EVACUATE {shown}")), "{text}");
        }
    }

    #[test]
    fn the_worst_columns_come_first_and_names_are_no_markdown() {
        let column = |number: usize| FleetColumn {
            name: format!("/c{number}"),
            parameters: Arc::default(),
        };
        let columns: Vec<_> = (0..20).map(column).collect();
        let mut fleet = ShownFleet::new(&columns, Vec::new());
        fleet.ids[4] = "a|b".into();
        let of = |action, residual_v1| ColumnMark {
            action: Some(action),
            residual_v1,
            impacts: 1,
            ..ColumnMark::default()
        };
        let mut marks = vec![of(Action::None, 0.0); 20];
        assert!(panel(&fleet, &marks, None).starts_with("## 20 columns, none with a warning"));
        marks[2] = of(Action::Inspect, 0.03);
        marks[3] = of(Action::Shore, 0.01);
        marks[4] = of(Action::Shore, -0.02);
        marks[5].phase = TwinPhase::Fractured;
        assert_eq!(worst_first(&marks), [5, 4, 3, 2]);
        let text = panel(&fleet, &marks, Some(3));
        assert!(
            text.starts_with("## 4 of 20 columns need attention"),
            "{text}"
        );
        assert!(text.contains("| a\\|b | SHORE | -20.0 mm |"), "{text}");
        assert!(text.contains("in rows"), "no column has a position: {text}");
        marks.fill(of(Action::Inspect, 0.03));
        let text = panel(&fleet, &marks, None);
        assert_eq!(text.matches(" inspect |").count(), MAX_LISTED);
        assert!(text.contains("and 8 more columns"), "{text}");
        assert_eq!(short(&"x".repeat(300)).len(), MAX_CHARACTERS + 1);
    }
}
