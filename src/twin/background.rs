//! What another thread computes for the twin with the lowest priority, and which of it comes first. The result comes back as a
//! command, so that the journal tells from when on the twin knows it, and a verification computes it again.

use super::command::Command;
use super::critical::CriticalVelocityTask;
use super::range::RangeTask;

/// Something to be computed in the background, as plain data for another thread.
#[derive(Debug, Clone, PartialEq)]
pub enum BackgroundTask {
    /// The range of the verdict on an impact: wanted as soon as the forecast is complete.
    Range(Box<RangeTask>),
    /// The critical velocities of the column at rest.
    CriticalVelocities(Box<CriticalVelocityTask>),
}

/// How urgent something in the background is, the most urgent first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BackgroundKind {
    /// The range of a verdict.
    Range,
    /// Critical velocities of a column that was hit.
    Damaged,
    /// Critical velocities of a column without damage.
    Undamaged,
}

impl BackgroundKind {
    /// Number of kinds, each of which is an index.
    pub const COUNT: usize = 3;
}

impl BackgroundTask {
    /// Computes it; `go_on` is asked before each response, and `None` is the result once it returns false.
    pub fn compute(&self, go_on: &mut dyn FnMut() -> bool) -> Option<Command> {
        Some(match self {
            Self::Range(task) => Command::VerdictRange(task.compute(go_on)?),
            Self::CriticalVelocities(task) => Command::CriticalVelocities {
                vehicles: task.compute(go_on)?,
            },
        })
    }

    /// How urgent it is.
    #[must_use]
    pub fn kind(&self) -> BackgroundKind {
        match self {
            Self::Range(_) => BackgroundKind::Range,
            Self::CriticalVelocities(task) if task.is_damaged() => BackgroundKind::Damaged,
            Self::CriticalVelocities(_) => BackgroundKind::Undamaged,
        }
    }

    /// Whether the result is that of another task.
    #[must_use]
    pub fn has_the_result_of(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Range(one), Self::Range(other)) => one.has_the_result_of(other),
            (Self::CriticalVelocities(one), Self::CriticalVelocities(other)) => {
                one.has_the_result_of(other)
            }
            _ => false,
        }
    }
}
