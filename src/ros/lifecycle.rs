//! The state of a managed node, and what it means for inputs and outputs.
//!
//! Parameters, `/parameter_events`, `/rosout` and `/diagnostics` work in every state. Only an active node takes inputs; what comes
//! while it is not active is counted, logged and rejected. What it has taken is answered to its end in every state.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::twin::{Rejection, RejectionCode};

use super::lifecycle_states::{State, Transition};
use super::qos::Endpoint;
use super::senders::Rejected;
use ros_node::log_limit::LogLimit;

/// Most rejections per period in the log.
const MAX_TOLD: u64 = 10;

/// The period of the log.
const TELLING_PERIOD: Duration = Duration::from_secs(10);

/// The state of a managed node, and how many inputs it has rejected because of it.
#[derive(Debug)]
pub(super) struct Lifecycle {
    state: Mutex<State>,
    rejected: AtomicU64,
    telling: Mutex<LogLimit>,
    /// Of streams, which would hide everything else.
    telling_streams: Mutex<LogLimit>,
}

impl Lifecycle {
    /// Of a node that has just started.
    pub fn unconfigured() -> Self {
        let limit = || Mutex::new(LogLimit::new(MAX_TOLD, TELLING_PERIOD));
        Self {
            state: Mutex::new(State::Unconfigured),
            rejected: AtomicU64::new(0),
            telling: limit(),
            telling_streams: limit(),
        }
    }

    /// The present state.
    pub fn state(&self) -> State {
        *self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the node takes inputs.
    pub fn is_active(&self) -> bool {
        self.state() == State::Active
    }

    /// Checks that the node takes what comes in on this endpoint; counts what it does not take.
    ///
    /// # Errors
    /// The node is not active, and the endpoint works only if it is.
    pub fn check_active(&self, endpoint: &Endpoint, now: Instant) -> Result<(), Rejected> {
        if self.is_active() || works_in_every_state(endpoint) {
            return Ok(());
        }
        self.rejected.fetch_add(1, Ordering::Relaxed);
        let telling = match endpoint.qos.reliable {
            true => &self.telling,
            false => &self.telling_streams,
        };
        let mut telling = telling.lock().unwrap_or_else(PoisonError::into_inner);
        let untold = telling.admit(now);
        let hidden = match untold {
            Some(hidden @ 1..) => {
                format!(" ({hidden} rejections before this one are only counted)")
            }
            _ => String::new(),
        };
        let reason = format!(
            "the node is managed and {}: activate it (`ros2 lifecycle set`){hidden}",
            self.state().label()
        );
        Err(Rejected {
            rejection: Rejection::new(RejectionCode::NotActive, reason),
            is_told: untold.is_some(),
        })
    }

    /// Makes the transition that is requested, if there is one in this state. `act` does what it stands for and says why it cannot;
    /// `tell` is given the transition and the one by which it ends. Returns whether the transition was made.
    pub fn change(
        &self,
        (id, label): (u8, &str),
        act: impl FnOnce(&Transition) -> Result<(), String>,
        mut tell: impl FnMut(&Transition),
    ) -> bool {
        let state = self.state();
        let Some(transition) = state.requested(id, label) else {
            let possible: Vec<_> = state
                .transitions()
                .map(|it| format!("{} ({})", it.label, it.id))
                .collect();
            tracing::warn!(
                "the transition {label:?} ({id}) was rejected: expected one of those of the state {}, {}",
                state.label(),
                possible.join(", ")
            );
            return false;
        };
        let mut enter = |transition: &Transition| {
            *self.state.lock().unwrap_or_else(PoisonError::into_inner) = transition.goal;
            tell(transition);
        };
        enter(transition);
        let outcome = act(transition);
        if let Some(end) = transition.goal.concluded(outcome.is_ok()) {
            enter(end);
        }
        let state = self.state().label();
        match &outcome {
            Ok(()) => tracing::info!("{}: the node is {state} now", transition.label),
            Err(reason) => {
                tracing::warn!(
                    "{} failed, and the node is {state}: {reason}",
                    transition.label
                );
            }
        }
        outcome.is_ok()
    }

    /// Number of inputs that were rejected because the node was not active.
    pub fn rejected(&self) -> u64 {
        self.rejected.load(Ordering::Relaxed)
    }
}

/// Whether an input works in every state: those that every managed node of ROS 2 has.
fn works_in_every_state(endpoint: &Endpoint) -> bool {
    ["rcl_interfaces", "lifecycle_msgs"].contains(&endpoint.package_and_type().0)
}

#[cfg(test)]
mod tests {
    use super::super::qos;
    use super::*;

    fn asked(lifecycle: &Lifecycle, label: &str, outcome: Result<(), String>) -> (bool, Vec<u8>) {
        let mut told = Vec::new();
        let made = lifecycle.change((0, label), |_| outcome, |it| told.push(it.id));
        (made, told)
    }

    #[test]
    fn every_transition_tells_its_begin_and_its_end() {
        let lifecycle = Lifecycle::unconfigured();
        assert_eq!(asked(&lifecycle, "activate", Ok(())), (false, vec![]));
        assert_eq!(asked(&lifecycle, "configure", Ok(())), (true, vec![1, 10]));
        assert_eq!(asked(&lifecycle, "activate", Ok(())), (true, vec![3, 30]));
        assert!(lifecycle.is_active());
        assert_eq!(asked(&lifecycle, "deactivate", Ok(())), (true, vec![4, 40]));
        assert_eq!(asked(&lifecycle, "cleanup", Ok(())), (true, vec![2, 20]));
        assert_eq!(asked(&lifecycle, "shutdown", Ok(())), (true, vec![5, 50]));
        assert_eq!(lifecycle.state(), State::Finalized);
    }

    #[test]
    fn a_transition_that_fails_leads_back() {
        let lifecycle = Lifecycle::unconfigured();
        let failed = asked(&lifecycle, "configure", Err("on purpose".to_owned()));
        assert_eq!(failed, (false, vec![1, 11]));
        assert_eq!(lifecycle.state(), State::Unconfigured);
        asked(&lifecycle, "configure", Ok(()));
        asked(&lifecycle, "activate", Ok(()));
        let failed = asked(&lifecycle, "deactivate", Err("on purpose".to_owned()));
        assert_eq!(failed, (false, vec![4, 41]));
        assert!(lifecycle.is_active());
    }

    #[test]
    fn every_rejected_input_is_counted_and_the_first_are_told() {
        let lifecycle = Lifecycle::unconfigured();
        let now = Instant::now();
        let check = |endpoint| lifecycle.check_active(endpoint, now);
        let told = |endpoint| {
            (0..50)
                .filter(|_| check(endpoint).is_err_and(|it| it.is_told))
                .count() as u64
        };
        // Samples of sensors do not hide an impact.
        assert_eq!(told(&qos::MEASUREMENTS), MAX_TOLD);
        assert_eq!(told(&qos::IMPACT_EVENT), MAX_TOLD);
        assert!(check(&qos::SET_PARAMETERS).is_ok() && check(&qos::CHANGE_STATE).is_ok());
        assert_eq!(lifecycle.rejected(), 100);
    }
}
