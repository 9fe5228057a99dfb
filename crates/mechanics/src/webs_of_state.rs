//! What can be observed of the webs in a state of the column.

use super::backbone::HingeFactors;
use super::bar::{Bar, BarForces, PlasticFlow};
use super::model::Model;
use super::rate::HingeStrength;
use super::sample::{WEBS, WebSample};
use super::shear::SliderStrength;
use super::state::{State, hinge_state};
use super::web_strength::WebState;

impl State {
    /// The webs of both bars; their default where they do not yield.
    pub(crate) fn web_samples(&self, model: &Model) -> [WebSample; WEBS] {
        if model.properties.shear.is_none() {
            return <[WebSample; WEBS]>::default();
        }
        let utilisation = self.web_utilisations(model);
        let web = |bar: &Bar, forces: &BarForces, plastic: &PlasticFlow, web: &WebState, used| {
            if bar.slider.is_none() {
                return WebSample::default();
            }
            WebSample {
                shear_force: (forces.moment[0] + forces.moment[1]) / bar.length,
                plastic_angle: plastic.shear_angle,
                utilisation: used,
                dynamic_factor: web.dynamic_factor(),
                work: web.work,
                state: hinge_state(web.flowing, bar.shears(plastic)),
            }
        };
        let Self {
            forces: f, webs: w, ..
        } = self;
        let p = self.plastic_of_steel(model);
        [
            web(
                &model.frame.below,
                &f.below,
                &p.below,
                &w.below,
                utilisation[0],
            ),
            web(
                &model.frame.above,
                &f.above,
                &p.above,
                &w.above,
                utilisation[1],
            ),
        ]
    }

    /// Which share of the resistance of each web is used, below and above the impact point; 0 where they do not yield.
    pub(crate) fn web_utilisations(&self, model: &Model) -> [f64; WEBS] {
        self.web_shares(model, WebState::strength)
    }

    /// The same share of the resistance of an undamaged web at rest.
    pub(crate) fn web_uses(&self, model: &Model) -> [f64; WEBS] {
        self.web_shares(model, |_| SliderStrength::UNDAMAGED)
    }

    fn web_shares(
        &self,
        model: &Model,
        strength: impl Fn(&WebState) -> SliderStrength,
    ) -> [f64; WEBS] {
        let of = |bar: &Bar, forces: &BarForces, web: &WebState, hinges: &[HingeStrength; 2]| {
            let weakest = HingeFactors::weakest([&hinges[0].factors, &hinges[1].factors]);
            bar.web_utilisation(forces, &strength(web), weakest)
        };
        let (frame, f, w, s) = (&model.frame, &self.forces, &self.webs, &self.strength);
        [
            of(&frame.below, &f.below, &w.below, &s.below),
            of(&frame.above, &f.above, &w.above, &s.above),
        ]
    }
}
