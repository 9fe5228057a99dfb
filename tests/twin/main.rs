//! The twin under a mock clock: no test waits for real time.

mod bad_input;
mod clock;
mod critical;
mod damage;
mod damage_correction;
mod estimates;
mod forecasts;
mod memory;
mod parameters;
mod range;
mod response;
mod second_impact;
mod second_opinion;
mod vehicles;

use column_twin::column::ImpactSpecification;
use std::sync::Arc;

use column_twin::parameters::{Parameters, Value};
use column_twin::time::Nanos;
use column_twin::twin::{
    Accepted, Command, ImpactCommand, Output, Rejected, Rejection, ReportOutput, SavedState,
    StateOutput, Status, Twin,
};

/// Start time of the tests.
pub const START: Nanos = 1_800_000_000_000_000_000;

/// One millisecond.
pub const MS: Nanos = 1_000_000;

/// A twin with its clock and all its outputs.
pub(crate) struct Bench {
    pub(crate) twin: Twin,
    pub(crate) now: Nanos,
    pub(crate) out: Vec<Output>,
}

pub(crate) fn parameters(changes: &[(&str, Value)]) -> Parameters {
    // A large step keeps the tests short. They were written for hinges that turn without limit; `vehicles.rs` has the limit.
    let coarse = [
        ("solver.dt", Value::from(1e-4)),
        ("assessment.ultimate_rotation", Value::from(0.0)),
    ];
    Parameters::from_values(coarse.iter().chain(changes).cloned()).expect("admissible")
}

impl Bench {
    pub(crate) fn new(changes: &[(&str, Value)]) -> Self {
        Self::with(parameters(changes), None)
    }

    pub(crate) fn with(parameters: Parameters, saved: Option<&SavedState>) -> Self {
        let stopwatch = Box::new(|| 0);
        let twin = Twin::new(parameters, saved, stopwatch, START).expect("the column stands");
        Self {
            twin,
            now: START,
            out: Vec::new(),
        }
    }

    pub(crate) fn handle(&mut self, command: Command) -> Result<Accepted, Rejection> {
        self.twin.handle(command, self.now, &mut self.out)
    }

    pub(crate) fn hit(&mut self, event: ImpactCommand) {
        let _ = self.handle(Command::Impact(event)); // a rejection is among the outputs
    }

    /// Advances to a time as the solver's thread would, with the forecast first.
    pub(crate) fn go_to(&mut self, instant: Nanos) {
        while self.now < instant {
            self.twin.run_ahead(u64::MAX, self.now, &mut self.out);
            let due = self.twin.next_deadline(self.now);
            self.now = due.clamp(self.now, instant);
            self.twin.advance_to(self.now, &mut self.out);
        }
    }

    pub(crate) fn go_on(&mut self, nanos: Nanos) {
        self.go_to(self.now + nanos);
    }

    /// Advances until the column is at rest.
    pub(crate) fn rest(&mut self) {
        self.twin.run_ahead(u64::MAX, self.now, &mut self.out);
        for _ in 0..10_000 {
            if !self.twin.is_responding() {
                return;
            }
            self.go_on(10 * MS);
        }
        panic!("no end of the response");
    }

    pub(crate) fn change(&mut self, changes: &[(&str, Value)]) {
        let changes = changes
            .iter()
            .map(|(name, value)| ((*name).to_owned(), value.clone()));
        let changes = changes.collect();
        let _ = self.handle(Command::SetParameters {
            changes,
            source: "test".into(),
        });
    }

    pub(crate) fn reset(&mut self) {
        let _ = self.handle(Command::Reset {
            source: "test".into(),
        });
    }

    pub(crate) fn states(&self) -> Vec<&StateOutput> {
        self.all(|it| {
            if let Output::State(state) = it {
                Some(state)
            } else {
                None
            }
        })
    }

    pub(crate) fn forecasts(&self) -> Vec<&ReportOutput> {
        self.all(|it| {
            if let Output::Forecast(report) = it {
                Some(report)
            } else {
                None
            }
        })
    }

    pub(crate) fn reports(&self) -> Vec<&ReportOutput> {
        self.all(|it| {
            if let Output::Report(report) = it {
                Some(report)
            } else {
                None
            }
        })
    }

    pub(crate) fn rejections(&self) -> Vec<&Rejected> {
        self.all(|it| {
            if let Output::Rejected(rejected) = it {
                Some(rejected)
            } else {
                None
            }
        })
    }

    pub(crate) fn saved(&self) -> Vec<&Arc<SavedState>> {
        self.all(|it| {
            if let Output::Save(saved) = it {
                Some(saved)
            } else {
                None
            }
        })
    }

    pub(crate) fn statuses(&self) -> Vec<&Status> {
        self.all(|it| {
            if let Output::Status(status) = it {
                Some(status)
            } else {
                None
            }
        })
    }

    /// The current status.
    pub(crate) fn status(&self) -> Status {
        self.twin.status(self.now)
    }

    fn all<'a, T>(&'a self, pick: impl Fn(&'a Output) -> Option<T>) -> Vec<T> {
        self.out.iter().filter_map(pick).collect()
    }
}

/// An impact of 1.5 t at 36 km/h.
pub(crate) fn event(id: &str, stamp: Nanos) -> ImpactCommand {
    ImpactCommand {
        event_id: id.to_owned(),
        column_id: "column".to_owned(),
        stamp,
        vehicle: String::new(),
        impact: ImpactSpecification {
            mass: 1500.0,
            velocity: 10.0,
            gap: None,
            restitution: None,
            height: None,
            direction: None,
        },
    }
}

/// An impact too light to cause damage.
pub(crate) fn light(id: &str, stamp: Nanos) -> ImpactCommand {
    ImpactCommand {
        impact: ImpactSpecification {
            mass: 10.0,
            velocity: 0.5,
            ..event(id, stamp).impact
        },
        ..event(id, stamp)
    }
}

/// An impact under which a column with a load of 2 MN collapses.
pub(crate) fn fatal(id: &str, stamp: Nanos) -> ImpactCommand {
    ImpactCommand {
        impact: ImpactSpecification {
            mass: 100_000.0,
            velocity: 50.0,
            ..event(id, stamp).impact
        },
        ..event(id, stamp)
    }
}
