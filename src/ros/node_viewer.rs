//! The viewer of a node, as configured by the parameters `viewer.*`.

use std::sync::Arc;

use crate::live::{FleetHandle, OutputQueue};
use crate::parameters::{FleetColumn, Parameters, ViewerMode};

#[cfg(feature = "viewer")]
use crate::viewer::{LiveViewer, Shown, ShownFleet, ViewerError, output_queue};

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

/// The queues to the viewer of so many columns: one, if the parameters of their node enable the viewer.
pub(super) fn queues(node: &Parameters, columns: usize) -> Vec<OutputQueue> {
    if node.settings().viewer.mode == ViewerMode::Off {
        return Vec::new();
    }
    #[cfg(feature = "viewer")]
    return vec![output_queue(columns)];
    #[cfg(not(feature = "viewer"))]
    {
        let _ = columns;
        tracing::warn!(
            "viewer.mode has no effect, because this program was built without the feature `viewer`"
        );
        Vec::new()
    }
}

/// Starts the viewer if its queue exists. It shows the column with the parameters of the node or, of a `fleet`, all columns in a plan
/// and those with these indices in full. Does nothing without the feature `viewer`.
///
/// # Errors
/// The thread cannot be started.
pub(super) fn start(
    node: &Arc<Parameters>,
    fleet: Option<(&[FleetColumn], Vec<u32>)>,
    handle: &FleetHandle,
    now: i64,
) -> std::io::Result<NodeViewer> {
    #[cfg(feature = "viewer")]
    if let Some(outputs) = handle.outputs(QUEUE) {
        let shown = match fleet {
            None => Shown::Column(Arc::clone(node)),
            Some((columns, selected)) => {
                let fleet = ShownFleet::new(columns, selected);
                if let Some(text) = fleet.plan.about_unplaced() {
                    tracing::info!("viewer: {text}");
                }
                Shown::Fleet(fleet)
            }
        };
        let measurements = handle.measurements().cloned();
        let viewer = LiveViewer::start(node, shown, outputs, measurements, now, Arc::new(log));
        return match viewer {
            Ok(viewer) => Ok(NodeViewer { viewer }),
            Err(ViewerError::Thread(error)) => Err(error),
            Err(error) => Err(std::io::Error::other(error)),
        };
    }
    let _ = (node, fleet, handle, now);
    Ok(NodeViewer::default())
}

#[cfg(feature = "viewer")]
fn log(level: crate::twin::NoticeLevel, text: String) {
    super::notice_log::log(level, &format!("viewer: {text}"));
}

#[cfg(all(test, feature = "viewer"))]
mod tests {
    use super::*;

    #[test]
    fn the_viewer_reads_the_queue_of_this_name() {
        assert_eq!(output_queue(1).name, QUEUE);
    }
}
