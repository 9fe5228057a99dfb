//! How the column moves during a hit, for those who draw it.

use super::beam::State;
use super::mesh::nearest;

/// Most points of a course over time: more than a figure has pixels.
const MAX_POINTS: usize = 2048;

/// How the column has moved during a hit: displacements along the hit and at right angles to it \[m\], from where the undamaged column
/// stands under its load.
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
    pub peak: Vec<[f64; 2]>,
    /// The nodes at rest after the hit; `None` after a collapse.
    pub remains: Option<Vec<[f64; 2]>>,
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
        remains.get(nearest(&self.heights, height)).copied()
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
    /// When the column has come to rest.
    fn rest(&mut self, moved: &[[f64; 3]]);
}

/// Without an observer.
impl Watch for () {
    fn begin(&mut self, _: &[[f64; 3]], _: &[[f64; 3]], _: usize) {}
    fn step<const D: usize, const R: usize>(&mut self, _: f64, _: &State<D, R>, _: bool) {}
    fn rest(&mut self, _: &[[f64; 3]]) {}
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
        }
    }

    /// What it has seen of a hit in this direction \[rad\] on nodes at these heights \[m\].
    pub fn finish(self, direction: f64, heights: &[f64]) -> Movement {
        let (c, s) = (libm::cos(direction), libm::sin(direction));
        let way = |from: &[f64; 3], to: &[f64; 3]| {
            let (y, z) = (to[1] - from[1], to[2] - from[2]);
            [c * y + s * z, c * z - s * y]
        };
        let nodes = |moved: &[[f64; 3]]| {
            let pairs = self.undamaged.iter().zip(moved);
            pairs.map(|(from, to)| way(from, to)).collect()
        };
        let point = |(time, at): &(f64, [f64; 3])| {
            let [along, across] = way(&self.undamaged[self.node], at);
            [*time, along, across]
        };
        Movement {
            direction,
            points: self.points.iter().map(point).collect(),
            heights: heights.to_vec(),
            peak: nodes(&self.peak),
            remains: self.rest.as_deref().map(nodes),
        }
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

    fn rest(&mut self, moved: &[[f64; 3]]) {
        self.rest = Some(moved.to_vec());
    }
}
