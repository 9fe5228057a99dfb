//! Colours, one for each meaning, in the scene and in the plots.

use crate::column::{HINGES, HingeState};

/// Red, green, blue, each 0 to 255.
pub type Rgb = [u8; 3];

/// Steel at utilisation 0.
pub const STEEL: Rgb = [122, 134, 148];
/// Steel at utilisation 0.5.
const HALF: Rgb = [240, 196, 60];
/// Steel at utilisation 1.
const YIELD: Rgb = [222, 40, 28];

/// Hinge that has never yielded.
pub const ELASTIC: Rgb = [64, 184, 96];
/// Hinge that is yielding.
pub const PLASTIC: Rgb = [235, 52, 40];
/// Hinge that has yielded and is elastic again.
pub const UNLOADED: Rgb = [250, 160, 40];

/// The vehicle and its curves.
pub const IMPACTOR: Rgb = [70, 130, 220];
/// Edges of the vehicle.
pub const VEHICLE_EDGE: Rgb = [120, 175, 250];
/// The nose of the vehicle when all of it is crushed.
pub const CRUSHED: Rgb = [250, 140, 40];
/// The engine of a vehicle.
pub const ENGINE: Rgb = [200, 205, 215];
/// The second and the third mass of a vehicle.
pub const CARGO: [Rgb; 2] = [[205, 160, 90], [170, 190, 100]];
/// Wheels.
pub const WHEEL: Rgb = [40, 42, 48];
/// The road.
pub const ROAD: Rgb = [86, 90, 96];
/// Springs of a vehicle in the plots, front first.
pub const SPRING: [Rgb; 3] = [[250, 140, 40], [205, 160, 90], [170, 190, 100]];
/// Contact force.
pub const CONTACT: Rgb = [214, 84, 190];
/// Load and top.
pub const TOP: Rgb = [90, 200, 200];
/// Impact point.
pub const IMPACT_POINT: Rgb = [240, 240, 240];
/// The fibre beam at its peak.
pub const BEAM_PEAK: Rgb = [226, 240, 130];
/// The fibre beam at rest.
pub const BEAM_REST: Rgb = [150, 214, 60];
/// The undeformed column.
pub const GHOST: Rgb = [110, 116, 124];
/// Supports.
pub const SUPPORT: Rgb = [150, 150, 150];
/// Moments.
pub const MOMENT: Rgb = [176, 140, 240];
/// Bar a.
pub const BAR_A: Rgb = [120, 190, 255];
/// Bar b.
pub const BAR_B: Rgb = [255, 170, 90];
/// Yield surfaces.
pub const SURFACE: Rgb = [190, 190, 190];
/// Axes.
pub const AXIS: Rgb = [90, 90, 90];

/// Hinges in the plots, in the order of [`HINGE_PLACES`](crate::observables::HINGE_PLACES).
pub const HINGE: [Rgb; HINGES] = *[
    [120, 190, 255],
    [255, 170, 90],
    [90, 200, 200],
    [250, 110, 110],
    [220, 150, 220],
    [230, 220, 100],
]
.first_chunk()
.expect("a colour for each hinge");

/// Entries of the energy ledger, from the bottom of the stack.
pub const ENERGIES: [Rgb; 6] = [
    [214, 84, 190],
    [250, 140, 40],
    [150, 150, 150],
    [235, 70, 50],
    [90, 200, 120],
    [90, 150, 240],
];

/// Colour of a hinge by its state.
#[must_use]
pub fn of_state(state: HingeState) -> Rgb {
    match state {
        HingeState::Elastic => ELASTIC,
        HingeState::Plastic => PLASTIC,
        HingeState::Unloaded => UNLOADED,
    }
}

/// Colour of the steel: grey at utilisation 0, yellow at 0.5, red from 1 on.
#[must_use]
pub fn of_utilisation(utilisation: f64) -> Rgb {
    if utilisation <= 0.5 {
        mix(STEEL, HALF, 2.0 * utilisation)
    } else {
        mix(HALF, YIELD, 2.0 * utilisation - 1.0)
    }
}

/// Mixes `part` (0 to 1) of `other` into `one`.
#[must_use]
pub fn mix(one: Rgb, other: Rgb, part: f64) -> Rgb {
    let part = part.clamp(0.0, 1.0);
    let mut mixed = one;
    for (value, (from, to)) in mixed.iter_mut().zip(one.into_iter().zip(other)) {
        let (from, to) = (f64::from(from), f64::from(to));
        *value = (from + part * (to - from)).round() as u8; // lies between the two colours; NaN becomes 0
    }
    mixed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utilisation_has_its_colours() {
        assert_eq!(of_utilisation(0.0), STEEL);
        assert_eq!(of_utilisation(0.5), HALF);
        assert_eq!(of_utilisation(1.0), YIELD);
        assert_eq!(of_utilisation(1.2), YIELD);
        assert_eq!(of_utilisation(-0.1), STEEL);
    }
}
