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

/// A place along the hull: a part of its length, a part of the length of the cab, and metres, which add up.
type Place = [f64; 3];

/// What a kind of vehicle looks like. Heights are parts of that of the hull; those of engine and wheels, of that of the vehicle.
#[derive(Debug, PartialEq)]
struct Look {
    /// Largest length of the cab \[m\], and its largest part of the length of the vehicle.
    cab: [f64; 2],
    /// Rear end of the nose.
    nose: Place,
    /// Front and rear end of the engine, if it is drawn.
    engine: Option<[Place; 2]>,
    /// The cross-sections of the hull: where; bottom and top.
    hull: &'static [(Place, [f64; 2])],
    /// The axles of the hull: where, and the radius of the wheels.
    axles: &'static [(Place, f64)],
    /// The boxes that stand for the hull: top of the nose; lower edge of the upper box, and its ends.
    boxes: (f64, f64, [Place; 2]),
}

/// The face, the rear end of the hull, and the rear end of the cab.
const FACE: Place = [0.0; 3];
const REAR: Place = part(1.0);
const CAB: Place = of_cab(1.0);

const fn part(of_length: f64) -> Place {
    [of_length, 0.0, 0.0]
}

const fn of_cab(part: f64) -> Place {
    [0.0, part, 0.0]
}

/// The paper's rigid mass: a block, which is a symbol and has no real size.
const RIGID_MASS: Look = Look {
    cab: [f64::INFINITY, 1.0],
    nose: FACE,
    engine: None,
    hull: &[(FACE, [0.0, 1.0]), (REAR, [0.0, 1.0])],
    axles: &[],
    boxes: (1.0, 1.0, [FACE; 2]),
};

/// Bonnet, cabin, boot.
#[rustfmt::skip]
const CAR: Look = Look {
    nose: part(0.27),
    hull: &[
        (FACE, [0.15, 0.47]), (part(0.03), [0.13, 0.56]), (part(0.27), [0.13, 0.67]),
        (part(0.42), [0.13, 0.98]), (part(0.58), [0.13, 1.0]), (part(0.72), [0.13, 0.96]),
        (part(0.88), [0.13, 0.70]), (part(0.98), [0.13, 0.66]), (REAR, [0.17, 0.50]),
    ],
    axles: &[(part(0.19), 0.22), (part(0.80), 0.22)],
    boxes: (0.47, 0.66, [part(0.36), part(0.80)]),
    ..RIGID_MASS
};

/// A short bonnet and a high body.
#[rustfmt::skip]
const VAN: Look = Look {
    nose: part(0.21),
    hull: &[
        (FACE, [0.12, 0.36]), (part(0.02), [0.10, 0.42]), (part(0.16), [0.10, 0.50]),
        (part(0.28), [0.10, 0.93]), (part(0.36), [0.10, 1.0]), (part(0.98), [0.10, 1.0]), (REAR, [0.12, 0.97]),
    ],
    axles: &[(part(0.16), 0.14), (part(0.78), 0.14)],
    boxes: (0.36, 0.50, [part(0.21), REAR]),
    ..RIGID_MASS
};

/// A low body with a mast.
#[rustfmt::skip]
const FORKLIFT: Look = Look {
    nose: part(0.15),
    hull: &[
        (FACE, [0.08, 1.0]), (part(0.06), [0.08, 1.0]), (part(0.06), [0.08, 0.40]),
        (part(0.45), [0.08, 0.40]), (part(0.55), [0.08, 0.55]), (REAR, [0.10, 0.55]),
    ],
    axles: &[(part(0.2), 0.16), (part(0.85), 0.12)],
    boxes: (0.55, 0.55, [FACE, part(0.06)]),
    ..RIGID_MASS
};

/// A cab above the front axle, and a load area, in one piece.
#[rustfmt::skip]
const LORRY: Look = Look {
    cab: [2.1, 0.3],
    nose: of_cab(0.95),
    engine: None,
    hull: &[
        (FACE, [0.11, 0.72]), (of_cab(0.15), [0.11, 0.80]), (CAB, [0.11, 0.80]), (CAB, [0.20, 0.28]),
        ([0.0, 1.0, 0.25], [0.20, 0.28]), ([0.0, 1.0, 0.25], [0.20, 1.0]), (REAR, [0.20, 1.0]),
    ],
    axles: &[([0.0, 0.0, 1.4], 0.14), (part(0.78), 0.14)],
    boxes: (0.76, 0.28, [CAB, REAR]),
};

/// A lorry whose load is a mass of its own, behind the cab on a frame.
#[rustfmt::skip]
const CHASSIS: Look = Look {
    engine: Some([of_cab(0.33), of_cab(0.8)]),
    hull: &[
        (FACE, [0.11, 0.72]), (of_cab(0.15), [0.11, 0.80]), (CAB, [0.11, 0.80]),
        (CAB, [0.20, 0.28]), ([0.0, 1.0, 0.25], [0.20, 0.28]), (REAR, [0.20, 0.28]),
    ],
    boxes: (0.76, 0.28, [of_cab(0.95), CAB]),
    ..LORRY
};

/// The same in front of a trailer.
const TRACTOR: Look = Look {
    axles: &[([0.0, 0.0, 1.4], 0.14), (part(0.85), 0.14)],
    ..CHASSIS
};

/// A part whose rear end is this far behind the hull \[m\] has wheels of its own.
const REACHES_FAR: f64 = 2.0;

/// Distances of their axles from that end \[m\], and their radius as a part of the height of the vehicle.
const REAR_AXLES: ([f64; 3], f64) = ([1.3, 2.6, 3.9], 0.13);

/// The body of a vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleBody {
    look: &'static Look,
    /// Overall length, width and height \[m\].
    pub size: [f64; 3],
    /// Length of the undeformed nose, which the crush of spring 1 shortens \[m\].
    pub nose: f64,
    /// Rear end of the cab \[m\]; the length of the vehicle if the body has one piece.
    pub cab: f64,
    /// Front and rear end of the engine \[m\], if it is drawn.
    pub engine: Option<[f64; 2]>,
    /// Its masses, front first. The first one is the hull, with nose and wheels.
    pub parts: Vec<VehiclePart>,
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

fn vehicle_part(name: &str, [from_m, to_m]: [f64; 2], [bottom_m, top_m]: [f64; 2]) -> VehiclePart {
    VehiclePart {
        name: name.to_owned(),
        from_m,
        to_m,
        bottom_m,
        top_m,
    }
}

impl Look {
    /// Length of the cab of a vehicle of this length \[m\].
    fn cab(&self, length: f64) -> f64 {
        self.cab[0].min(self.cab[1] * length)
    }
}

impl VehicleBody {
    /// The paper's rigid mass: length, width and height of its block \[m\] are a symbol.
    #[must_use]
    pub fn rigid_mass() -> Self {
        let size = [1.6, 1.4, 0.7];
        let block = vehicle_part("rigid mass", [0.0, size[0]], [0.0, size[2]]);
        Self::new(&RIGID_MASS, size, vec![block], &[0.0])
    }

    /// A body for a vehicle that is given by masses and springs alone: its size is an assumption of ours, which follows from
    /// its total mass \[kg\].
    ///
    /// `slack` \[m\] has one entry for each of its springs, front first.
    #[must_use]
    pub fn assumed(total: f64, slack: &[f64]) -> Self {
        let (look, size) = match slack.len() {
            0 | 1 if total < 2_500.0 => (&CAR, [4.5, 1.8, 1.5]),
            0 | 1 if total < 4_000.0 => (&VAN, [5.9, 2.0, 2.5]),
            _ if total < 4_000.0 => (&LORRY, [5.5, 1.9, 2.2]),
            _ if total < 20_000.0 => (&LORRY, [8.0, 2.5, 3.4]),
            _ => (&LORRY, [16.5, 2.55, 3.8]),
        };
        let [length, _, height] = size;
        let count = slack.len().max(1);
        let is_articulated = count > 1 && length > 12.0;
        let (name, hull, top) = match count {
            1 => ("vehicle", length, height),
            _ if is_articulated => ("tractor", 6.0, 0.87 * height),
            _ => ("cab and chassis", length, 0.87 * height),
        };
        let mut parts = vec![vehicle_part(name, [0.0, hull], [0.13 * height, top])];
        // The other masses divide the length behind the cab; the gaps in front of them are what can close.
        let cab = look.cab(length);
        let gap = |spring: usize| 0.5 + slack[spring];
        let gaps: f64 = (1..count).map(gap).sum();
        let each = ((length - cab - gaps) / (count.max(2) - 1) as f64).max(0.2 * length);
        let mut from = cab;
        for spring in 1..count {
            from += gap(spring);
            let name = match spring {
                1 if is_articulated => "trailer",
                1 => "load",
                _ => "rear load",
            };
            let extent = [from, from + each];
            parts.push(vehicle_part(name, extent, [0.36 * height, height]));
            from += each;
        }
        Self::new(look, size, parts, slack)
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
        let look = match vehicle.parts[0].name.as_str() {
            _ if slack.len() > 1 => &LORRY,
            "van" => &VAN,
            "lorry" | "tractor" => &LORRY,
            "forklift" => &FORKLIFT,
            _ => &CAR,
        };
        let size = &vehicle.size.value;
        let size = [size.length_m, size.width_m, size.height_m];
        Self::new(look, size, vehicle.parts.clone(), slack)
    }

    fn new(look: &'static Look, size: [f64; 3], parts: Vec<VehiclePart>, slack: &[f64]) -> Self {
        let [length, ..] = size;
        let look = match &parts[..] {
            [hull, _, ..] if hull.to_m < length => &TRACTOR,
            [_, _, ..] => &CHASSIS,
            _ => look,
        };
        let behind = parts.get(1).map_or(length, |part| part.from_m);
        let mut body = Self {
            look,
            size,
            nose: 0.0,
            cab: look.cab(length).min(behind),
            engine: None,
            parts,
            slack: slack.to_vec(),
        };
        body.nose = body.place(look.nose);
        body.engine = look.engine.map(|ends| ends.map(|it| body.place(it)));
        body
    }

    /// Names of what the masses are, front first.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().map(|part| part.name.as_str())
    }

    /// Rear end of the undeformed hull, which moves with the first mass \[m\].
    fn hull_length(&self) -> f64 {
        self.parts[0].to_m
    }

    /// How far a place of the undeformed hull is behind its face \[m\].
    fn place(&self, [of_length, of_cab, metres]: Place) -> f64 {
        of_length * self.hull_length() + of_cab * self.cab + metres
    }

    /// The second and the third mass.
    fn rear(&self) -> &[VehiclePart] {
        &self.parts[1..]
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
        !self.look.axles.is_empty()
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
            moved[index] = moved[index - 1] + closed.min(part.from_m - ahead);
            ahead = part.to_m;
        }
        CrushedVehicle {
            body: self,
            nose,
            moved,
        }
    }

    /// The cross-sections of the undeformed hull.
    fn stations(&self) -> [Station; HULL_STATIONS] {
        let (hull, h) = (self.look.hull, self.parts[0].top_m);
        std::array::from_fn(|index| {
            let (place, [bottom, top]) = hull[index.min(hull.len() - 1)];
            [self.place(place), bottom * h, top * h]
        })
    }

    /// Axles of the undeformed vehicle, front first: distance behind the face, radius, and the mass that carries them.
    fn axles(&self) -> Vec<(f64, f64, usize)> {
        let h = self.size[2];
        let own = self.look.axles.iter();
        let own = own.map(|(place, radius)| (self.place(*place), radius * h, 0));
        let (from_rear, radius) = REAR_AXLES;
        let far = self.hull_length() + REACHES_FAR;
        let rear = self.parts.iter().enumerate().skip(1);
        let rear = rear.filter(|(_, part)| part.to_m > far);
        let rear =
            rear.flat_map(|(index, part)| from_rear.map(|it| (part.to_m - it, radius * h, index)));
        own.chain(rear).collect()
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
        parts.map(|(part, moved)| [part.from_m, part.to_m].map(|end| end - moved))
    }

    /// The boxes of engine and rear parts: front and rear end, bottom and top, half the width \[m\]; the engine first.
    pub fn boxes(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2], f64)> + '_ {
        let [_, width, height] = self.body.size;
        let engine = self.engine().map(|extent| {
            let heights = ENGINE.map(|part| part * height);
            (extent, heights, 0.22 * width)
        });
        let rear = self.rear_parts().zip(self.body.rear());
        let rear =
            rear.map(move |(extent, part)| (extent, [part.bottom_m, part.top_m], 0.5 * width));
        engine.into_iter().chain(rear)
    }

    /// The hull as at most three boxes, for displays that know no other shape: front and rear end, bottom and top \[m\] of the
    /// nose, of what is behind it, and of what is above that. An end that is not in front of the other means that there is
    /// no such box.
    #[must_use]
    pub fn hull_boxes(&self) -> [([f64; 2], [f64; 2]); 3] {
        let body = self.body;
        let h = body.parts[0].top_m;
        let (nose_top, edge, upper) = body.look.boxes;
        let (nose_top, edge) = (nose_top * h, edge * h);
        let stations = body.stations();
        let bottom = stations[0][1];
        let top = stations.iter().map(|it| it[2]).fold(0.0, f64::max);
        let upper = upper.map(|it| body.place(it));
        let place = |extent: [f64; 2]| extent.map(|end| self.of_hull(end));
        [
            (place([0.0, body.nose]), [bottom, nose_top]),
            (place([body.nose, body.hull_length()]), [bottom, edge]),
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
        let stations = self.body.stations();
        let mut hull = Hull::default();
        let mut add = |corners: [[f64; 3]; 4], normal: [f64; 3], rear: f64| {
            hull.positions
                .extend(corners.map(|it| it.map(|it| it as f32)));
            hull.normals.extend([normal.map(|it| it as f32); 4]);
            let is_nose = self.body.nose > 0.0 && rear <= self.body.nose;
            hull.is_nose.extend([is_nose; 4]);
        };
        for pair in stations.windows(2) {
            let [[ahead, low, high], [rear, rear_low, rear_high]] = [pair[0], pair[1]];
            let side = [
                (ahead, low),
                (rear, rear_low),
                (rear, rear_high),
                (ahead, high),
            ];
            for y in [-half, half] {
                let corners = side.map(|(behind, z)| [front - self.of_hull(behind), y, road + z]);
                add(corners, [0.0, y.signum(), 0.0], rear);
            }
        }
        let [left, right] = [-half, half].map(|y| self.outline(front, road, y));
        let behind = stations.iter().chain(stations.iter().rev());
        let behind: Vec<_> = behind.chain([&stations[0]]).map(|it| it[0]).collect();
        for (edge, behind) in (0..left.len()).zip(behind.windows(2)) {
            let next = edge + 1;
            let ([x, _, z], [next_x, _, next_z]) = (left[edge], left[next]);
            let length = (next_x - x).hypot(next_z - z);
            let normal = match length > 0.0 {
                true => [(next_z - z) / length, 0.0, (x - next_x) / length],
                false => [0.0, 0.0, 1.0],
            };
            let corners = [left[edge], right[edge], right[next], left[next]];
            add(corners, normal, behind[0].max(behind[1]));
        }
        hull
    }

    /// The outline of the hull on the side `y` \[m\], closed: backwards along its top, and forwards along its bottom.
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
        assert_eq!((car.look, car.size), (&CAR, [4.9, 1.84, 1.45]));
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
                assert_eq!(vehicle, (body.nose - crush).max(0.0), "{:?}", body.look);
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
        let undeformed = body.parts[1].from_m;
        let at_first = [0.0, -0.3, 0.0];
        assert!((front(at_first) - undeformed).abs() < 1e-12);
        assert!((front([0.0, 0.0, 0.0]) - (undeformed - 0.3)).abs() < 1e-12);
        assert!((front([0.5, 0.2, 0.0]) - (undeformed - 0.3 - 0.2 - 0.5)).abs() < 1e-12);
    }

    /// Checks that no box, given by its ends and heights, is inside another one.
    fn share_no_space(boxes: &[([f64; 2], [f64; 2])], body: &VehicleBody) {
        let apart =
            |one: [f64; 2], other: [f64; 2]| one[0] >= other[1] - 1e-9 || other[0] >= one[1] - 1e-9;
        for (index, (extent, heights)) in boxes.iter().enumerate() {
            for (other, other_heights) in &boxes[..index] {
                let are_apart = apart(*extent, *other) || apart(*heights, *other_heights);
                assert!(are_apart, "{body:?}: {boxes:?}");
            }
        }
    }

    /// No box is inside another one or in front of the contact face, however large the crush is.
    #[test]
    fn boxes_never_overlap() {
        for body in bodies() {
            for sample in crushes() {
                let vehicle = body.crushed(&sample);
                let boxes: Vec<_> = vehicle.boxes().map(|(ends, z, _)| (ends, z)).collect();
                assert!(boxes.iter().all(|(ends, _)| ends[0] >= -1e-12), "{boxes:?}");
                share_no_space(&boxes, &body);
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
                let mut boxes = vehicle.hull_boxes().to_vec();
                boxes.retain(|(ends, _)| ends[1] > ends[0]);
                assert!(!boxes.is_empty());
                let end = vehicle.of_hull(body.hull_length());
                for (extent, heights) in &boxes {
                    assert!(extent[0] >= 0.0 && extent[1] <= end + 1e-12);
                    assert!(heights[0] < heights[1] && heights[1] <= body.size[2] + 1e-12);
                }
                share_no_space(&boxes, &body);
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
                assert!(bottom < above && above < top, "{:?}", body.look);
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
