//! The areas of the classes of a damage map.

use super::map_picture::Picture;
use super::page::Drawn;
use crate::assessment::Action;
use crate::study::ACTIONS;

/// A rectangle over the areas of the classes: its extent in both directions, and its class.
pub(super) type Island = ((f64, f64), (f64, f64), Option<Action>);

/// Adds a rectangle, or widens the one of the row before, so that no seam shows between both.
pub(super) fn island(
    islands: &mut Vec<Island>,
    x: (f64, f64),
    y: (f64, f64),
    found: Option<Action>,
) {
    // Not further back than the rectangles of two rows of the finest figure.
    const LOOKED_AT: usize = 800;
    let before = islands.iter_mut().rev().take(LOOKED_AT);
    match before
        .into_iter()
        .find(|(of, range, class)| of.1 == x.0 && *range == y && *class == found)
    {
        Some((of, ..)) => of.1 = x.1,
        None => islands.push((x, y, found)),
    }
}

/// Where each class begins, strip by strip: the area of a class reaches from there to the upper edge, and the next class is painted over
/// it, so that no seams show.
#[derive(Default)]
pub(super) struct Areas {
    strips: Vec<Strip>,
}

/// A strip from left to right, and where the classes begin in it.
pub(super) type Strip = ((f64, f64), [Option<f64>; ACTIONS.len()]);

impl Areas {
    pub(super) fn push(&mut self, strip: (f64, f64), begins: [Option<f64>; ACTIONS.len()]) {
        self.strips.push((strip, begins));
    }

    pub(super) fn fill(&self, picture: &Picture<'_, '_, '_>) -> Drawn<()> {
        picture.background(Action::None)?;
        for (class, action) in ACTIONS.into_iter().enumerate() {
            for strips in self.strips.split(|(_, begins)| begins[class].is_none()) {
                let line = strips.iter().flat_map(|((left, right), begins)| {
                    let begin = begins[class].unwrap_or(f64::NAN);
                    [(*left, begin), (*right, begin)]
                });
                picture.above(&line.collect::<Vec<_>>(), action)?;
            }
        }
        Ok(())
    }
}
