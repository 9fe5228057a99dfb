//! Newton's method with a line search for a step in time or an increment of equilibrium.

use super::beam::{BARS, Beam, Kind, State, Work, dimensions};
use super::contact::Striker;

/// Iterations of a step; four are usual.
const MAX_ITERATIONS: usize = 40;

/// Iterations that are spent beyond the tolerance of the forces on that of the energy: rounding may not allow it.
const MAX_REFINEMENTS: usize = 3;

/// Trials along a direction.
const MAX_TRIALS: usize = 8;

/// Residual moments count as forces at this lever \[m\].
const LEVER: f64 = 0.1;

/// Unknowns that couple with many nodes: the face of the vehicle and the shear angles.
const BORDERS: usize = 1 + BARS;

/// A very stiff spring that pushes an unknown of a node, so that the first direction already spreads the push over the column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Push {
    pub node: usize,
    pub unknown: usize,
    pub stiffness: f64,
    /// Where it pulls the unknown to in this increment \[m\].
    pub target: f64,
    /// Its force on the column at the end of the last increment \[N\].
    pub force: f64,
}

impl Push {
    /// Advances by `step` \[m\].
    pub fn aim(&mut self, step: f64) {
        self.target = step + self.force / self.stiffness;
    }
}

/// The unknowns and the memory of a solution.
#[derive(Debug, Clone)]
pub(crate) struct Solver<const D: usize, const R: usize> {
    pub work: Work<D, R>,
    pub increments: Vec<[f64; D]>,
    pub shear: [f64; BARS],
    tried: Vec<[f64; D]>,
    tried_shear: [f64; BARS],
    direction: Vec<[f64; D]>,
    direction_shear: [f64; BARS],
    columns: [Vec<[f64; D]>; BORDERS],
    /// The last increment of a push and its length \[m\].
    last: Vec<[f64; D]>,
    last_shear: [f64; BARS],
    last_step: f64,
    pub pushes: Vec<Push>,
    /// Evaluations so far.
    pub evaluations: u64,
    /// Negative pivots of the last factorisation.
    pub negative_pivots: usize,
    /// Whether the last solution has needed a factorisation.
    has_factored: bool,
    /// Largest residual that is accepted \[N\].
    pub tolerance: f64,
    /// Largest energy that a step may lose: the residual times the increment \[J\].
    pub energy_tolerance: f64,
    /// What the steps so far have lost together, as magnitudes \[J\].
    pub energy_lost: f64,
}

impl<const D: usize, const R: usize> Solver<D, R> {
    pub fn new<const Q: usize>(beam: &Beam<D, R, Q>) -> Self {
        let zeros = vec![[0.0; D]; beam.places.len()];
        Self {
            work: beam.work(),
            increments: zeros.clone(),
            shear: [0.0; BARS],
            tried: zeros.clone(),
            tried_shear: [0.0; BARS],
            direction: zeros.clone(),
            direction_shear: [0.0; BARS],
            columns: [zeros.clone(), zeros.clone(), zeros.clone()],
            last: zeros,
            last_shear: [0.0; BARS],
            last_step: 1.0,
            pushes: Vec::new(),
            evaluations: 0,
            negative_pivots: 0,
            has_factored: false,
            tolerance: 1.0,
            energy_tolerance: f64::INFINITY,
            energy_lost: 0.0,
        }
    }

    /// Starts from no increment.
    pub fn begin(&mut self) {
        self.increments.fill([0.0; D]);
        self.shear = [0.0; BARS];
    }

    /// Keeps the increment that was found of a push by `step` \[m\], or none to begin with.
    pub fn remember(&mut self, step: f64) {
        self.last.copy_from_slice(&self.increments);
        self.last_shear = self.shear;
        self.last_step = step;
    }

    /// Starts from the increment that was kept, for a push by `step` \[m\].
    pub fn go_on(&mut self, step: f64) {
        let ratio = step / self.last_step;
        for (to, from) in self.increments.iter_mut().zip(&self.last) {
            *to = from.map(|value| ratio * value);
        }
        self.shear = self.last_shear.map(|angle| ratio * angle);
    }

    /// Whether the equilibrium that was found is unstable.
    pub fn is_unstable<const Q: usize>(
        &mut self,
        beam: &Beam<D, R, Q>,
        state: &State<D, R>,
    ) -> bool {
        if !self.has_factored {
            // The start was the solution already.
            self.assemble(beam, state, Kind::Equilibrium, &None);
            self.negative_pivots = self.work.matrix.factor();
        }
        self.negative_pivots > 0
    }

    /// The increment that was found.
    pub fn increment(&self) -> (&[[f64; D]], &[f64; BARS]) {
        (&self.increments, &self.shear)
    }

    fn evaluate<const Q: usize>(
        &mut self,
        beam: &Beam<D, R, Q>,
        state: &State<D, R>,
        kind: Kind,
        striker: &mut Option<(&mut Striker, [f64; 2])>,
    ) -> f64 {
        self.evaluations += 1;
        let work = &mut self.work;
        let tried = (self.tried.as_slice(), &self.tried_shear);
        beam.evaluate(state, tried, kind, work);
        for push in &self.pushes {
            let beyond = self.tried[push.node][push.unknown] - push.target;
            work.residual[push.node][push.unknown] += push.stiffness * beyond;
        }
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
            }
        }
        let dim = dimensions(D);
        let (mut largest, mut is_nan) = (0.0_f64, false);
        for residual in &work.residual {
            for (k, value) in residual.iter().enumerate() {
                let force = if k < dim { *value } else { *value / LEVER };
                let size = force.abs();
                is_nan |= size.is_nan();
                if size > largest {
                    largest = size;
                }
            }
        }
        if is_nan {
            return f64::NAN;
        }
        for value in &work.shear_residual {
            largest = largest.max(value.abs() / LEVER);
        }
        largest
    }

    /// The stiffness at the increment that was evaluated last.
    fn assemble<const Q: usize>(
        &mut self,
        beam: &Beam<D, R, Q>,
        state: &State<D, R>,
        kind: Kind,
        striker: &Option<(&mut Striker, [f64; 2])>,
    ) {
        beam.assemble(state, kind, &mut self.work);
        for push in &self.pushes {
            self.work.matrix.diagonal[push.node][push.unknown][push.unknown] += push.stiffness;
        }
        if let Some((striker, normal)) = striker {
            for touch in &striker.touches {
                let block = &mut self.work.matrix.diagonal[touch.node];
                for i in 0..dimensions(D) - 1 {
                    for j in 0..dimensions(D) - 1 {
                        block[1 + i][1 + j] += touch.slope * normal[i] * normal[j];
                    }
                }
            }
        }
    }

    /// Finds the direction of Newton's method: the blocks of the nodes first, then the unknowns that couple many of them.
    fn solve_direction(&mut self, striker: &Option<(&mut Striker, [f64; 2])>, shears: bool) {
        self.negative_pivots = self.work.matrix.factor();
        self.has_factored = true;
        for (to, from) in self.direction.iter_mut().zip(&self.work.residual) {
            for k in 0..D {
                to[k] = -from[k];
            }
        }
        let mut used = [false; BORDERS];
        let mut own = [1.0; BORDERS];
        let mut right = [0.0; BORDERS];
        // What couples each of them with the nodes, before and after the solution.
        if let Some((striker, normal)) = striker
            && striker.touches.iter().any(|touch| touch.slope != 0.0)
        {
            used[0] = true;
            own[0] = striker.stiffness;
            self.columns[0].fill([0.0; D]);
            for touch in &striker.touches {
                for i in 0..dimensions(D) - 1 {
                    self.columns[0][touch.node][1 + i] = -touch.slope * normal[i];
                }
            }
        }
        if shears {
            for bar in 0..BARS {
                used[1 + bar] = self.work.shear_stiffness[bar] != 0.0;
                own[1 + bar] = self.work.shear_stiffness[bar];
                right[1 + bar] = -self.work.shear_residual[bar];
                self.columns[1 + bar].clone_from_slice(&self.work.shear_columns[bar]);
            }
        }
        let (matrix, direction) = (&self.work.matrix, &mut self.direction);
        let [face, low, high] = &mut self.columns;
        match used {
            [false, false, false] => matrix.solve([direction]),
            [true, false, false] => matrix.solve([direction, face]),
            _ => {
                for (column, used) in [&mut *face, &mut *low, &mut *high].into_iter().zip(used) {
                    if !used {
                        column.fill([0.0; D]);
                    }
                }
                matrix.solve([direction, face, low, high]);
            }
        }
        let mut dense = [[0.0; BORDERS]; BORDERS];
        for k in 0..BORDERS {
            if used[k] {
                right[k] -= self.border_product(k, striker, &self.direction);
            } else {
                dense[k][k] = 1.0;
                right[k] = 0.0;
            }
        }
        for k in 0..BORDERS {
            for other in 0..BORDERS {
                if used[k] && used[other] {
                    let mine = if k == other { own[k] } else { 0.0 };
                    dense[k][other] = mine - self.border_product(k, striker, &self.columns[other]);
                }
            }
        }
        let factors = solve_dense(dense, right);
        for k in 0..BORDERS {
            if used[k] {
                for (to, column) in self.direction.iter_mut().zip(&self.columns[k]) {
                    for i in 0..D {
                        to[i] -= factors[k] * column[i];
                    }
                }
            }
        }
        self.direction_shear.copy_from_slice(&factors[1..]);
    }

    /// The product of a coupling as it was before its solution with `x`.
    fn border_product(
        &self,
        k: usize,
        striker: &Option<(&mut Striker, [f64; 2])>,
        x: &[[f64; D]],
    ) -> f64 {
        match (k, striker) {
            (0, Some((striker, normal))) => {
                let mut sum = 0.0;
                for touch in &striker.touches {
                    for i in 0..dimensions(D) - 1 {
                        sum -= touch.slope * normal[i] * x[touch.node][1 + i];
                    }
                }
                sum
            }
            (0, None) => 0.0,
            _ => product(&self.work.shear_columns[k - 1], x),
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
        self.tried.clone_from_slice(&self.increments);
        self.tried_shear = self.shear;
        self.has_factored = false;
        beam.begin(state, &mut self.work);
        let mut size = self.evaluate(beam, state, kind, &mut striker);
        let most = match kind {
            Kind::Motion { .. } => MAX_ITERATIONS,
            Kind::Equilibrium => 2 * MAX_ITERATIONS,
        };
        let mut refinements = 0;
        for iteration in 0..most {
            if size <= self.tolerance {
                let lost = self.lost().abs();
                if refinements == MAX_REFINEMENTS || lost <= self.energy_tolerance {
                    if let Kind::Motion { .. } = kind {
                        self.energy_lost += lost;
                    }
                    self.increments.clone_from_slice(&self.tried);
                    self.shear = self.tried_shear;
                    for push in &mut self.pushes {
                        let beyond = self.tried[push.node][push.unknown] - push.target;
                        push.force = -push.stiffness * beyond;
                    }
                    return true;
                }
                refinements += 1;
            }
            if !size.is_finite() {
                return false;
            }
            self.assemble(beam, state, kind, &striker);
            self.solve_direction(&striker, beam.shears());
            let start: f64 = self.slope();
            self.increments.clone_from_slice(&self.tried);
            self.shear = self.tried_shear;
            let (mut low, mut high) = ((0.0, start), None);
            let mut share = 1.0;
            let before = size;
            // The first direction of a step in time finds most of the fibres that flow, and is followed to its end: a search along
            // it takes more evaluations than it saves.
            let is_whole = iteration == 0 && matches!(kind, Kind::Motion { .. });
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
                for bar in 0..BARS {
                    self.tried_shear[bar] = self.shear[bar] + share * self.direction_shear[bar];
                }
                let new = self.evaluate(beam, state, kind, &mut striker);
                let slope = self.slope();
                let enough = is_whole || slope.abs() <= 0.6 * start.abs() || new <= 0.3 * before;
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
        self.work_on(&self.direction, &self.direction_shear)
    }

    /// What the trial increment would lose of the energy \[J\].
    fn lost(&self) -> f64 {
        self.work_on(&self.tried, &self.tried_shear)
    }

    fn work_on(&self, moved: &[[f64; D]], shear: &[f64; BARS]) -> f64 {
        let mut sum = product(&self.work.residual, moved);
        for (residual, angle) in self.work.shear_residual.iter().zip(shear) {
            sum += residual * angle;
        }
        sum
    }
}

fn product<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        for k in 0..D {
            sum += a[k] * b[k];
        }
    }
    sum
}

/// Elimination without pivoting; the matrix is symmetric and mostly positive.
fn solve_dense(mut m: [[f64; BORDERS]; BORDERS], mut right: [f64; BORDERS]) -> [f64; BORDERS] {
    for k in 0..BORDERS {
        for i in k + 1..BORDERS {
            let factor = m[i][k] / m[k][k];
            for j in k..BORDERS {
                m[i][j] -= factor * m[k][j];
            }
            right[i] -= factor * right[k];
        }
    }
    for k in (0..BORDERS).rev() {
        for j in k + 1..BORDERS {
            right[k] -= m[k][j] * right[j];
        }
        right[k] /= m[k][k];
    }
    right
}
