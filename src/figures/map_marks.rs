//! Marks of a damage map: speed limits and vehicles of the catalogue, where an axis has them.

use crate::parameters::vehicle_catalogue;
use crate::study::{MapAxis, MapQuantity};

/// Usual speed limits of car parks, towns, country roads and motorways \[km/h\].
const SPEED_LIMITS: [f64; 7] = [10.0, 20.0, 30.0, 50.0, 80.0, 100.0, 130.0];
/// Metres per second for one kilometre per hour.
pub(super) const METRES_PER_SECOND: f64 = 1.0 / 3.6;
/// Least distance between two marks, as a part of the axis.
const LEAST_DISTANCE: f64 = 0.05;

/// A value of an axis, in its SI unit, and what stands there.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mark {
    pub value: f64,
    pub name: String,
}

/// What a reader compares an axis with: speed limits along a velocity, vehicles of the catalogue along a mass; the lowest first.
/// Marks that would be closer than a twentieth of the axis to the one before are left out.
pub(super) fn marks(axis: &MapAxis) -> Vec<Mark> {
    let Some([from, to]) = axis.ends() else {
        return Vec::new();
    };
    let mut marks: Vec<Mark> = match axis.quantity() {
        MapQuantity::Velocity => SPEED_LIMITS
            .into_iter()
            .map(|limit| Mark {
                value: limit * METRES_PER_SECOND,
                name: format!("{limit} km/h"),
            })
            .collect(),
        MapQuantity::Mass => vehicle_catalogue()
            .iter()
            .map(|vehicle| Mark {
                value: vehicle.masses.value.kg.iter().sum(),
                name: vehicle.name.clone(),
            })
            .filter(|mark| mark.value > 0.0)
            .collect(),
        _ => Vec::new(),
    };
    marks.retain(|mark| (from..=to).contains(&mark.value));
    marks.sort_by(|a, b| a.value.total_cmp(&b.value));
    let least = LEAST_DISTANCE * (to - from);
    let mut last = f64::NEG_INFINITY;
    marks.retain(|mark| {
        let is_apart = mark.value - last >= least;
        if is_apart {
            last = mark.value;
        }
        is_apart
    });
    marks
}
