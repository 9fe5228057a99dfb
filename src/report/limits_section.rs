//! The section of the report about what the model cannot know.

use maud::{Markup, html};

use super::limits;

/// What the model does not know.
pub(super) fn markup() -> Markup {
    html! {
        section.model-limits {
            h2 { "Limits of the model" }
            p {
                "The numbers are the answers of a model. It is validated against a reference solution of the same equations and \
                 against a fibre beam model that was written independently, not against a crash test of a column."
            }
            dl.limits {
                @for (limit, consequence) in &limits::limits() {
                    dt { (limit) }
                    dd { (consequence) }
                }
            }
        }
    }
}
