//! The viewer of a node, as configured by the parameters `viewer.*`.

use std::sync::Arc;

use crate::live::{LiveHandle, LiveOptions, MeasurementQueue};
use crate::parameters::{Parameters, ViewerMode};

#[cfg(feature = "viewer")]
use crate::viewer::{LiveViewer, ViewerError, output_queue};

/// Name of the output queue to the viewer.
pub(super) const QUEUE: &str = "viewer";

/// The viewer of a node, if there is one.
#[derive(Default)]
pub(super) struct NodeViewer {
    #[cfg(feature = "viewer")]
    viewer: Option<LiveViewer>,
}

impl NodeViewer {
    /// Stops within a second, even if the viewer does not respond.
    pub fn stop(self) {
        #[cfg(feature = "viewer")]
        if let Some(viewer) = self.viewer {
            viewer.stop();
        }
    }
}

/// The queue of measurements; with a viewer one that remembers the newest of them, which the viewer shows.
pub(super) fn measurement_queue(parameters: &Parameters) -> MeasurementQueue {
    let is_shown = cfg!(feature = "viewer") && parameters.settings().viewer.mode != ViewerMode::Off;
    match is_shown {
        true => MeasurementQueue::remembering(),
        false => MeasurementQueue::new(),
    }
}

/// Adds the queue to the viewer to the outputs of the twin, if the parameters enable the viewer.
pub(super) fn add_queue(parameters: &Parameters, options: &mut LiveOptions) {
    if parameters.settings().viewer.mode == ViewerMode::Off {
        return;
    }
    #[cfg(feature = "viewer")]
    options.outputs.push(output_queue());
    #[cfg(not(feature = "viewer"))]
    {
        let _ = options;
        tracing::warn!(
            "viewer.mode has no effect, because this program was built without the feature `viewer`"
        );
    }
}

/// Starts the viewer if its queue exists.
///
/// # Errors
/// The thread cannot be started.
#[cfg(feature = "viewer")]
pub(super) fn start(
    parameters: &Arc<Parameters>,
    handle: &LiveHandle,
    now: i64,
) -> std::io::Result<NodeViewer> {
    let Some(outputs) = handle.outputs(QUEUE) else {
        return Ok(NodeViewer::default());
    };
    let measured = handle.recent_measurements();
    match LiveViewer::start(parameters, outputs, measured, now, Arc::new(log)) {
        Ok(viewer) => Ok(NodeViewer { viewer }),
        Err(ViewerError::Thread(error)) => Err(error),
        Err(error) => Err(std::io::Error::other(error)),
    }
}

/// Does nothing without the feature `viewer`.
#[cfg(not(feature = "viewer"))]
pub(super) fn start(
    _parameters: &Arc<Parameters>,
    _handle: &LiveHandle,
    _now: i64,
) -> std::io::Result<NodeViewer> {
    Ok(NodeViewer::default())
}

#[cfg(feature = "viewer")]
fn log(severity: crate::twin::NoticeLevel, text: String) {
    use crate::twin::NoticeLevel::{Error, Info, Warning};
    match severity {
        Info => tracing::info!("viewer: {text}"),
        Warning => tracing::warn!("viewer: {text}"),
        Error => tracing::error!("viewer: {text}"),
    }
}

#[cfg(all(test, feature = "viewer"))]
mod tests {
    use super::*;

    #[test]
    fn the_viewer_reads_the_queue_of_this_name() {
        assert_eq!(output_queue().name, QUEUE);
    }
}
