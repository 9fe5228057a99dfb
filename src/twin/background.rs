//! What another thread computes for the twin with the lowest priority, and which of it comes first. The result comes back as a
//! command, so that the journal tells from when on the twin knows it, and a verification computes it again.

use super::command::Command;
use super::critical::CriticalVelocityTask;
use super::opinion::OpinionTask;
use super::range::RangeTask;

/// Something to be computed in the background, as plain data for another thread.
#[derive(Debug, Clone, PartialEq)]
pub enum BackgroundTask {
    /// The second opinion on an impact: wanted as soon as the forecast is complete.
    SecondOpinion(Box<OpinionTask>),
    /// The range of the verdict on an impact: wanted as soon as the forecast and the second opinion are known.
    Range(Box<RangeTask>),
    /// The critical velocities of the column at rest.
    CriticalVelocities(Box<CriticalVelocityTask>),
}

/// How urgent something in the background is, the most urgent first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BackgroundKind {
    /// A second opinion.
    SecondOpinion,
    /// The range of a verdict.
    Range,
    /// Critical velocities of a column that was hit.
    Damaged,
    /// Critical velocities of a column without damage.
    Undamaged,
}

impl BackgroundKind {
    /// Number of kinds, each of which is an index.
    pub const COUNT: usize = 4;

    /// Whether it is about critical velocities.
    #[must_use]
    pub fn is_of_critical_velocities(self) -> bool {
        matches!(self, Self::Damaged | Self::Undamaged)
    }
}

impl BackgroundTask {
    /// Computes it; `go_on` is asked before each response, and `None` is the result once it returns false.
    pub fn compute(&self, go_on: &mut dyn FnMut() -> bool) -> Option<Command> {
        Some(match self {
            Self::SecondOpinion(task) => match go_on() {
                true => Command::SecondOpinion(task.compute()),
                false => return None,
            },
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
            Self::SecondOpinion(_) => BackgroundKind::SecondOpinion,
            Self::Range(_) => BackgroundKind::Range,
            Self::CriticalVelocities(task) if task.is_damaged() => BackgroundKind::Damaged,
            Self::CriticalVelocities(_) => BackgroundKind::Undamaged,
        }
    }

    /// Whether the result is that of another task.
    #[must_use]
    pub fn has_the_result_of(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::SecondOpinion(one), Self::SecondOpinion(other)) => one.has_the_result_of(other),
            (Self::Range(one), Self::Range(other)) => one.has_the_result_of(other),
            (Self::CriticalVelocities(one), Self::CriticalVelocities(other)) => {
                one.has_the_result_of(other)
            }
            _ => false,
        }
    }
}
