//! What an impact leaves in the column: as little as possible, so that a fleet can keep it.
//!
//! Plastic strains are kept as whole numbers of 16 bits, in steps of the largest one of their section over 32 767: 6 kPa where that
//! is 1e-3, 0.3 MPa where it is 5 %. The equilibrium is computed again before the next impact, so that a column
//! whose damage was stored and restored responds exactly as one whose damage stayed in memory.

use base64::Engine;
use base64::engine::general_purpose::STANDARD_NO_PAD as TEXT;
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::beam::{BARS, Beam, POINTS, State};
use super::element::{Triad, UPRIGHT, turned};
use super::section::Section;

/// The damaged column at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Damage {
    /// Heights of the nodes \[m\].
    heights: Vec<f64>,
    /// Displacement of each node \[m\].
    moved: Vec<[f64; 3]>,
    /// Rotation of each node as a vector, twice the tangent of half the angle.
    rotated: Vec<[f64; 3]>,
    /// Shear angle below and above the impact point.
    shear: [f64; BARS],
    /// Where the sheared part below the impact point ends and the one above begins \[m\].
    sheared: [f64; BARS],
    /// Plastic shear angles of web and frame of each element.
    sliders: Vec<[f64; 2]>,
    /// Sections that have yielded; others take nothing.
    points: Vec<Yielded>,
    /// Whether it is in the plane of the web alone.
    plane: bool,
    /// Fibres of a section without and with shear.
    fibres: [usize; 2],
}

/// The plastic strains of a section.
#[derive(Debug, Clone, PartialEq)]
struct Yielded {
    place: usize,
    /// Steps of normal and of shear strains.
    steps: [f32; 2],
    /// In steps.
    plain: Vec<i16>,
    /// Normal and shear, in steps.
    web: Vec<[i16; 2]>,
}

impl Yielded {
    fn of(place: usize, plain: Vec<f64>, web: &[[f64; 2]]) -> Self {
        let normal = plain.iter().chain(web.iter().map(|[normal, _]| normal));
        let steps = [
            Self::step(normal),
            Self::step(web.iter().map(|[_, shear]| shear)),
        ];
        let in_steps = |strain: f64, step: f32| match step > 0.0 {
            true => libm::round(strain / f64::from(step)) as i16,
            false => 0,
        };
        Self {
            place,
            steps,
            plain: (plain.into_iter().map(|strain| in_steps(strain, steps[0]))).collect(),
            web: (web.iter())
                .map(|pair| [0, 1].map(|kind| in_steps(pair[kind], steps[kind])))
                .collect(),
        }
    }

    fn step<'a>(strains: impl Iterator<Item = &'a f64>) -> f32 {
        let largest = strains.fold(0.0_f64, |largest, strain| largest.max(strain.abs()));
        (largest / f64::from(i16::MAX)) as f32
    }

    /// The plastic strain of a fibre without shear.
    fn plain(&self, fibre: usize) -> f64 {
        f64::from(self.steps[0]) * f64::from(self.plain[fibre])
    }

    /// The plastic normal and shear strain of a fibre of the web.
    fn web(&self, fibre: usize) -> [f64; 2] {
        [0, 1].map(|kind| f64::from(self.steps[kind]) * f64::from(self.web[fibre][kind]))
    }
}

/// The rotation of a triad that was upright.
pub(crate) fn rotation(triad: &Triad) -> [f64; 3] {
    let [a, b, c] = triad;
    let per = 2.0 / (1.0 + a[0] + b[1] + c[2]);
    [b[2] - c[1], c[0] - a[2], a[1] - b[0]].map(|x| per * x)
}

/// Where the parts of one division of the column lie in those of another: for each new part its old parts and their shares.
fn overlaps(old: &[f64], new: &[f64]) -> Vec<Vec<(usize, f64)>> {
    new.windows(2)
        .map(|part| {
            let whole = part[1] - part[0];
            old.windows(2)
                .enumerate()
                .filter_map(|(index, other)| {
                    let common = part[1].min(other[1]) - part[0].max(other[0]);
                    (common > 0.0).then_some((index, common / whole))
                })
                .collect()
        })
        .collect()
}

/// The bounds of the parts that belong to the integration points of elements between these heights.
fn parts(heights: &[f64]) -> Vec<f64> {
    let mut bounds = vec![heights[0]];
    for pair in heights.windows(2) {
        for part in 1..=POINTS {
            let share = part as f64 / POINTS as f64;
            bounds.push(pair[0] + share * (pair[1] - pair[0]));
        }
    }
    bounds
}

impl Damage {
    pub(crate) fn of<const D: usize, const R: usize, const Q: usize>(
        beam: &Beam<D, R, Q>,
        state: &State<D, R>,
    ) -> Self {
        let section = &beam.section;
        let points = state.points.iter().enumerate();
        Self {
            heights: beam.places.iter().map(|place| place[0]).collect(),
            moved: state.moved.clone(),
            rotated: state.triads.iter().map(rotation).collect(),
            shear: state.shear,
            sheared: beam.sheared(),
            sliders: state.sliders.clone(),
            points: points
                .filter(|(place, _)| state.yielded[*place])
                .map(|(place, point)| {
                    Yielded::of(place, section.plastic_strains(point).collect(), &point.web)
                })
                .collect(),
            plane: D == 3,
            fibres: section.fibres(),
        }
    }

    /// Whether it lies in the plane of the web.
    #[must_use]
    pub fn is_plane(&self) -> bool {
        self.plane
    }

    /// Bytes of the text that it would be if every fibre of every section had yielded: no damage of this column takes more as long
    /// as its mesh is this one.
    #[must_use]
    pub fn most_bytes(&self) -> usize {
        let [plain, web] = self.fibres;
        let every = |place| Yielded {
            place,
            steps: [1.0; 2],
            plain: vec![1; plain],
            web: vec![[1; 2]; web],
        };
        let full = Self {
            points: (0..POINTS * (self.heights.len() - 1)).map(every).collect(),
            ..self.clone()
        };
        full.text().len()
    }

    /// As text.
    fn text(&self) -> String {
        TEXT.encode(self.to_bytes())
    }

    /// Heights of its nodes \[m\].
    pub(crate) fn heights(&self) -> &[f64] {
        &self.heights
    }

    /// Number of fibres of its sections.
    pub(crate) fn fibres(&self) -> [usize; 2] {
        self.fibres
    }

    /// Towards which side of y and z it is bent.
    pub(crate) fn sides(&self) -> [f64; 2] {
        [1, 2].map(|axis| {
            let mut farthest = 0.0_f64;
            for moved in &self.moved {
                if moved[axis].abs() > farthest.abs() {
                    farthest = moved[axis];
                }
            }
            if farthest < 0.0 { -1.0 } else { 1.0 }
        })
    }

    /// Damage of the same shape, with everything that is plastic so many times as large; its nodes are near their equilibrium only.
    pub(crate) fn times(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        let places = scaled.moved.iter_mut().chain(&mut scaled.rotated);
        let values = places.flatten().chain(&mut scaled.shear);
        values
            .chain(scaled.sliders.iter_mut().flatten())
            .for_each(|value| *value *= factor);
        let steps = (scaled.points.iter_mut()).flat_map(|point| &mut point.steps);
        steps.for_each(|step| *step = (factor * f64::from(*step)) as f32);
        scaled
    }

    /// Puts it into the undamaged state of a beam, which may have other nodes: displacements are interpolated, and the plastic
    /// strains of a new point are the mean over its part of the column, so that plastic rotation and shortening are kept.
    /// `from` is the section in the plane where the beam is in space and the damage is not. Tells whether the nodes
    /// are the same; elsewhere the state is only near an equilibrium.
    pub(crate) fn apply<const D: usize, const R: usize, const Q: usize>(
        &self,
        beam: &Beam<D, R, Q>,
        state: &mut State<D, R>,
        from: Option<&Section>,
    ) -> bool {
        let heights: Vec<f64> = beam.places.iter().map(|place| place[0]).collect();
        let same = heights == self.heights;
        for (node, &x) in heights.iter().enumerate() {
            let (below, share) = if same { (node, 0.0) } else { self.place(x) };
            let between = |values: &[[f64; 3]]| {
                if share == 0.0 {
                    return values[below];
                }
                [0, 1, 2].map(|k| (1.0 - share) * values[below][k] + share * values[below + 1][k])
            };
            state.moved[node] = between(&self.moved);
            state.triads[node] = turned(&UPRIGHT, &between(&self.rotated)).1;
        }
        let one = |count: usize| (0..count).map(|k| vec![(k, 1.0)]).collect::<Vec<_>>();
        let elements = match same {
            true => one(beam.elements.len()),
            false => overlaps(&self.heights, &heights),
        };
        for (index, (element, old)) in beam.elements.iter().zip(&elements).enumerate() {
            if element.bar.is_some() {
                let mean = |k: usize| {
                    let parts = old.iter().map(|(at, share)| share * self.sliders[*at][k]);
                    parts.sum()
                };
                state.sliders[index] = [mean(0), mean(1)];
            }
        }
        state.shear = self.shear;
        if !same {
            self.shear_anew(beam, state, &elements);
        }
        let points = match same {
            true => one(state.points.len()),
            false => overlaps(&parts(&self.heights), &parts(&heights)),
        };
        let section = &beam.section;
        let spread = from.map(|plane| section.counterparts(plane));
        for (place, old) in points.iter().enumerate() {
            let mut plain = vec![0.0; section.fibres()[0]];
            let mut web = vec![[0.0; 2]; section.fibres()[1]];
            for (at, share) in old {
                let Ok(index) = self.points.binary_search_by_key(at, |point| point.place) else {
                    continue;
                };
                state.yielded[place] = true;
                let point = &self.points[index];
                for (k, strain) in plain.iter_mut().enumerate() {
                    let fibre = spread.as_ref().map_or(k, |spread| spread[0][k]);
                    *strain += share * point.plain(fibre);
                }
                for (k, strains) in web.iter_mut().enumerate() {
                    let fibre = spread.as_ref().map_or(k, |spread| spread[1][k]);
                    for (strain, by) in strains.iter_mut().zip(point.web(fibre)) {
                        *strain += share * by;
                    }
                }
            }
            if state.yielded[place] {
                state.points[place] = section.point(&plain, web);
            }
        }
        same
    }

    /// Gives the parts of the column that shear in the beam their mean angles, and its nodes the place that follows from these
    /// angles and from the rotations that they had.
    fn shear_anew<const D: usize, const R: usize, const Q: usize>(
        &self,
        beam: &Beam<D, R, Q>,
        state: &mut State<D, R>,
        elements: &[Vec<(usize, f64)>],
    ) {
        let angle_before = |old: &Vec<(usize, f64)>| {
            let angles = old.iter().map(|(at, share)| {
                let middle = 0.5 * (self.heights[*at] + self.heights[at + 1]);
                if middle < self.sheared[0] {
                    share * self.shear[0]
                } else if middle > self.sheared[1] {
                    share * self.shear[1]
                } else {
                    0.0
                }
            });
            angles.sum::<f64>()
        };
        let sheared = beam.sheared();
        let impact = 0.5 * (sheared[0] + sheared[1]);
        let (mut ways, mut lengths) = ([0.0; BARS], [0.0; BARS]);
        for (index, old) in elements.iter().enumerate() {
            let (from, to) = (beam.places[index][0], beam.places[index + 1][0]);
            let bar = usize::from(0.5 * (from + to) > impact);
            ways[bar] += (to - from) * angle_before(old);
            if beam.elements[index].bar.is_some() {
                lengths[bar] += to - from;
            }
        }
        for bar in 0..BARS {
            state.shear[bar] = if lengths[bar] > 0.0 {
                ways[bar] / lengths[bar]
            } else {
                0.0
            };
        }
        // The axis turns by the rotation of the sections less the shear angle.
        let mut shifted = 0.0;
        for (index, old) in elements.iter().enumerate() {
            let length = beam.places[index + 1][0] - beam.places[index][0];
            let now = beam.elements[index].bar.map_or(0.0, |bar| state.shear[bar]);
            shifted -= length * (now - angle_before(old));
            state.moved[index + 1][1] += shifted;
        }
    }

    /// The node below a height and how far towards the next it lies.
    fn place(&self, x: f64) -> (usize, f64) {
        let last = self.heights.len() - 2;
        let above = self.heights.partition_point(|height| *height <= x);
        let below = above.saturating_sub(1).min(last);
        let (from, to) = (self.heights[below], self.heights[below + 1]);
        (below, ((x - from) / (to - from)).clamp(0.0, 1.0))
    }

    /// As bytes: nodes, shear angles, then of each section that has yielded its steps, a bit for each plastic strain, and those that are
    /// not 0. Numbers begin with their lowest byte.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut to = vec![FORMAT, u8::from(self.plane)];
        let counts = [
            self.heights.len(),
            self.fibres[0],
            self.fibres[1],
            self.points.len(),
        ];
        for count in counts {
            to.extend((count as u16).to_le_bytes());
        }
        let nodes = self.heights.iter().zip(&self.moved).zip(&self.rotated);
        let numbers =
            nodes.flat_map(|((x, moved), rotated)| [*x].into_iter().chain(*moved).chain(*rotated));
        let angles = self.shear.into_iter().chain(self.sheared);
        let angles = angles.chain(self.sliders.iter().flatten().copied());
        for number in numbers.chain(angles) {
            to.extend(number.to_le_bytes());
        }
        for point in &self.points {
            to.extend((point.place as u16).to_le_bytes());
            for step in point.steps {
                to.extend(step.to_le_bytes());
            }
            let web = point.web.iter().flatten();
            let strains: Vec<i16> = point.plain.iter().chain(web).copied().collect();
            for eight in strains.chunks(8) {
                let bits = eight.iter().enumerate();
                to.push(
                    bits.map(|(bit, strain)| u8::from(*strain != 0) << bit)
                        .sum(),
                );
            }
            for strain in strains.iter().filter(|strain| **strain != 0) {
                to.extend(strain.to_le_bytes());
            }
        }
        to
    }

    /// Reads what [`Damage::to_bytes`] has written.
    ///
    /// # Errors
    /// What is wrong with the bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, DamageError> {
        let mut from = Reader { bytes, at: 0 };
        let [format, plane] = from.take()?;
        if format != FORMAT || plane > 1 {
            return Err(DamageError::Format { found: format });
        }
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = usize::from(u16::from_le_bytes(from.take()?));
        }
        let [nodes, plain, web, yielded] = counts;
        let sections = POINTS * nodes.saturating_sub(1);
        if nodes < 2 || yielded > sections {
            return Err(DamageError::Numbers);
        }
        let mut damage = Self {
            heights: Vec::new(),
            moved: Vec::new(),
            rotated: Vec::new(),
            shear: [0.0; BARS],
            sheared: [0.0; BARS],
            sliders: Vec::new(),
            points: Vec::new(),
            plane: plane == 1,
            fibres: [plain, web],
        };
        for _ in 0..nodes {
            damage.heights.push(from.number()?);
            damage.moved.push(from.numbers()?);
            damage.rotated.push(from.numbers()?);
        }
        damage.shear = from.numbers()?;
        damage.sheared = from.numbers()?;
        for _ in 1..nodes {
            damage.sliders.push(from.numbers()?);
        }
        let rises = damage.heights.windows(2).all(|pair| pair[0] < pair[1]);
        let begins = damage.heights[0] == 0.0;
        let mut next = 0;
        for _ in 0..yielded {
            let place = usize::from(u16::from_le_bytes(from.take()?));
            if place < next || place >= sections {
                return Err(DamageError::Numbers);
            }
            next = place + 1;
            let steps = [from.take()?, from.take()?].map(f32::from_le_bytes);
            if !steps.iter().all(|step| step.is_finite()) {
                return Err(DamageError::Numbers);
            }
            let strains = from.strains(plain + 2 * web)?;
            let (normal, both) = strains.split_at(plain);
            damage.points.push(Yielded {
                place,
                steps,
                plain: normal.to_vec(),
                web: both
                    .chunks_exact(2)
                    .map(|pair| [pair[0], pair[1]])
                    .collect(),
            });
        }
        if !begins || !rises || from.at != bytes.len() {
            return Err(DamageError::Numbers);
        }
        Ok(damage)
    }
}

/// First byte of stored damage.
const FORMAT: u8 = 2;

/// Why bytes are not the damage of a beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum DamageError {
    /// Another format, or something else.
    #[error(
        "the damage of the beam begins with {found}; expected {FORMAT}, the format of this version"
    )]
    Format {
        /// Its first byte.
        found: u8,
    },
    /// Too short.
    #[error("the damage of the beam ends after {found} bytes; more were expected")]
    Short {
        /// How many bytes there are.
        found: usize,
    },
    /// Numbers that contradict each other.
    #[error(
        "the damage of the beam has numbers that are not finite or contradict each other; it was changed after it was stored"
    )]
    Numbers,
    /// Text that does not hold bytes.
    #[error("the damage of the beam is not text in base64 without padding")]
    Text,
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], DamageError> {
        let found = self.bytes.len();
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let taken = rest
            .first_chunk::<N>()
            .ok_or(DamageError::Short { found })?;
        self.at += N;
        Ok(*taken)
    }

    fn number(&mut self) -> Result<f64, DamageError> {
        let number = f64::from_le_bytes(self.take()?);
        if number.is_finite() {
            Ok(number)
        } else {
            Err(DamageError::Numbers)
        }
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], DamageError> {
        let mut to = [0.0; N];
        for number in &mut to {
            *number = self.number()?;
        }
        Ok(to)
    }

    fn strains(&mut self, count: usize) -> Result<Vec<i16>, DamageError> {
        let mut bits = Vec::new();
        for _ in 0..count.div_ceil(8) {
            let [eight] = self.take::<1>()?;
            bits.extend((0..8).map(|bit| eight >> bit & 1 == 1));
        }
        let mut strains = Vec::with_capacity(count);
        for yielded in bits.into_iter().take(count) {
            let strain = match yielded {
                true => i16::from_le_bytes(self.take()?),
                false => 0,
            };
            if yielded && strain == 0 {
                return Err(DamageError::Numbers);
            }
            strains.push(strain);
        }
        Ok(strains)
    }
}

/// Stored as bytes, or as text in base64 where the format is text.
impl Serialize for Damage {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match to.is_human_readable() {
            true => to.serialize_str(&self.text()),
            false => to.serialize_bytes(&self.to_bytes()),
        }
    }
}

impl<'de> Deserialize<'de> for Damage {
    fn deserialize<S: Deserializer<'de>>(from: S) -> Result<Self, S::Error> {
        let bytes = if from.is_human_readable() {
            let text = String::deserialize(from)?;
            (TEXT.decode(text)).map_err(|_| serde::de::Error::custom(DamageError::Text))?
        } else {
            from.deserialize_byte_buf(Bytes)?
        };
        Self::from_bytes(&bytes).map_err(serde::de::Error::custom)
    }
}

/// Bytes, or numbers where a format has no bytes.
struct Bytes;

impl<'de> Visitor<'de> for Bytes {
    type Value = Vec<u8>;

    fn expecting(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        to.write_str("the bytes of the damage of a beam")
    }

    fn visit_bytes<E: serde::de::Error>(self, bytes: &[u8]) -> Result<Vec<u8>, E> {
        Ok(bytes.to_vec())
    }

    fn visit_byte_buf<E: serde::de::Error>(self, bytes: Vec<u8>) -> Result<Vec<u8>, E> {
        Ok(bytes)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> Result<Vec<u8>, A::Error> {
        let mut bytes = Vec::new();
        while let Some(byte) = from.next_element()? {
            bytes.push(byte);
        }
        Ok(bytes)
    }
}
