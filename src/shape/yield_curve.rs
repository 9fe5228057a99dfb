//! The yield surface as a curve.

use std::f64::consts::TAU;

use crate::column::YieldExponents;

/// Points on the closed curve `|M / M^p|^alpha + |N / N^p|^beta = 1` (Eq 28), as `[M / M^p, N / N^p]`; the last one is the
/// first one again.
pub fn yield_curve(exponents: YieldExponents, pieces: u32) -> impl Iterator<Item = [f64; 2]> {
    // With the parameter t, M^alpha = cos^2 t and N^beta = sin^2 t satisfy the equation for every exponent.
    let power = |value: f64, exponent: f64| value.abs().powf(2.0 / exponent).copysign(value);
    (0..=pieces).map(move |piece| {
        let angle = f64::from(piece) / f64::from(pieces) * TAU;
        [
            power(angle.cos(), exponents.alpha),
            power(angle.sin(), exponents.beta),
        ]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::YieldSurface;

    #[test]
    fn the_curve_is_the_surface_of_the_model() {
        for (alpha, beta) in [(2.0, 2.0), (1.0, 1.3)] {
            let exponents = YieldExponents {
                alpha,
                beta,
                gamma: 1.0,
            };
            let model = YieldSurface::new(1.0, 1.0, exponents);
            for [moment, force] in yield_curve(exponents, 180) {
                let utilisation = model.utilisation(moment, force);
                assert!(
                    (utilisation - 1.0).abs() < 1e-5,
                    "{moment} {force}: {utilisation}"
                );
            }
        }
    }
}
