#![doc = include_str!("../README.md")]

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - bell.rs: Wakes the network's thread, which waits for sockets
// - client.rs: One client: its connection, its subscriptions, and what waits to be sent to it
// - door.rs: Who may connect
// - host.rs: What the host of a server says, answers and hears
// - network.rs: The network's thread: accepts clients, hears their requests, and sends them what is published
// - playback.rs: Playback of a recording under the control of clients
// - protocol.rs: The messages of the protocol
// - server.rs: The server as its host sees it
// - shared.rs: What the threads of a server share
// - worker.rs: The thread that lets the host answer requests, so that the network never waits for an answer

mod bell;
mod client;
mod door;
mod host;
mod network;
mod playback;
mod protocol;
mod server;
mod shared;
mod worker;

pub use host::{
    Channel, Handler, Importance, Notices, Parameter, Schema, Service, Settings, Statistics,
};
pub use playback::{PlaybackRequest, PlaybackState, PlaybackStatus};
pub use server::Server;
