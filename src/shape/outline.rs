//! The outline of the section.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::column::RolledSection;
use crate::parameters::{CatalogueSection, Parameters, SectionShape, catalogue};

/// Number of straight pieces of a root fillet.
const FILLET_PIECES: usize = 2;

/// Number of straight pieces of a circle.
const CIRCLE_PIECES: usize = 32;

/// Largest thickness of a wall over the side of a hollow section, so that a hole remains.
const THICKEST: f64 = 0.45;

/// A closed line of points `[a, b]` along the depth and along the flanges \[m\].
pub type Ring = Vec<[f64; 2]>;

/// The outline of a section, with the centroid at the origin.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// The outer line, counter-clockwise, and of a hollow section the inner one, clockwise.
    rings: Vec<Ring>,
    /// What the section consists of, as quadrangles, counter-clockwise.
    plates: Vec<[[f64; 2]; 4]>,
    /// Depth and width.
    size: [f64; 2],
}

impl Outline {
    /// The section of these parameters. An I or H section given by numbers alone is drawn as the section of the catalogue that is
    /// nearest in area and radius of gyration, scaled to its radius of gyration; a hollow section without dimensions as a square or a
    /// circle with its area and radius of gyration.
    #[must_use]
    pub fn of(parameters: &Parameters) -> Self {
        let (given, of_numbers) = (&parameters.settings().section, parameters.section());
        let is_known = given.height > 0.0 && given.web_thickness > 0.0;
        let gyration = (of_numbers.second_moment / of_numbers.area).sqrt();
        match given.shape {
            SectionShape::IOrH => Self::rolled(&drawn_section(parameters)),
            SectionShape::RectangularHollow if is_known && given.width > 0.0 => {
                Self::rectangular([given.height, given.width], given.web_thickness)
            }
            SectionShape::RectangularHollow => {
                // Of thin walls around the middle of the square.
                let middle = 6.0_f64.sqrt() * gyration;
                let wall = of_numbers.area / (4.0 * middle);
                Self::rectangular([middle + wall; 2], wall)
            }
            SectionShape::CircularHollow if is_known => {
                Self::circular(given.height, given.web_thickness)
            }
            SectionShape::CircularHollow => {
                let middle = 8.0_f64.sqrt() * gyration;
                let wall = of_numbers.area / (PI * middle);
                Self::circular(middle + wall, wall)
            }
        }
    }

    /// The outline of a rolled section.
    #[must_use]
    pub fn rolled(section: &RolledSection) -> Self {
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
        let RolledSection {
            depth,
            width,
            web_thickness,
            flange_thickness,
            ..
        } = *section;
        let (face, inner) = (0.5 * depth, 0.5 * depth - flange_thickness);
        let (edge, web) = (0.5 * width, 0.5 * web_thickness);
        let plates = [
            [-face, -inner, -edge, edge],
            [-inner, inner, -web, web],
            [inner, face, -edge, edge],
        ];
        let rectangle = |[from_a, to_a, from_b, to_b]: [f64; 4]| {
            [
                [from_a, from_b],
                [to_a, from_b],
                [to_a, to_b],
                [from_a, to_b],
            ]
        };
        Self {
            rings: vec![corners.concat()],
            plates: plates.map(rectangle).to_vec(),
            size: [depth, width],
        }
    }

    /// A rectangular hollow section with sharp corners.
    fn rectangular(size: [f64; 2], wall: f64) -> Self {
        let wall = wall.min(THICKEST * size[0].min(size[1]));
        let ring = |[depth, width]: [f64; 2]| {
            let (a, b) = (0.5 * depth, 0.5 * width);
            vec![[a, b], [-a, b], [-a, -b], [a, -b]]
        };
        Self::hollow(ring(size), ring(size.map(|it| it - 2.0 * wall)), size)
    }

    /// A circular hollow section.
    pub(super) fn circular(diameter: f64, wall: f64) -> Self {
        let wall = wall.min(THICKEST * diameter);
        let ring = |radius: f64| {
            let angles = (0..CIRCLE_PIECES).map(|piece| TAU * piece as f64 / CIRCLE_PIECES as f64);
            let points = angles.map(|angle| [radius * angle.cos(), radius * angle.sin()]);
            points.collect()
        };
        let radius = 0.5 * diameter;
        Self::hollow(ring(radius), ring(radius - wall), [diameter; 2])
    }

    /// What lies between two lines, both counter-clockwise, whose points belong together.
    fn hollow(outer: Ring, mut inner: Ring, size: [f64; 2]) -> Self {
        let plates = (0..outer.len()).map(|from| {
            let to = (from + 1) % outer.len();
            [outer[from], outer[to], inner[to], inner[from]]
        });
        let plates = plates.collect();
        inner.reverse();
        Self {
            rings: vec![outer, inner],
            plates,
            size,
        }
    }

    /// The outer line, counter-clockwise, and of a hollow section the inner one, clockwise; the last point of each is connected to
    /// the first.
    #[must_use]
    pub fn rings(&self) -> &[Ring] {
        &self.rings
    }

    /// The straight pieces of all lines, from one point to the next, with the steel on the left.
    pub fn edges(&self) -> impl Iterator<Item = [[f64; 2]; 2]> {
        self.rings.iter().flat_map(|ring| {
            let next = ring.iter().cycle().skip(1);
            ring.iter().zip(next).map(|(from, to)| [*from, *to])
        })
    }

    /// What the section consists of, as quadrangles, counter-clockwise.
    #[must_use]
    pub fn plates(&self) -> &[[[f64; 2]; 4]] {
        &self.plates
    }

    /// The point of the outer line that is farthest in this direction.
    #[must_use]
    pub fn farthest(&self, [along, across]: [f64; 2]) -> [f64; 2] {
        let way = |[a, b]: &[f64; 2]| along * a + across * b;
        let points = self.rings[0].iter();
        let farthest = points.max_by(|one, other| way(one).total_cmp(&way(other)));
        farthest.copied().unwrap_or_default()
    }

    /// How far it reaches in the direction of bending about the strong axis \[m\].
    #[must_use]
    pub fn depth(&self) -> f64 {
        self.size[0]
    }

    /// How far it reaches at right angles to that \[m\].
    #[must_use]
    pub fn width(&self) -> f64 {
        self.size[1]
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

/// The I or H section to draw.
fn drawn_section(parameters: &Parameters) -> RolledSection {
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
        let mut sums = [0.0; 2];
        for [[a, b], [next_a, next_b]] in outline.edges() {
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
            let [area, second_moment] =
                area_and_second_moment(&Outline::rolled(&section.dimensions));
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
        let outline = Outline::rolled(&section);
        let reach = |axis: usize| {
            let values = outline.rings()[0].iter().map(|corner| corner[axis]);
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

    /// With the area and the second moment of its dimensions, up to the chords of a circle; with those that are given, where the
    /// dimensions are not, up to the thickness of the wall.
    #[test]
    fn a_hollow_section_is_drawn_with_its_hole() {
        // 200 x 200 x 10 and 219.1 x 10 of EN 10210-2.
        let square: [(&str, f64); 3] = [
            ("section.height", 0.2),
            ("section.width", 0.2),
            ("section.web_thickness", 0.01),
        ];
        let tube = [("section.height", 0.2191), ("section.web_thickness", 0.01)];
        let numbers_of_square = [74.9e-4, 4471e-8];
        let numbers_of_tube = [65.7e-4, 3598e-8];
        for (shape, [area, second_moment], walls) in [
            ("rectangular_hollow", numbers_of_square, &square[..]),
            ("rectangular_hollow", numbers_of_square, &[][..]),
            ("circular_hollow", numbers_of_tube, &tube[..]),
            ("circular_hollow", numbers_of_tube, &[][..]),
        ] {
            let numbers = [
                ("section.name", Value::from("")),
                ("section.shape", Value::from(shape)),
                ("section.area", Value::from(area)),
                ("section.second_moment", Value::from(second_moment)),
                ("section.mass_per_length", Value::from(7850.0 * area)),
                ("resistance.moment", Value::from(1.7e5)),
                ("shear.model", Value::from("none")),
                ("softening.model", Value::from("none")),
            ];
            let walls = walls.iter().map(|(name, it)| (*name, Value::from(*it)));
            let parameters = Parameters::default().with_changes(numbers.into_iter().chain(walls));
            let parameters = parameters.expect("admissible");
            let outline = Outline::of(&parameters);
            assert_eq!(outline.rings().len(), 2);
            let found = area_and_second_moment(&outline);
            println!("{shape}: {found:?}, {} m deep", outline.depth());
            assert!((found[0] / area - 1.0).abs() < 0.03, "{found:?}");
            assert!((found[1] / second_moment - 1.0).abs() < 0.04, "{found:?}");
            let plates: f64 = outline.plates().iter().map(|plate| area_of(plate)).sum();
            assert!((plates / found[0] - 1.0).abs() < 1e-9);
        }
    }

    fn area_of(ring: &[[f64; 2]]) -> f64 {
        let next = ring.iter().cycle().skip(1);
        let crosses = ring.iter().zip(next).map(|([a, b], [c, d])| a * d - c * b);
        0.5 * crosses.sum::<f64>()
    }
}
