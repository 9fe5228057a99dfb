//! A study on a terminal: progress while it runs, and Ctrl-C.

use std::io::{IsTerminal, stderr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use column_twin::study::Batch;

/// Time between two looks at the progress and at the signals.
const PERIOD: Duration = Duration::from_millis(20);

/// SIGINT and SIGTERM while a study runs: the first one interrupts it, the second one ends the program. When the study is
/// over, the first one ends the program, too.
pub(super) struct Interruption {
    asked: Arc<AtomicBool>,
    over: Arc<AtomicBool>,
}

impl Interruption {
    /// Installs the handlers. A signal for which there can be none ends the program, as it would without.
    pub fn listen() -> Self {
        let asked = Arc::new(AtomicBool::new(false));
        let over = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // The order matters: the first signal finds the flag unset and sets it, the second one ends the program.
            let _ = flag::register_conditional_default(signal, Arc::clone(&over));
            let _ = flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&asked));
            let _ = flag::register(signal, Arc::clone(&asked));
        }
        Self { asked, over }
    }

    /// Runs a study, whose batch a signal interrupts. On a terminal, a bar shows the progress towards `total` of `what`, unless
    /// it is 0.
    pub fn watch<T>(&self, batch: &Batch, total: u64, what: &str, study: impl FnOnce() -> T) -> T {
        let ended = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let watch = || {
                let bar = (total > 0 && stderr().is_terminal()).then(|| progress_bar(total, what));
                while !ended.load(Ordering::Acquire) {
                    if self.asked.load(Ordering::Relaxed) {
                        batch.interrupt();
                    }
                    if let Some(bar) = &bar {
                        bar.set_position(batch.done());
                    }
                    std::thread::park_timeout(PERIOD);
                }
                if let Some(bar) = bar {
                    bar.finish_and_clear();
                }
            };
            // Without the thread there is neither progress nor an orderly end after Ctrl-C.
            let watcher = std::thread::Builder::new().name("progress".into());
            let watcher = watcher.spawn_scoped(scope, watch);
            let result = study();
            ended.store(true, Ordering::Release);
            if let Ok(watcher) = watcher {
                watcher.thread().unpark();
            }
            result
        })
    }
}

impl Drop for Interruption {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
    }
}

fn progress_bar(total: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
    let template = format!("{{bar:40}} {{pos}} of {{len}} {what}, {{per_sec}}, {{eta}} left");
    let style = ProgressStyle::with_template(&template);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
