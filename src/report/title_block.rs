//! The title block: project, site, author, checker, date, revision and signatures, with lines to be filled in by hand.

use maud::{Markup, html};

use super::details::ReportDetails;
use super::impact_section::when_in_words;
use super::reported_impact::ReportedImpact;
use super::words::shortened;

/// Most characters of a name of the program in the title block; the annex has the whole name.
const MAX_CHARS: usize = 48;

/// The block; about one impact, or about the recording as a whole.
pub(super) fn markup(details: &ReportDetails, impact: Option<&ReportedImpact>) -> Markup {
    let column = impact.map(|it| shortened(&it.parameters.settings().column_id, MAX_CHARS));
    let event = impact.and_then(|it| it.event.as_ref());
    html! {
        table.title-block {
            tbody {
                tr { (field(details, "project")) (field(details, "document")) }
                tr { (field(details, "site")) (field(details, "revision")) }
                tr { (field(details, "client")) (field(details, "date")) }
                tr {
                    td colspan="2" {
                        small { "Column" } " " (column.unwrap_or_default())
                        @if let Some((id, stamp)) = event {
                            br; small { "Event" } " " (shortened(id, MAX_CHARS)) ", " (when_in_words(*stamp))
                        }
                    }
                    (field(details, "hit_direction"))
                }
                tr.signed { (field(details, "author")) td colspan="2" { small { "Signature" } } }
                tr.signed { (field(details, "checker")) td colspan="2" { small { "Signature" } } }
            }
        }
    }
}

/// A field in two columns of the block; empty where it is to be filled in by hand.
fn field(details: &ReportDetails, name: &str) -> Markup {
    html! {
        td colspan="2" {
            small { (ReportDetails::label(name)) } " "
            @if let Some(text) = details.get(name) { (text) }
        }
    }
}
