//! Newton's method with a line search for a step in time or an increment of equilibrium.

use super::beam::{Beam, Kind, State, Work, dimensions};
use super::contact::Striker;

/// Iterations of a step; four are usual.
const MAX_ITERATIONS: usize = 40;

/// Trials along a direction.
const MAX_TRIALS: usize = 8;

/// Residual moments count as forces at this lever \[m\].
const LEVER: f64 = 0.1;

/// The unknowns and the memory of a solution.
#[derive(Debug, Clone)]
pub(crate) struct Solver<const D: usize, const R: usize> {
    pub work: Work<D, R>,
    pub increments: Vec<[f64; D]>,
    tried: Vec<[f64; D]>,
    direction: Vec<[f64; D]>,
    column: Vec<[f64; D]>,
    /// Evaluations so far.
    pub evaluations: u64,
    /// Negative pivots of the last factorisation.
    pub negative_pivots: usize,
    /// Largest residual that is accepted \[N\].
    pub tolerance: f64,
}

impl<const D: usize, const R: usize> Solver<D, R> {
    pub fn new<const Q: usize>(beam: &Beam<D, R, Q>) -> Self {
        let zeros = vec![[0.0; D]; beam.places.len()];
        Self {
            work: beam.work(),
            increments: zeros.clone(),
            tried: zeros.clone(),
            direction: zeros.clone(),
            column: zeros,
            evaluations: 0,
            negative_pivots: 0,
            tolerance: 1.0,
        }
    }

    fn evaluate<const Q: usize>(
        &mut self,
        beam: &Beam<D, R, Q>,
        state: &State<D, R>,
        kind: Kind,
        striker: &mut Option<(&mut Striker, [f64; 2])>,
        with_matrix: bool,
    ) -> f64 {
        self.evaluations += 1;
        let work = &mut self.work;
        beam.evaluate(state, &self.tried, kind, with_matrix, work);
        if let (Some((striker, normal)), Kind::Motion { secs }) = (striker, kind) {
            let plane = D == 3;
            for touch in &mut striker.touches {
                let moved = &self.tried[touch.node];
                touch.moved = normal[0] * moved[1];
                if !plane {
                    touch.moved += normal[1] * moved[2];
                }
            }
            striker.solve(secs);
            for touch in &striker.touches {
                work.residual[touch.node][1] -= normal[0] * touch.force;
                if !plane {
                    work.residual[touch.node][2] -= normal[1] * touch.force;
                }
                if with_matrix {
                    let block = &mut work.matrix.diagonal[touch.node];
                    for i in 0..dimensions(D) - 1 {
                        for j in 0..dimensions(D) - 1 {
                            block[1 + i][1 + j] += touch.slope * normal[i] * normal[j];
                        }
                    }
                }
            }
        }
        let dim = dimensions(D);
        let mut largest: f64 = 0.0;
        for residual in &work.residual {
            for (k, value) in residual.iter().enumerate() {
                let size = if k < dim { *value } else { *value / LEVER };
                largest = largest.max(size.abs());
                if size.is_nan() {
                    return f64::NAN;
                }
            }
        }
        largest
    }

    /// Finds the direction of Newton's method; the face of the vehicle couples all nodes behind it.
    fn solve_direction(&mut self, striker: &Option<(&mut Striker, [f64; 2])>) {
        self.negative_pivots = self.work.matrix.factor();
        for (to, from) in self.direction.iter_mut().zip(&self.work.residual) {
            for k in 0..D {
                to[k] = -from[k];
            }
        }
        self.work.matrix.solve(&mut self.direction);
        let Some((striker, normal)) = striker else {
            return;
        };
        if striker.touches.iter().all(|touch| touch.slope == 0.0) {
            return;
        }
        self.column.fill([0.0; D]);
        for touch in &striker.touches {
            for i in 0..dimensions(D) - 1 {
                self.column[touch.node][1 + i] = touch.slope * normal[i];
            }
        }
        let along = |x: &[[f64; D]]| {
            let mut sum = 0.0;
            for touch in &striker.touches {
                for i in 0..dimensions(D) - 1 {
                    sum += touch.slope * normal[i] * x[touch.node][1 + i];
                }
            }
            sum
        };
        self.work.matrix.solve(&mut self.column);
        let factor = along(&self.direction) / (striker.stiffness - along(&self.column));
        for (to, column) in self.direction.iter_mut().zip(&self.column) {
            for k in 0..D {
                to[k] += factor * column[k];
            }
        }
    }

    /// Solves from `increments` on; whether it converged.
    pub fn solve<const Q: usize>(
        &mut self,
        beam: &Beam<D, R, Q>,
        state: &State<D, R>,
        kind: Kind,
        mut striker: Option<(&mut Striker, [f64; 2])>,
    ) -> bool {
        beam.prepare(state, &mut self.work);
        self.tried.clone_from_slice(&self.increments);
        let mut size = self.evaluate(beam, state, kind, &mut striker, true);
        for _ in 0..MAX_ITERATIONS {
            if size <= self.tolerance {
                self.increments.clone_from_slice(&self.tried);
                return true;
            }
            if !size.is_finite() {
                return false;
            }
            self.solve_direction(&striker);
            let start: f64 = self.slope();
            self.increments.clone_from_slice(&self.tried);
            let (mut low, mut high) = ((0.0, start), None);
            let mut share = 1.0;
            for trial in 0..MAX_TRIALS {
                for (to, (from, by)) in self
                    .tried
                    .iter_mut()
                    .zip(self.increments.iter().zip(&self.direction))
                {
                    for k in 0..D {
                        to[k] = from[k] + share * by[k];
                    }
                }
                let new = self.evaluate(beam, state, kind, &mut striker, true);
                let slope = self.slope();
                let enough = slope.abs() <= 0.6 * start.abs() || new <= 0.3 * size;
                if (enough || trial + 1 == MAX_TRIALS || start >= 0.0) && new.is_finite() {
                    size = new;
                    break;
                }
                if !new.is_finite() {
                    share *= 0.25;
                    size = f64::NAN;
                    continue;
                }
                // Regula falsi: the slope of a convex function rises through zero.
                if slope < 0.0 {
                    low = (share, slope);
                } else {
                    high = Some((share, slope));
                }
                size = new;
                let Some((above, slope_above)) = high else {
                    break;
                };
                let (below, slope_below) = low;
                share = below + (above - below) * slope_below / (slope_below - slope_above);
                let room = 0.1 * (above - below);
                share = share.clamp(below + room, above - room);
            }
        }
        false
    }

    /// Residual times direction.
    fn slope(&self) -> f64 {
        let mut sum = 0.0;
        for (residual, direction) in self.work.residual.iter().zip(&self.direction) {
            for k in 0..D {
                sum += residual[k] * direction[k];
            }
        }
        sum
    }
}
