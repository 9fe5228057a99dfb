//! The viewer beside the node, as the parameters `viewer.*` say.

use std::sync::Arc;

use crate::live::{LiveHandle, LiveOptions};
use crate::parameters::{Parameters, ViewerMode};

#[cfg(feature = "viewer")]
use crate::viewer::{LiveViewer, ViewerError, output_queue};

/// Name of the queue of outputs to the viewer.
pub(super) const QUEUE: &str = "viewer";

/// A viewer that may be there.
#[derive(Default)]
pub(super) struct Pictures {
    #[cfg(feature = "viewer")]
    viewer: Option<LiveViewer>,
}

impl Pictures {
    /// Stops within a second, whatever the viewer does.
    pub fn stop(self) {
        #[cfg(feature = "viewer")]
        if let Some(viewer) = self.viewer {
            viewer.stop();
        }
    }
}

/// Adds the viewer's queue to those of the twin's outputs, where there is to be a viewer.
pub(super) fn ask_for_outputs(parameters: &Parameters, options: &mut LiveOptions) {
    if parameters.settings().viewer.mode == ViewerMode::Off {
        return;
    }
    #[cfg(feature = "viewer")]
    options.outputs.push(output_queue());
    #[cfg(not(feature = "viewer"))]
    {
        let _ = options;
        tracing::warn!(
            "viewer.mode has no effect: this program was built without the feature `viewer`"
        );
    }
}

/// Starts the viewer's thread, where there is to be one.
///
/// # Errors
/// There is no thread.
#[cfg(feature = "viewer")]
pub(super) fn start(
    parameters: &Arc<Parameters>,
    handle: &LiveHandle,
    now: i64,
) -> std::io::Result<Pictures> {
    let Some(outputs) = handle.outputs(QUEUE) else {
        return Ok(Pictures::default());
    };
    match LiveViewer::start(parameters, outputs, now, Arc::new(tell)) {
        Ok(viewer) => Ok(Pictures { viewer }),
        Err(ViewerError::Thread(error)) => Err(error),
        Err(error) => Err(std::io::Error::other(error)),
    }
}

/// There is none.
#[cfg(not(feature = "viewer"))]
pub(super) fn start(
    _parameters: &Arc<Parameters>,
    _handle: &LiveHandle,
    _now: i64,
) -> std::io::Result<Pictures> {
    Ok(Pictures::default())
}

#[cfg(feature = "viewer")]
fn tell(severity: crate::twin::Severity, text: String) {
    use crate::twin::Severity::{Error, Info, Warning};
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
    fn the_queue_has_its_name() {
        assert_eq!(output_queue().name, QUEUE);
    }
}
