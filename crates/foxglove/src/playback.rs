//! Playback of a recording under the control of clients.

/// What a client asks of a playback.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaybackRequest {
    /// Play, or pause.
    pub play: bool,
    /// Recorded seconds per second; positive and finite.
    pub speed: f32,
    /// Go to this time \[ns since 1970\] first.
    pub seek: Option<u64>,
    /// By which the client recognises the answer.
    pub id: String,
}

/// The state of a playback, which is told to all clients.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaybackState {
    /// What it does.
    pub status: PlaybackStatus,
    /// The recorded time that is played now \[ns since 1970\].
    pub time: u64,
    /// Recorded seconds per second.
    pub speed: f32,
    /// Whether it has gone to another time: what was published before is no longer kept for clients that connect later.
    pub did_seek: bool,
    /// The request that this answers; empty if none.
    pub request: String,
}

/// What a playback does, with the number that the protocol gives it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaybackStatus {
    /// It plays.
    Playing = 0,
    /// It is paused.
    Paused = 1,
    /// It has reached the end.
    Ended = 3,
}
