//! The thread that lets the host answer requests, so that the network never waits for an answer.

use std::sync::mpsc::{Receiver, SyncSender};

use tungstenite::Message;

use crate::bell::Bell;
use crate::host::{Handler, Parameter};
use crate::playback::PlaybackRequest;
use crate::protocol::{self, Call, Level};

/// A request that takes the host.
pub(crate) struct Job {
    /// The number of the client.
    pub client: u64,
    pub task: Task,
}

pub(crate) enum Task {
    Get {
        names: Vec<String>,
        id: Option<String>,
    },
    Set {
        parameters: Vec<Parameter>,
        id: Option<String>,
    },
    Call(Call),
    Playback(PlaybackRequest),
}

/// What to tell the client that asked.
pub(crate) struct Answer {
    /// The number of the client.
    pub client: u64,
    pub messages: Vec<Message>,
}

/// Answers requests until nobody can send any.
pub(crate) fn run(
    jobs: &Receiver<Job>,
    answers: &SyncSender<Answer>,
    bell: &Bell,
    mut handler: impl Handler,
    control: bool,
) {
    for Job { client, task } in jobs {
        let messages = match task {
            Task::Get { names, id } => {
                let values = handler.parameters(&names);
                vec![protocol::parameter_values(&values, id.as_deref()).into()]
            }
            Task::Set { parameters, id } => {
                let outcome = match control {
                    true => handler.set_parameters(&parameters),
                    false => Err(
                        "parameters can only be read: the server was started without control"
                            .to_owned(),
                    ),
                };
                let names: Vec<_> = parameters.into_iter().map(|it| it.name).collect();
                // Where nothing was set, the client shows again what holds. Of no names, the host would tell all.
                let values = match names.is_empty() {
                    true => Vec::new(),
                    false => handler.parameters(&names),
                };
                let values = protocol::parameter_values(&values, id.as_deref()).into();
                let fault = outcome.err();
                let fault = fault.map(|it| protocol::status(Level::Error, &it).into());
                [Some(values), fault].into_iter().flatten().collect()
            }
            Task::Call(call) => vec![match handler.call(call.service as usize, &call.payload) {
                Ok(payload) => protocol::call_answered(&call, &payload).into(),
                Err(reason) => protocol::call_failed(&call, &reason).into(),
            }],
            Task::Playback(request) => {
                handler.playback(request);
                Vec::new()
            }
        };
        if answers.send(Answer { client, messages }).is_err() {
            return;
        }
        bell.ring();
    }
}
