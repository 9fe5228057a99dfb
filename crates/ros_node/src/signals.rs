//! SIGINT and SIGTERM: the first signal asks the program to stop, the second ends it immediately.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use signal_hook::iterator::Signals;

/// Listens for SIGINT and SIGTERM.
#[derive(Debug)]
pub struct StopSignals {
    asked: Arc<AtomicBool>,
    signals: Signals,
}

impl StopSignals {
    /// Installs the handlers.
    ///
    /// # Errors
    /// The system rejects a handler.
    pub fn listen() -> io::Result<Self> {
        let asked = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // The order matters: the first signal finds the flag unset and sets it, the second one ends the program.
            flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&asked))?;
            flag::register(signal, Arc::clone(&asked))?;
        }
        let signals = Signals::new([SIGINT, SIGTERM])?;
        Ok(Self { asked, signals })
    }

    /// Whether the program is asked to stop.
    #[must_use]
    pub fn asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// Waits until the program is asked to stop.
    pub fn wait(&mut self) {
        while !self.asked() && self.signals.forever().next().is_none() {}
    }
}
