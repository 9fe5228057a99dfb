//! The services and the topic by which others read and change the state of a managed node, as `ros2 lifecycle` does.

use std::sync::Arc;
use std::thread;
use std::time::Duration;

use futures::channel::oneshot;
use futures::join;

use crate::messages::cdr;
use crate::messages::lifecycle_msgs::{
    self as msgs, ChangeStateRequest, ChangeStateResponse, GetAvailableStatesRequest,
    GetAvailableStatesResponse, GetAvailableTransitionsRequest, GetAvailableTransitionsResponse,
    GetStateRequest, GetStateResponse, TransitionEvent,
};

use super::counters::NodeCounters;
use super::inputs::{answer, answer_from};
use super::lifecycle::Lifecycle;
use super::lifecycle_states::{State, TRANSITIONS, Transition};
use super::node::{Node, NodeError};
use super::qos;
use super::receiving::Receiving;
use super::sending::encoded;
use super::transport::{Publisher, Server};
use ros_node::raw::Raw;

/// Time for the answer to `shutdown` to arrive before the process ends.
const ANSWER_TIME: Duration = Duration::from_millis(200);

impl ros2_client::Message for ChangeStateRequest {}
impl ros2_client::Message for ChangeStateResponse {}
impl ros2_client::Message for GetAvailableStatesRequest {}
impl ros2_client::Message for GetAvailableStatesResponse {}
impl ros2_client::Message for GetAvailableTransitionsRequest {}
impl ros2_client::Message for GetAvailableTransitionsResponse {}
impl ros2_client::Message for GetStateRequest {}
impl ros2_client::Message for GetStateResponse {}

/// What a managed node does in its transitions.
pub(super) struct Actions {
    /// Creates the inputs; called by the first configuration, and again after one that has failed.
    pub configure: Box<dyn FnMut() -> Result<(), NodeError> + Send>,
    /// Asks the process to end.
    pub shut_down: Box<dyn Fn() + Send>,
}

/// The servers behind `ros2 lifecycle`, and the topic of the transitions.
pub(super) struct LifecycleServers {
    lifecycle: Arc<Lifecycle>,
    change_state: Server<ChangeStateRequest, ChangeStateResponse>,
    get_state: Server<GetStateRequest, GetStateResponse>,
    states: Server<GetAvailableStatesRequest, GetAvailableStatesResponse>,
    transitions: Server<GetAvailableTransitionsRequest, GetAvailableTransitionsResponse>,
    graph: Server<GetAvailableTransitionsRequest, GetAvailableTransitionsResponse>,
    events: Publisher<Raw>,
    actions: Actions,
}

impl LifecycleServers {
    pub fn new(
        node: &mut Node,
        lifecycle: Arc<Lifecycle>,
        actions: Actions,
    ) -> Result<Self, NodeError> {
        Ok(Self {
            lifecycle,
            change_state: node.server(&qos::CHANGE_STATE)?,
            get_state: node.server(&qos::GET_STATE)?,
            states: node.server(&qos::GET_AVAILABLE_STATES)?,
            transitions: node.server(&qos::GET_AVAILABLE_TRANSITIONS)?,
            graph: node.server(&qos::GET_TRANSITION_GRAPH)?,
            events: node.publisher(&qos::TRANSITION_EVENT)?,
            actions,
        })
    }

    /// Answers requests until the task is stopped.
    pub async fn run(self, receiving: &Receiving) {
        let Self {
            lifecycle,
            change_state,
            get_state,
            states,
            transitions,
            graph,
            events,
            actions:
                Actions {
                    mut configure,
                    shut_down: end_process,
                },
        } = self;
        let (lifecycle, counters) = (&*lifecycle, &*receiving.counters);
        let mut is_configured = false;
        let mut act = |transition: &Transition| -> Result<(), String> {
            if transition.goal == State::Configuring && !is_configured {
                configure().map_err(|error| error.to_string())?;
                is_configured = true;
            }
            Ok(())
        };
        let tell = |transition: &Transition| {
            let event = TransitionEvent {
                timestamp: u64::try_from(receiving.columns.now()).unwrap_or(0),
                transition: name(transition),
                start_state: state(transition.start),
                goal_state: state(transition.goal),
            };
            let raw = encoded(cdr::encode(&event));
            if raw.is_none_or(|raw| events.publish(raw).is_err()) {
                NodeCounters::count(&counters.unpublished);
            }
        };
        let (end, ended) = oneshot::channel();
        let mut end = Some(end);
        let shut_down = async move {
            if ended.await.is_ok() {
                // Nothing else is left to do for this thread.
                thread::sleep(ANSWER_TIME);
                end_process();
            }
        };
        join!(
            answer_from(
                &qos::CHANGE_STATE,
                Some(&change_state),
                counters,
                |sender, request: ChangeStateRequest| {
                    let (endpoint, what) = (&qos::CHANGE_STATE, "a transition");
                    let is_admitted = receiving.admit(sender, None, endpoint, what).is_ok();
                    let msgs::Transition { id, label } = &request.transition;
                    let success = is_admitted && lifecycle.change((*id, label), &mut act, tell);
                    if success && lifecycle.state() == State::Finalized {
                        let _ = end.take().map(|it| it.send(()));
                    }
                    ChangeStateResponse { success }
                }
            ),
            shut_down,
            answer(&qos::GET_STATE, Some(&get_state), counters, |_| {
                GetStateResponse {
                    current_state: state(lifecycle.state()),
                }
            }),
            answer(&qos::GET_AVAILABLE_STATES, Some(&states), counters, |_| {
                GetAvailableStatesResponse {
                    available_states: State::ALL.iter().copied().map(state).collect(),
                }
            }),
            answer(
                &qos::GET_AVAILABLE_TRANSITIONS,
                Some(&transitions),
                counters,
                |_| described(lifecycle.state().transitions()),
            ),
            answer(&qos::GET_TRANSITION_GRAPH, Some(&graph), counters, |_| {
                described(TRANSITIONS.iter())
            }),
        );
    }
}

fn state(state: State) -> msgs::State {
    msgs::State {
        id: state.id(),
        label: state.label().to_owned(),
    }
}

fn name(transition: &Transition) -> msgs::Transition {
    msgs::Transition {
        id: transition.id,
        label: transition.label.to_owned(),
    }
}

fn described<'a>(
    transitions: impl Iterator<Item = &'a Transition>,
) -> GetAvailableTransitionsResponse {
    let described = transitions.map(|it| msgs::TransitionDescription {
        transition: name(it),
        start_state: state(it.start),
        goal_state: state(it.goal),
    });
    GetAvailableTransitionsResponse {
        available_transitions: described.collect(),
    }
}
