//! What an impact leaves in the column: as little as possible, so that a fleet can keep it.

use serde::{Deserialize, Serialize};

use super::beam::{BARS, State};
use super::element::Triad;
use super::section::PointState;

/// The damaged column at rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Damage {
    /// Displacement of each node \[m\].
    moved: Vec<[f64; 3]>,
    triads: Vec<Triad>,
    shear: [f64; BARS],
    sliders: Vec<[f64; 2]>,
    /// Sections that have yielded, with the plastic strains of their fibres; others take nothing.
    points: Vec<(u32, PointState)>,
    /// Whether it was in the plane of the web alone.
    plane: bool,
    /// How many sections there are.
    sections: u32,
}

impl Damage {
    pub(crate) fn of<const D: usize, const R: usize>(state: &State<D, R>) -> Self {
        let yielded = state
            .yielded
            .iter()
            .enumerate()
            .filter(|(_, yielded)| **yielded);
        Self {
            moved: state.moved.clone(),
            triads: state.triads.clone(),
            shear: state.shear,
            sliders: state.sliders.clone(),
            points: yielded
                .map(|(place, _)| (place as u32, state.points[place].clone()))
                .collect(),
            plane: D == 3,
            sections: state.points.len() as u32,
        }
    }

    /// Whether it lies in the plane of the web.
    #[must_use]
    pub fn is_plane(&self) -> bool {
        self.plane
    }

    /// Bytes of its numbers.
    #[must_use]
    pub fn size(&self) -> usize {
        let nodes = 8 * (3 + 9) * self.moved.len();
        let sliders = 8 * 2 * self.sliders.len();
        let fibres = self.points.iter().map(|(_, point)| {
            let [plain, web] = [point.plain.len(), 2 * point.web.len()];
            8 * (plain + web + point.locked.len())
        });
        nodes + sliders + fibres.sum::<usize>()
    }

    pub(crate) fn sections(&self) -> usize {
        self.sections as usize
    }

    /// Puts it into an undamaged state; `spread` tells, where plane damage comes into space, which fibre of the plane a fibre in
    /// space belongs to.
    pub(crate) fn apply<const D: usize, const R: usize>(
        &self,
        state: &mut State<D, R>,
        spread: Option<&[Vec<usize>; 2]>,
    ) {
        state.moved.clone_from(&self.moved);
        state.triads.clone_from(&self.triads);
        state.shear = self.shear;
        state.sliders.clone_from(&self.sliders);
        for (place, point) in &self.points {
            let place = *place as usize;
            state.yielded[place] = true;
            let Some([plain, web]) = spread else {
                state.points[place] = point.clone();
                continue;
            };
            let to = &mut state.points[place];
            for (to, from) in to.plain.iter_mut().zip(plain) {
                *to = point.plain[*from];
            }
            // The moment about the weak axis of a symmetric section stays zero.
            to.locked = point.locked;
            for (to, from) in to.web.iter_mut().zip(web) {
                *to = point.web[*from];
            }
        }
    }
}
