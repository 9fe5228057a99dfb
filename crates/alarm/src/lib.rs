#![doc = include_str!("../README.md")]

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
