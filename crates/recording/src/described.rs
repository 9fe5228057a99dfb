//! Topics with all their texts in the file.

use std::collections::{BTreeMap, HashSet};
use std::path::PathBuf;

use crate::chain::{Hash, TopicTexts};
use crate::error::RecordingError;
use crate::keys::{QOS_KEY, TYPE_HASH_KEY};
use crate::reader::RecordedTopic;
use crate::topic::TopicInfo;

/// A topic with all its texts in the file.
pub(crate) struct Described {
    pub name: String,
    pub type_name: String,
    pub schema_encoding: String,
    pub schema: Vec<u8>,
    pub message_encoding: String,
    pub metadata: BTreeMap<String, String>,
}

impl Described {
    pub fn new(topic: &TopicInfo) -> Result<Self, RecordingError> {
        let qos = topic
            .qos
            .to_yaml()
            .map_err(|error| RecordingError::WriteMetadata {
                path: PathBuf::from(&topic.name),
                reason: error.to_string(),
            })?;
        let metadata = [(QOS_KEY, qos), (TYPE_HASH_KEY, topic.type_hash.clone())];
        Ok(Self {
            name: topic.name.clone(),
            type_name: topic.type_name.clone(),
            schema_encoding: "ros2msg".to_owned(),
            schema: topic.schema.clone().into_bytes(),
            message_encoding: "cdr".to_owned(),
            metadata: metadata.map(|(key, value)| (key.to_owned(), value)).into(),
        })
    }

    /// What the topic contributes to the links of the chain.
    pub fn hash(&self) -> Hash {
        // A topic without a schema has no name of a type in the file.
        let type_name = if self.has_schema() {
            &self.type_name
        } else {
            ""
        };
        let texts = TopicTexts {
            name: &self.name,
            type_name,
            schema_encoding: &self.schema_encoding,
            schema: &self.schema,
            message_encoding: &self.message_encoding,
            metadata: &self.metadata,
        };
        texts.hash()
    }

    pub fn has_schema(&self) -> bool {
        !self.schema_encoding.is_empty() || !self.schema.is_empty()
    }

    /// Length of its texts \[bytes\].
    pub fn length(&self) -> u64 {
        let metadata: usize = self
            .metadata
            .iter()
            .map(|(key, value)| key.len() + value.len())
            .sum();
        (self.schema.len() + self.name.len() + self.type_name.len() + metadata) as u64
    }
}

impl From<&RecordedTopic> for Described {
    fn from(topic: &RecordedTopic) -> Self {
        Self {
            name: topic.name.to_string(),
            type_name: topic.type_name.to_string(),
            schema_encoding: topic.schema_encoding.clone(),
            schema: topic.schema.to_vec(),
            message_encoding: topic.encoding.clone(),
            metadata: topic.metadata.clone(),
        }
    }
}

/// Checks that all names differ.
pub(crate) fn check_topics(topics: &[TopicInfo]) -> Result<(), RecordingError> {
    let mut names = HashSet::new();
    for topic in topics {
        if !names.insert(&topic.name) {
            return Err(RecordingError::DuplicateTopic {
                topic: topic.name.clone(),
            });
        }
    }
    Ok(())
}
