//! Cross-sections of hot-rolled I and H profiles, computed from their five dimensions.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::properties::ShearProperties;

/// Density of structural steel \[kg/m³\] (EN 1991-1-1, table A.4, the value that section tables use).
pub const STEEL_DENSITY: f64 = 7850.0;

/// Dimensions of a doubly symmetric I or H profile with parallel flanges and circular root fillets.
///
/// ```
/// use column_mechanics::RolledSection;
///
/// let heb220 = RolledSection {
///     depth: 0.220,
///     width: 0.220,
///     web_thickness: 0.0095,
///     flange_thickness: 0.016,
///     root_radius: 0.018,
/// };
/// let properties = heb220.properties();
/// assert!((properties.area - 91.04e-4).abs() < 0.005e-4);
/// assert!((properties.second_moment - 8091e-8).abs() < 0.5e-8);
/// assert!((properties.plastic_modulus - 827.0e-6).abs() < 0.05e-6 + 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RolledSection {
    /// `h`: outer depth \[m\].
    pub depth: f64,
    /// `b`: flange width \[m\].
    pub width: f64,
    /// `t_w`: web thickness \[m\].
    pub web_thickness: f64,
    /// `t_f`: flange thickness \[m\].
    pub flange_thickness: f64,
    /// `r`: radius of the four root fillets \[m\].
    pub root_radius: f64,
}

/// The properties of a section that the mechanics needs; bending is about the strong axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SectionProperties {
    /// `A` \[m²\].
    pub area: f64,
    /// `I` \[m⁴\].
    pub second_moment: f64,
    /// `W_pl` \[m³\].
    pub plastic_modulus: f64,
    /// Mass per length \[kg/m\], with [`STEEL_DENSITY`].
    pub mass_per_length: f64,
}

impl RolledSection {
    /// Area, second moment and plastic modulus about the strong axis, and mass, fillets included exactly.
    ///
    /// Flanges and web are rectangles; each of the four fillets is a square of side `r` less a quarter disc.
    #[must_use]
    pub fn properties(&self) -> SectionProperties {
        let Self {
            depth: h,
            width: b,
            web_thickness: tw,
            flange_thickness: tf,
            root_radius: r,
        } = *self;
        let web_depth = h - 2.0 * tf;
        let fillet = Fillet::of_radius(r);
        let fillet_height = web_depth / 2.0 - fillet.from_corner; // of its centroid above the strong axis

        let area = 2.0 * b * tf + web_depth * tw + 4.0 * fillet.area;
        let square = |x: f64| x * x;
        let second_moment = (b * h * square(h) - (b - tw) * web_depth * square(web_depth)) / 12.0
            + 4.0 * (fillet.second_moment + fillet.area * square(fillet_height));
        let plastic_modulus =
            b * tf * (h - tf) + tw * square(web_depth) / 4.0 + 4.0 * fillet.area * fillet_height;
        SectionProperties {
            area,
            second_moment,
            plastic_modulus,
            mass_per_length: area * STEEL_DENSITY,
        }
    }
}

impl RolledSection {
    /// `I_z`: second moment of area about the weak axis \[m⁴\], fillets included exactly.
    #[must_use]
    pub fn weak_second_moment(&self) -> f64 {
        let (b, tw) = (self.width, self.web_thickness);
        let web_depth = self.depth - 2.0 * self.flange_thickness;
        let fillet = Fillet::of_radius(self.root_radius);
        let from_axis = tw / 2.0 + fillet.from_corner;
        (2.0 * self.flange_thickness * b * b * b + web_depth * tw * tw * tw) / 12.0
            + 4.0 * (fillet.second_moment + fillet.area * from_axis * from_axis)
    }

    /// `h_w`: depth of the web between the fillets \[m\], which codes divide by the web's thickness.
    #[must_use]
    pub fn clear_web_depth(&self) -> f64 {
        self.depth - 2.0 * (self.flange_thickness + self.root_radius)
    }
}

impl RolledSection {
    /// The shear of the web of a column of this section bent about its strong axis: `V_w = (f_y/sqrt 3) t_w (h - t_f)`,
    /// `m_f = b t_f^2 f_y / 4`, `G A_s` with `A_s = t_w (h - t_f)` and `G = E / (2 (1 + nu))`, hardening
    /// `A_s b E / 3`, for the yield strength `f_y` \[Pa\], Young's modulus `E` \[Pa\], Poisson's ratio `nu` and the slope
    /// `b E` after yield, `b` being [`ColumnProperties::hardening_ratio`](super::ColumnProperties::hardening_ratio).
    /// Without a cap of the hardening, a limit of the angle and a bumper, which the caller sets. The root radius has no
    /// effect.
    ///
    /// ```
    /// use column_mechanics::RolledSection;
    ///
    /// let heb220 = RolledSection {
    ///     depth: 0.220,
    ///     width: 0.220,
    ///     web_thickness: 0.0095,
    ///     flange_thickness: 0.016,
    ///     root_radius: 0.018,
    /// };
    /// let shear = heb220.shear(355e6, 210e9, 0.3, 0.0);
    /// assert!((shear.web_resistance - 397.2e3).abs() < 50.0);
    /// assert!((shear.flange_moment - 4998.0).abs() < 1.0);
    /// ```
    #[must_use]
    pub fn shear(
        &self,
        yield_strength: f64,
        young_modulus: f64,
        poisson_ratio: f64,
        hardening_ratio: f64,
    ) -> ShearProperties {
        let area = self.web_thickness * (self.depth - self.flange_thickness);
        let flange = self.flange_thickness;
        ShearProperties {
            web_resistance: yield_strength / 3.0_f64.sqrt() * area,
            flange_moment: 0.25 * self.width * flange * flange * yield_strength,
            rigidity: area * young_modulus / (2.0 * (1.0 + poisson_ratio)),
            hardening: area * hardening_ratio * young_modulus / 3.0,
            max_hardening: 0.0,
            ultimate_angle: 0.0,
            bumper_height: 0.0,
        }
    }
}

/// One root fillet: a square of side `r` in the corner of web and flange, less a quarter disc about its far corner.
struct Fillet {
    area: f64,
    /// Distance of the centroid from the flange's inner face.
    from_corner: f64,
    /// About the fillet's own centroid, parallel to the flange.
    second_moment: f64,
}

impl Fillet {
    fn of_radius(r: f64) -> Self {
        if r <= 0.0 {
            return Self {
                area: 0.0,
                from_corner: 0.0,
                second_moment: 0.0,
            }; // the centroid would be 0/0
        }
        let square = r * r;
        let disc = PI * square / 4.0;
        let disc_from_corner = r - 4.0 * r / (3.0 * PI);
        let area = square - disc;
        let from_corner = (square * r / 2.0 - disc * disc_from_corner) / area;
        let (to_square, to_disc) = (r / 2.0 - from_corner, disc_from_corner - from_corner);
        let square_about_centroid = square * square / 12.0 + square * to_square * to_square;
        let disc_about_centroid =
            (PI / 16.0 - 4.0 / (9.0 * PI)) * square * square + disc * to_disc * to_disc;
        Self {
            area,
            from_corner,
            second_moment: square_about_centroid - disc_about_centroid,
        }
    }
}

#[cfg(test)]
#[allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]
mod tests {
    use super::*;

    fn in_millimetres(h: f64, b: f64, tw: f64, tf: f64, r: f64) -> RolledSection {
        RolledSection {
            depth: h / 1e3,
            width: b / 1e3,
            web_thickness: tw / 1e3,
            flange_thickness: tf / 1e3,
            root_radius: r / 1e3,
        }
    }

    /// The four published numbers of HEB 220, to every printed digit.
    #[test]
    fn heb_220_as_published() {
        let section = in_millimetres(220.0, 220.0, 9.5, 16.0, 18.0).properties();
        assert_eq!(format!("{:.2}", section.area * 1e4), "91.04");
        assert_eq!(format!("{:.0}", section.second_moment * 1e8), "8091");
        assert_eq!(format!("{:.1}", section.plastic_modulus * 1e6), "827.0");
        assert_eq!(format!("{:.1}", section.mass_per_length), "71.5");
        let dimensions = in_millimetres(220.0, 220.0, 9.5, 16.0, 18.0);
        assert_eq!(
            format!("{:.0}", dimensions.weak_second_moment() * 1e8),
            "2843"
        );
        assert_eq!(format!("{:.3}", dimensions.clear_web_depth()), "0.152");
        assert!((section.plastic_modulus * 355e6 - 0.2936e6).abs() < 50.0);
        assert!((section.area * 355e6 - 3.232e6).abs() < 500.0);
    }

    /// Compares the closed forms with the definition of the moments, a sum over thin strips parallel to the flange.
    #[test]
    fn closed_forms_equal_a_sum_over_strips() {
        for section in [
            in_millimetres(1000.0, 300.0, 19.0, 36.0, 30.0),
            in_millimetres(80.0, 46.0, 3.8, 5.2, 5.0),
            in_millimetres(200.0, 100.0, 6.0, 10.0, 0.0),
        ] {
            let strips = 400_000;
            let half = section.depth / 2.0;
            let dy = half / f64::from(strips);
            let (mut area, mut first, mut second) = (0.0, 0.0, 0.0);
            for strip in 0..strips {
                let y = (f64::from(strip) + 0.5) * dy;
                let below_flange = half - section.flange_thickness - y;
                let r = section.root_radius;
                let width = if below_flange < 0.0 {
                    section.width
                } else if below_flange < r {
                    section.web_thickness + 2.0 * (r - (r * r - (r - below_flange).powi(2)).sqrt())
                } else {
                    section.web_thickness
                };
                area += 2.0 * width * dy;
                first += 2.0 * width * y * dy;
                second += 2.0 * width * y * y * dy;
            }
            let properties = section.properties();
            assert!((properties.area / area - 1.0).abs() < 1e-5, "{section:?}");
            assert!(
                (properties.plastic_modulus / first - 1.0).abs() < 1e-5,
                "{section:?}"
            );
            assert!(
                (properties.second_moment / second - 1.0).abs() < 1e-5,
                "{section:?}"
            );
        }
    }
}
