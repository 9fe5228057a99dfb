//! Whether a recording is whole, or cut off and damaged.

use std::fmt;
use std::path::Path;

use crate::error::RecordingError;
use crate::records::FileEnd;

/// Maximum number of faults that are described; all are counted.
const MAX_FAULTS: usize = 20;

/// Whether everything that was written to a recording can be read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Wholeness {
    /// Files without the end of an MCAP file: name, and how they end.
    pub cut_off: Vec<String>,
    /// Whether one of them ends in the middle of a record.
    pub ends_in_record: bool,
    /// Number of damaged records and chunks, which are left out.
    pub damaged: u64,
    /// Descriptions of the first of them.
    pub faults: Vec<String>,
}

impl Wholeness {
    /// Whether nothing is missing.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.cut_off.is_empty() && self.damaged == 0
    }

    /// Notes a damaged record.
    pub(crate) fn note_damage(&mut self, fault: &RecordingError) {
        self.damaged += 1;
        if self.faults.len() < MAX_FAULTS
            && let RecordingError::Damaged { offset, reason, .. } = fault
        {
            self.faults.push(format!("at byte {offset}: {reason}"));
        }
    }

    /// Notes how a file ends.
    pub(crate) fn note_end(&mut self, file: &Path, end: Option<FileEnd>) {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        match end {
            Some(FileEnd::Whole) => {}
            Some(FileEnd::InRecord(at)) => {
                self.ends_in_record = true;
                self.cut_off.push(format!(
                    "{name} is cut off in the record that begins at byte {at}"
                ));
            }
            Some(FileEnd::CutOff(at)) => {
                self.cut_off.push(format!(
                    "{name} has no end, its last whole record ends at byte {at}"
                ));
            }
            None => self.cut_off.push(format!("{name} was not read to its end")),
        }
    }
}

impl fmt::Display for Wholeness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_whole() {
            return f.write_str("whole");
        }
        f.write_str("not whole")?;
        for line in &self.cut_off {
            write!(f, "; {line}")?;
        }
        match (self.damaged, self.faults.first()) {
            (0, _) | (_, None) => Ok(()),
            (1, Some(fault)) => write!(f, "; {fault}"),
            (more, Some(first)) => write!(f, "; {more} records are damaged, the first: {first}"),
        }
    }
}
