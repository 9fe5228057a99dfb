//! What the two bars see of an oblique hit.

use super::value::rounded;
use crate::column::share_in_plane;

/// What the two bars see of a vehicle that travels in this direction \[rad\]; `None` where they see all of it.
///
/// ```
/// use column_twin::parameters::component_in_words;
///
/// let words = component_in_words(45.0_f64.to_radians()).expect("out of the plane");
/// assert_eq!(
///     words,
///     "the vehicle travels at 45 degrees to the plane of the two bars, which see the component in it, 0.7071 of the whole"
/// );
/// for in_plane in [0.0, std::f64::consts::PI] {
///     assert_eq!(component_in_words(in_plane), None);
/// }
/// ```
#[must_use]
pub fn component_in_words(direction: f64) -> Option<String> {
    let leaves_the_plane = share_in_plane(direction) < 1.0;
    leaves_the_plane.then(|| {
        format!(
            "the vehicle travels at {} degrees to the plane of the two bars, which see the component in it, {} of the whole",
            rounded(direction.to_degrees()),
            rounded(share_in_plane(direction)),
        )
    })
}
