//! The vehicle: its face, stiff contact springs between the face and the nodes behind it, and what moves the face.
//!
//! All act along the direction of travel, without friction. The face is the rigid mass itself or the massless front of a
//! chain of masses and springs that crush. Where the face is follows from its own equilibrium inside every evaluation.

use column_mechanics::{Chain, ChainPart, ChainPoint, Impact, Vehicle};

use super::column::BeamColumn;
use super::mesh::nearest;

/// Stiffness of the contact between column and vehicle \[N/m\]: a modelling choice; a tenth of it moves the peak by 1.6 %.
pub(crate) const CONTACT_STIFFNESS: f64 = 2e9;

/// Stiffness that holds a face on which nothing acts \[N/m\].
const LOOSE: f64 = 1.0;

const MAX_ITERATIONS: usize = 80;

/// A node behind the face.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touch {
    pub node: usize,
    pub stiffness: f64,
    /// How far the face has gone into the column here \[m\].
    pub depth: f64,
    /// Mean force of the trial step \[N\] and its derivative by the movement of the face.
    pub force: f64,
    pub slope: f64,
    /// Movement of the node along the direction in the trial step \[m\].
    pub moved: f64,
}

/// What is behind the face.
#[derive(Debug, Clone, Copy)]
#[expect(
    clippy::large_enum_variant,
    reason = "it lives on the stack of one response, where nothing may be allocated"
)]
enum Behind {
    Rigid { mass: f64, velocity: f64 },
    Chain { vehicle: Vehicle, chain: Chain },
}

/// A vehicle on its way.
#[derive(Debug, Clone)]
pub(crate) struct Striker {
    pub touches: Vec<Touch>,
    behind: Behind,
    acceleration: f64,
    /// Movement of the face in the trial step \[m\] and the stiffness of its equilibrium.
    advance: f64,
    pub stiffness: f64,
    point: ChainPoint,
    /// Work that the transverse force has done, and energy dissipated by crushing \[J\].
    pub pushed: f64,
    pub crushed: f64,
}

/// Mean force of a spring that acts in compression only, over a step from one depth to another, and its derivative.
fn mean_force(stiffness: f64, from: f64, to: f64) -> (f64, f64) {
    if from >= 0.0 && to >= 0.0 {
        return (0.5 * stiffness * (from + to), 0.5 * stiffness);
    }
    if from <= 0.0 && to <= 0.0 {
        return (0.0, 0.0);
    }
    let (work, end) = if to > 0.0 {
        (0.5 * stiffness * to * to, stiffness * to)
    } else {
        (-0.5 * stiffness * from * from, 0.0)
    };
    let force = work / (to - from);
    (force, (end - force) / (to - from))
}

impl Striker {
    /// The vehicle of an impact in front of these nodes, each with its share of the contact.
    pub fn new(impact: &Impact, nodes: &[(usize, f64)]) -> Self {
        let open = match impact.vehicle {
            None => impact.gap,
            Some(_) => 0.0,
        };
        let behind = match impact.vehicle {
            None => Behind::Rigid {
                mass: impact.mass,
                velocity: impact.velocity,
            },
            Some(vehicle) => Behind::Chain {
                vehicle,
                chain: Chain::new(&vehicle, impact.velocity, impact.gap),
            },
        };
        let touches = nodes.iter().map(|&(node, share)| Touch {
            node,
            stiffness: share * CONTACT_STIFFNESS,
            depth: -open,
            force: 0.0,
            slope: 0.0,
            moved: 0.0,
        });
        Self {
            touches: touches.collect(),
            behind,
            acceleration: impact.transverse_force / impact.mass,
            advance: 0.0,
            stiffness: 1.0,
            point: ChainPoint::default(),
            pushed: 0.0,
            crushed: 0.0,
        }
    }

    /// Finds the movement of the face for the movements of the nodes.
    pub fn solve(&mut self, secs: f64) {
        let Self {
            touches,
            behind,
            acceleration,
            advance,
            stiffness,
            point,
            ..
        } = self;
        let behind = &*behind;
        let part = match behind {
            Behind::Chain { vehicle, chain } => {
                Some(ChainPart::new(vehicle, chain, *acceleration, secs))
            }
            Behind::Rigid { .. } => None,
        };
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for _ in 0..MAX_ITERATIONS {
            let (mut force, mut slope, mut size) = (0.0, 0.0, 0.0);
            for touch in touches.iter_mut() {
                let to = touch.depth + (*advance - touch.moved);
                (touch.force, touch.slope) = mean_force(touch.stiffness, touch.depth, to);
                force += touch.force;
                slope += touch.slope;
            }
            size += force;
            match (&part, behind) {
                (Some(part), _) => {
                    part.solve(*advance, point);
                    force -= point.force();
                    size += point.force();
                    slope += point.stiffness();
                }
                (None, Behind::Rigid { mass, velocity }) => {
                    let inertia = 2.0 * mass / (secs * secs);
                    let free = secs * (velocity + 0.5 * *acceleration * secs);
                    force += inertia * (*advance - free);
                    size += inertia * (*advance - free).abs();
                    slope += inertia;
                }
                (None, Behind::Chain { .. }) => {}
            }
            *stiffness = slope + LOOSE;
            if force.is_nan() || force.abs() <= 4e-15 * size + 1e-9 {
                break;
            }
            if force > 0.0 {
                high = *advance;
            } else {
                low = *advance;
            }
            let mut next = *advance - force / *stiffness;
            if !(next > low && next < high) {
                next = 0.5 * (low + high);
            }
            if next == *advance || !next.is_finite() {
                break;
            }
            *advance = next;
        }
    }

    /// Before a step: a first guess of the movement of the face.
    pub fn begin(&mut self, secs: f64) {
        self.point = ChainPoint::default();
        self.advance = match self.behind {
            Behind::Rigid { velocity, .. } => secs * velocity,
            Behind::Chain { .. } => 0.0,
        };
    }

    /// Takes the trial step over.
    pub fn commit(&mut self, secs: f64) {
        for touch in &mut self.touches {
            touch.depth += self.advance - touch.moved;
        }
        let before = self.velocity();
        match &mut self.behind {
            Behind::Rigid { velocity, .. } => {
                *velocity = 2.0 / secs * self.advance - *velocity;
            }
            Behind::Chain { vehicle, chain } => {
                let crushed = chain.follow(vehicle, self.acceleration, secs, &self.point);
                self.crushed += crushed.dissipated.iter().sum::<f64>();
            }
        }
        let way = 0.5 * secs * (before + self.velocity());
        self.pushed += self.acceleration * self.mass() * way;
    }

    pub fn mass(&self) -> f64 {
        match &self.behind {
            Behind::Rigid { mass, .. } => *mass,
            Behind::Chain { vehicle, .. } => vehicle.total_mass(),
        }
    }

    /// Velocity of the centre of mass \[m/s\].
    pub fn velocity(&self) -> f64 {
        match &self.behind {
            Behind::Rigid { velocity, .. } => *velocity,
            Behind::Chain { vehicle, chain } => chain.mean_velocity(vehicle),
        }
    }

    /// Kinetic energy, elastic energy of springs and contact \[J\].
    pub fn energy(&self) -> f64 {
        let contact: f64 = self
            .touches
            .iter()
            .map(|touch| 0.5 * touch.stiffness * touch.depth.max(0.0) * touch.depth.max(0.0))
            .sum();
        contact
            + match &self.behind {
                Behind::Rigid { mass, velocity } => 0.5 * mass * velocity * velocity,
                Behind::Chain { vehicle, chain } => {
                    chain.kinetic_energy(vehicle) + chain.elastic_energy(vehicle)
                }
            }
    }

    /// Mean contact force of the step \[N\].
    pub fn force(&self) -> f64 {
        self.touches.iter().map(|touch| touch.force).sum()
    }

    pub fn is_deformable(&self) -> bool {
        matches!(self.behind, Behind::Chain { .. })
    }

    /// Whether it touches nothing and moves away.
    pub fn is_gone(&self) -> bool {
        let loose = self.touches.iter().all(|touch| touch.depth <= 0.0);
        match &self.behind {
            Behind::Rigid { velocity, .. } => loose && *velocity < 0.0,
            Behind::Chain { vehicle, chain } => {
                chain.contact_force(vehicle) == 0.0 && chain.mean_velocity(vehicle) < 0.0
            }
        }
    }
}

/// The nodes behind the bumper, each with the share of its part of the height.
pub(crate) fn touches(column: &BeamColumn, heights: &[f64]) -> Vec<(usize, f64)> {
    let half = 0.5 * column.bumper_height;
    let low = nearest(heights, column.length_below - half);
    let high = nearest(heights, column.length_below + half);
    let share = |k: usize| {
        if low == high {
            return (k, 1.0);
        }
        let (before, after) = (k.max(low + 1) - 1, k.min(high - 1) + 1);
        let part = 0.5 * (heights[after] - heights[before]);
        (k, part / column.bumper_height)
    };
    (low..=high).map(share).collect()
}
