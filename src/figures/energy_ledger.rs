//! The energy ledger as a stack over time.

use super::chart::{Curve, Mark, TimeChart};
use super::page::{Drawn, Stroke, colour};
use super::response_history::ResponseHistory;
use super::units::Unit;
use crate::column::Sample;

/// The entries of the stack from the bottom: dissipated energy is below stored energy.
type LedgerEntry = (&'static str, plotters::style::RGBColor, fn(&Sample) -> f64);
const LEDGER_ENTRIES: [LedgerEntry; 7] = [
    ("lost in impact impulses", colour::IMPACT_LOSS, |sample| {
        sample.impact_loss
    }),
    ("plastic work", colour::PLASTIC, |sample| {
        sample.plastic_work
    }),
    ("crush of the vehicle", colour::CRUSH, |sample| {
        sample.vehicle.dissipated.iter().sum()
    }),
    ("damping", colour::DAMPING, |sample| sample.damping_work),
    ("elastic", colour::ELASTIC, |sample| sample.elastic_energy),
    (
        "elastic in the vehicle",
        colour::VEHICLE_ELASTIC,
        |sample| sample.vehicle.elastic_energy,
    ),
    ("kinetic", colour::KINETIC, |sample| sample.kinetic_energy),
];

/// The energy ledger: at every instant the stack of all entries reaches the energy supplied until then.
///
/// The supplied energy is computed from the impactor's energy, the preload and the work of the load alone, so that it
/// meets the top of the stack only if the ledger closes.
pub(super) fn energy_ledger(response: &ResponseHistory<'_>) -> Drawn<String> {
    let report = response.report;
    let (first_load, preload) = response
        .samples
        .first()
        .map_or((0.0, 0.0), |first| (first.load_work, first.elastic_energy));
    let start = report.input_energy + preload;
    let supply = |sample: &Sample| start + (sample.load_work - first_load);
    let unit = Unit::energy(response.largest(|sample| [supply(sample), sample.kinetic_energy]));

    let mut sum: Vec<f64> = vec![0.0; response.samples.len()];
    let mut curves = Vec::new();
    for (name, colour, entry) in LEDGER_ENTRIES {
        if response.largest(|sample| [entry(sample)]) == 0.0 {
            continue;
        }
        let values = response.samples.iter().zip(&mut sum);
        let points = values
            .map(|(sample, sum)| {
                *sum += entry(sample);
                (sample.time, *sum)
            })
            .collect();
        let name = format!(
            "{name} {}",
            unit.show(response.samples.last().map_or(0.0, entry))
        );
        let stroke = Stroke::solid(colour, 0);
        curves.push(Curve {
            name,
            points,
            stroke,
            fill: Some(colour),
        });
    }
    // Each curve is filled down to zero; the highest is drawn first, so that the lower ones cover it.
    curves.reverse();
    let level = vec![(response.span().0, start), (response.span().1, start)];
    curves.push(Curve::line(
        "supplied at the start",
        level,
        Stroke::solid(colour::FAINT, 6),
    ));
    curves.push(Curve::line(
        "plus the work of the load since then",
        response.over_time(supply),
        Stroke::dashed(colour::INK, 10),
    ));
    let last = response.samples.last();
    let key = format!(
        "supplied: {} by the impactor, {} by the preload, {} by the load since then; largest residual {:.1e}",
        unit.show(report.input_energy),
        unit.show(preload),
        unit.show(last.map_or(0.0, |last| last.load_work - first_load)),
        report.ledger_residual,
    );
    TimeChart {
        title: "Energy ledger (values at the end)",
        lines: [response.title, &key],
        quantity: "energy",
        unit,
        span: response.span(),
        bands: Vec::new(),
        curves,
        marks: Vec::<Mark>::new(),
        arrows: Vec::new(),
        keys: Vec::new(),
        events: response.events(),
    }
    .draw()
}
