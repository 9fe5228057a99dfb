//! Passes what the columns give out to the readers, to the thread that writes the state files, and to those that detect impacts.

use std::sync::{Arc, PoisonError};

use super::shared::Shared;
use crate::time::Nanos;
use crate::twin::{NoticeLevel, Output, Outputs};

/// Passes the outputs of one column to the readers.
pub struct Sink<'a> {
    pub shared: &'a Shared,
    pub column: u32,
    /// The entries of its journal are wanted. A column that has executed no command since the start has none, so that one that is
    /// never hit costs nothing.
    pub has_journal: bool,
    pub is_unnotified: bool,
}

impl Sink<'_> {
    pub fn notify(&mut self) {
        if std::mem::take(&mut self.is_unnotified) {
            self.shared.outputs.notify();
        }
    }

    /// Says what is lost because the program stops, if anything is.
    pub fn lost_by_a_stop(&mut self, lost: &[String], now: Nanos) {
        if !lost.is_empty() {
            let text = format!("lost by the stop: {}", lost.join("; "));
            self.notice(NoticeLevel::Error, now, text);
        }
        self.notify();
    }
}

impl Outputs for Sink<'_> {
    fn put(&mut self, output: Output) {
        if let Some(news) = &self.shared.news
            && let Some(lost) = news.of(self.column).take(self.column, &output)
        {
            self.put(Output::Notice(lost));
        }
        match output {
            Output::Save(saved) => {
                if let Some(keeper) = &self.shared.keeper {
                    keeper.write(self.column, saved);
                }
            }
            Output::Journal(_) if !self.has_journal => {}
            output => {
                if let Output::ParametersChanged(changed) = &output {
                    let latest = self.shared.parameters[self.column as usize].write();
                    *latest.unwrap_or_else(PoisonError::into_inner) =
                        Arc::clone(&changed.parameters);
                }
                self.is_unnotified = true;
                self.shared.outputs.push_of(self.column, output);
            }
        }
    }
}
