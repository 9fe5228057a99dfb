//! What the system grants a thread with deadlines. Nothing of it is needed; all of it makes lateness rarer.

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::{Resource, geteuid, getrlimit};
use rustix::thread::{CpuSet, sched_setaffinity, set_current_timer_slack};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

use crate::parameters::{Parameters, processors};

/// What to ask the system for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RealTime {
    /// Priority under SCHED_FIFO, 1 to 99; `None`: as every thread.
    pub fifo_priority: Option<u8>,
    /// The processors that the solver's thread may run on; empty: all.
    pub processors: Vec<usize>,
    /// Whether to keep the program's memory from being swapped out.
    pub lock_memory: bool,
}

impl Default for RealTime {
    /// What the parameters say where nobody changes them.
    fn default() -> Self {
        Self::of(&Parameters::default())
    }
}

impl RealTime {
    /// What the parameters `real_time.*` say.
    #[must_use]
    pub fn of(parameters: &Parameters) -> Self {
        let wishes = &parameters.settings().real_time;
        Self {
            fifo_priority: (wishes.priority > 0).then_some(wishes.priority),
            // The parameters' own check lets nothing else through.
            processors: processors(&wishes.processors).unwrap_or_default(),
            lock_memory: wishes.lock_memory,
        }
    }

    /// Nothing.
    #[must_use]
    pub fn none() -> Self {
        Self {
            fifo_priority: None,
            processors: Vec::new(),
            lock_memory: false,
        }
    }
}

/// What became of one wish.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Grant {
    /// It was not asked for.
    #[default]
    NotAsked,
    /// It was granted.
    Granted,
    /// It was not: the twin goes on without. A warning to be logged.
    Denied {
        /// What the system says.
        reason: String,
        /// What to do about it.
        hint: &'static str,
    },
}

/// What the system granted.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RealTimeGrants {
    /// SCHED_FIFO for the solver's thread.
    pub fifo: Grant,
    /// The solver's thread on its processors.
    pub affinity: Grant,
    /// Memory that is never swapped out.
    pub memory: Grant,
}

impl RealTimeGrants {
    /// One line for each wish that was not granted.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        [
            ("SCHED_FIFO", &self.fifo),
            ("CPU affinity", &self.affinity),
            ("mlockall", &self.memory),
        ]
        .into_iter()
        .filter_map(|(name, grant)| match grant {
            Grant::Denied { reason, hint } => Some(format!("{name} not granted: {reason}; {hint}")),
            Grant::NotAsked | Grant::Granted => None,
        })
    }
}

/// Asks for the calling thread.
pub(super) fn ask(wishes: &RealTime) -> RealTimeGrants {
    // Normal threads wake up to 50 microseconds late so that others may wake with them.
    let _ = set_current_timer_slack(std::num::NonZeroU64::new(1));
    RealTimeGrants {
        fifo: wishes.fifo_priority.map_or(Grant::NotAsked, fifo),
        affinity: match wishes.processors.is_empty() {
            true => Grant::NotAsked,
            false => affinity(&wishes.processors),
        },
        memory: if wishes.lock_memory {
            memory()
        } else {
            Grant::NotAsked
        },
    }
}

/// Asks for the calling thread, which sends what the solver gives out: one step below the solver, so that a sample that is
/// there in time does not wait for programs without deadlines. Below priority 1 there is only what every thread has. What is
/// denied here is denied to the solver, which says so.
pub fn ask_for_sender(wishes: &RealTime) {
    let _ = set_current_timer_slack(std::num::NonZeroU64::new(1));
    if let Some(priority @ 2..) = wishes.fifo_priority {
        let _ = fifo(priority - 1);
    }
}

fn granted<E: std::fmt::Display>(result: Result<(), E>, hint: &'static str) -> Grant {
    match result {
        Ok(()) => Grant::Granted,
        Err(error) => Grant::Denied {
            reason: error.to_string(),
            hint,
        },
    }
}

fn fifo(priority: u8) -> Grant {
    let result = ThreadPriorityValue::try_from(priority).and_then(|priority| {
        set_thread_priority_and_policy(
            thread_native_id(),
            ThreadPriority::Crossplatform(priority),
            ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo),
        )
        .map_err(|error| format!("{error:?}"))
    });
    granted(
        result,
        "for fewer late samples allow it: `rtprio 99` for this user in /etc/security/limits.conf, LimitRTPRIO=99 in a \
         systemd unit, or --cap-add=SYS_NICE for a container",
    )
}

fn affinity(processors: &[usize]) -> Grant {
    const HINT: &str = "choose processors that this program may use (see `taskset -p $$`)";
    if let Some(beyond) = processors.iter().find(|&&it| it >= CpuSet::MAX_CPU) {
        return Grant::Denied {
            reason: format!("there is no processor {beyond}"),
            hint: HINT,
        };
    }
    let mut set = CpuSet::new();
    processors.iter().for_each(|&processor| set.set(processor));
    granted(sched_setaffinity(None, &set), HINT)
}

fn memory() -> Grant {
    // With a limit, memory that is allocated later must not be locked: its allocation would fail.
    let unlimited = geteuid().is_root() || getrlimit(Resource::Memlock).current.is_none();
    let later = if unlimited {
        MlockAllFlags::FUTURE
    } else {
        MlockAllFlags::empty()
    };
    granted(
        mlockall(MlockAllFlags::CURRENT | later),
        "for fewer late samples allow it: `memlock unlimited` for this user in /etc/security/limits.conf, \
         LimitMEMLOCK=infinity in a systemd unit, or --ulimit memlock=-1 for a container",
    )
}
