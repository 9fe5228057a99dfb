//! The figures of a section of the report, numbered in the order in which they appear.

use maud::{Markup, PreEscaped, html};

use crate::observables::HINGE_PLACES;

/// The figures of the section about one impact, numbered in the order in which they appear.
pub(super) struct Figures {
    drawings: Vec<(String, String)>,
    impact_number: Option<usize>,
    count: usize,
}

impl Figures {
    /// These drawings with their names; `impact_number` among several impacts.
    pub(super) fn new(drawings: Vec<(String, String)>, impact_number: Option<usize>) -> Self {
        Self {
            drawings,
            impact_number,
            count: 0,
        }
    }

    /// The figure of this name with its caption; nothing where it was not drawn.
    pub(super) fn markup(&mut self, name: &str, caption: &str) -> Markup {
        let Some((_, svg)) = self.drawings.iter().find(|(drawn, _)| drawn == name) else {
            return html! {};
        };
        self.count += 1;
        let number = match self.impact_number {
            Some(impact) => format!("{impact}.{}", self.count),
            None => self.count.to_string(),
        };
        html! {
            figure role="img" aria-label=(caption) {
                (PreEscaped(svg))
                figcaption { "Figure " (number) ". " (caption) }
            }
        }
    }

    /// The path of a hinge in its yield surface.
    pub(super) fn yield_path(&mut self, hinge: usize) -> Markup {
        let caption = format!(
            "Moment and normal force of hinge {}, the most severely strained one, in its yield surface.",
            HINGE_PLACES[hinge]
        );
        self.markup(&format!("mn_path_{}", HINGE_PLACES[hinge].name), &caption)
    }
}
