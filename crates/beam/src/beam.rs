//! The beam: its nodes, its state, and the forces and stiffness of a trial increment.

use super::element::{
    Chord, Ends, Part, Triad, UPRIGHT, angles, deformations, gradient, turn_in_plane,
    turn_to_angles, turned,
};
use super::parts::{Element, RotationSpring};
use super::section::{PointState, Section};
use super::tridiagonal::Tridiagonal;

/// Integration points of an element, after Gauss.
pub(crate) const POINTS: usize = 2;

/// Their places along the element.
const PLACES: [f64; POINTS] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// Parts of the column that shear: below and above the impact point.
pub(crate) const BARS: usize = 2;

/// What does not change during an impact.
#[derive(Debug, Clone)]
pub(crate) struct Beam<const D: usize, const R: usize, const Q: usize> {
    pub section: Section,
    pub places: Vec<[f64; 3]>,
    pub elements: Vec<Element<R>>,
    /// Mass \[kg\] and rotary inertia about x, y, z of the section \[kg m²\].
    pub inertia: Vec<[f64; 4]>,
    /// Which unknowns do not move.
    pub held: Vec<[bool; D]>,
    pub rotation_springs: Vec<RotationSpring>,
    pub top_spring: f64,
    pub top_load: f64,
    /// Effective `G I_t` \[N m²\].
    pub torsional_rigidity: f64,
    pub rate: Option<super::rate::Rate>,
}

/// What changes.
#[derive(Debug, Clone)]
pub(crate) struct State<const D: usize, const R: usize> {
    pub moved: Vec<[f64; 3]>,
    pub triads: Vec<Triad>,
    /// Translation along x, y, z and rotation about the axes of the section.
    pub velocity: Vec<[f64; 6]>,
    pub deformation: Vec<[f64; R]>,
    pub forces: Vec<[f64; R]>,
    /// Shear angle of the part of the column below and above the impact point. It is one for each part: the flanges, which a
    /// plane section lets shear freely, hold the web from shearing in a short length.
    pub shear: [f64; BARS],
    /// What drives the shear angle of each element against its moments \[N m\].
    pub shear_forces: Vec<f64>,
    pub sliders: Vec<[f64; 2]>,
    pub points: Vec<PointState>,
    pub yielded: Vec<bool>,
    /// Filtered strain rate \[1/s\] and its factor of the strength.
    pub rates: Vec<[f64; 2]>,
}

/// Memory of the evaluations: allocated once.
#[derive(Debug, Clone)]
pub(crate) struct Work<const D: usize, const R: usize> {
    pub residual: Vec<[f64; D]>,
    /// What the base exerts on the column, forces and moments, before its equations are replaced.
    pub base: [f64; D],
    pub matrix: Tridiagonal<D>,
    /// What the matrix needs of each element.
    pub(super) parts: Vec<Part<R>>,
    /// The chord of each element where the increment begins \[m\], and the inverse of its length \[1/m\].
    from: Vec<([f64; 3], f64)>,
    /// The deformations of each element there, with the sines of its rotations.
    sines: Vec<[f64; R]>,
    pub(super) middle: Vec<Triad>,
    pub(super) end: Vec<Triad>,
    deformation: Vec<[f64; R]>,
    forces: Vec<[f64; R]>,
    shear_forces: Vec<f64>,
    sliders: Vec<[f64; 2]>,
    /// Residual and stiffness of the shear angles, and their coupling with the other unknowns.
    pub shear_residual: [f64; BARS],
    pub shear_stiffness: [f64; BARS],
    pub shear_columns: [Vec<[f64; D]>; BARS],
    flows: Vec<bool>,
    /// Strains of the sections that were not elastic beyond doubt.
    strains: Vec<[f64; 4]>,
}

impl<const D: usize, const R: usize> Work<D, R> {
    /// Whether any fibre flows in the trial increment.
    pub fn flows(&self) -> bool {
        self.flows.iter().any(|flows| *flows)
    }
}

/// A step in time or an increment of equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    Motion { secs: f64 },
    Equilibrium,
}

impl Kind {
    /// Share of an increment that reaches the place where forces are in balance: the middle of a step, the end of an increment.
    pub fn share(self) -> f64 {
        match self {
            Self::Motion { .. } => 0.5,
            Self::Equilibrium => 1.0,
        }
    }
}

/// Number of translations of a node.
pub(crate) const fn dimensions(d: usize) -> usize {
    if d == 3 { 2 } else { 3 }
}

impl<const D: usize, const R: usize, const Q: usize> Beam<D, R, Q> {
    /// The rotation of an increment as a vector.
    fn rotation(increment: &[f64; D]) -> [f64; 3] {
        if D == 3 {
            [0.0, 0.0, increment[2]]
        } else {
            [increment[3], increment[4], increment[5]]
        }
    }

    fn translation(increment: &[f64; D]) -> [f64; 3] {
        if D == 3 {
            [increment[0], increment[1], 0.0]
        } else {
            [increment[0], increment[1], increment[2]]
        }
    }

    pub fn undamaged(&self) -> State<D, R> {
        let (nodes, elements) = (self.places.len(), self.elements.len());
        let initial = self
            .elements
            .iter()
            .map(|element| element.initial)
            .collect();
        State {
            moved: vec![[0.0; 3]; nodes],
            triads: vec![UPRIGHT; nodes],
            velocity: vec![[0.0; 6]; nodes],
            deformation: initial,
            forces: vec![[0.0; R]; elements],
            shear: [0.0; BARS],
            shear_forces: vec![0.0; elements],
            sliders: vec![[0.0; 2]; elements],
            points: vec![self.section.undamaged(); POINTS * elements],
            yielded: vec![false; POINTS * elements],
            rates: vec![[0.0, 1.0]; POINTS * elements],
        }
    }

    pub fn work(&self) -> Work<D, R> {
        let state = self.undamaged();
        let nodes = self.places.len();
        Work {
            residual: vec![[0.0; D]; nodes],
            base: [0.0; D],
            matrix: Tridiagonal::new(nodes),
            parts: vec![Part::nothing(); self.elements.len()],
            from: vec![([0.0; 3], 0.0); self.elements.len()],
            sines: vec![[0.0; R]; self.elements.len()],
            middle: state.triads.clone(),
            end: state.triads,
            deformation: state.deformation,
            forces: state.forces,
            shear_forces: state.shear_forces,
            sliders: state.sliders,
            shear_residual: [0.0; BARS],
            shear_stiffness: [0.0; BARS],
            shear_columns: [vec![[0.0; D]; nodes], vec![[0.0; D]; nodes]],
            flows: state.yielded,
            strains: vec![[0.0; 4]; state.points.len()],
        }
    }

    /// Prepares for evaluations of increments that begin in this state.
    pub fn begin(&self, state: &State<D, R>, work: &mut Work<D, R>) {
        for (element, (chord, inverse)) in work.from.iter_mut().enumerate() {
            for (k, value) in chord.iter_mut().enumerate() {
                *value = (self.places[element + 1][k] - self.places[element][k])
                    + (state.moved[element + 1][k] - state.moved[element][k]);
            }
            let triads = [&state.triads[element], &state.triads[element + 1]];
            let begin = Ends::new::<R>(*chord, triads);
            *inverse = begin.inverse;
            work.sines[element] = deformations(&begin, self.elements[element].length);
        }
    }

    /// The residual of a trial increment, after [`Beam::begin`]. Contact is added by the caller.
    pub fn evaluate(
        &self,
        state: &State<D, R>,
        (increments, shear): (&[[f64; D]], &[f64; BARS]),
        kind: Kind,
        work: &mut Work<D, R>,
    ) {
        let share = kind.share();
        for value in &mut work.residual {
            *value = [0.0; D];
        }
        work.shear_residual = [0.0; BARS];
        for (node, increment) in increments.iter().enumerate() {
            let psi = Self::rotation(increment);
            let triad = &state.triads[node];
            let (middle, end) = (&mut work.middle[node], &mut work.end[node]);
            if D == 3 {
                turn_in_plane(triad, psi[2], middle, end);
            } else {
                (*middle, *end) = turned(triad, &psi);
            }
        }
        for element in 0..self.elements.len() {
            self.add_element(state, (increments, shear), element, share, work);
        }
        if let Kind::Motion { secs } = kind {
            self.add_inertia(state, increments, secs, work);
        }
        // Without the springs: what they bear is a reaction of the base, too.
        work.base = work.residual[0];
        self.add_supports(state, increments, share, work);
        for (residual, held) in work.residual.iter_mut().zip(&self.held) {
            for (value, held) in residual.iter_mut().zip(held) {
                if *held {
                    *value = 0.0;
                }
            }
        }
    }

    fn add_element(
        &self,
        state: &State<D, R>,
        (increments, shear): (&[[f64; D]], &[f64; BARS]),
        index: usize,
        share: f64,
        work: &mut Work<D, R>,
    ) {
        let dim = dimensions(D);
        let element = &self.elements[index];
        let (from, inverse) = work.from[index];
        let (one, two) = (
            Self::translation(&increments[index]),
            Self::translation(&increments[index + 1]),
        );
        let to = [0, 1, 2].map(|k| from[k] + (two[k] - one[k]));
        let end = Ends::new::<R>(to, [&work.end[index], &work.end[index + 1]]);
        let inverses = [inverse, end.inverse];
        let sines: [f64; R] = deformations(&end, element.length);
        let d = angles(&sines);
        work.deformation[index] = d;
        let gamma = element.bar.map_or(0.0, |bar| state.shear[bar] + shear[bar]);
        let Responded {
            forces: new_forces,
            mut stiffness,
            balance,
            own,
            mixed,
        } = self.respond(state, index, &d, gamma, work);
        work.shear_forces[index] = balance;
        if let Some(bar) = element.bar {
            work.shear_residual[bar] += (1.0 - share) * state.shear_forces[index] + share * balance;
        }
        work.forces[index] = new_forces;
        let forces: [f64; R] =
            std::array::from_fn(|k| (1.0 - share) * state.forces[index][k] + share * new_forces[k]);
        let triads = if share == 0.5 {
            [&work.middle[index], &work.middle[index + 1]]
        } else {
            [&work.end[index], &work.end[index + 1]]
        };
        let chord = if share == 0.5 {
            Chord::new::<R>([&from, &to], inverses)
        } else {
            Chord::new::<R>([&to, &to], [inverses[1]; 2])
        };
        let mut rows: [[f64; Q]; R] = gradient(&chord, triads);
        let before = if share == 0.5 {
            &work.sines[index]
        } else {
            &sines
        };
        let of_sines = turn_to_angles([before, &sines], &forces, &mut rows, &mut stiffness);
        let mut total = [0.0; Q];
        for (row, force) in rows.iter().zip(&forces) {
            for k in 0..Q {
                total[k] += row[k] * force;
            }
        }
        let (first, second) = (dim, Q - (D - dim));
        for k in 0..dim {
            work.residual[index][k] -= total[k];
            work.residual[index + 1][k] += total[k];
        }
        for k in 0..D - dim {
            work.residual[index][dim + k] += total[first + k];
            work.residual[index + 1][dim + k] += total[second + k];
        }
        let part = &mut work.parts[index];
        for (to, row) in part.rows.iter_mut().zip(&rows) {
            to[..Q].copy_from_slice(row);
        }
        part.chord = chord;
        part.forces = of_sines;
        part.stiffness = stiffness;
        part.own = own;
        part.mixed = mixed;
    }

    /// Whether any part of the column shears.
    pub fn shears(&self) -> bool {
        self.section.web_rigidity > 0.0
    }

    /// Where the sheared part below the impact point ends and the one above begins \[m\].
    pub fn sheared(&self) -> [f64; BARS] {
        let ends = |bar: usize| {
            let of_bar = self
                .elements
                .iter()
                .enumerate()
                .filter(move |(_, it)| it.bar == Some(bar));
            of_bar.map(|(index, _)| index)
        };
        let low = ends(0)
            .next_back()
            .map_or(0.0, |last| self.places[last + 1][0]);
        let high = ends(1)
            .next()
            .map_or(f64::MAX, |first| self.places[first][0]);
        [low, high]
    }

    /// The element of the integration point of this number, and how far along it the point lies, from 0 to 1.
    pub fn point(&self, index: usize) -> (usize, f64) {
        (index / POINTS, PLACES[index % POINTS])
    }

    /// Strain at an integration point of an element.
    pub fn strain(&self, index: usize, point: usize, d: &[f64; R], gamma: f64) -> [f64; 4] {
        let per = 1.0 / self.elements[index].length;
        let (b1, b2) = (-4.0 + 6.0 * PLACES[point], -2.0 + 6.0 * PLACES[point]);
        let weak = if R == 6 {
            (b1 * d[R - 3] + b2 * d[R - 2]) * per
        } else {
            0.0
        };
        let bending = (b1 * (d[1] - gamma) + b2 * (d[2] - gamma)) * per;
        [d[0] * per, bending, weak, gamma]
    }

    /// Forces and stiffness of an element with deformations `d` and the shear angle `gamma`.
    fn respond(
        &self,
        state: &State<D, R>,
        index: usize,
        d: &[f64; R],
        gamma: f64,
        work: &mut Work<D, R>,
    ) -> Responded<R> {
        let element = &self.elements[index];
        let l = element.length;
        let d: [f64; R] = std::array::from_fn(|k| d[k] - element.initial[k]);
        let strains: [[f64; 4]; POINTS] =
            std::array::from_fn(|point| self.strain(index, point, &d, gamma));
        let strength = |place: usize| self.section.steel.yield_strength * state.rates[place][1];
        let stays_elastic: [bool; POINTS] = std::array::from_fn(|point| {
            let place = POINTS * index + point;
            !state.yielded[place] && self.section.stays_elastic(&strains[point], strength(place))
        });
        // The points that are left to compute.
        let (mut to, points) = if stays_elastic == [true; POINTS] {
            work.flows[POINTS * index..POINTS * (index + 1)].fill(false);
            (self.respond_elastically(index, &d, gamma), 0)
        } else {
            (Responded::nothing(), POINTS)
        };
        let per_length = 1.0 / l;
        for point in 0..points {
            let place = POINTS * index + point;
            let (b1, b2) = (-4.0 + 6.0 * PLACES[point], -2.0 + 6.0 * PLACES[point]);
            let (strain, strength) = (strains[point], strength(place));
            let (f, c, flows) = if stays_elastic[point] {
                let rigidity = self.section.elastic();
                let (mut f, mut c) = ([0.0; 4], [[0.0; 4]; 4]);
                for k in 0..4 {
                    f[k] = rigidity[k] * strain[k];
                    c[k][k] = rigidity[k];
                }
                (f, c, false)
            } else {
                let (section, from) = (&self.section, &state.points[place]);
                work.strains[place] = strain;
                if R == 6 {
                    section.respond::<true>(&strain, strength, from)
                } else {
                    section.respond::<false>(&strain, strength, from)
                }
            };
            work.flows[place] = flows;
            // Each deformation is one strain times a coefficient.
            let parts = [(0, 1.0), (1, b1), (1, b2), (2, b1), (2, b2)];
            let count = R.min(5);
            for i in 0..count {
                let (row, ci) = parts[i];
                to.forces[i] += 0.5 * ci * f[row];
                for j in 0..=i {
                    let (column, cj) = parts[j];
                    let value = 0.5 * per_length * ci * cj * c[row][column];
                    to.stiffness[i][j] += value;
                    if i != j {
                        to.stiffness[j][i] += value;
                    }
                }
            }
            if element.bar.is_some() {
                let b = (b1 + b2) * per_length;
                for i in 0..count {
                    let (row, ci) = parts[i];
                    to.mixed[i] += 0.5 * ci * (c[row][3] - b * c[row][1]);
                }
                to.balance += 0.5 * l * (f[3] - b * f[1]);
                to.own += 0.5 * l * (c[3][3] - 2.0 * b * c[1][3] + b * b * c[1][1]);
            }
        }
        if element.bar.is_some() {
            for (slider, plastic) in element.sliders.iter().zip(0..2) {
                let (force, tangent, new) = slider.respond(gamma, state.sliders[index][plastic]);
                to.balance += l * force;
                to.own += l * tangent;
                work.sliders[index][plastic] = new;
            }
        }
        if R == 6 {
            let rigidity = self.torsional_rigidity * per_length;
            to.forces[R - 1] = rigidity * d[R - 1];
            to.stiffness[R - 1][R - 1] = rigidity;
        }
        to
    }

    /// The same while no fibre reaches its yield strength anywhere in the element: the integrals over the fibres and along the
    /// element are those of an elastic bar.
    fn respond_elastically(&self, index: usize, d: &[f64; R], gamma: f64) -> Responded<R> {
        let element = &self.elements[index];
        let l = element.length;
        let &[axial, strong, weak, web] = self.section.elastic();
        let mut to = Responded::nothing();
        let per_length = 1.0 / l;
        to.forces[0] = axial * per_length * d[0];
        to.stiffness[0][0] = axial * per_length;
        let mut bend = |first: usize, rigidity: f64, [one, two]: [f64; 2]| {
            let per = 2.0 * rigidity * per_length;
            to.forces[first] = per * (2.0 * one + two);
            to.forces[first + 1] = per * (one + 2.0 * two);
            to.stiffness[first][first] = 2.0 * per;
            to.stiffness[first + 1][first + 1] = 2.0 * per;
            to.stiffness[first][first + 1] = per;
            to.stiffness[first + 1][first] = per;
        };
        let turns = [d[1] - gamma, d[2] - gamma];
        bend(1, strong, turns);
        if R == 6 {
            bend(R - 3, weak, [d[R - 3], d[R - 2]]);
        }
        if element.bar.is_some() {
            let per = 6.0 * strong * per_length;
            to.mixed[1] = -per;
            to.mixed[2] = -per;
            to.balance = l * web * gamma - per * (turns[0] + turns[1]);
            to.own = l * web + 2.0 * per;
        }
        to
    }

    fn add_inertia(
        &self,
        state: &State<D, R>,
        increments: &[[f64; D]],
        secs: f64,
        work: &mut Work<D, R>,
    ) {
        let per = 2.0 / (secs * secs);
        let dim = dimensions(D);
        for (node, inertia) in self.inertia.iter().enumerate() {
            let (increment, velocity) = (&increments[node], &state.velocity[node]);
            let mass = per * inertia[0];
            for k in 0..dim {
                work.residual[node][k] += mass * (increment[k] - secs * velocity[k]);
            }
            if D == 3 {
                let rotary = per * inertia[3];
                work.residual[node][2] += rotary * (increment[2] - secs * velocity[5]);
                continue;
            }
            let triad = &state.triads[node];
            let psi = Self::rotation(increment);
            for axis in 0..3 {
                let rotary = per * inertia[1 + axis];
                let director = &triad[axis];
                let turn = super::element::dot(director, &psi) - secs * velocity[3 + axis];
                for i in 0..3 {
                    work.residual[node][dim + i] += rotary * turn * director[i];
                }
            }
        }
    }

    fn add_supports(
        &self,
        state: &State<D, R>,
        increments: &[[f64; D]],
        share: f64,
        work: &mut Work<D, R>,
    ) {
        let top = self.places.len() - 1;
        let moved = state.moved[top][0] + share * increments[top][0];
        work.residual[top][0] += self.top_spring * moved + self.top_load;
        for spring in &self.rotation_springs {
            let at = if share == 0.5 {
                &work.middle[spring.node]
            } else {
                &work.end[spring.node]
            };
            // The sines of the rotations are components of the director along the column.
            let mean = |k: usize| {
                (1.0 - share) * state.triads[spring.node][0][k]
                    + share * work.end[spring.node][0][k]
            };
            let dim = dimensions(D);
            if D == 3 {
                work.residual[spring.node][2] += spring.stiffness * mean(1) * at[0][0];
                continue;
            }
            for k in 1..3 {
                let mut axis = [0.0; 3];
                axis[k] = 1.0;
                let lever = super::element::cross(&at[0], &axis);
                for i in 0..3 {
                    work.residual[spring.node][dim + i] += spring.stiffness * mean(k) * lever[i];
                }
            }
        }
    }

    /// Takes the trial increment over into the state; returns the work done on the fibres \[J\].
    pub fn commit(
        &self,
        state: &mut State<D, R>,
        (increments, shear): (&[[f64; D]], &[f64; BARS]),
        kind: Kind,
        work: &Work<D, R>,
    ) -> f64 {
        let mut done = 0.0;
        for (index, element) in self.elements.iter().enumerate() {
            if let Some(bar) = element.bar {
                let mean = 0.5 * (state.shear_forces[index] + work.shear_forces[index]);
                done += mean * shear[bar];
            }
            for k in 0..R {
                let mean = 0.5 * (state.forces[index][k] + work.forces[index][k]);
                done += mean * (work.deformation[index][k] - state.deformation[index][k]);
            }
        }
        for (place, flows) in work.flows.iter().enumerate() {
            if *flows {
                state.yielded[place] = true;
                let strength = self.section.steel.yield_strength * state.rates[place][1];
                self.section
                    .flow(&work.strains[place], strength, &mut state.points[place]);
            }
        }
        if let Kind::Motion { secs } = kind {
            self.follow_rates(state, shear, secs, work);
            for (node, increment) in increments.iter().enumerate() {
                let velocity = &mut state.velocity[node];
                let moved = Self::translation(increment);
                let psi = Self::rotation(increment);
                for k in 0..3 {
                    velocity[k] = 2.0 / secs * moved[k] - velocity[k];
                    let turn = super::element::dot(&state.triads[node][k], &psi);
                    velocity[3 + k] = 2.0 / secs * turn - velocity[3 + k];
                }
            }
        }
        for (moved, increment) in state.moved.iter_mut().zip(increments) {
            for (value, by) in moved.iter_mut().zip(Self::translation(increment)) {
                *value += by;
            }
        }
        state.triads.copy_from_slice(&work.end);
        state.deformation.copy_from_slice(&work.deformation);
        state.forces.copy_from_slice(&work.forces);
        if self.shears() {
            for (angle, by) in state.shear.iter_mut().zip(shear) {
                *angle += by;
            }
            state.shear_forces.copy_from_slice(&work.shear_forces);
            state.sliders.copy_from_slice(&work.sliders);
        }
        done
    }

    fn follow_rates(
        &self,
        state: &mut State<D, R>,
        shear: &[f64; BARS],
        secs: f64,
        work: &Work<D, R>,
    ) {
        let Some(rate) = &self.rate else { return };
        for index in 0..self.elements.len() {
            let change: [f64; R] =
                std::array::from_fn(|k| work.deformation[index][k] - state.deformation[index][k]);
            let sheared = self.elements[index].bar.map_or(0.0, |bar| shear[bar]);
            for point in 0..POINTS {
                let [axial, bent, weak, _] = self.strain(index, point, &change, sheared);
                let reach = self.section.reach();
                let outer = axial.abs() + reach[0] * bent.abs() + reach[1] * weak.abs();
                let web = sheared.abs() / 3.0_f64.sqrt();
                rate.follow(
                    &mut state.rates[POINTS * index + point],
                    outer.max(web) / secs,
                    secs,
                );
            }
        }
    }
}

/// What an element does to its deformations.
struct Responded<const R: usize> {
    forces: [f64; R],
    stiffness: [[f64; R]; R],
    /// Force of the shear angle and its derivatives by the angle and by the deformations.
    balance: f64,
    own: f64,
    mixed: [f64; R],
}

impl<const R: usize> Responded<R> {
    fn nothing() -> Self {
        Self {
            forces: [0.0; R],
            stiffness: [[0.0; R]; R],
            balance: 0.0,
            own: 0.0,
            mixed: [0.0; R],
        }
    }
}
