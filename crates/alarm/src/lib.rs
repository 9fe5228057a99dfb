#![doc = include_str!("../README.md")]

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - backoff.rs: How long to wait before the next attempt
// - bell.rs: A bell between threads: ringing it never waits, and a ring is kept until it is heard
// - book.rs: Which alarms are active, so that each is raised once and cleared once, also across restarts
// - channel.rs: One way of delivery with its rules, active alarms and spool: all but the network
// - condition.rs: What the host says about something that it watches
// - delivery.rs: The delivery: threads that take conditions, spool what is an alarm, and send it
// - error.rs: The errors of a start, each with what to do next
// - message.rs: The message of an alarm, as a receiver reads it
// - mqtt.rs: Delivery by MQTT 5
// - notice.rs: What the delivery tells its host, for the log
// - rules.rs: Which conditions are alarms
// - secret.rs: Files that hold secrets or certificates
// - sender.rs: What the senders of all channels share: when to try, when to wait, when to end
// - signature.rs: Signatures of webhooks, after Standard Webhooks (<https://www.standardwebhooks.com>): HMAC-SHA256 over id,
//   time and body, which libraries in most languages check
// - spool.rs: Messages on disk until they are delivered
// - statistics.rs: What became of the messages of a channel
// - tls.rs: Certificates and keys, for both ways of delivery
// - topic.rs: Topic names of MQTT from one template
// - webhook.rs: Delivery by HTTPS POST

mod backoff;
mod bell;
mod book;
mod channel;
mod condition;
mod delivery;
mod error;
mod message;
mod mqtt;
mod notice;
mod rules;
mod secret;
mod sender;
mod signature;
mod spool;
mod statistics;
mod tls;
mod topic;
mod webhook;

pub use condition::{Condition, Level, NODE_STOPPED, Watched};
pub use delivery::{Alarms, MAX_QUEUED, Settings, Tried, try_out};
pub use error::{StartError, TopicFault};
pub use message::{JSON_SCHEMA, MAX_REASON, Message, SCHEMA, State};
pub use mqtt::MqttSettings;
pub use notice::{Importance, Notices};
pub use rules::Rules;
pub use statistics::{ChannelStatistics, Statistics};
pub use tls::TlsFiles;
pub use topic::TopicTemplate;
pub use webhook::WebhookSettings;
