//! `metadata.yaml` of a recording, version 9, as rosbag2 writes it (`rosbag2_storage/yaml.hpp`).

use std::collections::HashSet;
use std::path::Path;

use bounded_file::read_at_most;
use serde::{Deserialize, Serialize};
use serde_yaml_ng::Value;

use crate::bounded_yaml;
use crate::error::RecordingError;

/// Name of the file.
pub(crate) const METADATA_FILE: &str = "metadata.yaml";

/// Maximum length of a `metadata.yaml` that is read \[bytes\].
const MAX_LENGTH: u64 = 16 << 20;

/// The version that is written.
const VERSION: u32 = 9;

/// The content of `metadata.yaml` under `rosbag2_bagfile_information`.
#[derive(Debug, Serialize)]
pub(crate) struct BagMetadata {
    version: u32,
    storage_identifier: &'static str,
    duration: Nanoseconds,
    starting_time: NanosecondsSinceEpoch,
    message_count: u64,
    topics_with_message_count: Vec<TopicWithCount>,
    compression_format: &'static str,
    compression_mode: &'static str,
    relative_file_paths: [String; 1],
    files: [BagFile; 1],
    custom_data: Option<()>,
    ros_distro: String,
}

/// What `metadata.yaml` says about a recording.
pub(crate) struct BagSummary {
    /// Name of the program that recorded it.
    pub application: String,
    /// Name of the MCAP file.
    pub file: String,
    /// First and last time; `None` without messages.
    pub span: Option<(u64, u64)>,
    pub topics: Vec<TopicSummary>,
}

pub(crate) struct TopicSummary {
    pub name: String,
    pub type_name: String,
    /// Encoding of the messages.
    pub encoding: String,
    /// Offered profiles, in YAML.
    pub qos: String,
    pub type_hash: String,
    pub messages: u64,
}

#[derive(Debug, Clone, Copy, Serialize)]
struct Nanoseconds {
    nanoseconds: u64,
}

#[derive(Debug, Clone, Copy, Serialize)]
struct NanosecondsSinceEpoch {
    nanoseconds_since_epoch: u64,
}

#[derive(Debug, Serialize)]
struct TopicWithCount {
    topic_metadata: TopicMetadata,
    message_count: u64,
}

#[derive(Debug, Serialize)]
struct TopicMetadata {
    name: String,
    r#type: String,
    serialization_format: String,
    offered_qos_profiles: Vec<Value>,
    type_description_hash: String,
}

#[derive(Debug, Serialize)]
struct BagFile {
    path: String,
    starting_time: NanosecondsSinceEpoch,
    duration: Nanoseconds,
    message_count: u64,
}

#[derive(Serialize)]
struct Document<'a> {
    rosbag2_bagfile_information: &'a BagMetadata,
}

impl From<BagSummary> for BagMetadata {
    fn from(summary: BagSummary) -> Self {
        let (first, last) = summary.span.unwrap_or((0, 0));
        let duration = Nanoseconds {
            nanoseconds: last - first,
        };
        let starting_time = NanosecondsSinceEpoch {
            nanoseconds_since_epoch: first,
        };
        let message_count = summary.topics.iter().map(|topic| topic.messages).sum();
        let topics = summary.topics.into_iter().map(|topic| TopicWithCount {
            topic_metadata: TopicMetadata {
                name: topic.name,
                r#type: topic.type_name,
                serialization_format: topic.encoding,
                offered_qos_profiles: serde_yaml_ng::from_str(&topic.qos).unwrap_or_default(),
                type_description_hash: topic.type_hash,
            },
            message_count: topic.messages,
        });
        Self {
            version: VERSION,
            storage_identifier: "mcap",
            duration,
            starting_time,
            message_count,
            topics_with_message_count: topics.collect(),
            // MCAP compresses the chunks; these entries are for compression by rosbag2.
            compression_format: "",
            compression_mode: "",
            relative_file_paths: [summary.file.clone()],
            files: [BagFile {
                path: summary.file,
                starting_time,
                duration,
                message_count,
            }],
            custom_data: None,
            ros_distro: summary.application,
        }
    }
}

impl BagMetadata {
    /// The content of `metadata.yaml`.
    pub fn document(&self) -> Result<String, serde_yaml_ng::Error> {
        serde_yaml_ng::to_string(&Document {
            rosbag2_bagfile_information: self,
        })
    }

    /// The text of the metadata record `rosbag2` in the MCAP file.
    pub fn record(&self) -> Result<String, serde_yaml_ng::Error> {
        serde_yaml_ng::to_string(self)
    }
}

/// The part of `metadata.yaml` that is read, of any version.
#[derive(Debug, Deserialize)]
struct ReadDocument {
    rosbag2_bagfile_information: ReadMetadata,
}

#[derive(Debug, Deserialize)]
struct ReadMetadata {
    storage_identifier: String,
    relative_file_paths: Vec<String>,
    #[serde(default)]
    compression_mode: String,
}

/// The names of the MCAP files that the `metadata.yaml` at `path` lists, in order, without directories.
pub(crate) fn read_file_names(path: &Path) -> Result<Vec<String>, RecordingError> {
    let bad = |reason: String| RecordingError::BadMetadata {
        path: path.to_path_buf(),
        reason,
    };
    let bytes = read_at_most(path, MAX_LENGTH).map_err(|source| match source.kind() {
        std::io::ErrorKind::InvalidData => bad(source.to_string()),
        _ => RecordingError::io("read", path, source),
    })?;
    let text = String::from_utf8(bytes).map_err(|_| bad("expected valid UTF-8".to_owned()))?;
    let document: ReadDocument = bounded_yaml::parse(&text).map_err(|reason| {
        bad(format!(
            "expected the metadata of a rosbag2 recording: {reason}"
        ))
    })?;
    let metadata = document.rosbag2_bagfile_information;
    let mode = metadata.compression_mode.to_lowercase();
    let storage = metadata.storage_identifier;
    let reason = if storage != "mcap" {
        Some(format!("expected storage_identifier mcap, found {storage}"))
    } else if !matches!(mode.as_str(), "" | "none" | "storage") {
        Some(format!(
            "expected compression by MCAP, found a recording that rosbag2 compressed by {mode}"
        ))
    } else {
        None
    };
    if let Some(reason) = reason {
        let path = path.to_path_buf();
        return Err(RecordingError::OtherStorage { path, reason });
    }
    let names = metadata.relative_file_paths.into_iter();
    // Older versions wrote paths; the files are in the same directory as metadata.yaml in any case.
    let plain = |name: String| {
        let file_name = Path::new(&name).file_name();
        file_name.map(|it| it.to_string_lossy().into_owned())
    };
    let names: Vec<String> = names.filter_map(plain).collect();
    if names.is_empty() {
        return Err(bad(
            "expected names of files in relative_file_paths, found none".to_owned(),
        ));
    }
    let mut seen = HashSet::new();
    if let Some(twice) = names.iter().find(|name| !seen.insert(name.as_str())) {
        return Err(bad(format!(
            "expected each file once in relative_file_paths, found {twice:?} twice"
        )));
    }
    Ok(names)
}
