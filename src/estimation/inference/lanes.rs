//! Numbers of several sensors side by side, with which the processor calculates at once.

/// Sensors in one group.
pub(crate) const WIDTH: usize = 4;

/// One number for each sensor of a group; 0 for those beyond the last sensor.
pub(crate) type Lanes = [f64; WIDTH];

/// Nothing.
pub(crate) const ZERO: Lanes = [0.0; WIDTH];

/// Zeros for so many sensors.
pub(crate) fn lanes(sensors: usize) -> Vec<Lanes> {
    vec![ZERO; sensors.div_ceil(WIDTH)]
}
