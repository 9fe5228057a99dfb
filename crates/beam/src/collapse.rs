//! The test of a collapse by displacement: whether the column finds an equilibrium under its load, wherever its top is held.

use super::beam::Beam;
use super::column::{BeamColumn, BeamError};
use super::contact::touches;
use super::damage::Damage;
use super::mesh::nearest;
use super::newton::Solver;
use super::opinion::{BeamModel, Hit};
use super::response::Run;
use super::statics::{CollapseTest, settle, share_borne};

impl BeamModel {
    /// Repeats a hit and, where the column collapses, tests that: without the vehicle, its top is held where it is and lowered from
    /// there by up to a quarter of the height. Where the column comes to rest in the plane of the web and gives way about its weak
    /// axis, its capacity is tested. `None` where the column stands.
    ///
    /// # Errors
    /// A direction or an impact out of range, no equilibrium before it, damage of another mesh.
    pub fn test_collapse(
        &self,
        hit: &Hit,
        damage: Option<&Damage>,
    ) -> Result<Option<CollapseTest>, BeamError> {
        self.check_hit(hit, damage)?;
        if Self::is_plane(hit, damage) {
            self.test_in::<3, 3, 4>(hit, damage)
        } else {
            self.test_in::<6, 6, 9>(hit, damage)
        }
    }

    fn test_in<const D: usize, const R: usize, const Q: usize>(
        &self,
        hit: &Hit,
        damage: Option<&Damage>,
    ) -> Result<Option<CollapseTest>, BeamError> {
        let column = self.column();
        let heights = self.heights(hit, column.elements, D == 3);
        let beam: Beam<D, R, Q> = column.beam(&heights, column.bows());
        let mut solver = Solver::new(&beam);
        let unstable = BeamError::Unstable {
            load: column.top_load,
        };
        let Some(mut state) = self.state(&beam, damage, &mut solver) else {
            return Err(unstable);
        };
        if !settle(&beam, &mut state, &mut solver) {
            return Err(unstable);
        }
        let node = nearest(&heights, column.length_below);
        let rest = state.moved[node];
        let touches = touches(column, &heights);
        let mut run = Run::new(&beam, state, &hit.impact, hit.direction, &touches, node);
        run.follow(self.step(hit, D == 3), &rest, &mut ());
        if !run.course.collapsed {
            let mut state = run.state.clone();
            let rests = settle(&beam, &mut state, &mut solver) && solver.negative_pivots == 0;
            if rests {
                let left = Damage::of(&beam, &state);
                return match self.stands_in_space(Some(&left)) {
                    true => Ok(None),
                    false => self.test_about_weak_axis(&left).map(Some),
                };
            }
        }
        Ok(Some(share_borne(&beam, run.state, &mut solver)))
    }

    /// The capacity without its load before of a column that rests in the plane of the web.
    fn test_about_weak_axis(&self, left: &Damage) -> Result<CollapseTest, BeamError> {
        let column = self.column();
        let unloaded = Self::new(&BeamColumn {
            top_load: 0.0,
            top_spring_stiffness: 0.0,
            ..*column
        })?;
        let capacity = unloaded.capacity_left(column.bows(), left);
        Ok(CollapseTest {
            share_borne: capacity / column.top_load,
            hangs: false,
        })
    }
}
