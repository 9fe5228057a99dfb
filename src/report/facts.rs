//! A row of a table of facts, as every section of the report writes it.

use maud::{Markup, html};

/// A row of a table of facts.
pub(super) fn fact(name: &str, text: impl AsRef<str>) -> Markup {
    html! { tr { th scope="row" { (name) } td { (text.as_ref()) } } }
}
