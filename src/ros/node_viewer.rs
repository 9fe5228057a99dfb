//! The viewer of a node, as configured by the parameters `viewer.*`.

use std::sync::Arc;

use crate::live::{FleetHandle, LiveHandle, LiveOptions, MeasurementQueue, OutputQueue};
use crate::parameters::{FleetColumns, Parameters, ViewerMode};

#[cfg(feature = "viewer")]
use crate::viewer::{LiveViewer, ShownFleet, ViewerError, fleet_output_queue, output_queue};

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
        false => MeasurementQueue::default(),
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
        warn_of_absence();
    }
}

#[cfg(not(feature = "viewer"))]
fn warn_of_absence() {
    tracing::warn!(
        "viewer.mode has no effect, because this program was built without the feature `viewer`"
    );
}

/// The queues to the viewer of a fleet: one, if the parameters of its node enable the viewer.
pub(super) fn fleet_queues(fleet: &FleetColumns) -> Vec<OutputQueue> {
    if fleet.node.settings().viewer.mode == ViewerMode::Off {
        return Vec::new();
    }
    #[cfg(feature = "viewer")]
    return vec![fleet_output_queue(fleet.columns.len())];
    #[cfg(not(feature = "viewer"))]
    {
        warn_of_absence();
        Vec::new()
    }
}

/// Starts the viewer of a fleet, which shows the columns with the indices `selected` in full, if its queue exists.
///
/// # Errors
/// The thread cannot be started.
#[cfg(feature = "viewer")]
pub(super) fn start_of_fleet(
    fleet: &FleetColumns,
    selected: Vec<u32>,
    handle: &FleetHandle,
    now: i64,
) -> std::io::Result<NodeViewer> {
    let Some(outputs) = handle.outputs(QUEUE) else {
        return Ok(NodeViewer::default());
    };
    let shown = ShownFleet::new(&fleet.columns, selected);
    if let Some(text) = shown.plan.about_unplaced() {
        tracing::info!("viewer: {text}");
    }
    started(LiveViewer::start_of_fleet(
        &fleet.node,
        shown,
        outputs,
        now,
        Arc::new(log),
    ))
}

/// Does nothing without the feature `viewer`.
#[cfg(not(feature = "viewer"))]
pub(super) fn start_of_fleet(
    _fleet: &FleetColumns,
    _selected: Vec<u32>,
    _handle: &FleetHandle,
    _now: i64,
) -> std::io::Result<NodeViewer> {
    Ok(NodeViewer::default())
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
    let viewer = LiveViewer::start(parameters, outputs, measured, now, Arc::new(log));
    started(viewer)
}

#[cfg(feature = "viewer")]
fn started(viewer: Result<Option<LiveViewer>, ViewerError>) -> std::io::Result<NodeViewer> {
    match viewer {
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
fn log(level: crate::twin::NoticeLevel, text: String) {
    super::notice_log::log(level, &format!("viewer: {text}"));
}

#[cfg(all(test, feature = "viewer"))]
mod tests {
    use super::*;

    #[test]
    fn the_viewer_reads_the_queue_of_this_name() {
        assert_eq!(output_queue().name, QUEUE);
        assert_eq!(fleet_output_queue(1).name, QUEUE);
    }
}
