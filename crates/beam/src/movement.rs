//! How the column moves during a hit, for those who draw it.

use super::beam::{Beam, State};
use super::mesh::nearest;

/// Most points of a course over time: more than a figure has pixels.
const MAX_POINTS: usize = 2048;

/// Most fibres that are kept, those with the largest plastic strains.
const MAX_FIBRES: usize = 4096;

/// Plastic strain up to which a fibre has not yielded: the round-off of its residual stress.
const LEAST_STRAIN: f64 = 1e-7;

/// How the column has moved during a hit: displacements along the hit, at right angles to it, and upwards \[m\], from where the
/// undamaged column stands under its load.
#[derive(Debug, Clone, PartialEq)]
pub struct Movement {
    /// Direction of the hit \[rad\].
    pub direction: f64,
    /// The impact point over time: seconds since the touch \[s\], along, at right angles. To the end of the response, which is soon
    /// after the peak; of a long one not every step.
    pub points: Vec<[f64; 3]>,
    /// Heights of the nodes above the base \[m\].
    pub heights: Vec<f64>,
    /// The nodes when the impact point is furthest along the hit.
    pub peak: Vec<[f64; 3]>,
    /// The nodes at rest after the hit; `None` after a collapse.
    pub remains: Option<Vec<[f64; 3]>>,
    /// The fibres that have yielded, at rest after the hit; after a collapse as its computation has ended.
    pub yielded: Vec<YieldedFibre>,
}

/// A fibre that has yielded, at an integration point of its element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct YieldedFibre {
    /// Its place in the straight column, from the middle of the base: along the hit, at right angles to it, and upwards \[m\]. In
    /// the plane of the web both halves of a flange are one fibre.
    pub place: [f64; 3],
    /// How it has moved from there, as the nodes \[m\].
    pub moved: [f64; 3],
    /// Magnitude of its plastic strain, after von Mises where it bears shear.
    pub plastic_strain: f64,
}

impl Movement {
    /// Time of the peak displacement of the impact point along the hit since the touch \[s\], and the displacement \[m\].
    #[must_use]
    pub fn largest(&self) -> [f64; 2] {
        let points = self.points.iter().map(|point| [point[0], point[1]]);
        let largest = points.reduce(|one, other| if other[1] > one[1] { other } else { one });
        largest.unwrap_or_default()
    }

    /// What remains of the displacement of the impact point, which is at this height \[m\], along the hit and at right angles to
    /// it \[m\]; `None` after a collapse.
    #[must_use]
    pub fn remains_at(&self, height: f64) -> Option<[f64; 2]> {
        let remains = self.remains.as_ref()?;
        let [along, across, _] = *remains.get(nearest(&self.heights, height))?;
        Some([along, across])
    }
}

/// Follows a response, which it does not change.
pub(crate) trait Watch {
    /// Before the first step: the undamaged column, the column now, and the node of the impact point.
    fn begin(&mut self, undamaged: &[[f64; 3]], now: &[[f64; 3]], node: usize);
    /// After a step, at the time since the touch \[s\]; `is_peak` where the impact point is further along the hit than before.
    fn step<const D: usize, const R: usize>(
        &mut self,
        time: f64,
        state: &State<D, R>,
        is_peak: bool,
    );
    /// At the end: the column at rest, or, where it does not stand, as its response has ended.
    fn end<const D: usize, const R: usize, const Q: usize>(
        &mut self,
        beam: &Beam<D, R, Q>,
        state: &State<D, R>,
        stands: bool,
    );
}

/// Without an observer.
impl Watch for () {
    fn begin(&mut self, _: &[[f64; 3]], _: &[[f64; 3]], _: usize) {}
    fn step<const D: usize, const R: usize>(&mut self, _: f64, _: &State<D, R>, _: bool) {}
    fn end<const D: usize, const R: usize, const Q: usize>(
        &mut self,
        _: &Beam<D, R, Q>,
        _: &State<D, R>,
        _: bool,
    ) {
    }
}

/// Shows an observer after each step whether the impact point is further along the hit than before.
pub(crate) struct Steps<F>(pub F);

impl<F: FnMut(bool)> Watch for Steps<F> {
    fn begin(&mut self, _: &[[f64; 3]], _: &[[f64; 3]], _: usize) {}
    fn step<const D: usize, const R: usize>(&mut self, _: f64, _: &State<D, R>, is_peak: bool) {
        (self.0)(is_peak);
    }
    fn end<const D: usize, const R: usize, const Q: usize>(
        &mut self,
        _: &Beam<D, R, Q>,
        _: &State<D, R>,
        _: bool,
    ) {
    }
}

/// Keeps what a drawing needs in memory that it takes before the first step.
pub(crate) struct Recorder {
    points: Vec<(f64, [f64; 3])>,
    /// How many steps there are between two points, and since the last one.
    every: usize,
    since: usize,
    node: usize,
    undamaged: Vec<[f64; 3]>,
    peak: Vec<[f64; 3]>,
    rest: Option<Vec<[f64; 3]>>,
    /// Upwards, along y and along z.
    yielded: Vec<YieldedFibre>,
}

impl Recorder {
    pub fn new() -> Self {
        Self {
            points: Vec::with_capacity(MAX_POINTS),
            every: 1,
            since: 0,
            node: 0,
            undamaged: Vec::new(),
            peak: Vec::new(),
            rest: None,
            yielded: Vec::new(),
        }
    }

    /// What it has seen of a hit in this direction \[rad\] on nodes at these heights \[m\].
    pub fn finish(self, direction: f64, heights: &[f64]) -> Movement {
        let (c, s) = (libm::cos(direction), libm::sin(direction));
        let turned = |[x, y, z]: [f64; 3]| [c * y + s * z, c * z - s * y, x];
        let way = |from: &[f64; 3], to: &[f64; 3]| turned([0, 1, 2].map(|k| to[k] - from[k]));
        let nodes = |moved: &[[f64; 3]]| {
            let pairs = self.undamaged.iter().zip(moved);
            pairs.map(|(from, to)| way(from, to)).collect()
        };
        let point = |(time, at): &(f64, [f64; 3])| {
            let [along, across, _] = way(&self.undamaged[self.node], at);
            [*time, along, across]
        };
        Movement {
            direction,
            points: self.points.iter().map(point).collect(),
            heights: heights.to_vec(),
            peak: nodes(&self.peak),
            remains: self.rest.as_deref().map(nodes),
            yielded: self
                .yielded
                .iter()
                .map(|fibre| YieldedFibre {
                    place: turned(fibre.place),
                    moved: turned(fibre.moved),
                    ..*fibre
                })
                .collect(),
        }
    }

    /// The yielded fibres of a state, of which those remain that have the largest plastic strains.
    fn fibres<const D: usize, const R: usize, const Q: usize>(
        &self,
        beam: &Beam<D, R, Q>,
        state: &State<D, R>,
    ) -> Vec<YieldedFibre> {
        let mut found = Vec::new();
        for (index, yielded) in state.yielded.iter().enumerate() {
            if !yielded {
                continue;
            }
            let (element, share) = beam.point(index);
            let between = |nodes: [[f64; 3]; 2]| {
                [0, 1, 2].map(|k| (1.0 - share) * nodes[0][k] + share * nodes[1][k])
            };
            let both = [element, element + 1];
            let axis = between(
                both.map(|node| [0, 1, 2].map(|k| state.moved[node][k] - self.undamaged[node][k])),
            );
            let height = between(both.map(|node| [beam.places[node][0], 0.0, 0.0]))[0];
            let [along_y, along_z] =
                [1, 2].map(|k| between(both.map(|node| state.triads[node][k])));
            for ([y, z], plastic_strain) in beam.section.yielded(&state.points[index]) {
                if plastic_strain > LEAST_STRAIN {
                    let place = [height, y, z];
                    let turned = [0, 1, 2].map(|k| y * along_y[k] + z * along_z[k]);
                    found.push(YieldedFibre {
                        place,
                        moved: [
                            axis[0] + turned[0],
                            axis[1] + turned[1] - y,
                            axis[2] + turned[2] - z,
                        ],
                        plastic_strain,
                    });
                }
            }
        }
        if found.len() > MAX_FIBRES {
            found.sort_by(|one, other| other.plastic_strain.total_cmp(&one.plastic_strain));
            found.truncate(MAX_FIBRES);
        }
        found
    }
}

impl Watch for Recorder {
    fn begin(&mut self, undamaged: &[[f64; 3]], now: &[[f64; 3]], node: usize) {
        self.node = node;
        self.undamaged = undamaged.to_vec();
        self.peak = now.to_vec();
        self.points.push((0.0, now[node]));
    }

    fn step<const D: usize, const R: usize>(
        &mut self,
        time: f64,
        state: &State<D, R>,
        is_peak: bool,
    ) {
        if is_peak {
            self.peak.copy_from_slice(&state.moved);
        }
        self.since += 1;
        if self.since < self.every {
            return;
        }
        self.since = 0;
        if self.points.len() == MAX_POINTS {
            // Every second point stays.
            for kept in 0..MAX_POINTS / 2 {
                self.points[kept] = self.points[2 * kept];
            }
            self.points.truncate(MAX_POINTS / 2);
            self.every *= 2;
        }
        self.points.push((time, state.moved[self.node]));
    }

    fn end<const D: usize, const R: usize, const Q: usize>(
        &mut self,
        beam: &Beam<D, R, Q>,
        state: &State<D, R>,
        stands: bool,
    ) {
        self.rest = stands.then(|| state.moved.clone());
        self.yielded = self.fibres(beam, state);
    }
}
