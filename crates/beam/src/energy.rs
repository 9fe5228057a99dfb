//! The energy of a beam.

use super::beam::{Beam, POINTS, State};

impl<const D: usize, const R: usize, const Q: usize> Beam<D, R, Q> {
    /// Kinetic energy, energy stored in the fibres (elastic and hardening, without torsion), energy of springs and load.
    pub fn energies(&self, state: &State<D, R>) -> [f64; 3] {
        let mut kinetic = 0.0;
        for (inertia, velocity) in self.inertia.iter().zip(&state.velocity) {
            for k in 0..3 {
                kinetic += 0.5 * inertia[0] * velocity[k] * velocity[k];
                kinetic += 0.5 * inertia[1 + k] * velocity[3 + k] * velocity[3 + k];
            }
        }
        let mut stored = 0.0;
        for (index, element) in self.elements.iter().enumerate() {
            let l = element.length;
            let d: [f64; R] =
                std::array::from_fn(|k| state.deformation[index][k] - element.initial[k]);
            let gamma = element.bar.map_or(0.0, |bar| state.shear[bar]);
            for point in 0..POINTS {
                let strain = self.strain(index, point, &d, gamma);
                let place = POINTS * index + point;
                stored += 0.5 * l * self.section.stored_energy(&strain, &state.points[place]);
            }
            if R == 6 {
                stored += 0.5 * self.torsional_rigidity / l * d[R - 1] * d[R - 1];
            }
            for (slider, plastic) in element.sliders.iter().zip(state.sliders[index]) {
                let elastic = gamma - plastic;
                stored += 0.5
                    * l
                    * (slider.rigidity * elastic * elastic + slider.hardening * plastic * plastic);
            }
        }
        let top = state.moved[self.places.len() - 1][0];
        let mut outside = 0.5 * self.top_spring * top * top + self.top_load * top;
        for spring in &self.rotation_springs {
            let along = &state.triads[spring.node][0];
            outside += 0.5 * spring.stiffness * (along[1] * along[1] + along[2] * along[2]);
        }
        [kinetic, stored, outside]
    }
}
