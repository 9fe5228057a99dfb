//! The shape of the column before the impact, at its peak displacement and at rest.

use super::chart::Mark;
use super::page::{Drawn, Stroke, colour};
use super::path_chart::{PathAxis, PathChart, PathLine};
use super::response_history::ResponseHistory;
use super::units::{Unit, significant};

/// Draws both straight bars over the height of the column; displacements are exaggerated by the scale of the axes.
pub(super) fn deformed_shape(response: &ResponseHistory<'_>) -> Drawn<String> {
    let report = response.report;
    let (below, above) = (response.lengths.below, response.lengths.above);
    // Above a free top's impact point the column goes on straight, as it leans there.
    let shape = |v1: f64, u1: f64, u2: f64, lean: f64| {
        let height = below - u1;
        let top = match response.lengths.top_is_free {
            true => (v1 + above * lean.sin(), height + above * lean.cos()),
            false => (0.0, below + above - u2),
        };
        vec![(0.0, 0.0), (v1, height), top]
    };
    let undeformed = shape(0.0, 0.0, 0.0, 0.0);
    let mut paths = vec![PathLine::new(
        "undeformed",
        undeformed,
        Stroke::dashed(colour::FAINT, 8),
    )];
    let mut marks = Vec::new();
    let unit = Unit::length(report.max_v1);
    let highest = response
        .samples
        .iter()
        .filter(|sample| sample.v1.is_finite())
        .max_by(|one, other| one.v1.total_cmp(&other.v1));
    if let Some(peak) = highest {
        paths.push(PathLine::new(
            format!("at the peak, {}", response.time_unit().show(peak.time)),
            shape(peak.v1, peak.u1, peak.u2, peak.beta1),
            Stroke::solid(colour::IMPACT_POINT, 18),
        ));
        marks.push(Mark {
            time: peak.v1,
            value: below - peak.u1,
            colour: colour::IMPACT_POINT,
            text: Some(unit.show(report.max_v1)),
        });
    }
    let last = response.samples.last();
    let residual = report.residual_v1.zip(report.residual_u2).zip(last);
    if let Some(((v1, u2), last)) = residual {
        paths.push(PathLine::new(
            format!("at rest, {}", unit.show(v1)),
            shape(v1, last.u1, u2, v1.atan2(below - last.u1)),
            Stroke::solid(colour::IMPACTOR, 12),
        ));
    }
    let scale = format!(
        "column {} m high, hit {} m above its base; horizontal and vertical scales differ",
        significant(below + above, 4),
        significant(below, 4),
    );
    PathChart {
        title: "Shape of the column",
        lines: [response.title, &scale],
        x: PathAxis {
            name: "transverse displacement, in the vehicle's direction",
            unit,
            includes: &[0.0],
        },
        y: PathAxis {
            name: "height above the base",
            unit: Unit {
                symbol: "m",
                per_si: 1.0,
            },
            includes: &[0.0],
        },
        paths,
        marks,
        keys: Vec::new(),
    }
    .draw()
}
