//! The springs of the vehicle in a diagram of force over crush: their envelopes, paths and present positions.
//!
//! One unit of the diagram is 1 m across and 1 MN upwards, so that all vehicles have the same scale.

use rerun::{LineStrips2D, Points2D, Radius, RecordingStreamResult};

use super::branch::Branch;
use super::colour;
use super::rerun_types::color;
use crate::column::{Vehicle, VehicleSample};
use crate::shape::round_number;

/// Entity of the paths.
pub const PATH: &str = "force_crush/path";
/// Entity of the present positions.
pub const NOW: &str = "force_crush/now";
/// Entity of the envelopes.
const ENVELOPE: &str = "force_crush/envelope";
/// Entity of the axes.
const AXES: &str = "force_crush/axes";
/// Entity of the numbers at the axes.
const NUMBERS: &str = "force_crush/numbers";

/// Force per unit of the diagram \[N\].
const FORCE: f64 = 1e6;

/// Crush \[m\] and force \[MN\] that the diagram shows if the springs are not known.
const UNKNOWN: [f64; 2] = [1.0, 1.0];

/// Number of ticks of an axis, approximately.
const TICKS: f64 = 5.0;

/// The position of a spring in the diagram. The vertical axis of a view points down.
#[must_use]
pub fn point(vehicle: &VehicleSample, spring: usize) -> [f32; 2] {
    let crush = vehicle.crush[spring].max(0.0);
    [crush as f32, (-vehicle.force[spring] / FORCE) as f32]
}

/// Largest crush \[m\] and force \[MN\] of the envelopes.
#[must_use]
pub fn extent(vehicle: Option<&Vehicle>) -> [f64; 2] {
    let Some(vehicle) = vehicle else {
        return UNKNOWN;
    };
    let points = vehicle.springs().iter();
    let points = points.flat_map(|spring| spring.envelope.points());
    points.fold([0.0; 2], |[crush, force], point| {
        [crush.max(point[0]), force.max(point[1] / FORCE)]
    })
}

/// Writes envelopes, axes and styles.
///
/// # Errors
/// The stream rejects the data.
pub fn send_statics(stream: &Branch, vehicle: Option<&Vehicle>) -> RecordingStreamResult<()> {
    let springs = vehicle.map_or(&[][..], |it| it.springs());
    let envelopes = springs.iter().map(|spring| {
        let points = spring.envelope.points().iter();
        let points = points.map(|[crush, force]| [*crush as f32, (-force / FORCE) as f32]);
        std::iter::once([0.0; 2]).chain(points).collect::<Vec<_>>()
    });
    let envelopes = LineStrips2D::new(envelopes)
        .with_colors([color(colour::SURFACE)])
        .with_radii([Radius::new_ui_points(1.0)]);
    stream.log_static(ENVELOPE, &envelopes)?;

    let [crush, force] = extent(vehicle).map(|it| (1.08 * it) as f32);
    let mut lines = vec![
        vec![[0.0, 0.0], [crush, 0.0]],
        vec![[0.0, 0.0], [0.0, -force]],
    ];
    let mut numbers = Vec::new();
    let tick = 0.012 * crush.max(force);
    for crush in ticks(f64::from(crush)) {
        let x = crush as f32;
        lines.push(vec![[x, 0.0], [x, tick]]);
        numbers.push(([x, tick], format!("{crush} m")));
    }
    for force in ticks(f64::from(force)) {
        let y = -force as f32;
        lines.push(vec![[0.0, y], [-tick, y]]);
        numbers.push(([-0.09 * crush, y], format!("{:.0} kN", 1e3 * force)));
    }
    let axes = LineStrips2D::new(lines)
        .with_colors([color(colour::AXIS)])
        .with_radii([Radius::new_ui_points(0.7)]);
    stream.log_static(AXES, &axes)?;
    let texts = Points2D::new(numbers.iter().map(|(place, _)| *place))
        .with_labels(numbers.iter().map(|(_, text)| text.as_str()))
        .with_colors([color(colour::SURFACE)])
        .with_radii([Radius::new_ui_points(0.0)])
        .with_show_labels(true);
    stream.log_static(NUMBERS, &texts)?;

    let path = LineStrips2D::update_fields()
        .with_colors(colour::SPRING.map(color))
        .with_radii([Radius::new_ui_points(1.5)]);
    stream.log_static(PATH, &path)?;
    let now = Points2D::update_fields()
        .with_colors(colour::SPRING.map(color))
        .with_radii([Radius::new_ui_points(5.0)]);
    stream.log_static(NOW, &now)
}

/// Round numbers up to `end`, without 0.
fn ticks(end: f64) -> impl Iterator<Item = f64> {
    let step = round_number(end / TICKS);
    let count = (end / step).floor().max(0.0) as u32;
    // Rounded so that 3 times 0.1 is written as 0.3.
    (1..=count).map(move |tick| (f64::from(tick) * step * 1e6).round() / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::{CrushCurve, CrushSpring};

    #[test]
    fn the_diagram_holds_all_envelopes() {
        let spring = |points: &[[f64; 2]]| CrushSpring {
            envelope: CrushCurve::new(points).expect("a curve"),
            unloading_stiffness: 50e6,
            slack: 0.0,
        };
        let springs = [
            spring(&[[0.5, 1.5e6], [2.0, 1e6]]),
            spring(&[[0.2, 4e5], [3.0, 4e5]]),
        ];
        let vehicle = Vehicle::new(&[5500.0, 2500.0], &springs).expect("a vehicle");
        assert_eq!(extent(Some(&vehicle)), [3.0, 1.5]);
        assert_eq!(extent(None), UNKNOWN);
    }

    #[test]
    fn crush_points_right_and_force_up_and_an_open_spring_is_at_the_origin() {
        let vehicle = VehicleSample {
            masses: 2,
            crush: [0.25, -0.1, 0.0],
            force: [5e5, 0.0, 0.0],
            ..VehicleSample::default()
        };
        assert_eq!(point(&vehicle, 0), [0.25, -0.5]);
        assert_eq!(point(&vehicle, 1), [0.0, -0.0]);
    }

    #[test]
    fn ticks_are_round_numbers_within_the_axis() {
        let ticks = |end| ticks(end).collect::<Vec<_>>();
        for end in [0.05, 0.7, 1.08, 4.3, 120.0] {
            let ticks = ticks(end);
            assert!((2..=10).contains(&ticks.len()), "{end}: {ticks:?}");
            assert!(ticks.iter().all(|it| 0.0 < *it && *it <= end));
            assert!(
                ticks.iter().all(|it| it.to_string().len() <= 5),
                "{ticks:?}"
            );
        }
    }
}
