//! The test of a collapse by displacement: whether the column finds an equilibrium under its load, wherever its top is held.

use super::beam::Beam;
use super::column::{BeamColumn, BeamError};
use super::contact::touches;
use super::damage::Damage;
use super::mesh::nearest;
use super::newton::Solver;
use super::opinion::{BeamModel, Hit, sided};
use super::response::{MOVING, Run};
use super::statics::{CollapseTest, come_to_rest, settle, share_borne};

impl BeamModel {
    /// Repeats a hit and, where the column collapses, tests that: without the vehicle, its top is held where it is and lowered from
    /// there by up to a quarter of the height. Where it bears its load so, it is let go from where its response has ended, and must
    /// come to rest without its shape. Where the column comes to rest in the plane of the web and gives way about its weak axis,
    /// its capacity is tested. `None` where the column stands.
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
        let ended = run.state.clone();
        let lowest = MOVING * self.lowest();
        if !run.course.collapsed
            && come_to_rest(&beam, &mut run.state, &mut solver, lowest)
            && !run.is_misshapen(1.0, run.displacement(&rest))
        {
            let left = Damage::of(&beam, &run.state);
            return match self.stands_in_space(Some(&left)) {
                true => Ok(None),
                false => self.test_about_weak_axis(&left).map(Some),
            };
        }
        let mut test = share_borne(&beam, ended.clone(), &mut solver);
        if !test.gives_way() {
            let is_crushed = run.is_crushed();
            run.state = ended;
            let rests = come_to_rest(&beam, &mut run.state, &mut solver, 2.0 * lowest);
            let limit = if rests { 1.0 } else { 2.0 * MOVING };
            test.lost_shape = is_crushed || run.is_misshapen(limit, run.displacement(&rest));
        }
        Ok(Some(test))
    }

    /// The capacity without its load before of a column that rests in the plane of the web.
    fn test_about_weak_axis(&self, left: &Damage) -> Result<CollapseTest, BeamError> {
        let column = self.column();
        let unloaded = Self::new(&BeamColumn {
            top_load: 0.0,
            top_spring_stiffness: 0.0,
            ..*column
        })?;
        // Without load it stands: where no equilibrium is found, nothing is confirmed.
        let capacity =
            unloaded.pushed_if_standing::<6, 6, 9>(sided(column.bows(), left), Some(left));
        Ok(CollapseTest {
            share_borne: capacity.map_or(f64::NAN, |it| it / column.top_load),
            hangs: false,
            lost_shape: false,
        })
    }
}
