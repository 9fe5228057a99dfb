//! The measures of a scenario: the same vehicles once more behind each, and what that changes.

use std::fmt::{self, Write as _};

use super::numbers::{interval, small};
use column_twin::figures::units::significant;
use column_twin::study::risk::{Measure, MeasureRisk, RiskResult};

/// What came of the measures.
#[derive(Debug, Default)]
pub(super) struct Compared {
    /// Those that were computed, in the order of the scenario.
    pub risks: Vec<MeasureRisk>,
    /// Those that this column cannot have, each with the reason.
    pub omitted: Vec<String>,
    pub is_interrupted: bool,
}

/// The comparison for people.
pub(super) fn write(
    f: &mut fmt::Formatter<'_>,
    compared: &Compared,
    without: &RiskResult,
) -> fmt::Result {
    let actions = &without.annual;
    let Some(last) = actions.len().checked_sub(1) else {
        return Ok(());
    };
    writeln!(
        f,
        "\nMeasures: probability in one year, with its interval, and how many times that without the measure it is"
    )?;
    let shown = [0, last];
    let mut heading = format!("  {:<22}", "");
    for index in shown {
        let _ = write!(
            heading,
            "{:<44}",
            format!("{} or worse", actions[index].action)
        );
    }
    writeln!(f, "{}", heading.trim_end())?;
    let mut line = format!("  {:<22}", "without");
    for index in shown {
        let _ = write!(line, "{:<44}", interval(&actions[index].annual, small));
    }
    writeln!(f, "{}", line.trim_end())?;
    for risk in &compared.risks {
        let mut line = format!("  {:<22}", risk.measure.name);
        for index in shown {
            let of = &risk.actions[index];
            let times = of
                .times
                .map_or(String::new(), |it| format!(" x {}", significant(it, 2)));
            let _ = write!(line, "{:<44}", interval(&of.annual, small) + &times);
        }
        writeln!(f, "{}", line.trim_end())?;
    }
    for omitted in &compared.omitted {
        writeln!(f, "  {omitted}")?;
    }
    writeln!(f, "  Their assumptions:")?;
    for risk in &compared.risks {
        let Measure {
            name,
            description,
            source,
            ..
        } = &risk.measure;
        writeln!(
            f,
            "  {name:<22}{}: {description}; {source}",
            risk.assumption()
        )?;
    }
    Ok(())
}
