//! What is left of a vehicle that earlier impacts have crushed.

use super::vehicle::{
    CrushCurve, CrushSpring, MAX_CURVE_POINTS, MAX_MASSES, NARROW_APART, Vehicle, VehicleError,
};

impl Vehicle {
    /// The vehicle that an earlier impact has crushed: `largest` \[m\] is the largest crush of each spring so far, front first;
    /// springs that are left out are new. Crush counts from what is left of the vehicle: a spring is touched where its permanent
    /// crush has left it, follows its unloading stiffness up to the largest crush so far, and its envelope beyond. A load that
    /// has struck what is in front of it lies against it, without slack.
    ///
    /// # Errors
    /// More values than springs, a value that is not a finite number >= 0, or a spring of which nothing is left.
    pub fn crushed(&self, largest: &[f64]) -> Result<Self, VehicleError> {
        if largest.len() > self.springs().len() {
            return Err(VehicleError::Crushes {
                found: largest.len(),
                springs: self.springs().len(),
            });
        }
        let mut springs = [self.springs()[0]; MAX_MASSES];
        springs[..self.springs().len()].copy_from_slice(self.springs());
        for (index, (spring, &largest)) in springs.iter_mut().zip(largest).enumerate() {
            if !(largest.is_finite() && largest >= 0.0) {
                return Err(VehicleError::Crush {
                    spring: index + 1,
                    found: largest,
                });
            }
            if largest > 0.0 {
                *spring = spring.crushed(largest)?;
            }
        }
        Self::new(self.masses(), &springs[..self.springs().len()])
    }

    /// The largest crush of each spring \[m\] after another impact: of this vehicle, `before` of which is that of earlier impacts
    /// as in [`Self::crushed`], and `more` \[m\] the largest crush of each spring in the impact of the vehicle that they left.
    #[must_use]
    pub fn crush_after(&self, before: &[f64], more: &[f64]) -> [f64; MAX_MASSES] {
        let at = |list: &[f64], index: usize| list.get(index).copied().unwrap_or(0.0);
        let mut largest = [0.0; MAX_MASSES];
        for (index, spring) in self.springs().iter().enumerate() {
            let (before, more) = (at(before, index), at(more, index));
            largest[index] = before.max(spring.permanent_crush(before) + more);
        }
        largest
    }
}

impl CrushSpring {
    /// Crush that remains when the force has gone, after a largest crush \[m\].
    #[must_use]
    pub fn permanent_crush(&self, largest: f64) -> f64 {
        (largest - self.envelope.force(largest) / self.unloading_stiffness).max(0.0)
    }

    /// The spring after this largest crush \[m\], > 0, its crush counted from what remains.
    fn crushed(&self, largest: f64) -> Result<Self, VehicleError> {
        let permanent = self.permanent_crush(largest);
        let force = self.envelope.force(largest);
        // What remains of the curve, one point before it, and at most two behind it.
        let mut points = [[0.0; 2]; MAX_CURVE_POINTS + 3];
        let mut count = 0;
        let mut add = |crush: f64, force: f64| {
            points[count] = [crush, force];
            count += 1;
        };
        if force > 0.0 {
            add(force / self.unloading_stiffness, force);
        }
        let is_beyond = |crush: f64| crush > largest + NARROW_APART;
        let mut is_last = true;
        for &[crush, force] in self.envelope.points() {
            if is_beyond(crush) {
                add(crush - permanent, force);
                is_last = false;
            }
        }
        if is_last {
            // Behind the last point its slope continues, but not below zero.
            const ALONG: f64 = 1.0; // m, any distance
            let piece = self.envelope.pieces_beyond(largest).next();
            let falls_to_zero = piece
                .map(|it| it.end)
                .filter(|&end| end.is_finite() && is_beyond(end));
            if let Some(end) = falls_to_zero {
                add(end - permanent, 0.0);
            }
            let from = falls_to_zero.unwrap_or(largest) + ALONG;
            add(from - permanent, self.envelope.force(from));
        }
        Ok(Self {
            envelope: CrushCurve::new(&points[..count])?,
            slack: 0.0,
            ..*self
        })
    }
}
