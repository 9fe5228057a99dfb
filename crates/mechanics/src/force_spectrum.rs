//! The equivalent static force of a contact: what a neighbouring member that is pushed by the same force would feel, by its period.

/// Periods of a spectrum: twelve to a decade.
pub const SPECTRUM_PERIODS: usize = 37;

/// The shortest period \[s\].
const SHORTEST: f64 = 1e-3;

/// Periods to a decade.
const PER_DECADE: f64 = 12.0;

/// The response spectrum of a contact force: for undamped oscillators with one degree of freedom, at rest at first, the largest
/// force in the spring during and after the contact. A static force of this size would stretch the spring as far.
///
/// The force is taken as constant between two points of its history, so that its impulse is exact, that of instantaneous impacts
/// included. A history that rises and falls between two points is followed only by oscillators that are slower than they.
#[derive(Debug, Clone)]
pub struct ForceSpectrum {
    oscillators: [Oscillator; SPECTRUM_PERIODS],
    /// Time \[s\] and impulse \[N s\] of the last point.
    last: [f64; 2],
    /// Length of the last interval \[s\].
    interval: f64,
}

/// An undamped oscillator with one degree of freedom.
#[derive(Debug, Clone, Copy)]
struct Oscillator {
    /// Circular frequency \[rad/s\].
    frequency: f64,
    /// Force in the spring \[N\], and its rate of change over the circular frequency.
    force: f64,
    rate: f64,
    /// Largest force in the spring so far \[N\].
    largest: f64,
    /// Cosine and sine of the turn in the last interval.
    turn: [f64; 2],
}

impl Default for ForceSpectrum {
    /// Before the contact, at time 0.
    fn default() -> Self {
        Self {
            oscillators: Self::periods().map(|period| Oscillator {
                frequency: std::f64::consts::TAU / period,
                force: 0.0,
                rate: 0.0,
                largest: 0.0,
                turn: [1.0, 0.0],
            }),
            last: [0.0; 2],
            interval: 0.0,
        }
    }
}

impl ForceSpectrum {
    /// The periods of the oscillators, rising \[s\].
    #[must_use]
    pub fn periods() -> [f64; SPECTRUM_PERIODS] {
        std::array::from_fn(|k| SHORTEST * libm::exp10(k as f64 / PER_DECADE))
    }

    /// The next point of the history: time \[s\] and impulse of the contact since the beginning \[N s\]. A point that is not later
    /// than the one before is left out.
    pub fn push(&mut self, time: f64, impulse: f64) {
        let interval = time - self.last[0];
        if interval.is_nan() || interval <= 0.0 {
            return;
        }
        let force = (impulse - self.last[1]) / interval;
        // Most steps are equally long, up to round-off.
        let is_as_long = (interval - self.interval).abs() <= 1e-9 * interval;
        for oscillator in &mut self.oscillators {
            if !is_as_long {
                let (sin, cos) = libm::sincos(oscillator.frequency * interval);
                oscillator.turn = [cos, sin];
            }
            oscillator.follow(force);
        }
        if !is_as_long {
            self.interval = interval;
        }
        self.last = [time, impulse];
    }

    /// The equivalent static force \[N\] by the periods of [`ForceSpectrum::periods`], if nothing pushes after the last point.
    #[must_use]
    pub fn equivalent_forces(&self) -> [f64; SPECTRUM_PERIODS] {
        self.oscillators.map(|it| it.largest.max(it.amplitude()))
    }
}

impl Oscillator {
    /// One interval with a constant force \[N\].
    fn follow(&mut self, pushed: f64) {
        let [cos, sin] = self.turn;
        let offset = self.force - pushed;
        (self.force, self.rate) = (
            pushed + offset * cos + self.rate * sin,
            self.rate * cos - offset * sin,
        );
        self.largest = self.largest.max(self.force.abs());
    }

    /// Amplitude of its free vibration \[N\].
    fn amplitude(&self) -> f64 {
        libm::hypot(self.force, self.rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// The spectrum of this force \[N\] over a duration \[s\], in steps of 10 microseconds.
    fn of(duration: f64, impulse: impl Fn(f64) -> f64) -> [f64; SPECTRUM_PERIODS] {
        let mut spectrum = ForceSpectrum::default();
        let steps = (duration / 1e-5).round() as u32;
        for step in 1..=steps {
            let time = f64::from(step) * duration / f64::from(steps);
            spectrum.push(time, impulse(time));
        }
        spectrum.equivalent_forces()
    }

    fn compare(found: &[f64; SPECTRUM_PERIODS], expected: impl Fn(f64) -> f64) {
        for (period, found) in ForceSpectrum::periods().iter().zip(found) {
            let ratio = found / expected(*period);
            assert!((ratio - 1.0).abs() < 2e-3, "{period} s: {ratio}");
        }
    }

    #[test]
    fn periods_reach_from_a_millisecond_to_a_second() {
        let periods = ForceSpectrum::periods();
        assert_eq!(periods[0], 1e-3);
        assert!((periods[12] - 1e-2).abs() < 1e-15);
        assert!((periods[SPECTRUM_PERIODS - 1] - 1.0).abs() < 1e-12);
    }

    /// Chopra, Dynamics of Structures, 4.7: twice the force, or its impulse over what a short one becomes.
    #[test]
    fn a_rectangular_pulse_has_its_closed_form() {
        let (force, duration) = (5e5, 0.04);
        let found = of(duration, |time| force * time);
        compare(&found, |period| {
            let ratio = duration / period;
            force
                * if ratio >= 0.5 {
                    2.0
                } else {
                    2.0 * libm::sin(PI * ratio)
                }
        });
    }

    /// Chopra, 4.8: forced and free part of a half sine.
    #[test]
    fn a_half_sine_pulse_has_its_closed_form() {
        // Not half of a period of the spectrum, where the closed form is 0 / 0.
        let (force, duration) = (3e5, 0.0511);
        let found = of(duration, |time| {
            force * duration / PI * (1.0 - libm::cos(PI * time / duration))
        });
        compare(&found, |period| {
            let ratio = period / (2.0 * duration);
            let at = |time: f64| {
                let (push, ring) = (
                    libm::sin(PI * time / duration),
                    libm::sin(TAU * time / period),
                );
                ((push - ratio * ring) / (1.0 - ratio * ratio)).abs()
            };
            let forced = (0..=20_000).map(|k| at(duration * f64::from(k) / 20_000.0));
            let forced = forced.fold(0.0, f64::max);
            let free = 2.0 * ratio / (ratio * ratio - 1.0) * libm::cos(PI / (2.0 * ratio));
            force * forced.max(free.abs())
        });
    }

    /// An instantaneous impact starts every oscillator with its impulse.
    #[test]
    fn an_instantaneous_impact_is_its_impulse_times_the_circular_frequency() {
        let mut spectrum = ForceSpectrum::default();
        spectrum.push(1e-5, 15e3);
        spectrum.push(0.5, 15e3);
        compare(&spectrum.equivalent_forces(), |period| 15e3 * TAU / period);
    }

    #[test]
    fn points_that_are_not_later_are_left_out() {
        let mut spectrum = ForceSpectrum::default();
        for (time, impulse) in [(0.0, 0.0), (0.01, 1e3), (0.01, 9e9), (f64::NAN, 9e9)] {
            spectrum.push(time, impulse);
        }
        assert!(spectrum.equivalent_forces().iter().all(|it| *it < 3e5));
    }
}
