//! A second impact while the column still moves from the first one, which is told although it cannot be estimated.

use crate::sensors::Sensor;

/// Length of the windows that are compared \[s\].
const WINDOW: f64 = 25e-3;

/// Windows before the current one in which the column has shown how far it still moves.
const WINDOWS: usize = 3;

/// After the first impact \[s\]: what comes sooner is its own, such as a vehicle that is struck back and strikes again.
const SOONEST: f64 = 0.15;

/// A blow moves the reading by so many times what it moved before.
const GROWTH: f64 = 3.0;

/// A blow moves the reading by so many standard deviations of the noise.
const OPENING: f64 = 8.0;

/// Blows that several sensors show are one within this time \[s\].
const COMMON: f64 = 60e-3;

/// Looks for a second blow in the readings that follow a detected impact.
#[derive(Debug, Clone)]
pub(crate) struct SecondBlow {
    first: f64,
    channels: Vec<Channel>,
    /// When it came \[s\].
    found: Option<f64>,
}

#[derive(Debug, Clone)]
struct Channel {
    /// Of all sensors but those that react to something else than a motion.
    counts: bool,
    noise: f64,
    /// Reading at rest before the first impact; `None` of a sensor that returns to it while the column keeps its shape.
    at_rest: Option<f64>,
    window: i64,
    sum: f64,
    count: f64,
    /// Mean of the window before.
    base: f64,
    /// Largest distance from the mean before, in the current window and in those before it.
    largest: [f64; 1 + WINDOWS],
    /// Windows that are complete.
    complete: usize,
    blow: Option<f64>,
}

impl SecondBlow {
    /// After an impact at `first` \[s\], seen by these sensors with these standard deviations of their noise; `zeros` are their readings at
    /// rest with their standard deviations.
    pub fn new(sensors: &[Sensor], zeros: &[(f64, f64)], first: f64) -> Self {
        let channel = |(sensor, zero): (&Sensor, &(f64, f64))| Channel {
            counts: sensor.quantity.shows_bending(),
            noise: sensor.noise,
            at_rest: sensor.quantity.is_level().then_some(zero.0),
            window: i64::MIN,
            sum: 0.0,
            count: 0.0,
            base: 0.0,
            largest: [0.0; 1 + WINDOWS],
            complete: 0,
            blow: None,
        };
        Self {
            first,
            channels: sensors.iter().zip(zeros).map(channel).collect(),
            found: None,
        }
    }

    /// Takes a reading of a sensor, in the order of time.
    pub fn push(&mut self, sensor: usize, time: f64, value: f64) {
        let Some(channel) = self.channels.get_mut(sensor) else {
            return;
        };
        if self.found.is_some() || !channel.counts || !value.is_finite() {
            return;
        }
        let Some(blow) = channel.push(time - self.first, value) else {
            return;
        };
        let counted = self.channels.iter().filter(|it| it.counts).count();
        let near = |it: &&Channel| it.blow.is_some_and(|other| (other - blow).abs() <= COMMON);
        let shown = self.channels.iter().filter(near);
        // A single sensor may be disturbed by anything, unless there is only one.
        if shown.clone().count() >= counted.min(2) {
            let earliest = shown.filter_map(|it| it.blow).fold(blow, f64::min);
            self.found = Some(self.first + earliest);
        }
    }

    /// When the column was struck once more \[s\].
    pub fn found(&self) -> Option<f64> {
        self.found
    }
}

impl Channel {
    /// Takes a reading at a time after the first impact \[s\]; the time of a blow that it shows.
    fn push(&mut self, time: f64, value: f64) -> Option<f64> {
        let window = (time / WINDOW).floor() as i64;
        if window != self.window {
            if self.count > 0.0 {
                self.base = self.sum / self.count;
                self.complete += 1;
            }
            self.largest.rotate_right(1);
            self.largest[0] = 0.0;
            (self.window, self.sum, self.count) = (window, 0.0, 0.0);
        }
        self.sum += value;
        self.count += 1.0;
        if self.complete == 0 {
            return None;
        }
        let distance = (value - self.base).abs();
        self.largest[0] = self.largest[0].max(distance);
        let before = self.largest[1..].iter().copied().fold(0.0, f64::max);
        let is_blow = time > SOONEST
            && self.complete > WINDOWS
            && distance > GROWTH * before
            && distance > OPENING * self.noise
            && self.moves_away(value);
        if is_blow {
            self.blow = Some(time);
        }
        self.blow.filter(|_| is_blow)
    }

    /// Whether a reading is further from rest than those before it. A vehicle that leaves a column which it has long bent moves it as
    /// suddenly as a blow does, but back.
    fn moves_away(&self, value: f64) -> bool {
        self.at_rest
            .is_none_or(|rest| (value - rest).abs() > (self.base - rest).abs())
    }
}
