//! Compares the definitions of the types in a recording with those of this program.

use super::comparison::Place;
use super::verification::Verification;
use crate::endpoints::ENDPOINTS;
use crate::recording::{self, Reader};

/// Compares the definitions in the recording with those of this program: other programs read the messages by the former.
pub(super) fn compare_definitions(reader: &Reader, found: &mut Verification) {
    let about = found.about.clone();
    let known = about.as_ref().map(|it| &it.topics).into_iter().flatten();
    // The type of each topic of this program by the name in the recording.
    let types: Vec<(&str, &str)> = known
        .filter_map(|(endpoint, topic)| {
            let endpoint = ENDPOINTS.iter().find(|it| it.name == endpoint)?;
            Some((topic.as_str(), endpoint.type_name))
        })
        .collect();
    for topic in reader.topics() {
        let own = types.iter().find(|(name, _)| *name == &*topic.name);
        let is_own = own.is_some() || topic.type_name.starts_with("column_twin_msgs/");
        if !is_own {
            continue;
        }
        let place = Place {
            topic: &topic.name,
            log_time: reader.span().map_or(0, |it| it.0),
            ..Place::default()
        };
        let difference = match own {
            Some((_, type_name)) if *type_name != &*topic.type_name => {
                Some(place.difference("its type", &*topic.type_name, *type_name))
            }
            _ => recording::check_definition(topic).err().map(|error| {
                place.difference(
                    "the definition of its type",
                    error.to_string(),
                    "the definition of this program",
                )
            }),
        };
        if let Some(difference) = difference {
            found.note_difference(difference);
        }
    }
}
