//! What instruments on the beam read during an impact and after it: signals whose truth another model knows.

use column_mechanics::Impact;

use super::beam::{Beam, State};
use super::column::{BeamColumn, BeamError};
use super::contact::touches;
use super::mesh;
use super::mesh::nearest;
use super::response::Run;
use super::statics::settle;

/// Most samples of a history.
const MAX_SAMPLES: usize = 100_000;

/// What an instrument reads, at a height above the base \[m\]. Relative to the column at rest, as in the main program: a motion
/// in the direction of the vehicle, and tension, are positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Instrument {
    /// Transverse displacement \[m\] of the node that is nearest to the height.
    Displacement(f64),
    /// Transverse acceleration \[m/s²\] of this node.
    Acceleration(f64),
    /// Bending strain of the outer fibre on the side that is struck: negative at the base, positive at the impact point.
    BendingStrain(f64),
}

/// When the instruments are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Time between two samples \[s\].
    pub period: f64,
    /// Steps between two samples, at least one: a sample is the mean over them.
    pub steps: u32,
    /// How many samples there are.
    pub samples: usize,
}

/// Readings from contact on, and what a person would want to know about them.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    /// For each sample the means of the instruments since the sample before.
    pub rows: Vec<Vec<f64>>,
    /// Largest displacement of the impact point \[m\], and when \[s\].
    pub peak: [f64; 2],
    /// Impulse that the vehicle has delivered to the column by the end \[N s\].
    pub impulse: f64,
    /// Whether a fibre has yielded.
    pub yielded: bool,
    /// Whether the vehicle has left the column.
    pub released: bool,
    /// Whether the column has collapsed; the rows end there.
    pub collapsed: bool,
}

/// Follows a head-on impact in the plane of the web on the undamaged column.
///
/// # Errors
/// Numbers out of range, no equilibrium before the impact, or a step that is not solved.
pub fn history(
    column: &BeamColumn,
    impact: &Impact,
    instruments: &[Instrument],
    sampling: &Sampling,
) -> Result<History, BeamError> {
    let Sampling {
        period,
        steps,
        samples,
    } = *sampling;
    column.check()?;
    impact.check()?;
    let heights = column.heights(column.elements, mesh::FINE);
    let beam: Beam<3, 3, 4> = column.beam(&heights, column.bows());
    let mut solver = super::newton::Solver::new(&beam);
    let mut state = beam.undamaged();
    if !settle(&beam, &mut state, &mut solver) || solver.negative_pivots > 0 {
        return Err(BeamError::Unstable {
            load: column.top_load,
        });
    }
    let node = nearest(&heights, column.length_below);
    let probes: Vec<_> = instruments
        .iter()
        .map(|it| Probe::new(it, &heights, column.depth()))
        .collect();
    let at_rest: Vec<f64> = probes.iter().map(|it| it.read(&beam, &state)).collect();
    let rest = state.moved[node];
    let behind = touches(column, &heights);
    let mut run = Run::new(&beam, state, impact, 0.0, &behind, node);
    let mut found = History {
        rows: Vec::new(),
        peak: [0.0; 2],
        impulse: 0.0,
        yielded: false,
        released: false,
        collapsed: false,
    };
    let secs = period / f64::from(steps);
    let mut last: Vec<f64> = vec![0.0; probes.len()];
    for _ in 0..samples.min(MAX_SAMPLES) {
        let mut sums = vec![0.0; probes.len()];
        for _ in 0..steps {
            let solved = run.advance(secs, 0);
            let along = run.displacement(&rest)[0];
            if along > found.peak[0] {
                found.peak = [along, run.course.secs];
            }
            if run.has_collapsed(solved, [along, 0.0]) {
                found.collapsed = true;
                break;
            }
            if !solved {
                return Err(BeamError::NotSolved {
                    time: run.course.secs,
                });
            }
            for ((sum, probe), rest) in sums.iter_mut().zip(&probes).zip(&at_rest) {
                *sum += (probe.read(&beam, &run.state) - rest) / f64::from(steps);
            }
        }
        if found.collapsed {
            break;
        }
        for (((sum, last), probe), rest) in
            sums.iter_mut().zip(&mut last).zip(&probes).zip(&at_rest)
        {
            if probe.is_rate {
                // The mean acceleration is the change of the velocity.
                let velocity = probe.read(&beam, &run.state) - rest;
                *sum = (velocity - *last) / period;
                *last = velocity;
            }
        }
        found.rows.push(sums);
    }
    found.impulse = run.course.impulse;
    found.yielded = run.state.yielded.iter().any(|it| *it);
    found.released = run.striker.is_gone();
    Ok(found)
}

/// Where an instrument is on the beam.
#[derive(Debug, Clone, Copy)]
struct Probe {
    /// Node, or the element of a gauge.
    index: usize,
    /// Place in the element, from 0 to 1, and distance of the fibre \[m\]; of a gauge only.
    gauge: Option<[f64; 2]>,
    /// It is the velocity whose change is read.
    is_rate: bool,
}

impl Probe {
    fn new(instrument: &Instrument, heights: &[f64], depth: f64) -> Self {
        let at_node = |height: f64, is_rate| Self {
            index: nearest(heights, height),
            gauge: None,
            is_rate,
        };
        match *instrument {
            Instrument::Displacement(height) => at_node(height, false),
            Instrument::Acceleration(height) => at_node(height, true),
            Instrument::BendingStrain(height) => {
                let above = heights.partition_point(|it| *it <= height);
                let index = above.clamp(1, heights.len() - 1) - 1;
                let place = (height - heights[index]) / (heights[index + 1] - heights[index]);
                Self {
                    index,
                    gauge: Some([place.clamp(0.0, 1.0), 0.5 * depth]),
                    is_rate: false,
                }
            }
        }
    }

    fn read(&self, beam: &Beam<3, 3, 4>, state: &State<3, 3>) -> f64 {
        match self.gauge {
            None if self.is_rate => state.velocity[self.index][1],
            None => state.moved[self.index][1],
            Some([place, fibre]) => {
                let element = &beam.elements[self.index];
                let d = &state.deformation[self.index];
                let turns = [1, 2].map(|k| d[k] - element.initial[k]);
                let curvature = (-4.0 + 6.0 * place) * turns[0] + (-2.0 + 6.0 * place) * turns[1];
                -fibre * curvature / element.length
            }
        }
    }
}
