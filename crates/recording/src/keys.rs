//! Keys of the metadata of a channel, which writer and reader share.

/// Key of the offered quality of service in the metadata of a channel.
pub(crate) const QOS_KEY: &str = "offered_qos_profiles";

/// Key of the type hash in the metadata of a channel.
pub(crate) const TYPE_HASH_KEY: &str = "topic_type_hash";
