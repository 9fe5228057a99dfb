//! The vehicle as it is drawn: a body of its real size whose nose shortens as its front crushes.
//!
//! Distances along the vehicle are measured from the face of the undeformed front backwards, heights from the road, both in
//! \[m\]. Spring 1 of the vehicle lies between this face and the first mass: its crush shortens the nose. Behind the nose the
//! body is rigid and moves with the first mass. The second and the third mass are parts of their own (a cargo, a trailer),
//! which move towards the mass in front of them as the springs between them are crushed.
//!
//! The body is a picture and no model: only masses, crush and positions of the parts relative to one another follow from
//! the mechanics.

use crate::column::{MAX_MASSES, VehicleSample};
use crate::parameters::{CatalogueVehicle, VehiclePart};

/// What a vehicle looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyStyle {
    /// The paper's rigid mass: a block, which is a symbol and has no real size.
    RigidMass,
    /// Bonnet, cabin, boot.
    Car,
    /// A short bonnet and a high body.
    Van,
    /// A cab above the front axle; behind it a load area, or a frame if the load is a mass of its own.
    Lorry,
    /// A low body with a mast.
    Forklift,
}

/// The part of a vehicle that one of its masses is.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyPart {
    /// What it is, for labels.
    pub name: String,
    /// Front and rear end in the undeformed vehicle \[m\].
    pub extent: [f64; 2],
    /// Bottom and top \[m\].
    pub heights: [f64; 2],
}

impl From<&VehiclePart> for BodyPart {
    fn from(part: &VehiclePart) -> Self {
        Self {
            name: part.name.clone(),
            extent: [part.from_m, part.to_m],
            heights: [part.bottom_m, part.top_m],
        }
    }
}

/// The body of a vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleBody {
    /// What it looks like.
    pub style: BodyStyle,
    /// Overall length, width and height \[m\].
    pub size: [f64; 3],
    /// Length of the undeformed nose, which the crush of spring 1 shortens \[m\].
    pub nose: f64,
    /// Rear end of the cab \[m\]; the length of the vehicle if the body has one piece.
    pub cab: f64,
    /// Front and rear end of the engine \[m\], if it is drawn.
    pub engine: Option<[f64; 2]>,
    /// Its masses, front first. The first one is the hull, with nose and wheels.
    pub parts: Vec<BodyPart>,
    /// Distance that closes before the spring in front of each part acts \[m\].
    pub slack: Vec<f64>,
}

/// One cross-section of the hull: distance from the face, bottom, top \[m\].
type Station = [f64; 3];

/// Number of cross-sections of every hull, so that all hulls have the same triangles.
const HULL_STATIONS: usize = 9;

/// Corners of the hull: four faces of four corners between each two cross-sections, and two ends.
const HULL_CORNERS: usize = 16 * (HULL_STATIONS - 1) + 8;

/// Distance of the impact from the lower and upper edge of a vehicle's front, if it hits it \[m\].
const FRONT_MARGIN: f64 = 0.08;

/// Bottom and top of the engine, as fractions of the height of the vehicle.
const ENGINE: [f64; 2] = [0.13, 0.29];

/// Length of the cab of a lorry \[m\], and its largest share of the length.
const CAB: [f64; 2] = [2.1, 0.3];

/// A wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wheel {
    /// Distance of its axle behind the contact face \[m\].
    pub behind: f64,
    /// Radius \[m\].
    pub radius: f64,
}

/// A vehicle whose springs are crushed: all distances behind the contact face, where it is now \[m\].
#[derive(Debug, Clone, PartialEq)]
pub struct CrushedVehicle<'a> {
    body: &'a VehicleBody,
    /// Length of the nose.
    nose: f64,
    /// How far each part has moved towards the contact face.
    moved: [f64; MAX_MASSES],
}

/// Rear end of the cab \[m\].
fn cab(style: BodyStyle, length: f64) -> f64 {
    match style {
        BodyStyle::Lorry => CAB[0].min(CAB[1] * length),
        _ => length,
    }
}

impl VehicleBody {
    /// The paper's rigid mass: length, width and height of its block \[m\] are a symbol.
    #[must_use]
    pub fn rigid_mass() -> Self {
        let size = [1.6, 1.4, 0.7];
        let block = BodyPart {
            name: "rigid mass".to_owned(),
            extent: [0.0, size[0]],
            heights: [0.0, size[2]],
        };
        Self::new(BodyStyle::RigidMass, size, vec![block], &[0.0])
    }

    /// A body for a vehicle that is given by masses and springs alone: its size is an assumption of ours, which follows from
    /// its total mass \[kg\].
    ///
    /// `slack` \[m\] has one entry for each of its springs, front first.
    #[must_use]
    pub fn assumed(total: f64, slack: &[f64]) -> Self {
        let (style, size) = match slack.len() {
            0 | 1 if total < 2_500.0 => (BodyStyle::Car, [4.5, 1.8, 1.5]),
            0 | 1 if total < 4_000.0 => (BodyStyle::Van, [5.9, 2.0, 2.5]),
            _ if total < 4_000.0 => (BodyStyle::Lorry, [5.5, 1.9, 2.2]),
            _ if total < 20_000.0 => (BodyStyle::Lorry, [8.0, 2.5, 3.4]),
            _ => (BodyStyle::Lorry, [16.5, 2.55, 3.8]),
        };
        let [length, _, height] = size;
        let count = slack.len().max(1);
        let is_articulated = count > 1 && length > 12.0;
        let hull = if is_articulated { 6.0 } else { length };
        let first = BodyPart {
            name: match count {
                1 => "vehicle",
                _ if is_articulated => "tractor",
                _ => "cab and chassis",
            }
            .to_owned(),
            extent: [0.0, hull],
            heights: [0.13 * height, 0.87 * height],
        };
        let mut parts = vec![first];
        // The other masses divide the length behind the cab; the gaps in front of them are what can close.
        let cab = cab(style, length);
        let gap = |spring: usize| 0.5 + slack[spring];
        let gaps: f64 = (1..count).map(gap).sum();
        let each = ((length - cab - gaps) / (count.max(2) - 1) as f64).max(0.2 * length);
        let mut from = cab;
        for spring in 1..count {
            from += gap(spring);
            parts.push(BodyPart {
                name: match spring {
                    1 if is_articulated => "trailer",
                    1 => "load",
                    _ => "rear load",
                }
                .to_owned(),
                extent: [from, from + each],
                heights: [0.36 * height, height],
            });
            from += each;
        }
        if count == 1 {
            parts[0].heights[1] = height;
        }
        Self::new(style, size, parts, slack)
    }

    /// The body of the vehicle of this name in the catalogue; for other names an assumed one of this total mass \[kg\].
    ///
    /// `slack` \[m\] has one entry for each of its springs, front first; it is empty for a rigid mass.
    #[must_use]
    pub fn named(name: &str, total: f64, slack: &[f64]) -> Self {
        if slack.is_empty() {
            return Self::rigid_mass();
        }
        let known = CatalogueVehicle::of_crushed(name).filter(|it| it.parts.len() == slack.len());
        let Some(vehicle) = known else {
            return Self::assumed(total, slack);
        };
        let size = &vehicle.size.value;
        let parts: Vec<_> = vehicle.parts.iter().map(BodyPart::from).collect();
        let style = match parts[0].name.as_str() {
            _ if parts.len() > 1 => BodyStyle::Lorry,
            "van" => BodyStyle::Van,
            "lorry" | "tractor" => BodyStyle::Lorry,
            "forklift" => BodyStyle::Forklift,
            _ => BodyStyle::Car,
        };
        let size = [size.length_m, size.width_m, size.height_m];
        Self::new(style, size, parts, slack)
    }

    /// A body of this style, this overall length, width and height \[m\] and these parts, one for each of its masses; `slack`
    /// \[m\] has one entry for each of its springs, front first.
    #[must_use]
    pub fn new(style: BodyStyle, size: [f64; 3], parts: Vec<BodyPart>, slack: &[f64]) -> Self {
        let [length, ..] = size;
        let behind = parts.get(1).map(|part| part.extent[0]);
        let cab = cab(style, length).min(behind.unwrap_or(length));
        let nose = match style {
            BodyStyle::RigidMass => 0.0,
            BodyStyle::Car => 0.27 * length,
            BodyStyle::Van => 0.21 * length,
            BodyStyle::Forklift => 0.15 * length,
            BodyStyle::Lorry => 0.95 * cab,
        };
        let has_engine = style == BodyStyle::Lorry && parts.len() > 1;
        Self {
            style,
            size,
            nose,
            cab,
            engine: has_engine.then_some([0.33 * cab, 0.8 * cab]),
            parts,
            slack: slack.to_vec(),
        }
    }

    /// Names of what the masses are, front first.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().map(|part| part.name.as_str())
    }

    /// Rear end of the undeformed hull, which moves with the first mass \[m\].
    fn hull_length(&self) -> f64 {
        self.parts
            .first()
            .map_or(self.size[0], |hull| hull.extent[1])
    }

    /// The second and the third mass.
    fn rear(&self) -> &[BodyPart] {
        self.parts.get(1..).unwrap_or_default()
    }

    /// Overall length \[m\].
    #[must_use]
    pub fn length(&self) -> f64 {
        self.size[0]
    }

    /// Overall width \[m\].
    #[must_use]
    pub fn width(&self) -> f64 {
        self.size[1]
    }

    /// Number of its masses; 0 for a rigid mass.
    #[must_use]
    pub fn masses(&self) -> usize {
        if self.is_real() { self.parts.len() } else { 0 }
    }

    /// Whether it is a vehicle on wheels and not a rigid mass.
    #[must_use]
    pub fn is_real(&self) -> bool {
        self.style != BodyStyle::RigidMass
    }

    /// Height of the road above the base of the column \[m\], so that the front hits the column at the height `impact`: 0 where
    /// it does so anyway. A rigid mass is centred on the impact.
    #[must_use]
    pub fn road(&self, impact: f64) -> f64 {
        let [_, bottom, top] = self.stations()[0];
        if !self.is_real() {
            return impact - 0.5 * (bottom + top);
        }
        let (low, high) = (bottom + FRONT_MARGIN, top - FRONT_MARGIN);
        (impact - high).max(0.0) + (impact - low).min(0.0)
    }

    /// The body with these crushes.
    #[must_use]
    pub fn crushed(&self, sample: &VehicleSample) -> CrushedVehicle<'_> {
        // An open spring keeps its permanent crush. `max` takes a crush of NaN for 0.
        let crush = sample.crush[0].max(sample.permanent_crush[0]).max(0.0);
        let nose = (self.nose - crush).max(0.0);
        let mut moved = [self.nose - nose; MAX_MASSES];
        let mut ahead = self.cab;
        let rear = self.parts.iter().zip(&self.slack).zip(sample.crush);
        for (index, ((part, slack), crush)) in rear.enumerate().skip(1) {
            // The crush of these springs is counted from the end of the slack. No part can be drawn inside the one ahead.
            let closed = crush + slack;
            let closed = if closed.is_finite() { closed } else { 0.0 };
            moved[index] = moved[index - 1] + closed.min(part.extent[0] - ahead);
            ahead = part.extent[1];
        }
        CrushedVehicle {
            body: self,
            nose,
            moved,
        }
    }

    /// The cross-sections of the undeformed hull.
    fn stations(&self) -> [Station; HULL_STATIONS] {
        let h = self
            .parts
            .first()
            .map_or(self.size[2], |hull| hull.heights[1]);
        let l = self.hull_length();
        let outline: &[Station] = match self.style {
            BodyStyle::RigidMass => &[[0.0, 0.0, h], [l, 0.0, h]],
            BodyStyle::Car => &[
                [0.0, 0.15 * h, 0.47 * h],
                [0.03 * l, 0.13 * h, 0.56 * h],
                [0.27 * l, 0.13 * h, 0.67 * h],
                [0.42 * l, 0.13 * h, 0.98 * h],
                [0.58 * l, 0.13 * h, h],
                [0.72 * l, 0.13 * h, 0.96 * h],
                [0.88 * l, 0.13 * h, 0.70 * h],
                [0.98 * l, 0.13 * h, 0.66 * h],
                [l, 0.17 * h, 0.50 * h],
            ],
            BodyStyle::Van => &[
                [0.0, 0.12 * h, 0.36 * h],
                [0.02 * l, 0.10 * h, 0.42 * h],
                [0.16 * l, 0.10 * h, 0.50 * h],
                [0.28 * l, 0.10 * h, 0.93 * h],
                [0.36 * l, 0.10 * h, h],
                [0.98 * l, 0.10 * h, h],
                [l, 0.12 * h, 0.97 * h],
            ],
            BodyStyle::Forklift => &[
                [0.0, 0.08 * h, h],
                [0.06 * l, 0.08 * h, h],
                [0.06 * l, 0.08 * h, 0.40 * h],
                [0.45 * l, 0.08 * h, 0.40 * h],
                [0.55 * l, 0.08 * h, 0.55 * h],
                [l, 0.10 * h, 0.55 * h],
            ],
            BodyStyle::Lorry => {
                let (cab, box_front) = (self.cab, self.cab + 0.25);
                let frame = [0.20 * h, 0.28 * h];
                let roof = if self.rear().is_empty() { h } else { frame[1] };
                &[
                    [0.0, 0.11 * h, 0.72 * h],
                    [0.15 * cab, 0.11 * h, 0.80 * h],
                    [cab, 0.11 * h, 0.80 * h],
                    [cab, frame[0], frame[1]],
                    [box_front, frame[0], frame[1]],
                    [box_front, frame[0], roof],
                    [l, frame[0], roof],
                ]
            }
        };
        let last = outline.len() - 1;
        std::array::from_fn(|index| outline[index.min(last)])
    }

    /// Axles of the undeformed vehicle, front first: distance behind the face, radius, and the mass that carries them.
    fn axles(&self) -> Vec<(f64, f64, usize)> {
        let [_, _, h] = self.size;
        let l = self.hull_length();
        let mut axles = match self.style {
            BodyStyle::RigidMass => Vec::new(),
            BodyStyle::Car => vec![(0.19, 0.22), (0.80, 0.22)],
            BodyStyle::Van => vec![(0.16, 0.14), (0.78, 0.14)],
            BodyStyle::Forklift => vec![(0.2, 0.16), (0.85, 0.12)],
            BodyStyle::Lorry if l < self.length() => vec![(1.4 / l, 0.14), (0.85, 0.14)],
            BodyStyle::Lorry => vec![(1.4 / l, 0.14), (0.78, 0.14)],
        }
        .into_iter()
        .map(|(along, radius)| (along * l, radius * h, 0))
        .collect::<Vec<_>>();
        if self.style == BodyStyle::Lorry {
            for (index, part) in self.parts.iter().enumerate().skip(1) {
                // A part that reaches far behind the frame has wheels of its own.
                if part.extent[1] > l + 2.0 {
                    let radius = 0.13 * h;
                    let behind = [1.3, 2.6, 3.9].map(|from_rear| part.extent[1] - from_rear);
                    axles.extend(behind.map(|behind| (behind, radius, index)));
                }
            }
        }
        axles
    }
}

impl CrushedVehicle<'_> {
    /// The body.
    #[must_use]
    pub fn body(&self) -> &VehicleBody {
        self.body
    }

    /// Length of the nose: the undeformed length minus the crush of spring 1, but not less than 0 \[m\].
    #[must_use]
    pub fn nose(&self) -> f64 {
        self.nose
    }

    /// How much of the nose is crushed, from 0 to 1.
    #[must_use]
    pub fn crushed_share(&self) -> f64 {
        if self.body.nose > 0.0 {
            1.0 - self.nose / self.body.nose
        } else {
            0.0
        }
    }

    /// Where a point of the hull is, which was `behind` the face \[m\].
    #[must_use]
    pub fn of_hull(&self, behind: f64) -> f64 {
        if behind < self.body.nose {
            behind * self.nose / self.body.nose
        } else {
            behind - self.moved[0]
        }
    }

    /// Front and rear end of the engine, which moves with the first mass until it is at the contact face.
    #[must_use]
    pub fn engine(&self) -> Option<[f64; 2]> {
        self.body.engine.map(|extent| {
            let moved = self.moved[0].min(extent[0]);
            extent.map(|end| end - moved)
        })
    }

    /// Front and rear end of the second and the third mass.
    pub fn rear_parts(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let parts = self.body.rear().iter().zip(&self.moved[1..]);
        parts.map(|(part, moved)| part.extent.map(|end| end - moved))
    }

    /// The boxes of engine and rear parts: front and rear end, bottom and top, half the width \[m\]; the engine first.
    pub fn boxes(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2], f64)> + '_ {
        let [_, width, height] = self.body.size;
        let engine = self.engine().map(|extent| {
            let heights = ENGINE.map(|part| part * height);
            (extent, heights, 0.22 * width)
        });
        let rear = self.rear_parts().zip(self.body.rear());
        let rear = rear.map(move |(extent, part)| (extent, part.heights, 0.5 * width));
        engine.into_iter().chain(rear)
    }

    /// The hull as at most three boxes, for displays that know no other shape: front and rear end, bottom and top \[m\] of the
    /// nose, of what is behind it, and of what is above that. An end that is not in front of the other means that there is
    /// no such box.
    #[must_use]
    pub fn hull_boxes(&self) -> [([f64; 2], [f64; 2]); 3] {
        let body = self.body;
        let stations = body.stations();
        let [_, bottom, front_top] = stations[0];
        let top = stations.iter().map(|it| it[2]).fold(0.0, f64::max);
        let length = body.hull_length();
        // Ends of the upper box, and its lower edge.
        let (upper, edge) = match body.style {
            BodyStyle::RigidMass => ([0.0, 0.0], top),
            BodyStyle::Car => ([0.36 * length, 0.80 * length], 0.66 * top),
            BodyStyle::Van => ([body.nose, length], 0.50 * top),
            BodyStyle::Forklift => ([0.0, 0.06 * length], 0.55 * top),
            BodyStyle::Lorry if body.parts.len() > 1 => ([body.nose, body.cab], stations[3][2]),
            BodyStyle::Lorry => ([body.cab, length], stations[3][2]),
        };
        let nose_top = match body.style {
            BodyStyle::Lorry => 0.5 * (front_top + stations[2][2]),
            BodyStyle::Forklift => edge,
            _ => front_top,
        };
        let place = |extent: [f64; 2]| extent.map(|end| self.of_hull(end));
        [
            (place([0.0, body.nose]), [bottom, nose_top]),
            (place([body.nose, length]), [bottom, edge]),
            (place(upper), [edge, top]),
        ]
    }

    /// The wheels of one side.
    pub fn wheels(&self) -> impl Iterator<Item = Wheel> + '_ {
        let axles = self.body.axles().into_iter();
        axles.map(|(behind, radius, mass)| Wheel {
            behind: if mass == 0 {
                self.of_hull(behind)
            } else {
                behind - self.moved[mass]
            },
            radius,
        })
    }

    /// The hull in space, if its contact face is at `front` \[m\] on the axis `x` and its road at the height `road` \[m\]:
    /// positions and normals of the corners of [`hull_triangles`].
    #[must_use]
    pub fn hull(&self, front: f64, road: f64) -> Hull {
        let half = 0.5 * self.body.width();
        let stations = self
            .body
            .stations()
            .map(|[behind, bottom, top]| [front - self.of_hull(behind), road + bottom, road + top]);
        let mut hull = Hull {
            positions: Vec::with_capacity(HULL_CORNERS),
            normals: Vec::with_capacity(HULL_CORNERS),
            is_nose: Vec::with_capacity(HULL_CORNERS),
        };
        let ahead = self.body.stations();
        for (pair, undeformed) in stations.windows(2).zip(ahead.windows(2)) {
            let [[x, bottom, top], [rear, rear_bottom, rear_top]] = [pair[0], pair[1]];
            let in_nose = undeformed[1][0] <= self.body.nose;
            let mut face = |corners: [[f64; 3]; 4], normal| hull.add(corners, normal, in_nose);
            for y in [-half, half] {
                face(
                    [
                        [x, y, bottom],
                        [rear, y, rear_bottom],
                        [rear, y, rear_top],
                        [x, y, top],
                    ],
                    [0.0, y.signum(), 0.0],
                );
            }
            for (up, [z, rear_z]) in [(-1.0, [bottom, rear_bottom]), (1.0, [top, rear_top])] {
                let (along, rise) = (x - rear, z - rear_z);
                let length = along.hypot(rise);
                let normal = if length > 0.0 {
                    [-up * rise / length, 0.0, up * along / length]
                } else {
                    [0.0, 0.0, up]
                };
                let corners = [
                    [x, -half, z],
                    [x, half, z],
                    [rear, half, rear_z],
                    [rear, -half, rear_z],
                ];
                face(corners, normal);
            }
        }
        for (station, outwards) in [(stations[0], 1.0), (stations[HULL_STATIONS - 1], -1.0)] {
            let [x, bottom, top] = station;
            let corners = [
                [x, -half, bottom],
                [x, half, bottom],
                [x, half, top],
                [x, -half, top],
            ];
            let in_nose = outwards > 0.0 && self.body.nose > 0.0;
            hull.add(corners, [outwards, 0.0, 0.0], in_nose);
        }
        hull
    }

    /// The outline of the hull on the side `y` \[m\], closed.
    #[must_use]
    pub fn outline(&self, front: f64, road: f64, y: f64) -> Vec<[f64; 3]> {
        let stations = self.body.stations();
        let point = |behind: f64, z: f64| [front - self.of_hull(behind), y, road + z];
        let top = stations.iter().map(|[behind, _, top]| point(*behind, *top));
        let bottom = stations.iter().rev();
        let bottom = bottom.map(|[behind, bottom, _]| point(*behind, *bottom));
        let [behind, _, first] = stations[0];
        top.chain(bottom).chain([point(behind, first)]).collect()
    }
}

/// The surface of a hull.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Hull {
    /// Position of each corner \[m\].
    pub positions: Vec<[f32; 3]>,
    /// Outward unit normal at each corner.
    pub normals: Vec<[f32; 3]>,
    /// Whether each corner belongs to the nose.
    pub is_nose: Vec<bool>,
}

impl Hull {
    /// A hull of no size, for instants without a vehicle.
    #[must_use]
    pub fn absent() -> Self {
        Self {
            positions: vec![[0.0; 3]; HULL_CORNERS],
            normals: vec![[0.0, 0.0, 1.0]; HULL_CORNERS],
            is_nose: vec![false; HULL_CORNERS],
        }
    }

    fn add(&mut self, corners: [[f64; 3]; 4], normal: [f64; 3], is_nose: bool) {
        for corner in corners {
            self.positions.push(corner.map(|it| it as f32));
            self.normals.push(normal.map(|it| it as f32));
            self.is_nose.push(is_nose);
        }
    }
}

/// The triangles of every hull, as indices of its corners.
#[must_use]
pub fn hull_triangles() -> Vec<[u32; 3]> {
    let faces = HULL_CORNERS as u32 / 4;
    let of_face = |face: u32| {
        let first = 4 * face;
        [[0, 1, 2], [0, 2, 3]].map(|corners: [u32; 3]| corners.map(|it| first + it))
    };
    (0..faces).flat_map(of_face).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::vehicle_catalogue;

    /// Bodies of every style, with one to three masses.
    fn bodies() -> Vec<VehicleBody> {
        let mut bodies = vec![VehicleBody::rigid_mass()];
        for it in vehicle_catalogue() {
            let slack = vec![0.0; it.parts.len()];
            bodies.push(VehicleBody::named(&it.name, 0.0, &slack));
        }
        for total in [0.0, 1_500.0, 3_500.0, 8_000.0, 36_000.0] {
            for slack in [&[0.0][..], &[0.0, 0.3], &[0.0, 0.0, 0.4]] {
                bodies.push(VehicleBody::assumed(total, slack));
            }
        }
        bodies
    }

    /// Every vehicle of the catalogue has its own size and masses, and a nose that its front can crush.
    #[test]
    fn bodies_of_the_catalogue_have_their_real_size() {
        for it in vehicle_catalogue() {
            let slack = vec![0.0; it.parts.len()];
            let body = VehicleBody::named(&it.name, 0.0, &slack);
            let vehicle = body.crushed(&VehicleSample::default());
            let ends = vehicle.rear_parts().map(|[_, to]| to);
            let end = ends.fold(vehicle.of_hull(body.hull_length()), f64::max);
            assert!((end - it.size.value.length_m).abs() < 1e-9, "{}", it.name);
            assert_eq!(body.masses(), it.masses.value.kg.len(), "{}", it.name);
            assert!(body.nose > 0.4, "{}: {}", it.name, body.nose);
        }
        let car = VehicleBody::named("mid_car", 1719.0, &[0.0]);
        assert_eq!((car.style, car.size), (BodyStyle::Car, [4.9, 1.84, 1.45]));
        // The number of masses tells that this is another vehicle.
        let other = VehicleBody::named("mid_car", 9_000.0, &[0.0, 0.0]);
        assert_eq!(other, VehicleBody::assumed(9_000.0, &[0.0, 0.0]));
        assert_eq!(
            VehicleBody::named("mid_car", 1.0, &[]),
            VehicleBody::rigid_mass()
        );
    }

    fn crushed(crush: [f64; MAX_MASSES]) -> VehicleSample {
        VehicleSample {
            crush,
            ..VehicleSample::default()
        }
    }

    /// Every combination of some crushes, small and absurd.
    fn crushes() -> Vec<VehicleSample> {
        const CRUSHES: [f64; 8] = [0.0, -0.3, 0.1, 0.6, 1.7, 9.0, f64::NAN, f64::INFINITY];
        let mut all = Vec::new();
        for first in CRUSHES {
            for second in CRUSHES {
                all.extend(CRUSHES.map(|third| crushed([first, second, third])));
            }
        }
        all
    }

    #[test]
    fn the_nose_is_shorter_by_the_crush_and_never_negative() {
        for body in bodies() {
            for crush in [0.0, 0.05, 0.3, 0.9, 1.9, 50.0, f64::INFINITY] {
                let vehicle = body.crushed(&crushed([crush, 0.0, 0.0])).nose();
                assert_eq!(vehicle, (body.nose - crush).max(0.0), "{:?}", body.style);
            }
            let whole = body.crushed(&crushed([-0.2, 0.0, 0.0]));
            assert_eq!((whole.nose(), whole.crushed_share()), (body.nose, 0.0));
            // After the separation the crush that remains is drawn.
            let mut separated = crushed([0.1, 0.0, 0.0]);
            separated.permanent_crush[0] = 0.4;
            let expected = (body.nose - 0.4).max(0.0);
            assert_eq!(body.crushed(&separated).nose(), expected);
        }
    }

    /// What is behind the nose keeps its shape, and follows the contact face by the crush.
    #[test]
    fn the_hull_behind_the_nose_is_rigid() {
        for body in bodies() {
            let l = body.hull_length();
            let crush = 0.7 * body.nose;
            let vehicle = body.crushed(&crushed([crush, 0.0, 0.0]));
            assert!((vehicle.of_hull(l) - (l - crush)).abs() < 1e-12);
            let at_nose = vehicle.of_hull(body.nose);
            assert!((at_nose - vehicle.nose()).abs() < 1e-12);
            assert_eq!(vehicle.of_hull(0.0), 0.0);
        }
    }

    /// The crush of the second spring brings the load nearer to the cab by as much, beginning with its slack.
    #[test]
    fn the_load_moves_towards_the_cab() {
        let body = VehicleBody::assumed(8_000.0, &[0.0, 0.3]);
        let front = |crush: [f64; MAX_MASSES]| {
            let vehicle = body.crushed(&crushed(crush));
            let [front, _] = vehicle.rear_parts().next().expect("a load");
            front
        };
        let undeformed = body.parts[1].extent[0];
        let at_first = [0.0, -0.3, 0.0];
        assert!((front(at_first) - undeformed).abs() < 1e-12);
        assert!((front([0.0, 0.0, 0.0]) - (undeformed - 0.3)).abs() < 1e-12);
        assert!((front([0.5, 0.2, 0.0]) - (undeformed - 0.3 - 0.2 - 0.5)).abs() < 1e-12);
    }

    /// No box is inside another one or in front of the contact face, however large the crush is.
    #[test]
    fn boxes_never_overlap() {
        for body in bodies() {
            for sample in crushes() {
                let vehicle = body.crushed(&sample);
                let boxes: Vec<_> = vehicle.boxes().collect();
                for (index, (extent, heights, _)) in boxes.iter().enumerate() {
                    assert!(extent[0] >= -1e-12, "{:?}: {extent:?}", body.style);
                    for (other, other_heights, _) in &boxes[..index] {
                        let apart = |one: [f64; 2], other: [f64; 2]| {
                            one[0] >= other[1] - 1e-9 || other[0] >= one[1] - 1e-9
                        };
                        assert!(
                            apart(*extent, *other) || apart(*heights, *other_heights),
                            "{body:?} {sample:?}: {boxes:?}"
                        );
                    }
                }
                // The rear parts are behind the cab.
                if let Some([front, _]) = vehicle.rear_parts().next() {
                    assert!(front >= vehicle.of_hull(body.cab) - 1e-9);
                }
            }
        }
    }

    #[test]
    fn the_hull_has_its_size_and_no_corner_in_front_of_the_contact_face() {
        let triangles = hull_triangles();
        for body in bodies() {
            for sample in crushes() {
                let hull = body.crushed(&sample).hull(2.0, 0.5);
                assert_eq!(hull.positions.len(), HULL_CORNERS);
                assert_eq!(hull.normals.len(), HULL_CORNERS);
                assert_eq!(hull.is_nose.len(), HULL_CORNERS);
                let in_front = |it: &[f32; 3]| it[0] > 2.0 + 1e-6;
                assert!(!hull.positions.iter().any(in_front));
                for normal in &hull.normals {
                    let square: f32 = normal.iter().map(|it| it * it).sum();
                    assert!((square - 1.0).abs() < 1e-5);
                }
            }
            let hull = body.crushed(&VehicleSample::default()).hull(0.0, 0.0);
            let along = |axis: usize| {
                let values = hull.positions.iter().map(move |it| f64::from(it[axis]));
                let least = values.clone().fold(f64::INFINITY, f64::min);
                values.fold(f64::NEG_INFINITY, f64::max) - least
            };
            assert!((along(0) - body.hull_length()).abs() < 1e-5);
            assert!((along(1) - body.width()).abs() < 1e-5);
            assert!(along(2) <= body.size[2] + 1e-5);
        }
        let largest = triangles.iter().flatten().max();
        assert_eq!(largest, Some(&(HULL_CORNERS as u32 - 1)));
        assert_eq!(Hull::absent().positions.len(), HULL_CORNERS);
    }

    /// The boxes that stand for the hull stay within it, and none is inside another.
    #[test]
    fn the_boxes_of_the_hull_share_no_space() {
        for body in bodies() {
            for crush in [0.0, 0.4, 1.3, 9.0] {
                let vehicle = body.crushed(&crushed([crush, 0.0, 0.0]));
                let boxes = vehicle.hull_boxes();
                let is_there = |it: &&([f64; 2], [f64; 2])| it.0[1] > it.0[0];
                let boxes: Vec<_> = boxes.iter().filter(is_there).collect();
                assert!(!boxes.is_empty());
                let end = vehicle.of_hull(body.hull_length());
                for (index, (extent, heights)) in boxes.iter().enumerate() {
                    assert!(extent[0] >= 0.0 && extent[1] <= end + 1e-12);
                    assert!(heights[0] < heights[1] && heights[1] <= body.size[2] + 1e-12);
                    for (other, other_heights) in &boxes[..index] {
                        let apart = |one: [f64; 2], other: [f64; 2]| {
                            one[0] >= other[1] - 1e-9 || other[0] >= one[1] - 1e-9
                        };
                        assert!(
                            apart(*extent, *other) || apart(*heights, *other_heights),
                            "{body:?}: {boxes:?}"
                        );
                    }
                }
            }
        }
    }

    /// The front hits the column at the height of the impact; a vehicle stands on the base's level if it can.
    #[test]
    fn the_road_is_where_the_front_meets_the_impact() {
        for body in bodies() {
            let [_, bottom, top] = body.stations()[0];
            for impact in [0.05, 0.3, 0.6, 1.0, 1.25, 3.0] {
                let road = body.road(impact);
                let above = impact - road;
                assert!(bottom < above && above < top, "{:?}", body.style);
                let margin = FRONT_MARGIN;
                if body.is_real() && (bottom + margin..top - margin).contains(&impact) {
                    assert_eq!(road, 0.0);
                }
            }
        }
    }

    #[test]
    fn every_wheel_is_under_the_vehicle() {
        for body in bodies() {
            let vehicle = body.crushed(&VehicleSample::default());
            for wheel in vehicle.wheels() {
                assert!(0.0 < wheel.behind && wheel.behind < body.length());
                assert!(0.1 < wheel.radius && wheel.radius < 0.7, "{wheel:?}");
            }
            assert_eq!(vehicle.wheels().count() > 0, body.is_real());
        }
    }
}
