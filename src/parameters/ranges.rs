//! Ranges and texts that several rows of the parameter table share.

use std::ops::RangeInclusive;

use super::parameter::{Admissible, list, or_zero, real, text};
use crate::sensors::MAX_SENSORS;

/// Most columns of a fleet that the viewer always shows in full: each has some thirty views and curves of its own.
pub const MAX_SELECTED_COLUMNS: usize = 8;

/// Lengths that a bar may have \[m\].
pub(super) const LENGTH_RANGE: RangeInclusive<f64> = 0.02..=100.0;
pub(super) const LENGTH: Admissible = real(*LENGTH_RANGE.start(), *LENGTH_RANGE.end());
/// A position in a plan: a site, not a country, so that millimetres remain in the pictures.
pub(super) const SITE: Admissible = real(-100_000.0, 100_000.0);
pub(super) const EXPONENT: Admissible = real(1.0, 50.0);
pub(super) const FROM_SECTION: &str = "from `section.name`";
const FROM_SUPPORTS: &str = "from the supports";
pub(super) const SUPPORT: Admissible = Admissible::Choice(&["built_in", "pinned", "semi_rigid"]);
pub(super) const TOP_SUPPORT: Admissible =
    Admissible::Choice(&["built_in", "pinned", "semi_rigid", "free"]);
pub(super) const SUPPORT_STIFFNESS: Admissible = or_zero(1.0, 1e13, "not semi-rigid");
pub(super) const HINGE_STIFFNESS: Admissible = or_zero(1.0, 1e13, FROM_SUPPORTS);
pub(super) const DIRECTORY: Admissible = text(1, 4096);
pub(super) const OPTIONAL_PATH: Admissible = text(0, 4096);
pub(super) const IDENTIFIER: Admissible = text(1, 255);

/// Most points of a force-crush curve that parameters give: a narrow object adds some to them.
const MAX_POINTS: usize = 16;
pub(super) const CURVE_CRUSH: Admissible = list(&real(1e-6, 20.0), 0, MAX_POINTS);
pub(super) const CURVE_FORCE: Admissible = list(&real(0.0, 1e9), 0, MAX_POINTS);
pub(super) const SENSOR_NAMES: Admissible = list(&Admissible::SensorName, 0, MAX_SENSORS);
pub(super) const UNLOADING_STIFFNESS: Admissible = or_zero(1.0, 1e12, "not given");
pub(super) const SELECTED_COLUMNS: Admissible = list(&IDENTIFIER, 0, MAX_SELECTED_COLUMNS);
pub(super) const VEHICLE_MASS: Admissible = real(1e-3, 1e6);
pub(super) const SLACK: Admissible = real(0.0, 10.0);
/// Of an effective length: a column held by several storeys of bracing has less than 0.5, one above a soft joint more than 2.
pub(super) const BUCKLING_FACTOR: Admissible = or_zero(0.05, 20.0, FROM_SUPPORTS);
pub(super) const ALARM_ACTION: Admissible =
    Admissible::Choice(&["off", "inspect", "restrict", "shore", "evacuate"]);
pub(super) const ORIGINS: Admissible = list(&text(1, 256), 0, 16);
