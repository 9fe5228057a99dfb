//! One impact with everything that the report needs of it.

use std::sync::Arc;

use super::course::{Course, Struck};
use super::words;
use crate::column::{
    ForceSpectrum, Impact, Model, Report, Response, Sample, SimulationError, State, StepError,
    Support, error_estimate, is_direction, is_seen_by_the_bars, with_half_the_step,
};
use crate::figures::ResponseHistory;
use crate::parameters::Parameters;
use crate::second_opinion::{BeamTask, Movement, SecondOpinion, is_out_of_plane};
use crate::time::Nanos;
use crate::twin::{KnownBeamDamage, Lengths};

/// One impact with everything that the report needs of it.
#[derive(Debug, Clone)]
pub struct ReportedImpact {
    /// One line that describes column and impact.
    pub title: String,
    /// Identifier and stamp of the event; `None` for a simulation.
    pub event: Option<(String, Nanos)>,
    /// The parameters that held.
    pub parameters: Arc<Parameters>,
    /// Name of the vehicle in the catalogue; empty: given by numbers.
    pub vehicle: String,
    /// What hit the column, with the component of its velocity in the plane of the two bars.
    pub impact: Impact,
    /// Whole speed of the vehicle, whatever its direction \[m/s\].
    pub velocity: f64,
    /// Direction in which it travels \[rad\]: see [`ImpactSpecification::direction`](crate::column::ImpactSpecification::direction).
    pub direction: f64,
    /// The column that was hit; its lower bar ends at the impact point.
    pub model: Model,
    /// The history, possibly thinned.
    pub samples: Vec<Sample>,
    /// The outcome.
    pub report: Report,
    /// The response spectrum of the contact force, of every step; `None` where only the published states are known.
    pub spectrum: Option<ForceSpectrum>,
    /// The column at rest after the impact; `None` if it has no equilibrium.
    pub settled: Option<State>,
    /// The beginning of the impact, if it is known; computations with other properties start from it.
    pub struck: Option<Struck>,
    /// The second opinion on an impact that was recorded; that of a simulated one is computed for the report.
    pub second_opinion: Option<Arc<SecondOpinion>>,
    /// How the fibre beam moves during it, if that is known.
    pub beam: Option<Movement>,
    /// The damage of the beam before it, if that is known.
    pub beam_before: Option<KnownBeamDamage>,
    /// What a reader has to know about the origin of these data.
    pub remarks: Vec<String>,
}

impl ReportedImpact {
    /// The impact that `parameters` describe on an undamaged column.
    ///
    /// # Errors
    /// The column or the impact is impossible, or a step does not converge.
    pub fn simulated(parameters: &Parameters) -> Result<Self, SimulationError> {
        let impact = parameters.impact();
        let model = Model::new(&parameters.column_properties().before(&impact))?;
        let mut state = State::at_rest(&model);
        let max_duration = parameters.response_duration();
        let response = Response::begin(&model, &mut state, impact, max_duration)?;
        let struck = Struck {
            model,
            state,
            response,
        };
        let vehicle = &parameters.settings().vehicle.name;
        let computed = Self::computed(
            Arc::new(parameters.clone()),
            vehicle,
            impact,
            (parameters.whole_impact().velocity, parameters.direction()),
            &struck,
        )?;
        let beam = BeamTask::of_parameters(parameters).and_then(|task| task.movement());
        Ok(Self {
            beam: beam.ok(),
            beam_before: Some(KnownBeamDamage::Undamaged),
            ..computed
        })
    }

    /// An impact of the vehicle of this name, which travels with this whole speed \[m/s\] in this direction \[rad\], computed from its
    /// beginning.
    ///
    /// # Errors
    /// A step that does not converge.
    pub fn computed(
        parameters: Arc<Parameters>,
        vehicle: &str,
        impact: Impact,
        (velocity, direction): (f64, f64),
        struck: &Struck,
    ) -> Result<Self, StepError> {
        let Course {
            samples,
            report,
            spectrum,
            settled,
        } = struck.course()?;
        Ok(Self {
            title: words::title(
                &parameters,
                vehicle,
                &Impact { velocity, ..impact },
                struck.model.properties.length_below,
                direction,
            ),
            event: None,
            vehicle: vehicle.to_owned(),
            parameters,
            impact,
            velocity,
            direction,
            model: struck.model,
            samples,
            report,
            spectrum: Some(spectrum),
            settled,
            struck: Some(*struck),
            second_opinion: None,
            beam: None,
            beam_before: None,
            remarks: Vec::new(),
        })
    }

    /// Relative error of the peak `v1` by the length of the step, estimated by a second run with half of it; `None` where
    /// the beginning of the impact is not known or the second run does not converge.
    #[must_use]
    pub fn error_estimate(&self) -> Option<f64> {
        let properties = self.model.properties;
        let halved = with_half_the_step(&properties)?;
        let finer = self.struck?.with_properties(&halved)?.report().ok()?;
        error_estimate(&self.report, &finer)
    }

    /// The history for the figures.
    #[must_use]
    pub fn history(&self) -> ResponseHistory<'_> {
        let properties = &self.model.properties;
        ResponseHistory {
            title: &self.title,
            samples: &self.samples,
            report: &self.report,
            spectrum: self.spectrum.as_ref(),
            yield_surface: properties.yield_surface,
            resistance_moment: properties.resistance_moment,
            resistance_axial: properties.resistance_axial,
            lengths: Lengths::from(properties),
            vehicle: self.impact.vehicle,
            beam: self.beam.as_ref(),
        }
    }

    /// Whether the vehicle travels out of the plane of the two bars, which then see a component of the hit only.
    pub(super) fn is_oblique(&self) -> bool {
        is_direction(self.direction) && is_out_of_plane(self.direction)
    }

    /// Whether the two bars see the hit at all: at right angles to their plane it has no component in it.
    pub(super) fn is_seen_by_the_bars(&self) -> bool {
        is_seen_by_the_bars(self.direction)
    }

    /// Height of the column \[m\].
    pub(super) fn height(&self) -> f64 {
        self.model.properties.length_below + self.model.properties.length_above
    }

    /// The kink that remains at the impact point \[rad\], as it can be measured between both bars; where no equilibrium remains
    /// or the top is free, the plastic rotation of hinges 1a and 1b, of which only the sum is determined.
    pub(super) fn kink(&self) -> f64 {
        let properties = &self.model.properties;
        match self.report.residual_v1 {
            Some(v1) if properties.top != Support::Free => {
                (v1 / properties.length_below + v1 / properties.length_above).abs()
            }
            _ => {
                let [below, above, ..] = &self.report.hinges;
                (below.plastic_rotation + above.plastic_rotation).abs()
            }
        }
    }

    /// The web that has sheared beyond its ultimate angle, if one has.
    pub(super) fn fractured_web(&self) -> Option<usize> {
        let ultimate = self.model.properties.shear?.ultimate_angle;
        let webs = self.report.webs.iter();
        webs.map(|web| web.plastic_angle.abs())
            .position(|angle| ultimate > 0.0 && angle >= ultimate)
    }

    /// The hinge with the largest plastic rotation or, where none has yielded, with the largest utilisation.
    pub(super) fn governing_hinge(&self) -> usize {
        let hinges = &self.report.hinges;
        let order = |index: &usize| {
            let hinge = &hinges[*index];
            (hinge.plastic_rotation.abs(), hinge.max_utilisation)
        };
        (0..hinges.len())
            .max_by(|one, other| {
                let (one, other) = (order(one), order(other));
                one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1))
            })
            .unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::simulate;

    /// The figure was computed from the thinned history, and differed from the spectrum in the JSON output.
    #[test]
    fn the_spectrum_of_a_thinned_history_is_that_of_every_step() {
        let long = [
            ("solver.dt", 1e-6.into()),
            ("response.duration", 0.05.into()),
        ];
        let parameters = Parameters::from_values(long).expect("admissible");
        let reported = ReportedImpact::simulated(&parameters).expect("a response");
        let (kept, steps) = (reported.samples.len() as u64, reported.report.steps);
        assert!(
            kept < steps,
            "{kept} samples of {steps} steps are not thinned"
        );
        let impact = parameters.impact();
        let mut expected = ForceSpectrum::default();
        simulate(
            &parameters.column_properties().before(&impact),
            &impact,
            parameters.response_duration(),
            &mut |sample| expected.push(sample.time, sample.impulse),
        )
        .expect("a response");
        let found = reported
            .history()
            .spectrum
            .expect("every step was computed");
        assert_eq!(found.equivalent_forces(), expected.equivalent_forces());
    }
}
