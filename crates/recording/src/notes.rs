//! The metadata records of a recording: what its recorder, or a repair, notes about it.

use std::collections::BTreeMap;
use std::ops::Range;

use mcap::records::Metadata;

/// Note of a recording that could not wait for a checkpoint and begins with a copy of the last one.
pub(crate) const REPEATED_CHECKPOINT: &str = "repeated_checkpoint";

/// End of the name of the metadata record at the beginning, which holds the notes of the recording program.
pub(crate) const START: &str = "_start";

/// End of the name of the metadata records that count lost messages, the last of which is valid: `lost_messages`, and
/// at the end of a recording `ended`, the reason.
pub(crate) const LOSSES: &str = "_losses";

/// End of the name of the metadata record that says from what a recording was repaired, and why.
pub(crate) const REPAIR: &str = "_repair";

/// Entry of that record: the number of messages that could not be read.
pub(crate) const UNREAD: &str = "unread_messages";

/// The reason why a repaired recording ends.
pub(crate) const REPAIRED: &str = "repaired";

/// Name of a metadata record.
pub(crate) fn record_name(application: &str, kind: &str) -> String {
    format!("{application}{kind}")
}

pub(crate) fn record<const N: usize>(name: String, entries: [(&str, String); N]) -> Metadata {
    Metadata {
        name,
        metadata: entries.map(|(key, value)| (key.to_owned(), value)).into(),
    }
}

/// The notes of a recording, in their order.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    pub records: Vec<(String, BTreeMap<String, String>)>,
    /// Which of them stand in a sealed file behind its last seal.
    pub unsealed: Vec<Range<usize>>,
}

impl Notes {
    /// The records whose names end so.
    pub fn of_kind(&self, kind: &str) -> impl Iterator<Item = &BTreeMap<String, String>> {
        let records = self.records.iter();
        records
            .filter(move |(name, _)| name.ends_with(kind))
            .map(|(_, entries)| entries)
    }

    /// The last count of lost messages that is sealed, or in a file without a seal.
    pub fn lost_messages(&self) -> Option<u64> {
        let counts = self.losses().filter(|(_, is_sealed)| *is_sealed);
        counts
            .filter_map(|(entries, _)| entries.get("lost_messages")?.parse().ok())
            .next_back()
    }

    /// Why the recorder ended the recording. Behind its last seal, a file can only say that it was repaired.
    pub fn ended(&self) -> Option<&str> {
        let (entries, is_sealed) = self.losses().next_back()?;
        let reason = entries.get("ended").map(String::as_str);
        match is_sealed {
            true => reason,
            false => reason
                .filter(|it| *it == REPAIRED)
                .or_else(|| self.ended_before_repair()),
        }
    }

    /// Whether the recording was repaired, and its original did not tell how it ended.
    pub fn was_cut_off(&self) -> bool {
        self.of_kind(REPAIR).next().is_some() && self.ended_before_repair().is_none()
    }

    /// How the original of a repaired recording ended.
    fn ended_before_repair(&self) -> Option<&str> {
        let mut reasons = self
            .losses()
            .filter(|(_, is_sealed)| *is_sealed)
            .filter_map(|(entries, _)| entries.get("ended").map(String::as_str));
        reasons.rfind(|it| *it != REPAIRED)
    }

    /// The counts of lost messages, and whether a seal covers each, if there is one.
    fn losses(&self) -> impl DoubleEndedIterator<Item = (&BTreeMap<String, String>, bool)> {
        let records = self.records.iter().enumerate();
        let is_sealed = |index| !self.unsealed.iter().any(|it| it.contains(&index));
        records
            .filter(|(_, (name, _))| name.ends_with(LOSSES))
            .map(move |(index, (_, entries))| (entries, is_sealed(index)))
    }
}
