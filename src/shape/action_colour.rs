//! The colours of the actions, in figures and in the viewer.

use crate::assessment::Action;

/// Colour of an action as red, green, blue: from light to dark, so that the order remains without colours, and of hues that the
/// colour-blind can distinguish (after Okabe and Ito).
#[must_use]
pub fn action_colour(action: Action) -> [u8; 3] {
    match action {
        Action::None => [223, 240, 233],
        Action::Inspect => [158, 206, 236],
        Action::Restrict => [236, 176, 72],
        Action::Shore => [217, 102, 44],
        Action::Evacuate => [122, 28, 40],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A print in grey shows the order.
    #[test]
    fn the_more_severe_the_darker() {
        let luminance = Action::ALL.map(|action| {
            let [red, green, blue] = action_colour(action).map(f64::from);
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        });
        assert!(
            luminance.windows(2).all(|pair| pair[0] > pair[1] + 10.0),
            "{luminance:?}"
        );
    }
}
