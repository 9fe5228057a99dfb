//! A column that sways, as in an earthquake or a storm, and was taken for one that is struck.
//!
//! The first swing of a sway is that of a column which a soft vehicle pushes. A vehicle does not pull, though: once it has left the
//! column, or been crushed, the column vibrates about its position of rest, which is on the side to which it was pushed. A sway
//! takes it to the other side, and for longer than a vibration does.

use std::collections::VecDeque;

use crate::sensors::{Quantity, Sensor};

/// Readings are averaged over this time, or one sample of a slower sensor \[s\].
const CELL: f64 = 1e-3;

/// Means over at least this time, and over [`PERIODS`] of the column, decide \[s\].
const LEAST_WINDOW: f64 = 25e-3;

/// A mean over two whole periods contains nothing of a vibration; one that is half a period off contains less than a fifth of its
/// amplitude, which is at most the largest reading.
const PERIODS: f64 = 2.0;

/// Share of the largest reading that such a mean has on the other side if the column sways: more than a vibration can leave in it, also
/// where its period is half as long again as by formula.
const OTHER_SIDE: f64 = 0.3;

/// A sensor has moved if it has read so many standard deviations of the noise.
const OPENING: f64 = 8.0;

/// A displacement that changes towards the other side by more than this share of the largest one from one cell to the next is that of a
/// sensor that came loose: a sway of 10 Hz changes by 0.06 of it in 1 ms.
const TORN: f64 = 0.5;

/// A sensor whose readings come later than this after those of the others is not waited for \[s\], as estimates do not wait for it.
const MAX_WAIT: f64 = 50e-3;

/// Looks for a sway in the readings since a detected contact.
#[derive(Debug, Clone)]
pub(crate) struct Sway {
    contact: f64,
    channels: Vec<Channel>,
    /// When it was found \[s\].
    found: Option<f64>,
}

#[derive(Debug, Clone)]
struct Channel {
    quantity: Quantity,
    zero: f64,
    /// Of a single reading.
    noise: f64,
    /// Length of a cell \[s\], and cells of a window.
    cell: f64,
    window: usize,
    number: i64,
    sum: f64,
    count: f64,
    /// The means of the last cells, without a gap.
    recent: VecDeque<f64>,
    /// The mean with the largest magnitude so far.
    largest: f64,
    /// The largest changes from one cell to the next, downwards and upwards.
    steps: [f64; 2],
    has_moved: bool,
    /// When it was on the other side for the first time \[s after contact\].
    crossed_at: Option<f64>,
    /// The last reading \[s after contact\].
    last: f64,
}

impl Sway {
    /// For a contact at `contact` \[s\] of a column with this period \[s\], and sensors with these readings at rest.
    pub fn new(sensors: &[Sensor], zeros: &[(f64, f64)], contact: f64, period: f64) -> Self {
        let window = LEAST_WINDOW.max(PERIODS * period);
        let channel = |(sensor, &(zero, _)): (&Sensor, &(f64, f64))| {
            let cell = CELL.max(1.0 / sensor.rate);
            Channel {
                quantity: sensor.quantity,
                zero,
                noise: sensor.noise,
                cell,
                window: (window / cell).ceil() as usize,
                number: i64::MIN,
                sum: 0.0,
                count: 0.0,
                recent: VecDeque::new(),
                largest: 0.0,
                steps: [0.0; 2],
                has_moved: false,
                crossed_at: None,
                last: 0.0,
            }
        };
        Self {
            contact,
            channels: sensors.iter().zip(zeros).map(channel).collect(),
            found: None,
        }
    }

    /// Takes a reading of a sensor, in the order of time. Those before the contact do not count.
    pub fn push(&mut self, sensor: usize, time: f64, value: f64) {
        let Some(channel) = self.channels.get_mut(sensor) else {
            return;
        };
        if self.found.is_some() || time < self.contact || !value.is_finite() {
            return;
        }
        channel.push(time - self.contact, value);
        if self.is_shared() && !self.is_awaited() {
            self.found = Some(time);
        }
    }

    /// Whether readings that are on their way may still show that a sensor had moved, and not to the other side, when others were
    /// there.
    fn is_awaited(&self) -> bool {
        let counted = || self.channels.iter().filter(|it| it.counts());
        let newest = counted().map(|it| it.last).fold(0.0, f64::max);
        let crossed = counted().filter_map(|it| it.crossed_at);
        let crossed = crossed.fold(0.0, f64::max);
        counted().any(|it| it.last < crossed && newest - it.last <= MAX_WAIT)
    }

    /// Whether a sensor of displacement was on the other side, and every other one that has moved. A permanent bend leaves moments of
    /// either sign in the column, so that strains alone do not decide; and a laser that came loose in the impact stands alone.
    fn is_shared(&self) -> bool {
        let mut moved = self.channels.iter().filter(|it| it.has_moved);
        let is_displacement = |it: &Channel| it.quantity == Quantity::Displacement;
        let has_swayed = |it: &Channel| is_displacement(it) && it.crossed_at.is_some();
        self.channels.iter().any(has_swayed) && moved.all(|it| it.crossed_at.is_some())
    }

    /// When it was certain that the column sways \[s\].
    pub fn found(&self) -> Option<f64> {
        self.found
    }
}

impl Channel {
    /// Whether it shows on which side the column is.
    fn counts(&self) -> bool {
        self.quantity.shows_bending() && self.quantity.is_level()
    }

    /// Takes a reading at a time after the contact \[s\].
    fn push(&mut self, time: f64, value: f64) {
        if !self.counts() {
            return;
        }
        self.last = time;
        let number = (time / self.cell).floor() as i64;
        if number != self.number {
            self.complete();
            if number != self.number.saturating_add(1) {
                self.recent.clear();
            }
            (self.number, self.sum, self.count) = (number, 0.0, 0.0);
        }
        self.sum += value - self.zero;
        self.count += 1.0;
    }

    fn complete(&mut self) {
        if self.count == 0.0 {
            return;
        }
        let mean = self.sum / self.count;
        if let Some(before) = self.recent.back() {
            let step = mean - before;
            self.steps = [self.steps[0].min(step), self.steps[1].max(step)];
        }
        if mean.abs() > self.largest.abs() {
            self.largest = mean;
        }
        self.has_moved |= mean.abs() > OPENING * self.noise / self.count.sqrt();
        self.recent.push_back(mean);
        if self.recent.len() < self.window {
            return;
        }
        let level = self.recent.iter().sum::<f64>() / self.recent.len() as f64;
        self.recent.pop_front();
        let side = self.largest.signum();
        let away = self.steps.map(|step| -step * side);
        let is_torn = self.quantity == Quantity::Displacement
            && away
                .into_iter()
                .any(|step| step > TORN * self.largest.abs());
        // A contact force has one direction only.
        let has_crossed = self.has_moved
            && !is_torn
            && self.quantity != Quantity::ContactForce
            && -level * side > OTHER_SIDE * self.largest.abs();
        if has_crossed && self.crossed_at.is_none() {
            self.crossed_at = Some(self.last);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::detection::detector::{Detection, Detector};
    use crate::numerics::Random;

    const PERIOD: f64 = 10e-3;

    fn sensor(quantity: Quantity, noise: f64) -> Sensor {
        Sensor {
            name: quantity.word().to_owned(),
            quantity,
            height: 1.0,
            range: 0.0,
            noise,
            bias: 0.0,
            gain_error: 0.0,
            rate: 1e4,
            bandwidth: 5e3,
            reversed: false,
            fibre: 0.1,
        }
    }

    /// When readings with these sizes, over the time since contact, are a sway.
    fn found(of: [&dyn Fn(f64) -> f64; 2]) -> Option<f64> {
        let sensors = [
            sensor(Quantity::Displacement, 1e-4),
            sensor(Quantity::BendingStrain, 1e-6),
        ];
        let mut sway = Sway::new(&sensors, &[(0.0, 0.0); 2], 0.0, PERIOD);
        for sample in 0..10_000 {
            let time = 1e-4 * f64::from(sample);
            for (index, reading) in of.iter().enumerate() {
                sway.push(index, time, reading(time));
            }
        }
        sway.found()
    }

    fn wave(frequency: f64, time: f64) -> f64 {
        (std::f64::consts::TAU * frequency * time).sin()
    }

    #[test]
    fn a_swing_to_the_other_side_is_a_sway() {
        for frequency in [1.5, 2.0, 5.0, 10.0] {
            let at = found([&|time| 5e-3 * wave(frequency, time), &|time| {
                -1e-4 * wave(frequency, time)
            }]);
            // After half a period, and until the largest reading of the other half.
            let at = at.expect("a sway") * frequency;
            assert!((0.5..0.9).contains(&at), "{frequency} Hz: {at} periods");
        }
    }

    /// The ground shakes a structure of this frequency \[Hz\] at random from an instant on: whether that is taken for an impact, and
    /// whether it is found to be none as long as there would be estimates.
    fn shaken(frequency: f64, damping: f64, seed: u64) -> [bool; 2] {
        const STEP: f64 = 1e-4;
        let sensors = [
            sensor(Quantity::Displacement, 1e-4),
            sensor(Quantity::BendingStrain, 1e-6),
        ];
        let mut random = Random::new(seed);
        let circular = std::f64::consts::TAU * frequency;
        let (mut detector, mut sway) = (Detector::new(&sensors), None::<Sway>);
        let (mut position, mut velocity, mut ground) = (0.0, 0.0, 0.0);
        for sample in 0..25_000 {
            let time = STEP * f64::from(sample);
            if sample >= 5_000 && sample % 100 == 0 {
                ground = 6e-3 * circular * circular * random.normal();
            }
            let pull = circular * circular * position + 2.0 * damping * circular * velocity;
            velocity += STEP * (ground - pull);
            position += STEP * velocity;
            for (index, size) in [position, 0.04 * position].into_iter().enumerate() {
                let reading = size + sensors[index].noise * random.normal();
                match &mut sway {
                    Some(sway) => sway.push(index, time, reading),
                    None => {
                        let detected = detector.push(index, time, reading);
                        let begun =
                            |it: Detection| Sway::new(&sensors, &it.zeros, it.contact.time, PERIOD);
                        sway = detected.map(begun);
                    }
                }
            }
        }
        let found = sway.as_ref().and_then(|it| Some(it.found()? - it.contact));
        [sway.is_some(), found.is_some_and(|after| after < 0.5)]
    }

    #[test]
    fn most_random_shaking_that_is_taken_for_an_impact_is_found_to_be_none() {
        let (mut taken, mut given_up) = (0, 0);
        for (frequency, damping) in [(1.2, 0.05), (2.0, 0.05), (5.0, 0.05), (3.0, 0.3)] {
            for seed in 0..20 {
                let [is_taken, is_given_up] = shaken(frequency, damping, seed);
                taken += u32::from(is_taken);
                given_up += u32::from(is_given_up);
            }
        }
        println!("{given_up} of {taken} were given up");
        assert!(
            taken > 40 && 10 * given_up > 7 * taken,
            "{given_up} of {taken}"
        );
    }

    #[test]
    fn a_sensor_whose_readings_come_late_contradicts_a_sway() {
        let sensors = [
            sensor(Quantity::Displacement, 1e-4),
            sensor(Quantity::BendingStrain, 1e-6),
        ];
        let mut sway = Sway::new(&sensors, &[(0.0, 0.0); 2], 0.0, PERIOD);
        // The displacement is certain to be on the other side at 0.12 s; the gauge has moved by then, and never swings back.
        for sample in 0..3_000 {
            let time = 1e-4 * f64::from(sample);
            sway.push(0, time, 5e-3 * wave(5.0, time));
            let late = time - 20e-3;
            let strain = if late < 0.11 { 0.0 } else { 1e-4 };
            sway.push(1, late, strain);
        }
        assert_eq!(sway.found(), None);
    }

    #[test]
    fn a_struck_column_that_vibrates_is_no_sway() {
        // It springs back and vibrates about its rest with its period, with half of it, and with one that is longer than known, as on
        // hinges instead of clamps.
        for period in [0.5, 1.0, 1.5, 2.0, 2.27].map(|it| it * PERIOD) {
            let swing = |time: f64| wave(1.0 / period, time) * (-time / 0.3).exp();
            assert_eq!(found([&|t| 1e-3 * swing(t), &|t| 1e-4 * swing(t)]), None);
        }
        // Its gauge shows the moment that a permanent bend has left.
        let bent = |time: f64| if time < 0.1 { 0.2 * time } else { 0.015 };
        let left = |time: f64| if time < 0.05 { 1e-4 } else { -0.8e-4 };
        assert_eq!(found([&bent, &left]), None);
        // Its laser came loose, and reads the other end of its range.
        let loose = |time: f64| if time < 0.02 { 0.5 * time } else { -0.006 };
        assert_eq!(found([&loose, &|time| (2e-2 * time).min(1e-3)]), None);
        // Also if its gauge shows the moment that a permanent bend has left, or nothing.
        assert_eq!(found([&loose, &left]), None);
        assert_eq!(found([&loose, &|_| 0.0]), None);
    }
}
