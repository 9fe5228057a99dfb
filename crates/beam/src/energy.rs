//! The energy of a beam.

use super::beam::{Beam, State};

impl<const D: usize, const R: usize, const Q: usize> Beam<D, R, Q> {
    /// Kinetic energy, and energy of springs and load \[J\].
    pub fn energies(&self, state: &State<D, R>) -> [f64; 2] {
        let mut kinetic = 0.0;
        for (inertia, velocity) in self.inertia.iter().zip(&state.velocity) {
            for k in 0..3 {
                kinetic += 0.5 * inertia[0] * velocity[k] * velocity[k];
                kinetic += 0.5 * inertia[1 + k] * velocity[3 + k] * velocity[3 + k];
            }
        }
        let top = state.moved[self.places.len() - 1][0];
        let mut outside = 0.5 * self.top_spring * top * top + self.top_load * top;
        for spring in &self.rotation_springs {
            let along = &state.triads[spring.node][0];
            outside += 0.5 * spring.stiffness * (along[1] * along[1] + along[2] * along[2]);
        }
        [kinetic, outside]
    }
}
