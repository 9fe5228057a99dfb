//! What the host of a server says, answers and hears.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::playback::PlaybackRequest;

/// What to serve, to whom.
pub struct Settings {
    /// The name that clients show.
    pub name: String,
    /// Address and port, such as `127.0.0.1:8765`; with port 0 any free one.
    pub address: String,
    /// Web pages that may connect besides those of this machine, by their origins (`https://app.foxglove.dev`).
    pub origins: Vec<String>,
    /// What the host calls these origins: a page that is rejected is told with it.
    pub origins_name: &'static str,
    /// Whether a host of a request, with or without a port, is this machine.
    pub is_this_machine: fn(&str) -> bool,
    /// Whether clients may set parameters.
    pub control: bool,
    /// What can be subscribed to.
    pub channels: Vec<Channel>,
    /// What can be called.
    pub services: Vec<Service>,
    /// The first and the last time \[ns since 1970\] of a recording whose playback clients control; `None` for live topics.
    pub playback: Option<(u64, u64)>,
}

/// A topic with its type.
pub struct Channel {
    /// Its full name.
    pub topic: String,
    /// The type of its messages.
    pub schema: Schema,
    /// How many of the newest messages a client gets when it subscribes.
    pub history: usize,
}

/// A ROS 2 type.
pub struct Schema {
    /// Its name, such as `std_msgs/msg/String`.
    pub name: String,
    /// Its definition with those that it needs, in the encoding `ros2msg`.
    pub text: String,
}

/// A service with its types.
pub struct Service {
    /// Its full name.
    pub name: String,
    /// The name of its type, such as `std_srvs/srv/Trigger`.
    pub type_name: String,
    /// The type of its requests.
    pub request: Schema,
    /// The type of its responses.
    pub response: Schema,
}

/// A parameter with its value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value; null if there is none.
    #[serde(default, skip_serializing_if = "Value::is_null")]
    pub value: Value,
    /// `float64` or `float64_array`, where the value may look like whole numbers.
    #[serde(default, rename = "type", skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
}

/// Answers requests, one after another, in a thread of its own; it may take its time.
pub trait Handler: Send + 'static {
    /// The parameters with these names that exist; all of them if there are no names.
    fn parameters(&mut self, names: &[String]) -> Vec<Parameter>;

    /// Sets all of these parameters or none.
    ///
    /// # Errors
    /// Why none was set.
    fn set_parameters(&mut self, given: &[Parameter]) -> Result<(), String>;

    /// Answers a request to the service with this index, both in CDR with encapsulation header.
    ///
    /// # Errors
    /// Why there is no answer.
    fn call(&mut self, service: usize, request: &[u8]) -> Result<Vec<u8>, String>;

    /// Hears what a client asks of the playback, if [`Settings::playback`] offers one. The answer is the next state that the host
    /// tells with [`Server::playback`](crate::Server::playback).
    fn playback(&mut self, request: PlaybackRequest) {
        drop(request);
    }
}

/// How important a notice is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Importance {
    /// Good to know.
    Info,
    /// Somebody does not get what they asked for.
    Warning,
    /// Somebody may not connect.
    Rejection,
}

/// Takes notices for the log. It is called from the threads of the server and must not wait.
pub type Notices = Arc<dyn Fn(Importance, String) + Send + Sync>;

/// Counts since the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Clients that are connected.
    pub clients: u64,
    /// Connections that were rejected.
    pub rejected: u64,
    /// Messages that clients lost because they read too slowly, and messages that the network's thread was too slow for.
    pub dropped: u64,
}
