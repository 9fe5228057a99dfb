//! States and transitions of a managed node.
//!
//! Ids and labels are those of rcl, `rcl_lifecycle/src/default_state_machine.c` in <https://github.com/ros2/rcl>, and are described in
//! <https://design.ros2.org/articles/node_lifecycle.html>.

// States with their ids and the names that tools show, in the order in which rcl registers them.
macro_rules! states {
    ($($state:ident = $id:literal $label:literal;)*) => {
        /// A state of a managed node, by its id in `lifecycle_msgs/msg/State`. A running node is never unknown.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(super) enum State { $($state = $id),* }

        impl State {
            /// All states, in the order in which rcl registers them.
            pub const ALL: &[Self] = &[$(Self::$state),*];

            /// The name that tools show.
            pub fn label(self) -> &'static str {
                match self { $(Self::$state => $label),* }
            }
        }
    };
}

states! {
    Unknown = 0 "unknown";
    Unconfigured = 1 "unconfigured";
    Inactive = 2 "inactive";
    Active = 3 "active";
    Finalized = 4 "finalized";
    Configuring = 10 "configuring";
    CleaningUp = 11 "cleaningup";
    ShuttingDown = 12 "shuttingdown";
    Activating = 13 "activating";
    Deactivating = 14 "deactivating";
    ErrorProcessing = 15 "errorprocessing";
}

/// A transition between two states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Transition {
    /// As in `lifecycle_msgs/msg/Transition`.
    pub id: u8,
    pub label: &'static str,
    pub start: State,
    pub goal: State,
}

// Transitions: id, label, and the states between which they lead.
macro_rules! transitions {
    ($($id:literal $label:literal $start:ident $goal:ident;)*) => {
        &[$(Transition { id: $id, label: $label, start: State::$start, goal: State::$goal }),*]
    };
}

/// All transitions, in the order in which rcl registers them.
pub(super) const TRANSITIONS: &[Transition] = transitions! {
    1 "configure" Unconfigured Configuring;
    10 "transition_success" Configuring Inactive;
    11 "transition_failure" Configuring Unconfigured;
    12 "transition_error" Configuring ErrorProcessing;
    2 "cleanup" Inactive CleaningUp;
    20 "transition_success" CleaningUp Unconfigured;
    21 "transition_failure" CleaningUp Inactive;
    22 "transition_error" CleaningUp ErrorProcessing;
    3 "activate" Inactive Activating;
    30 "transition_success" Activating Active;
    31 "transition_failure" Activating Inactive;
    32 "transition_error" Activating ErrorProcessing;
    4 "deactivate" Active Deactivating;
    40 "transition_success" Deactivating Inactive;
    41 "transition_failure" Deactivating Active;
    42 "transition_error" Deactivating ErrorProcessing;
    5 "shutdown" Unconfigured ShuttingDown;
    6 "shutdown" Inactive ShuttingDown;
    7 "shutdown" Active ShuttingDown;
    50 "transition_success" ShuttingDown Finalized;
    51 "transition_failure" ShuttingDown Finalized;
    52 "transition_error" ShuttingDown ErrorProcessing;
    60 "transition_success" ErrorProcessing Unconfigured;
    61 "transition_failure" ErrorProcessing Finalized;
    62 "transition_error" ErrorProcessing Finalized;
};

impl State {
    /// The id in `lifecycle_msgs/msg/State`.
    pub fn id(self) -> u8 {
        self as u8
    }

    /// The transitions that begin in this state.
    pub fn transitions(self) -> impl Iterator<Item = &'static Transition> {
        TRANSITIONS.iter().filter(move |it| it.start == self)
    }

    /// The transition of this state that a request names, if there is one. As in rclcpp, a label takes precedence over the id: a
    /// request with only a label has the id 0.
    pub fn requested(self, id: u8, label: &str) -> Option<&'static Transition> {
        self.transitions().find(|it| match label {
            "" => it.id == id,
            label => it.label == label,
        })
    }

    /// The transition by which an intermediate state ends; `None` in a primary state.
    pub fn concluded(self, is_successful: bool) -> Option<&'static Transition> {
        let label = match is_successful {
            true => "transition_success",
            false => "transition_failure",
        };
        self.requested(0, label)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::lifecycle_msgs;

    /// The ids of `lifecycle_msgs`, and the table of `rcl_lifecycle_init_default_state_machine`.
    #[test]
    fn states_and_transitions_are_those_of_rcl() {
        use lifecycle_msgs::{State as S, Transition as T};
        let ids: Vec<_> = State::ALL.iter().map(|it| it.id()).collect();
        assert_eq!(
            ids,
            [
                S::PRIMARY_STATE_UNKNOWN,
                S::PRIMARY_STATE_UNCONFIGURED,
                S::PRIMARY_STATE_INACTIVE,
                S::PRIMARY_STATE_ACTIVE,
                S::PRIMARY_STATE_FINALIZED,
                S::TRANSITION_STATE_CONFIGURING,
                S::TRANSITION_STATE_CLEANINGUP,
                S::TRANSITION_STATE_SHUTTINGDOWN,
                S::TRANSITION_STATE_ACTIVATING,
                S::TRANSITION_STATE_DEACTIVATING,
                S::TRANSITION_STATE_ERRORPROCESSING,
            ]
        );
        let expected = [
            (T::TRANSITION_CONFIGURE, "unconfigured configuring"),
            (T::TRANSITION_ON_CONFIGURE_SUCCESS, "configuring inactive"),
            (
                T::TRANSITION_ON_CONFIGURE_FAILURE,
                "configuring unconfigured",
            ),
            (
                T::TRANSITION_ON_CONFIGURE_ERROR,
                "configuring errorprocessing",
            ),
            (T::TRANSITION_CLEANUP, "inactive cleaningup"),
            (T::TRANSITION_ON_CLEANUP_SUCCESS, "cleaningup unconfigured"),
            (T::TRANSITION_ON_CLEANUP_FAILURE, "cleaningup inactive"),
            (T::TRANSITION_ON_CLEANUP_ERROR, "cleaningup errorprocessing"),
            (T::TRANSITION_ACTIVATE, "inactive activating"),
            (T::TRANSITION_ON_ACTIVATE_SUCCESS, "activating active"),
            (T::TRANSITION_ON_ACTIVATE_FAILURE, "activating inactive"),
            (
                T::TRANSITION_ON_ACTIVATE_ERROR,
                "activating errorprocessing",
            ),
            (T::TRANSITION_DEACTIVATE, "active deactivating"),
            (T::TRANSITION_ON_DEACTIVATE_SUCCESS, "deactivating inactive"),
            (T::TRANSITION_ON_DEACTIVATE_FAILURE, "deactivating active"),
            (
                T::TRANSITION_ON_DEACTIVATE_ERROR,
                "deactivating errorprocessing",
            ),
            (
                T::TRANSITION_UNCONFIGURED_SHUTDOWN,
                "unconfigured shuttingdown",
            ),
            (T::TRANSITION_INACTIVE_SHUTDOWN, "inactive shuttingdown"),
            (T::TRANSITION_ACTIVE_SHUTDOWN, "active shuttingdown"),
            (T::TRANSITION_ON_SHUTDOWN_SUCCESS, "shuttingdown finalized"),
            (T::TRANSITION_ON_SHUTDOWN_FAILURE, "shuttingdown finalized"),
            (
                T::TRANSITION_ON_SHUTDOWN_ERROR,
                "shuttingdown errorprocessing",
            ),
            (
                T::TRANSITION_ON_ERROR_SUCCESS,
                "errorprocessing unconfigured",
            ),
            (T::TRANSITION_ON_ERROR_FAILURE, "errorprocessing finalized"),
            (T::TRANSITION_ON_ERROR_ERROR, "errorprocessing finalized"),
        ];
        let found = TRANSITIONS.iter().map(|it| {
            let states = format!("{} {}", it.start.label(), it.goal.label());
            (it.id, states)
        });
        let expected = expected.map(|(id, states)| (id, states.to_owned()));
        assert_eq!(found.collect::<Vec<_>>(), expected);
    }

    #[test]
    fn a_request_names_a_transition_of_the_present_state_only() {
        let requested = |state: State, id, label| state.requested(id, label).map(|it| it.id);
        assert_eq!(requested(State::Unconfigured, 1, ""), Some(1));
        assert_eq!(requested(State::Inactive, 0, "activate"), Some(3));
        // The label counts.
        assert_eq!(requested(State::Inactive, 2, "activate"), Some(3));
        assert_eq!(requested(State::Active, 0, "shutdown"), Some(7));
        assert_eq!(requested(State::Unconfigured, 3, ""), None);
        assert_eq!(requested(State::Active, 5, ""), None);
        // Nobody but the node ends an intermediate state.
        assert_eq!(requested(State::Active, 40, ""), None);
        assert_eq!(requested(State::Finalized, 1, ""), None);
        assert_eq!(State::Finalized.transitions().count(), 0);
    }

    #[test]
    fn every_intermediate_state_ends_in_a_primary_one() {
        for state in State::ALL.iter().copied() {
            let is_intermediate = state.id() >= State::Configuring.id();
            for is_successful in [true, false] {
                let end = state.concluded(is_successful).map(|it| it.goal.id());
                assert_eq!(end.is_some(), is_intermediate, "{state:?}");
                assert!(end.is_none_or(|it| it < State::Configuring.id()));
            }
        }
    }
}
