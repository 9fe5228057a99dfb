//! Outputs that are published once the damage of their column is written: a node that is killed must not have lost an impact whose
//! forecast is known. The states of the column are published meanwhile.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::twin::Output;

/// Most time for which a forecast waits until the damage of its column is written: a disk that hangs must not hold it up for longer.
const SAVING_PATIENCE: Duration = Duration::from_millis(50);

/// Time between two looks at whether it is written.
pub(super) const SAVING_INTERVAL: Duration = Duration::from_micros(200);

/// A forecast, and what follows it in the outputs of its column.
#[derive(Debug)]
struct Waiting {
    column: u32,
    since: Instant,
    forecast: Output,
    behind: Vec<Output>,
}

/// The outputs that wait, in the order in which their columns had their forecasts.
#[derive(Debug, Default)]
pub(super) struct Withheld {
    columns: VecDeque<Waiting>,
}

impl Withheld {
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Withholds a forecast whose damage `is_saving` says is being written, and what follows a withheld forecast, except for states
    /// that only overtake forecasts and what is logged of them. Returns what is to be published now.
    pub fn pass(
        &mut self,
        column: u32,
        output: Output,
        now: Instant,
        is_saving: impl Fn(u32) -> bool,
    ) -> Option<Output> {
        let before = self.columns.iter_mut().find(|it| it.column == column);
        match before {
            Some(waiting)
                if !matches!(output, Output::State(_))
                    || !waiting.behind.iter().all(may_be_overtaken) =>
            {
                waiting.behind.push(output);
                None
            }
            None if matches!(output, Output::Forecast(_)) && is_saving(column) => {
                self.columns.push_back(Waiting {
                    column,
                    since: now,
                    forecast: output,
                    behind: Vec::new(),
                });
                None
            }
            _ => Some(output),
        }
    }

    /// A column whose damage is written, or has been awaited for too long, with its forecast, which is to be published, and what came
    /// behind it, which is to be [passed](Self::pass) again.
    pub fn release(
        &mut self,
        now: Instant,
        is_saving: impl Fn(u32) -> bool,
    ) -> Option<(u32, Output, Vec<Output>)> {
        let is_over =
            |it: &Waiting| now.duration_since(it.since) >= SAVING_PATIENCE || !is_saving(it.column);
        let index = self.columns.iter().position(is_over)?;
        let released = self.columns.remove(index)?;
        Some((released.column, released.forecast, released.behind))
    }
}

/// Whether a state may be published before an output that came before it: its readers need not know that output to read the state.
fn may_be_overtaken(output: &Output) -> bool {
    matches!(
        output,
        Output::Forecast(_) | Output::Notice(_) | Output::Save(_)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::ImpactSpecification;
    use crate::parameters::Parameters;
    use crate::twin::{Command, ImpactCommand, Twin};

    const MILLISECOND: i64 = 1_000_000;

    /// Those of the first milliseconds of a response, up to the second forecast, which contains the error of the time step.
    fn outputs() -> Vec<Output> {
        let values = [
            ("response.duration", 0.05.into()),
            ("beam.mode", "off".into()),
        ];
        let parameters = Parameters::from_values(values).expect("admissible");
        let mut twin = Twin::new(parameters, None, Box::new(|| 0), 0).expect("stands");
        let impact = Command::Impact(ImpactCommand {
            event_id: "a".to_owned(),
            column_id: twin.column_id().to_string(),
            stamp: 0,
            vehicle: String::new(),
            impact: ImpactSpecification {
                mass: 1500.0,
                velocity: 8.0,
                gap: None,
                restitution: None,
                height: None,
                direction: None,
            },
        });
        let mut outputs = Vec::new();
        twin.handle(impact, 0, &mut outputs).expect("accepted");
        let forecasts = |outputs: &[Output]| outputs.iter().filter(|it| is_forecast(it)).count();
        for now in (1..40).map(|it| it * MILLISECOND) {
            twin.advance_to(now, &mut outputs);
            if forecasts(&outputs) < 2 {
                twin.run_ahead(1000, now, &mut outputs);
            }
        }
        assert_eq!(forecasts(&outputs), 2);
        outputs
    }

    fn is_forecast(output: &Output) -> bool {
        matches!(output, Output::Forecast(_))
    }

    fn is_state(output: &Output) -> bool {
        matches!(output, Output::State(_))
    }

    fn words(outputs: &[Output]) -> Vec<String> {
        outputs.iter().map(|it| format!("{it:?}")).collect()
    }

    /// Its column alone waits, and nothing overtakes its forecast but states.
    #[test]
    fn a_stream_goes_on_while_the_damage_of_its_column_is_written() {
        let (all, now) = (outputs(), Instant::now());
        let mut withheld = Withheld::default();
        let mut passed = Vec::new();
        for output in &all {
            passed.extend(withheld.pass(7, output.clone(), now, |_| true));
            let other = withheld.pass(8, output.clone(), now, |_| false);
            assert!(other.is_some(), "another column does not wait");
        }
        let first = all.iter().position(is_forecast).expect("a forecast");
        let (before, behind) = all.split_at(first);
        let overtaken = |it: &&Output| is_state(it) || may_be_overtaken(it);
        let reach = behind.iter().take_while(overtaken).count();
        let (near, far) = behind.split_at(reach);
        let (stream, waiting): (Vec<_>, Vec<_>) = near.iter().cloned().partition(is_state);
        assert!(!stream.is_empty() && waiting.len() > 1 && !far.is_empty());
        assert_eq!(words(&passed), words(&[before, &stream].concat()));

        assert!(withheld.release(now, |_| true).is_none());
        let (column, forecast, behind) = withheld.release(now, |_| false).expect("it is written");
        assert_eq!((column, withheld.is_empty()), (7, true));
        assert_eq!(
            words(&[vec![forecast], behind].concat()),
            words(&[&waiting, far].concat())
        );
    }

    #[test]
    fn a_disk_that_hangs_does_not_hold_up_a_forecast_for_long() {
        let (all, now) = (outputs(), Instant::now());
        let forecast = all.into_iter().find(is_forecast).expect("a forecast");
        let mut withheld = Withheld::default();
        assert!(withheld.pass(0, forecast, now, |_| true).is_none());
        let late = now + SAVING_PATIENCE;
        let before = late - Duration::from_millis(1);
        assert!(withheld.release(before, |_| true).is_none());
        assert!(withheld.release(late, |_| true).is_some());
    }
}
