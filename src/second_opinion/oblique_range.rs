//! The range of the verdict on a hit as far as it takes the fibre beam: all of it for a hit out of the plane of the two bars, and
//! the beam with another hardening for one in the plane. Each variation is judged by both models.

use column_beam::both;

use super::answer::BeamDamageBefore;
use super::joint::JointVerdict;
use super::opinion::is_out_of_plane;
use super::two_threads::TwoThreads;
use crate::assessment::{
    ActionRange, Assumption, DAMAGED, EarlierImpacts, HARDENING_BAND, OpenVerdict, Variation,
    both_ends,
};
use crate::column::{ColumnProperties, Impact};
use crate::parameters::{BeamSteel, Parameters};

/// A hit in any direction on a column, with the damage that it had before.
#[derive(Debug, Clone, Copy)]
pub struct ObliqueHit<'a> {
    /// Of the column; the height of the hit is that of `struck`.
    pub parameters: &'a Parameters,
    /// The column with the height at which it was hit.
    pub struck: &'a ColumnProperties,
    /// The component in the plane of the two bars.
    pub in_plane: Impact,
    /// With the whole speed of the vehicle.
    pub whole: Impact,
    /// Direction in which the vehicle travels \[rad\].
    pub direction: f64,
    /// What the impacts before it have left, as the two bars know it; `None` where they have left nothing.
    pub earlier: Option<&'a EarlierImpacts>,
    /// The damage of the beam before it; `None` where it has none.
    pub beam_before: Option<&'a BeamDamageBefore>,
}

/// Why not every assumption is varied.
const BY_BOTH: &str = "of a hit out of the plane of the two bars, whose variations take the fibre beam, no more than speed, \
                       height, front and hardening are varied";

/// The hardening ratio with which the beam is computed once more: the lower end of the band of the two bars, with which a column is
/// weaker, or the upper end where it hardens no more than that itself.
fn other_hardening(own: f64) -> f64 {
    let [least, most] = HARDENING_BAND;
    if own > least { least } else { most }
}

impl ObliqueHit<'_> {
    /// The range of this verdict by both models: speed, height, force of the front and hardening are varied, with at most seven
    /// responses of the fibre beam, two at once. Height and hardening of a hit on a damaged column are not: they would have changed the
    /// damage, too. `None` where the vehicle travels in the plane, where the fibre beam does not answer, and once `go_on`, which is asked
    /// before each two responses, returns false.
    pub fn range(
        &self,
        verdict: &OpenVerdict,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Option<ActionRange> {
        if !is_out_of_plane(self.direction) {
            return None;
        }
        let mut variations = Vec::new();
        let mut not_varied = Vec::new();
        let mut ends = self.ends();
        while let Some(first) = ends.next() {
            if !go_on() {
                return None;
            }
            let vary = |(assumption, end)| (assumption, self.varied(assumption, end));
            let second = ends.next();
            let (one, other) = both(&TwoThreads, || vary(first), || second.map(vary));
            for (assumption, varied) in [one].into_iter().chain(other) {
                match varied {
                    Ok(variation) => variations.push(variation),
                    Err(reason) => not_varied.push((assumption, reason)),
                }
            }
        }
        if variations.is_empty() && !not_varied.is_empty() {
            return None;
        }
        if self.is_damaged() {
            let of_damage = [Assumption::Height, Assumption::Hardening];
            not_varied.extend(of_damage.map(|it| (it, DAMAGED.to_owned())));
        }
        not_varied.push((Assumption::Direction, BY_BOTH.to_owned()));
        Some(ActionRange::of_variations(verdict, variations, not_varied))
    }

    /// Makes the range that the two bars have found for this verdict, if any, the range of both models; `yields` tells whether the beam has
    /// yielded.
    pub fn complete(&self, range: &mut Option<ActionRange>, verdict: &OpenVerdict, yields: bool) {
        if let Some(by_both) = self.range(verdict, &mut || true) {
            *range = Some(by_both);
        } else if let Some(range) = range {
            self.include_hardening(range, verdict, yields);
        }
    }

    /// Includes in the range of this verdict on a hit in the plane what both models say with another hardening of the steel; `yields`
    /// tells whether the beam has yielded. One that stays elastic does not harden, and a damaged column would have another damage:
    /// nothing is included then.
    pub fn include_hardening(&self, range: &mut ActionRange, verdict: &OpenVerdict, yields: bool) {
        if is_out_of_plane(self.direction) || self.is_damaged() || !yields {
            return;
        }
        let hardening = other_hardening(self.struck.hardening_ratio);
        match self.varied(Assumption::Hardening, hardening) {
            Ok(variation) => range.include(verdict, variation),
            Err(reason) => range.not_varied.push((Assumption::Hardening, reason)),
        }
    }

    fn is_damaged(&self) -> bool {
        let by_bars = self.earlier.is_some_and(EarlierImpacts::have_damaged);
        by_bars || self.beam_before.is_some()
    }

    /// What is varied, and by how much.
    fn ends(&self) -> impl Iterator<Item = (Assumption, f64)> {
        let ranges = &self.parameters.settings().assessment;
        let front = self.whole.vehicle.map_or(0.0, |_| ranges.range_front);
        let (height, hardening) = match self.is_damaged() {
            true => (0.0, None),
            false => {
                let other = other_hardening(self.struck.hardening_ratio);
                (ranges.range_height, Some((Assumption::Hardening, other)))
            }
        };
        [
            (Assumption::Speed, ranges.range_velocity),
            (Assumption::Height, height),
            (Assumption::FrontForce, front),
        ]
        .into_iter()
        .flat_map(|(assumption, width)| both_ends(width).map(move |end| (assumption, end)))
        .chain(hardening)
    }

    /// The hit with one assumption changed to this end.
    fn varied(&self, assumption: Assumption, end: f64) -> Result<Variation, String> {
        let [mut in_plane, mut whole] = [self.in_plane, self.whole];
        let mut moved = 0.0;
        let mut hardening = None;
        let instead = match assumption {
            Assumption::Speed => {
                in_plane.velocity *= 1.0 + end;
                whole.velocity *= 1.0 + end;
                format!("{:.2} m/s", whole.velocity)
            }
            Assumption::Height => {
                moved = end;
                format!("{:.2} m above the base", self.struck.length_below + end)
            }
            Assumption::Hardening => {
                hardening = Some(end);
                let whose = match self.parameters.settings().beam.steel {
                    BeamSteel::Bilinear => "by both models",
                    BeamSteel::Plateau => "in the two bars alone",
                };
                format!("{:.1} %, {whose}", 100.0 * end)
            }
            _ => {
                for impact in [&mut in_plane, &mut whole] {
                    let scaled = impact.vehicle.map(|it| it.with_force_factor(1.0 + end));
                    impact.vehicle = scaled.transpose().map_err(|fault| fault.to_string())?;
                }
                format!("{:.2} times the force", 1.0 + end)
            }
        };
        let [below, above] = [
            self.struck.length_below + moved,
            self.struck.length_above - moved,
        ];
        if !(below > 0.0 && above > 0.0) {
            return Err(format!("{instead} is not on the column"));
        }
        let lengths = [
            ("geometry.length_below", below.into()),
            ("geometry.length_above", above.into()),
        ];
        let hardened = hardening.map(|ratio| ("hardening.ratio", ratio.into()));
        let parameters = self
            .parameters
            .with_changes(lengths.into_iter().chain(hardened))
            .map_err(|faults| faults.in_one_line())?;
        let before = (self.earlier, self.beam_before.cloned());
        let found = JointVerdict::after(&parameters, &in_plane, whole, self.direction, before)
            .map_err(|fault| fault.to_string())?;
        let opinion = found.second_opinion.map_err(|reason| reason.to_string())?;
        let mut report = found.report;
        if opinion.decides {
            let [[peak, _], [residual, _]] = opinion.from_undamaged();
            report.outcome = opinion.outcome();
            report.max_v1 = peak;
            report.residual_v1 = Some(residual).filter(|it| !it.is_nan());
        }
        Ok(Variation {
            assumption,
            instead,
            report,
            hardening_ratio: hardening.unwrap_or(self.struck.hardening_ratio),
            softens: self.struck.softening.is_some(),
            action: found.assessment.action,
            not_evaluated: OpenVerdict::from(&found.assessment).not_evaluated,
        })
    }
}
