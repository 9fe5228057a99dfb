//! What the threads of a server share.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64};

use crossbeam_queue::ArrayQueue;

use crate::bell::Bell;
use crate::host::Parameter;
use crate::playback::PlaybackState;

/// Queue, flags and counts.
pub(crate) struct Shared {
    pub published: ArrayQueue<Published>,
    /// For each channel, whether somebody needs its messages.
    pub wanted: Vec<AtomicBool>,
    pub bell: Bell,
    pub stop: AtomicBool,
    pub clients: AtomicU64,
    pub rejected: AtomicU64,
    pub dropped: AtomicU64,
}

/// What the host hands over.
pub(crate) enum Published {
    Message(Message),
    Parameters(Vec<Parameter>),
    Playback(PlaybackState),
    /// The recorded time that is played \[ns since 1970\].
    Time(u64),
}

/// A message of a channel.
#[derive(Clone)]
pub(crate) struct Message {
    /// The index of the channel.
    pub channel: usize,
    /// \[ns since 1970\]
    pub time: u64,
    pub bytes: Arc<[u8]>,
}
