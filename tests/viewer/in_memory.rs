//! A stream whose messages stay in memory, and which shows every frame.

use column_twin::viewer::StreamOptions;
use rerun::sink::MemorySinkStorage;
use rerun::{RecordingStream, RecordingStreamBuilder};

pub fn stream() -> (RecordingStream, MemorySinkStorage, StreamOptions) {
    let (stream, storage) = RecordingStreamBuilder::new("test")
        .enabled(true)
        .memory()
        .expect("a stream");
    let options = StreamOptions {
        frame_period: 0,
        budget: None,
        curves_period: 0,
        follows: false,
        ranges: Default::default(),
    };
    (stream, storage, options)
}
