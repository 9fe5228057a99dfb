//! The energy ledger as a stack over time.

use plotters::style::RGBColor;

use super::chart::{Curve, TimeChart};
use super::page::{Drawn, Stroke, colour};
use super::response_history::ResponseHistory;
use super::units::Unit;
use crate::column::Sample;
use crate::observables::{
    CRUSH_WORK, DAMPING_WORK, ELASTIC_ENERGY, IMPACT_LOSS, KINETIC_ENERGY, Observable,
    PLASTIC_WORK, SPRING_ENERGY,
};

/// The entries of the stack from the bottom: dissipated energy is below stored energy.
const LEDGER_ENTRIES: [(Observable, RGBColor); 7] = [
    (IMPACT_LOSS, colour::IMPACT_LOSS),
    (PLASTIC_WORK, colour::PLASTIC),
    (CRUSH_WORK, colour::CRUSH),
    (DAMPING_WORK, colour::DAMPING),
    (ELASTIC_ENERGY, colour::ELASTIC),
    (SPRING_ENERGY, colour::VEHICLE_ELASTIC),
    (KINETIC_ENERGY, colour::KINETIC),
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
    let supplied = response.over_time(supply);
    let finite = supplied
        .iter()
        .map(|point| point.1.abs())
        .filter(|it| it.is_finite());
    let unit = Unit::energy(finite.fold(response.largest(&[KINETIC_ENERGY]), f64::max));

    let mut sum: Vec<f64> = vec![0.0; response.samples.len()];
    let mut curves = Vec::new();
    for (entry, colour) in LEDGER_ENTRIES {
        if response.largest(&[entry]) == 0.0 {
            continue;
        }
        let values = response.samples.iter().zip(&mut sum);
        let points = values
            .map(|(sample, sum)| {
                *sum += entry.value(sample, 0);
                (sample.time, *sum)
            })
            .collect();
        let name = format!(
            "{} {}",
            entry.in_figures(0),
            unit.show(
                response
                    .samples
                    .last()
                    .map_or(0.0, |last| entry.value(last, 0))
            )
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
        supplied,
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
        curves,
        ..response.chart("Energy ledger (values at the end)", &key, "energy", unit)
    }
    .draw()
}
