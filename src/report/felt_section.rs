//! The section about the impacts of a recording that the sensors have felt.

use std::sync::Arc;

use maud::{Markup, PreEscaped, html};

use super::estimate_section;
use crate::figures::{FigureError, TimedEstimate, forecast_svg};
use crate::senses::EstimateRecord;

/// The section; empty without such impacts. Each has its estimates in their order.
pub(super) fn markup(felt: &[Vec<Arc<EstimateRecord>>]) -> Result<Markup, FigureError> {
    let impacts: Result<Vec<Markup>, FigureError> = felt.iter().map(|it| impact(it)).collect();
    let impacts = impacts?;
    Ok(html! {
        @if !impacts.is_empty() {
            section id="felt" {
                h2 { "Felt by the sensors" }
                p {
                    "What the sensors say about an impact, beside the event or the estimate that the twin has followed. The journal \
                     of the recording holds these estimates."
                }
                @for impact in &impacts { (impact) }
            }
        }
    })
}

fn impact(records: &[Arc<EstimateRecord>]) -> Result<Markup, FigureError> {
    let Some(last) = records.last() else {
        return Ok(html! {});
    };
    // The times of an estimate have the origin of its own record.
    let estimates: Vec<_> = records
        .iter()
        .flat_map(|it| TimedEstimate::all([&it.estimate], it.detection.contact.time))
        .collect();
    let title = format!("impact \"{}\", felt by the sensors", last.event_id);
    let drawing = forecast_svg(&title, &estimates)?;
    let caption = "Largest and remaining displacement of the impact point, over the time up to which data were used.";
    Ok(html! {
        h3 { "Impact " (last.event_id) }
        @if !last.is_final {
            p.fault { "The recording ends before the final estimate, or another impact came before it." }
        }
        (estimate_section::verdict(&estimates))
        (estimate_section::content(&estimates))
        figure role="img" aria-label=(caption) {
            (PreEscaped(drawing))
            figcaption { (caption) }
        }
    })
}
