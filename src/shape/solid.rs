//! The solid that a section sweeps along the bent axis.

use super::bent_axis::{BentAxis, Station};
use super::outline::Outline;

/// Triangles with a normal at each corner. Faces do not share corners, so that edges stay sharp.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Solid {
    /// Corners \[m\].
    pub positions: Vec<[f32; 3]>,
    /// Outward unit normals, one for each corner.
    pub normals: Vec<[f32; 3]>,
    /// Three corners each, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Solid {
    /// The solid that `outline` sweeps along `axis`, closed at both ends.
    #[must_use]
    pub fn swept(outline: &Outline, axis: &BentAxis) -> Self {
        let mut solid = Self::default();
        solid.move_to(outline, axis);
        solid.triangles = triangles(outline, axis.stations().len());
        solid
    }

    /// Number of corners at each station, before those of the ends.
    #[must_use]
    pub fn corners_per_station(outline: &Outline) -> usize {
        2 * outline.edges().count()
    }

    /// Sets positions and normals for another axis; the triangles stay the same.
    pub fn move_to(&mut self, outline: &Outline, axis: &BentAxis) {
        let stations = axis.stations();
        let ends = 2 * outline.plates().as_flattened().len();
        let corners = stations.len() * Self::corners_per_station(outline) + ends;
        self.positions.clear();
        self.normals.clear();
        self.positions.reserve(corners);
        self.normals.reserve(corners);
        for station in stations {
            self.add_faces(outline, station);
        }
        for (end, outwards) in [(stations.first(), -1.0), (stations.last(), 1.0)] {
            if let Some(station) = end {
                self.add_end(outline, station, outwards);
            }
        }
    }

    /// Adds both corners of every face of the outline.
    fn add_faces(&mut self, outline: &Outline, station: &Station) {
        for [from, to] in outline.edges() {
            let (along, across) = (to[0] - from[0], to[1] - from[1]);
            let length = along.hypot(across).max(f64::MIN_POSITIVE);
            let normal = in_space(station, [across / length, -along / length]);
            for corner in [from, to] {
                self.add(station, corner, normal);
            }
        }
    }

    fn add_end(&mut self, outline: &Outline, station: &Station, outwards: f64) {
        let up = station.section;
        let normal = [outwards * up.x, 0.0, outwards * up.z];
        for corner in outline.plates().as_flattened() {
            self.add(station, *corner, normal);
        }
    }

    fn add(&mut self, station: &Station, corner: [f64; 2], normal: [f64; 3]) {
        let [x, y, z] = in_space(station, corner);
        let place = station.place;
        self.positions
            .push([x + place.x, y, z + place.z].map(single));
        self.normals.push(normal.map(single));
    }
}

/// A vector `[a, b]` in the plane of the section, in space.
fn in_space(station: &Station, [a, b]: [f64; 2]) -> [f64; 3] {
    let up = station.section;
    [a * up.z, b, -a * up.x]
}

fn single(value: f64) -> f32 {
    value as f32
}

fn triangles(outline: &Outline, stations: usize) -> Vec<[u32; 3]> {
    let per_station = Solid::corners_per_station(outline) as u32;
    let stations = stations as u32;
    let mut triangles = Vec::new();
    for lower in 0..stations.saturating_sub(1) {
        for face in 0..per_station / 2 {
            let from = lower * per_station + 2 * face;
            let (to, above) = (from + 1, from + per_station);
            triangles.push([from, to, above + 1]);
            triangles.push([from, above + 1, above]);
        }
    }
    let ends = stations * per_station;
    let plates = outline.plates().len() as u32;
    for (end, flipped) in [(0, true), (1, false)] {
        for plate in 0..plates {
            let first = ends + 4 * (plates * end + plate);
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                let corner = |number: u32| first + number;
                triangles.push(if flipped {
                    [corner(a), corner(c), corner(b)]
                } else {
                    [corner(a), corner(b), corner(c)]
                });
            }
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::{RolledSection, Sample, WEBS};
    use crate::parameters::CatalogueSection;
    use crate::shape::{Joints, Lengths};

    fn heb220() -> RolledSection {
        CatalogueSection::named("HEB220").expect("known").dimensions
    }

    fn solid(sample: &Sample) -> (Solid, Joints, Outline) {
        solid_of(Outline::rolled(&heb220()), sample)
    }

    fn solid_of(outline: Outline, sample: &Sample) -> (Solid, Joints, Outline) {
        let lengths = Lengths {
            below: 1.0,
            above: 3.0,
            top_is_free: false,
        };
        let joints = Joints::new(lengths, sample, 1.0);
        let axis = BentAxis::new(&joints, sample.beta1, [0.0; WEBS], true, true);
        (Solid::swept(&outline, &axis), joints, outline)
    }

    fn bent() -> Sample {
        Sample {
            v1: 0.0946,
            u1: 0.0047,
            beta1: 0.03,
            u2: 0.0098,
            ..Sample::default()
        }
    }

    fn cross(solid: &Solid, [a, b, c]: [u32; 3]) -> ([f64; 3], [f64; 3]) {
        let at = |corner: u32| solid.positions[corner as usize].map(f64::from);
        let (a, b, c) = (at(a), at(b), at(c));
        let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let (u, v) = (minus(b, a), minus(c, a));
        let cross = [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ];
        (cross, a)
    }

    /// The ends of the solid are the base and the top, and its middle section is centred on the impact point.
    #[test]
    fn ends_and_impact_point_follow_the_state() {
        let (solid, joints, outline) = solid(&bent());
        let per_station = Solid::corners_per_station(&outline);
        let centre = |station: usize| {
            let corners = &solid.positions[station * per_station..(station + 1) * per_station];
            let mut sum = [0.0; 3];
            for corner in corners {
                for (sum, value) in sum.iter_mut().zip(corner) {
                    *sum += f64::from(*value) / per_station as f64;
                }
            }
            sum
        };
        for (station, joint) in [
            (0, joints.base),
            (BentAxis::STATIONS / 2, joints.impact),
            (BentAxis::STATIONS - 1, joints.top),
        ] {
            let [x, y, z] = centre(station);
            assert!((x - joint.x).abs() < 1e-6 && y.abs() < 1e-6 && (z - joint.z).abs() < 1e-6);
        }
        assert_eq!((joints.impact.x, joints.impact.z), (0.0946, 1.0 - 0.0047));
    }

    /// By the divergence theorem, a closed surface with outward normals has the volume area times length.
    #[test]
    fn the_surface_is_closed_and_its_normals_point_outwards() {
        // A tube of 200 x 10 mm.
        let area_of_tube = std::f64::consts::PI * (0.1 * 0.1 - 0.09 * 0.09);
        for (outline, area) in [
            (Outline::rolled(&heb220()), heb220().properties().area),
            (Outline::circular(0.2, 0.01), area_of_tube),
        ] {
            let (solid, ..) = solid_of(outline, &Sample::default());
            let volume: f64 = solid
                .triangles
                .iter()
                .map(|triangle| {
                    let (cross, a) = cross(&solid, *triangle);
                    (cross[0] * a[0] + cross[1] * a[1] + cross[2] * a[2]) / 6.0
                })
                .sum();
            let exact = 4.0 * area;
            assert!((volume / exact - 1.0).abs() < 0.02, "{volume} {exact}");
        }
    }

    #[test]
    fn normals_point_out_of_their_triangles() {
        for outline in [Outline::rolled(&heb220()), Outline::circular(0.2, 0.01)] {
            let (solid, ..) = solid_of(outline, &bent());
            assert_eq!(solid.positions.len(), solid.normals.len());
            for triangle in &solid.triangles {
                let (cross, _) = cross(&solid, *triangle);
                for corner in triangle {
                    let normal = solid.normals[*corner as usize].map(f64::from);
                    let length: f64 = normal.iter().map(|it| it * it).sum();
                    assert!((length - 1.0).abs() < 1e-5);
                    let along: f64 = cross.iter().zip(normal).map(|(a, b)| a * b).sum();
                    assert!(along > 0.0, "{triangle:?} {cross:?} {normal:?}");
                }
            }
        }
    }
}
