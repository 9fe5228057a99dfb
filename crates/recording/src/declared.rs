//! Schemas and channels as a file declares them, compared by hashes: a file may declare thousands of channels with one long
//! schema, and each of them takes a time that depends on its own length only.

use std::collections::BTreeMap;
use std::sync::Arc;

use mcap::records::{Channel, SchemaHeader};

use crate::chain::{Hash, TopicTexts};

/// The definition of a type.
#[derive(Debug)]
pub(crate) struct Schema {
    pub name: String,
    pub encoding: String,
    pub text: Arc<[u8]>,
    /// Of all the others.
    pub hash: Hash,
}

impl Schema {
    pub fn new(header: SchemaHeader, data: Vec<u8>) -> Self {
        let texts = TopicTexts {
            type_name: &header.name,
            schema_encoding: &header.encoding,
            schema: &data,
            ..TopicTexts::default()
        };
        let hash = texts.hash();
        Self {
            name: header.name,
            encoding: header.encoding,
            text: data.into(),
            hash,
        }
    }

    pub fn is(&self, header: &SchemaHeader, data: &[u8]) -> bool {
        self.name == header.name && self.encoding == header.encoding && *self.text == *data
    }

    /// Length of its texts \[bytes\].
    pub fn length(&self) -> usize {
        self.text.len() + self.name.len()
    }
}

/// By what channels are told apart.
pub(crate) struct Keys {
    /// The same for all channels of one topic.
    pub topic: Hash,
    /// The same for channels that have their metadata in common, too.
    pub declaration: Hash,
}

impl Keys {
    pub fn of(channel: &Channel, schema: Option<&Arc<Schema>>) -> Self {
        let none = Hash([0; 32]);
        // The hash of the schema stands for its text.
        let mut texts = TopicTexts {
            name: &channel.topic,
            schema: &schema.map_or(none, |it| it.hash).0,
            message_encoding: &channel.message_encoding,
            ..TopicTexts::default()
        };
        let topic = texts.hash();
        texts.metadata = &channel.metadata;
        Self {
            topic,
            declaration: texts.hash(),
        }
    }
}

/// What a channel contributes to the links of the chain. Reads the whole schema.
pub(crate) fn hash_of(channel: &Channel, schema: Option<&Arc<Schema>>) -> Hash {
    let texts = TopicTexts {
        name: &channel.topic,
        type_name: schema.map_or("", |it| &it.name),
        schema_encoding: schema.map_or("", |it| &it.encoding),
        schema: schema.map_or(&[], |it| &it.text),
        message_encoding: &channel.message_encoding,
        metadata: &channel.metadata,
    };
    texts.hash()
}

/// Length of the entries \[bytes\].
pub(crate) fn text_length(entries: &BTreeMap<String, String>) -> usize {
    entries
        .iter()
        .map(|(key, value)| key.len() + value.len())
        .sum()
}
