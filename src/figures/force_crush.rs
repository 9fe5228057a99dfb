//! The force of each spring of a deformable vehicle over its crush, with the envelope of the force.

use super::chart::Mark;
use super::page::{Drawn, Stroke, colour};
use super::path_chart::{PathAxis, PathChart, PathLine};
use super::response_history::ResponseHistory;
use super::units::Unit;
use crate::column::Vehicle;
use crate::observables::{CRUSH, OPEN_OR_CRUSHED, SPRING_FORCE};

/// Draws the path of every spring and its envelope; `None` for a rigid vehicle.
pub(super) fn force_crush(response: &ResponseHistory<'_>) -> Option<Drawn<String>> {
    let vehicle = response.vehicle?;
    Some(draw(response, &vehicle))
}

fn draw(response: &ResponseHistory<'_>, vehicle: &Vehicle) -> Drawn<String> {
    let springs = vehicle.springs();
    let crushed = response.report.vehicle;
    let largest_crush = crushed.max_crush.iter().fold(0.0_f64, |a, b| a.max(*b));
    let largest_force = response.largest(&[SPRING_FORCE]);
    // Where nothing was crushed, the figure shows the beginning of the envelope.
    let shown = match largest_crush > 0.0 {
        true => 1.15 * largest_crush,
        false => springs[0].envelope.points()[0][0],
    };
    let length = Unit::length(shown);
    let energy = Unit::energy(crushed.dissipated.iter().sum());
    let mut paths = Vec::new();
    let mut marks = Vec::new();
    let mut facts = Vec::new();
    for (number, spring) in springs.iter().enumerate() {
        let stroke = Stroke::dashed(colour::SPRINGS[number], 8);
        let name = match number {
            0 => "spring 1 (front)".to_owned(),
            _ => format!("spring {} (behind mass {number})", number + 1),
        };
        let corners = spring.envelope.points().iter().map(|point| point[0]);
        let abscissae = std::iter::once(0.0)
            .chain(corners.filter(|crush| *crush < shown))
            .chain([shown]);
        paths.push(PathLine::new(
            format!("envelope of {name}"),
            abscissae
                .map(|crush| (crush, spring.envelope.force(crush)))
                .collect(),
            stroke,
        ));
        let path = response.samples.iter().map(|sample| {
            [OPEN_OR_CRUSHED, SPRING_FORCE]
                .map(|it| it.value(sample, number))
                .into()
        });
        paths.push(PathLine::new(
            name,
            path.collect(),
            Stroke::solid(colour::SPRINGS[number], 14),
        ));
        marks.push(Mark {
            time: crushed.permanent_crush[number],
            value: 0.0,
            colour: colour::SPRINGS[number],
            text: None,
        });
        facts.push(format!(
            "spring {}: largest crush {}, permanent {}, {} absorbed",
            number + 1,
            length.show(crushed.max_crush[number]),
            length.show(crushed.permanent_crush[number]),
            energy.show(crushed.dissipated[number]),
        ));
    }
    PathChart {
        title: "Crush force of the vehicle (ring: permanent crush)",
        lines: [response.title, &facts.join("; ")],
        x: PathAxis {
            name: &CRUSH.in_figures(0),
            unit: length,
            includes: &[0.0],
        },
        y: PathAxis {
            name: &SPRING_FORCE.in_figures(0),
            unit: Unit::force(largest_force),
            includes: &[0.0],
        },
        paths,
        marks,
        keys: Vec::new(),
    }
    .draw()
}
