//! Copies of recordings with other messages, as a forger writes them: every chunk has the right CRC.

use std::path::{Path, PathBuf};

use column_twin::endpoints::NodeKind;
use column_twin::evidence::Topics;
use column_twin::recording::{Entry, Message, Reader, Writer, WriterOptions};
use tempfile::TempDir;

/// All messages of a recording, in their order.
pub fn messages(path: &Path) -> Vec<Message> {
    let reader = Reader::open(path).unwrap();
    reader.messages().map(Result::unwrap).collect()
}

/// A recording with these messages, in this order.
pub fn written(messages: &[Message]) -> (TempDir, PathBuf) {
    written_with(&WriterOptions::default(), messages)
}

/// A recording with these options and messages.
pub fn written_with(options: &WriterOptions, messages: &[Message]) -> (TempDir, PathBuf) {
    written_on(
        &Topics::of_default_node(NodeKind::Single),
        options,
        messages,
    )
}

/// A recording with these topics, options and messages.
pub fn written_on(
    topics: &Topics,
    options: &WriterOptions,
    messages: &[Message],
) -> (TempDir, PathBuf) {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("forged");
    let declared = topics.declared().unwrap();
    let options = WriterOptions {
        sync: false,
        ..options.clone()
    };
    let mut writer = Writer::create(&path, &options, &declared).unwrap();
    for message in messages {
        let topic = declared.iter().position(|it| *it.name == *message.topic);
        let entry = Entry {
            topic: topic.unwrap(),
            log_time: message.log_time,
            publish_time: message.publish_time,
            data: message.data.clone().into(),
            checkpoint: false,
        };
        writer.write(&entry).unwrap();
    }
    writer.finish().unwrap();
    (directory, path)
}

/// A copy of a recording in which `change` has changed or removed messages.
pub fn forged(
    original: &Path,
    mut change: impl FnMut(&Message) -> Option<Vec<u8>>,
) -> (TempDir, PathBuf) {
    let mut all = messages(original);
    all.retain_mut(|message| {
        let data = change(message);
        let is_kept = data.is_some();
        message.data = data.unwrap_or_default();
        is_kept
    });
    written(&all)
}
