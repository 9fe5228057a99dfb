//! The curves of an impact in a Rerun stream: one column of data per entity for a batch of states.

use rerun::{LineStrip2D, LineStrips2D, Points2D, RecordingStreamResult, Scalars, TimeColumn};

use super::branch::Branch;
use super::colour;
use super::force_crush;
use super::plots;
use super::rerun_types::{color, time_columns};
use super::scene::Drawing;
use super::static_scene;
use super::timeline::Moment;
use crate::column::{HINGES, MAX_MASSES, Sample};
use crate::twin::StateOutput;

/// Writes the curves of one column.
pub(super) struct Curves<'a> {
    pub branch: &'a Branch,
    pub drawing: &'a Drawing,
    /// The last state of the impact that the curves contain, from which their paths go on.
    pub plotted: Option<Sample>,
    /// Ends of the axis of the displacement at the impact.
    pub displacement_axis: [f64; 2],
    /// Where an impact impulse is marked in its plot.
    pub impact_impulse_mark: f64,
}

impl Curves<'_> {
    /// Sends the curves of some states, of which there is at least one.
    ///
    /// # Errors
    /// The stream rejects the data.
    pub fn send(&self, batch: &[(Moment, StateOutput)]) -> RecordingStreamResult<()> {
        self.curves(batch)?;
        self.vehicle_path(batch)?;
        self.impact_impulses(batch)?;
        self.stresses(batch)
    }

    fn curves(&self, batch: &[(Moment, StateOutput)]) -> RecordingStreamResult<()> {
        let times = time_columns(batch.iter().map(|(moment, _)| *moment));
        for plot in &plots::ALL {
            self.curve(plot.entity, &times, batch, |sample| plot.values(sample))?;
        }
        self.curve(plots::SPRING_FORCES, &times, batch, |sample| {
            plots::spring_forces(sample).collect()
        })?;
        self.force_crush(&times, batch)
    }

    /// The path of the vehicle's front, where it is on its axis.
    fn vehicle_path(&self, batch: &[(Moment, StateOutput)]) -> RecordingStreamResult<()> {
        let on_axis = batch.iter().filter_map(|(moment, state)| {
            let front = plots::vehicle_front(&state.sample, self.displacement_axis)?;
            Some((*moment, front))
        });
        let (moments, fronts): (Vec<_>, Vec<_>) = on_axis.unzip();
        if fronts.is_empty() {
            return Ok(());
        }
        let ones = vec![1; fronts.len()];
        let scalars = Scalars::new(fronts).columns(ones)?;
        self.branch
            .send_columns(plots::VEHICLE_PATH, time_columns(moments), scalars)
    }

    /// Writes some curves, unless none has a value.
    fn curve(
        &self,
        entity: &str,
        times: &[TimeColumn],
        batch: &[(Moment, StateOutput)],
        values: impl Fn(&Sample) -> Vec<f64>,
    ) -> RecordingStreamResult<()> {
        let mut all = Vec::with_capacity(4 * batch.len());
        let mut lengths = Vec::with_capacity(batch.len());
        for (_, state) in batch {
            let values = values(&state.sample);
            lengths.push(values.len());
            all.extend(values);
        }
        if all.is_empty() {
            return Ok(());
        }
        let scalars = Scalars::new(all).columns(lengths)?;
        self.branch.send_columns(entity, times.to_vec(), scalars)
    }

    /// The path of each spring in its diagram of force over crush, piece by piece, and its present position.
    fn force_crush(
        &self,
        times: &[TimeColumn],
        batch: &[(Moment, StateOutput)],
    ) -> RecordingStreamResult<()> {
        if batch
            .iter()
            .all(|(_, state)| state.sample.vehicle.masses == 0)
        {
            return Ok(());
        }
        let mut last = self.plotted.unwrap_or(batch[0].1.sample);
        let mut strips = Vec::with_capacity(batch.len());
        let mut points = Vec::with_capacity(batch.len());
        let mut lengths = Vec::with_capacity(batch.len());
        for (_, state) in batch {
            let sample = &state.sample;
            let springs = sample.vehicle.masses.min(MAX_MASSES);
            lengths.push(springs);
            for spring in 0..springs {
                let from = force_crush::point(&last.vehicle, spring);
                let to = force_crush::point(&sample.vehicle, spring);
                strips.push(LineStrip2D::from_iter([from, to]));
                points.push(to);
            }
            last = *sample;
        }
        let path = LineStrips2D::update_fields().with_strips(strips);
        let path = path.columns(lengths.clone())?;
        self.branch
            .send_columns(force_crush::PATH, times.to_vec(), path)?;
        let now = Points2D::update_fields().with_positions(points);
        self.branch
            .send_columns(force_crush::NOW, times.to_vec(), now.columns(lengths)?)
    }

    fn impact_impulses(&self, batch: &[(Moment, StateOutput)]) -> RecordingStreamResult<()> {
        let struck = batch
            .iter()
            .filter(|(_, it)| it.sample.impact_impulse > 0.0);
        let times: Vec<_> = struck.map(|(moment, _)| *moment).collect();
        if times.is_empty() {
            return Ok(());
        }
        let marks = Scalars::new(vec![self.impact_impulse_mark; times.len()]);
        let columns_of_marks = marks.columns(vec![1; times.len()])?;
        self.branch.send_columns(
            plots::IMPACT_IMPULSES,
            time_columns(times),
            columns_of_marks,
        )
    }

    /// The path of each hinge in its yield surface, piece by piece, and its present position.
    fn stresses(&self, batch: &[(Moment, StateOutput)]) -> RecordingStreamResult<()> {
        let times = time_columns(batch.iter().map(|(moment, _)| *moment));
        let resistances = [
            self.drawing.resistance_moment,
            self.drawing.resistance_axial,
        ];
        for hinge in 0..HINGES {
            let mut last = self.plotted.unwrap_or(batch[0].1.sample);
            let mut strips = Vec::with_capacity(batch.len());
            let mut points = Vec::with_capacity(batch.len());
            for (_, state) in batch {
                let from = plots::stress(&last, hinge, resistances);
                let to = plots::stress(&state.sample, hinge, resistances);
                strips.push(LineStrip2D::from_iter([from, to]));
                points.push(to);
                last = state.sample;
            }
            let ones = vec![1; batch.len()];
            let path = LineStrips2D::update_fields().with_strips(strips);
            let entity = static_scene::stress_entity(hinge, "path");
            self.branch
                .send_columns(entity, times.clone(), path.columns(ones.clone())?)?;
            let colours = batch
                .iter()
                .map(|(_, state)| color(colour::of_state(state.sample.hinges[hinge].state)));
            let now = Points2D::update_fields()
                .with_positions(points)
                .with_colors(colours);
            let entity = static_scene::stress_entity(hinge, "now");
            self.branch
                .send_columns(entity, times.clone(), now.columns(ones)?)?;
        }
        Ok(())
    }
}
