//! The strength of the two hinges and of the web of one bar over one part of a step.

use super::bar::{Bar, BarForces};
use super::shear::SliderStrength;
use super::yield_surface::AxialLead;

/// Strength of a bar's two hinges over one part of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BarStrength {
    /// Factors of `M^p` and their inverses.
    pub moment: [f64; 2],
    per_moment: [f64; 2],
    /// Inverses of the factors of `N^p`.
    per_axial: [f64; 2],
    /// The hinge that is weaker against normal forces.
    pub weaker: usize,
    /// Its factor, and that of the other one.
    pub weakest: f64,
    strongest: f64,
    /// By how much the other one is stronger, once it is needed.
    lead: Option<AxialLead>,
    /// `g_k`: growth of the moments, relative to them, with the plastic rotation \[1/rad\].
    pub growth: [f64; 2],
    /// Of the web.
    pub slider: SliderStrength,
    /// Whether a hinge is expected to flow, which only saves the search without it.
    pub hinges_flow: bool,
}

impl BarStrength {
    /// Of a bar whose hinges have the factors `whole` of the whole yield surface, and in addition `moment` of the moments; all
    /// positive. `growth` is the growth of the moments, relative to them, with the plastic rotation \[1/rad\], >= 0. `slider` is
    /// the strength of its web. `None` where all have the resistances of an undamaged column at rest.
    pub(crate) fn new(
        whole: [f64; 2],
        moment: [f64; 2],
        growth: [f64; 2],
        slider: SliderStrength,
    ) -> Option<Self> {
        let is_undamaged = whole == [1.0; 2]
            && moment == [1.0; 2]
            && growth == [0.0; 2]
            && slider == SliderStrength::UNDAMAGED;
        (!is_undamaged).then(|| Self::of_factors(whole, moment, growth, slider))
    }

    pub(crate) fn of_factors(
        whole: [f64; 2],
        moment: [f64; 2],
        growth: [f64; 2],
        slider: SliderStrength,
    ) -> Self {
        let weaker = usize::from(whole[1] < whole[0]);
        let moment = [whole[0] * moment[0], whole[1] * moment[1]];
        Self {
            moment,
            per_moment: moment.map(|factor| 1.0 / factor),
            per_axial: whole.map(|factor| 1.0 / factor),
            weaker,
            weakest: whole[weaker],
            strongest: whole[1 - weaker],
            lead: None,
            growth,
            slider,
            hinges_flow: false,
        }
    }

    /// The lead of the stronger hinge.
    pub(crate) fn lead(&mut self, bar: &Bar) -> AxialLead {
        let (weakest, strongest) = (self.weakest, self.strongest);
        *self
            .lead
            .get_or_insert_with(|| bar.surface.axial_lead(weakest, strongest))
    }

    /// The lead of the stronger hinge if a stress lies outside of either surface.
    pub(crate) fn exceeded(&mut self, bar: &Bar, stress: &BarForces) -> Option<AxialLead> {
        let surface = &bar.surface;
        let n = surface.relative_axial(stress.normal).abs();
        let n = self.per_axial.map(|per_axial| n * per_axial);
        let m =
            [0, 1].map(|k| surface.relative_moment(stress.moment[k]).abs() * self.per_moment[k]);
        if !surface.may_be_exceeded(m[0], n[0]) && !surface.may_be_exceeded(m[1], n[1]) {
            return None;
        }
        let lead = self.lead(bar);
        surface
            .either_exceeded(m, n, self.weaker, &lead)
            .then_some(lead)
    }
}
