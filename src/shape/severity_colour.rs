//! The colours of the severities, in figures and in the viewer.

use crate::assessment::Severity;

/// Colour of a severity as red, green, blue: from light to dark, so that the order remains without colours, and of hues that the
/// colour-blind can distinguish (after Okabe and Ito).
#[must_use]
pub fn severity_colour(severity: Severity) -> [u8; 3] {
    match severity {
        Severity::None => [223, 240, 233],
        Severity::Inspect => [158, 206, 236],
        Severity::Restrict => [236, 176, 72],
        Severity::Prop => [217, 102, 44],
        Severity::Evacuate => [122, 28, 40],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A print in grey shows the order.
    #[test]
    fn the_more_severe_the_darker() {
        let luminance = Severity::ALL.map(|severity| {
            let [red, green, blue] = severity_colour(severity).map(f64::from);
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        });
        assert!(
            luminance.windows(2).all(|pair| pair[0] > pair[1] + 10.0),
            "{luminance:?}"
        );
    }
}
