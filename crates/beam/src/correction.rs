//! Corrects the damage by what was measured on the column at rest: plastic strains and plastic shear angles are multiplied by one
//! factor, so that the shape remains that of the hits, and the column is brought into its new equilibrium.

use super::beam::{Beam, State};
use super::column::BeamError;
use super::damage::Damage;
use super::newton::Solver;
use super::opinion::BeamModel;
use super::statics::{settle, settle_elastically};

/// Halvings with which the factor is found.
const HALVINGS: u32 = 40;

/// Standard deviations of the measurement by which the corrected beam may miss it.
const TOLERANCE: f64 = 0.01;

/// What was measured on the column at rest in the plane of its web, relative to the undamaged column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement {
    /// Whether it is a rotation \[rad\]; otherwise it is a displacement \[m\].
    pub is_rotation: bool,
    /// Above the base \[m\].
    pub height: f64,
    /// What was measured.
    pub value: f64,
    /// Its standard deviation, > 0.
    pub deviation: f64,
    /// The least and the largest factor by which the plastic deformation may be corrected.
    pub factors: [f64; 2],
}

impl BeamModel {
    /// The damage with which the column has what was measured; the same damage where it has it within the standard deviation.
    ///
    /// # Errors
    /// Damage of another column, or no factor that makes the column meet the measurement in equilibrium.
    pub fn corrected(&self, damage: &Damage, measured: &Measurement) -> Result<Damage, BeamError> {
        self.check_damage(damage)?;
        if damage.is_plane() {
            self.corrected_in::<3, 3, 4>(damage, measured)
        } else {
            self.corrected_in::<6, 6, 9>(damage, measured)
        }
    }

    fn corrected_in<const D: usize, const R: usize, const Q: usize>(
        &self,
        damage: &Damage,
        measured: &Measurement,
    ) -> Result<Damage, BeamError> {
        let column = self.column();
        let beam: Beam<D, R, Q> = column.beam(damage.heights(), column.bows());
        let mut solver = Solver::new(&beam);
        let mut undamaged = beam.undamaged();
        let unstable = BeamError::Unstable {
            load: column.top_load,
        };
        if !settle(&beam, &mut undamaged, &mut solver) {
            return Err(unstable);
        }
        let read = |state: &State<D, R>| reading(damage.heights(), state, &undamaged, measured);
        let mut scaled = |factor: f64| {
            let mut state = beam.undamaged();
            damage.times(factor).apply(&beam, &mut state, None);
            let stands = settle_elastically(&beam, &mut state, &mut solver)
                && settle(&beam, &mut state, &mut solver)
                && solver.negative_pivots == 0;
            stands.then_some(state)
        };
        let before = read(&scaled(1.0).ok_or(unstable)?);
        if (before - measured.value).abs() <= measured.deviation {
            return Ok(damage.clone());
        }
        for bound in measured.factors {
            let (mut near, mut far, mut factor) = (1.0, bound, bound);
            for _ in 0..HALVINGS {
                // Without an equilibrium the factor is too far from 1.
                match scaled(factor) {
                    Some(state) => {
                        let found = read(&state);
                        if (found - measured.value).abs() <= TOLERANCE * measured.deviation {
                            return Ok(Damage::of(&beam, &state));
                        }
                        match (found > measured.value) == (before > measured.value) {
                            true if factor == bound => break,
                            true => near = factor,
                            false => far = factor,
                        }
                    }
                    None => far = factor,
                }
                factor = 0.5 * (near + far);
            }
        }
        Err(BeamError::Correction {
            before,
            measured: measured.value,
            height: measured.height,
        })
    }
}

/// What an instrument at the height of a measurement reads, relative to the undamaged column.
fn reading<const D: usize, const R: usize>(
    heights: &[f64],
    state: &State<D, R>,
    undamaged: &State<D, R>,
    measured: &Measurement,
) -> f64 {
    let above = heights.partition_point(|it| *it <= measured.height);
    let below = above.clamp(1, heights.len() - 1) - 1;
    let length = heights[below + 1] - heights[below];
    let [low, high] =
        [below, below + 1].map(|node| state.moved[node][1] - undamaged.moved[node][1]);
    match measured.is_rotation {
        true => (high - low) / length,
        false => low + (high - low) * (measured.height - heights[below]) / length,
    }
}
