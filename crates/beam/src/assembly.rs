//! The stiffness of a trial increment, from what its evaluation has found of each element: only where a direction is sought, because
//! an increment that is in balance needs none.

use super::beam::{Beam, Kind, State, Work, dimensions};
use super::element::{add_in_plane, add_in_space, cross, geometric};

impl<const D: usize, const R: usize, const Q: usize> Beam<D, R, Q> {
    /// The stiffness at the trial increment that was evaluated last, of a step or an increment that begins in `state`. Contact is
    /// added by the caller.
    pub fn assemble(&self, state: &State<D, R>, kind: Kind, work: &mut Work<D, R>) {
        let share = kind.share();
        work.matrix.clear();
        if self.shears() {
            work.shear_stiffness.fill(0.0);
            for column in &mut work.shear_columns {
                column.fill([0.0; D]);
            }
        }
        for index in 0..self.elements.len() {
            self.assemble_element(index, share, work);
        }
        if let Kind::Motion { secs } = kind {
            self.assemble_inertia(state, secs, work);
        }
        self.assemble_supports(share, work);
        for (node, held) in self.held.iter().enumerate() {
            for (unknown, held) in held.iter().enumerate() {
                if *held {
                    work.matrix.hold(node, unknown);
                    for column in &mut work.shear_columns {
                        column[node][unknown] = 0.0;
                    }
                }
            }
        }
    }

    fn assemble_element(&self, index: usize, share: f64, work: &mut Work<D, R>) {
        let dim = dimensions(D);
        let (first, second) = (dim, Q - (D - dim));
        let part = &work.parts[index];
        let rows: [[f64; Q]; R] =
            std::array::from_fn(|row| std::array::from_fn(|k| part.rows[row][k]));
        if let Some(bar) = self.elements[index].bar {
            work.shear_stiffness[bar] += share * part.own;
            let mut column = [0.0; Q];
            for (row, force) in rows.iter().zip(&part.mixed) {
                for k in 0..Q {
                    column[k] += share * row[k] * force;
                }
            }
            let to = &mut work.shear_columns[bar];
            for k in 0..dim {
                to[index][k] -= column[k];
                to[index + 1][k] += column[k];
            }
            for k in 0..D - dim {
                to[index][dim + k] += column[first + k];
                to[index + 1][dim + k] += column[second + k];
            }
        }
        let mut k_all = [[0.0; Q]; Q];
        if R == 3 {
            add_in_plane(&rows, &part.stiffness, share, &mut k_all);
        } else {
            add_in_space(&rows, &part.stiffness, share, &mut k_all);
        }
        let triads = if share == 0.5 {
            [&work.middle[index], &work.middle[index + 1]]
        } else {
            [&work.end[index], &work.end[index + 1]]
        };
        geometric::<R, Q>(&part.chord, triads, &part.forces, share, &mut k_all);
        let (before, after) = work.matrix.diagonal.split_at_mut(index + 1);
        let (one, two) = (&mut before[index], &mut after[0]);
        let coupling = &mut work.matrix.coupling[index];
        for i in 0..dim {
            for j in 0..dim {
                let value = k_all[i][j];
                one[i][j] += value;
                two[i][j] += value;
                coupling[i][j] -= value;
            }
            for j in 0..D - dim {
                let (near, far) = (k_all[i][first + j], k_all[i][second + j]);
                one[i][dim + j] -= near;
                one[dim + j][i] -= near;
                coupling[dim + j][i] += near;
                two[i][dim + j] += far;
                two[dim + j][i] += far;
                coupling[i][dim + j] -= far;
            }
        }
        for i in 0..D - dim {
            for j in 0..D - dim {
                one[dim + i][dim + j] += k_all[first + i][first + j];
                two[dim + i][dim + j] += k_all[second + i][second + j];
                coupling[dim + i][dim + j] += k_all[first + i][second + j];
            }
        }
    }

    fn assemble_inertia(&self, state: &State<D, R>, secs: f64, work: &mut Work<D, R>) {
        let per = 2.0 / (secs * secs);
        let dim = dimensions(D);
        for (node, inertia) in self.inertia.iter().enumerate() {
            let block = &mut work.matrix.diagonal[node];
            for k in 0..dim {
                block[k][k] += per * inertia[0];
            }
            if D == 3 {
                block[2][2] += per * inertia[3];
                continue;
            }
            for (director, inertia) in state.triads[node].iter().zip(&inertia[1..]) {
                let rotary = per * inertia;
                for i in 0..3 {
                    for j in 0..3 {
                        block[dim + i][dim + j] += rotary * director[i] * director[j];
                    }
                }
            }
        }
    }

    fn assemble_supports(&self, share: f64, work: &mut Work<D, R>) {
        let top = self.places.len() - 1;
        work.matrix.diagonal[top][0][0] += share * self.top_spring;
        let dim = dimensions(D);
        for spring in &self.rotation_springs {
            let block = &mut work.matrix.diagonal[spring.node];
            if D == 3 {
                block[2][2] += share * spring.stiffness;
                continue;
            }
            let at = if share == 0.5 {
                &work.middle[spring.node]
            } else {
                &work.end[spring.node]
            };
            for k in 1..3 {
                let mut axis = [0.0; 3];
                axis[k] = 1.0;
                let lever = cross(&at[0], &axis);
                for i in 0..3 {
                    for j in 0..3 {
                        block[dim + i][dim + j] += share * spring.stiffness * lever[i] * lever[j];
                    }
                }
            }
        }
    }
}
