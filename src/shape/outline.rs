//! The outline of the section.

use std::f64::consts::FRAC_PI_2;

use crate::column::RolledSection;
use crate::parameters::{CatalogueSection, Parameters, catalogue};

/// Number of straight pieces of a root fillet.
const FILLET_PIECES: usize = 2;

/// The closed outline of an I or H section: points `[a, b]` along the depth and along the flanges \[m\], counter-clockwise,
/// with the centroid at the origin.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    corners: Vec<[f64; 2]>,
    section: RolledSection,
}

impl Outline {
    /// The outline of a section.
    #[must_use]
    pub fn new(section: &RolledSection) -> Self {
        let quarter = quarter(section);
        let mirrored = |along: f64, across: f64, reversed: bool| {
            let mut points: Vec<_> = quarter
                .iter()
                .map(|[a, b]| [along * a, across * b])
                .collect();
            if reversed {
                points.reverse();
            }
            points
        };
        let corners = [
            mirrored(1.0, 1.0, false),
            mirrored(-1.0, 1.0, true),
            mirrored(-1.0, -1.0, false),
            mirrored(1.0, -1.0, true),
        ];
        Self {
            corners: corners.concat(),
            section: *section,
        }
    }

    /// The corners in order; the last one is connected to the first.
    #[must_use]
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners
    }

    /// The section.
    #[must_use]
    pub fn section(&self) -> &RolledSection {
        &self.section
    }

    /// Flanges and web as rectangles: `[from a, to a, from b, to b]` \[m\].
    #[must_use]
    pub fn plates(&self) -> [[f64; 4]; 3] {
        let RolledSection {
            depth,
            width,
            web_thickness,
            flange_thickness,
            ..
        } = self.section;
        let (face, inner) = (0.5 * depth, 0.5 * depth - flange_thickness);
        let (edge, web) = (0.5 * width, 0.5 * web_thickness);
        [
            [-face, -inner, -edge, edge],
            [-inner, inner, -web, web],
            [inner, face, -edge, edge],
        ]
    }
}

/// The corners in the quarter `a, b >= 0`: from the flange's face over its edge to the web.
fn quarter(section: &RolledSection) -> Vec<[f64; 2]> {
    let RolledSection {
        depth,
        width,
        web_thickness,
        flange_thickness,
        root_radius,
    } = *section;
    let (inner, web) = (0.5 * depth - flange_thickness, 0.5 * web_thickness);
    let radius = root_radius.min(inner).min(0.5 * width - web).max(0.0);
    let mut corners = vec![[0.5 * depth, 0.5 * width], [inner, 0.5 * width]];
    if radius > 0.0 {
        let centre = [inner - radius, web + radius];
        corners.extend((0..=FILLET_PIECES).map(|piece| {
            let angle = FRAC_PI_2 * piece as f64 / FILLET_PIECES as f64;
            [
                centre[0] + radius * angle.cos(),
                centre[1] - radius * angle.sin(),
            ]
        }));
    } else {
        corners.push([inner, web]);
    }
    corners
}

/// The section to draw. A section given by numbers alone is drawn as the section of the catalogue that is nearest in area and
/// radius of gyration, scaled to its radius of gyration.
#[must_use]
pub fn drawn_section(parameters: &Parameters) -> RolledSection {
    if let Some(named) = CatalogueSection::named(&parameters.settings().section.name) {
        return named.dimensions;
    }
    let given = parameters.section();
    let gyration = |second_moment: f64, area: f64| (second_moment / area).sqrt();
    let wanted = gyration(given.second_moment, given.area);
    let distance = |section: &CatalogueSection| {
        let it = section.properties();
        let of_gyration = (gyration(it.second_moment, it.area) / wanted).ln();
        // An area is proportional to the square of a length.
        let of_area = 0.5 * (it.area / given.area).ln();
        of_gyration.hypot(of_area)
    };
    let nearest = catalogue()
        .iter()
        .min_by(|one, other| distance(one).total_cmp(&distance(other)));
    let Some(nearest) = nearest else {
        return square(given.area.sqrt());
    };
    let it = nearest.properties();
    let factor = wanted / gyration(it.second_moment, it.area);
    let RolledSection {
        depth,
        width,
        web_thickness,
        flange_thickness,
        root_radius,
    } = nearest.dimensions;
    RolledSection {
        depth: factor * depth,
        width: factor * width,
        web_thickness: factor * web_thickness,
        flange_thickness: factor * flange_thickness,
        root_radius: factor * root_radius,
    }
}

fn square(side: f64) -> RolledSection {
    RolledSection {
        depth: side,
        width: side,
        web_thickness: 0.1 * side,
        flange_thickness: 0.1 * side,
        root_radius: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{Value, parse_override};

    fn area_and_second_moment(outline: &Outline) -> [f64; 2] {
        let corners = outline.corners();
        let mut sums = [0.0; 2];
        for (number, [a, b]) in corners.iter().enumerate() {
            let [next_a, next_b] = corners[(number + 1) % corners.len()];
            let cross = a * next_b - next_a * b;
            sums[0] += cross / 2.0;
            sums[1] += cross * (a * a + a * next_a + next_a * next_a) / 12.0;
        }
        sums
    }

    /// The polygon has the area and the second moment of the section, except for the chords of the fillets.
    #[test]
    fn the_outline_is_that_of_the_section() {
        for section in catalogue() {
            let [area, second_moment] = area_and_second_moment(&Outline::new(&section.dimensions));
            let exact = section.properties();
            assert!((area / exact.area - 1.0).abs() < 0.025, "{}", section.name);
            assert!(
                (second_moment / exact.second_moment - 1.0).abs() < 0.025,
                "{}",
                section.name
            );
        }
    }

    #[test]
    fn the_outline_reaches_depth_and_width() {
        let section = CatalogueSection::named("HEB220").expect("known").dimensions;
        let outline = Outline::new(&section);
        let reach = |axis: usize| {
            let values = outline.corners().iter().map(|corner| corner[axis]);
            (
                values.clone().fold(f64::INFINITY, f64::min),
                values.fold(f64::NEG_INFINITY, f64::max),
            )
        };
        assert_eq!(reach(0), (-0.11, 0.11));
        assert_eq!(reach(1), (-0.11, 0.11));
    }

    #[test]
    fn a_named_section_is_drawn_with_its_dimensions() {
        let parameters = Parameters::load(&[], &[parse_override("section.name:=IPE300")]);
        let section = drawn_section(&parameters.expect("admissible"));
        assert_eq!((section.depth, section.width), (0.3, 0.15));
    }

    /// The paper's column, given by numbers, looks like the HEB 220 that it is.
    #[test]
    fn a_section_given_by_numbers_is_drawn_like_the_nearest_one() {
        let parameters = Parameters::from_values([
            ("section.name", Value::from("")),
            ("section.area", Value::from(91.0e-4)),
            ("section.second_moment", Value::from(8091e-8)),
            ("section.mass_per_length", Value::from(70.1)),
            ("resistance.moment", Value::from(0.307e6)),
        ])
        .expect("admissible");
        let section = drawn_section(&parameters);
        assert!((section.depth - 0.22).abs() < 0.002, "{section:?}");
        assert!((section.width - 0.22).abs() < 0.002, "{section:?}");
    }
}
