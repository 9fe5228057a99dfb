//! Free vibrations of small amplitude in the plane of the web, of the straight column under its load.
//!
//! The column consists of Timoshenko elements with the exact stiffness between their nodes, the geometric stiffness of the load,
//! and consistent masses. Frequencies are found by the number of negative pivots of `K - w² M`, which is the number of modes below
//! `w`, and halving; the shape follows by inverse iteration.

use column_mechanics::Support;

use super::column::{BeamColumn, BeamError};
use super::tridiagonal::{Block, Tridiagonal};

/// Elements along the column: the second frequency is exact to a ten-thousandth.
const ELEMENTS: usize = 48;

/// Halvings of the interval that contains a frequency, and doublings until one does.
const HALVINGS: usize = 40;
const DOUBLINGS: usize = 80;

/// Steps of the inverse iteration.
const ITERATIONS: usize = 4;

/// A mode of vibration. The node that moves most has the displacement 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// Frequency \[Hz\].
    pub frequency: f64,
    element: f64,
    /// Share of the shear in the flexibility of an element: `12 E I / (G A l²)`.
    shear: f64,
    /// Displacement, and rotation of the section \[1/m\], of each node.
    nodes: Vec<[f64; 2]>,
}

/// The lowest modes of the column, by rising frequency. Its bow is left out: of the usual size it changes a frequency by less than a
/// thousandth. The spring at the top acts along the axis and has no effect.
///
/// # Errors
/// Numbers out of range, or a load under which the straight column buckles.
pub fn modes(column: &BeamColumn, count: usize) -> Result<Vec<Mode>, BeamError> {
    column.check()?;
    let whole = Vibrating::new(column);
    if whole.modes_below(0.0) > 0 {
        return Err(BeamError::Unstable {
            load: column.top_load,
        });
    }
    let mut found = Vec::with_capacity(count);
    for index in 0..count.min(ELEMENTS / 4) {
        let (mut low, mut high) = (
            0.0,
            whole.bending / whole.mass / libm::pow(column.length(), 4.0),
        );
        for _ in 0..DOUBLINGS {
            if whole.modes_below(high) > index {
                break;
            }
            low = high;
            high *= 2.0;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if whole.modes_below(middle) > index {
                high = middle;
            } else {
                low = middle;
            }
        }
        let square = 0.5 * (low + high);
        found.push(Mode {
            frequency: square.sqrt() / (2.0 * std::f64::consts::PI),
            element: whole.element,
            shear: whole.shear,
            nodes: whole.shape(square),
        });
    }
    Ok(found)
}

impl Mode {
    /// Transverse displacement at a height above the base \[m\], which is cut to the column.
    #[must_use]
    pub fn displacement(&self, height: f64) -> f64 {
        let (x, [one, two], [first, second], _) = self.at(height);
        let rest = 1.0 - x;
        one * rest + two * x + self.element * x * rest * (first * rest - second * x)
    }

    /// Rotation of the section at a height \[1/m\], positive where a displacement grows upwards.
    #[must_use]
    pub fn rotation(&self, height: f64) -> f64 {
        let (x, [one, two], [first, second], gamma) = self.at(height);
        let chord = (two - one) / self.element;
        let bent = first * (1.0 - 4.0 * x + 3.0 * x * x) + second * (3.0 * x * x - 2.0 * x);
        chord - gamma + bent
    }

    /// Curvature at a height \[1/m²\]: the derivative of the rotation, negative where the column bends as it does at the largest
    /// displacement.
    #[must_use]
    pub fn curvature(&self, height: f64) -> f64 {
        let (x, _, [first, second], _) = self.at(height);
        ((6.0 * x - 4.0) * first + (6.0 * x - 2.0) * second) / self.element
    }

    /// Place in the element at a height, displacements of its ends, what bends them against the chord, and its shear angle.
    fn at(&self, height: f64) -> (f64, [f64; 2], [f64; 2], f64) {
        let place = (height / self.element).max(0.0).min(ELEMENTS as f64);
        let index = (libm::floor(place) as usize).min(ELEMENTS - 1);
        let ([one, turn_one], [two, turn_two]) = (self.nodes[index], self.nodes[index + 1]);
        let chord = (two - one) / self.element;
        let turns = [turn_one - chord, turn_two - chord];
        let gamma = -0.5 * self.shear / (1.0 + self.shear) * (turns[0] + turns[1]);
        let bent = turns.map(|it| it + gamma);
        (place - index as f64, [one, two], bent, gamma)
    }
}

/// The column as what vibrates.
struct Vibrating {
    /// `E I` \[N m²\] and mass per length \[kg/m\].
    bending: f64,
    mass: f64,
    /// Rotary inertia per length \[kg m\].
    rotary: f64,
    load: f64,
    element: f64,
    shear: f64,
    supports: [Support; 2],
    top_mass: f64,
}

impl Vibrating {
    fn new(column: &BeamColumn) -> Self {
        let section = column.section(true);
        let [_, bending, _, web] = *section.elastic();
        let density = column.steel.density;
        let element = column.length() / ELEMENTS as f64;
        let sheared = web + column.steel.shear_modulus() * section.shear_only_area;
        let shear = match web > 0.0 {
            true => 12.0 * bending / (sheared * element * element),
            false => 0.0,
        };
        Self {
            bending,
            mass: density * section.area,
            rotary: density * section.second_moment[0],
            load: column.top_load,
            element,
            shear,
            supports: [column.base, column.top],
            top_mass: column.top_mass,
        }
    }

    /// How many modes have a lower square of their circular frequency than this \[1/s²\].
    fn modes_below(&self, square: f64) -> usize {
        self.matrix(square).factor()
    }

    /// `K - w² M`.
    fn matrix(&self, square: f64) -> Tridiagonal<2> {
        let mut matrix = Tridiagonal::new(ELEMENTS + 1);
        let [near, cross, far] = self.element_blocks(square);
        for index in 0..ELEMENTS {
            for i in 0..2 {
                for j in 0..2 {
                    matrix.diagonal[index][i][j] += near[i][j];
                    matrix.diagonal[index + 1][i][j] += far[i][j];
                    matrix.coupling[index][i][j] += cross[i][j];
                }
            }
        }
        matrix.diagonal[ELEMENTS][0][0] -= square * self.top_mass;
        for (node, support) in [0, ELEMENTS].into_iter().zip(self.supports) {
            if let Support::SemiRigid { stiffness } = support {
                matrix.diagonal[node][1][1] += stiffness;
            }
            if support != Support::Free {
                matrix.hold(node, 0);
            }
            if support == Support::BuiltIn {
                matrix.hold(node, 1);
            }
        }
        matrix
    }

    /// The part of an element: for its lower end, between its ends, for its upper end.
    fn element_blocks(&self, square: f64) -> [Block<2>; 3] {
        let (l, phi) = (self.element, self.shear);
        let stiff = self.bending / (l * l * l * (1.0 + phi));
        let load = self.load / (30.0 * l);
        let mass = square * self.mass * l / 420.0;
        let rotary = 0.5 * square * self.rotary * l;
        let direct = 12.0 * stiff - 36.0 * load;
        let lever = (6.0 * stiff - 3.0 * load) * l;
        let own = ((4.0 + phi) * stiff - 4.0 * load) * l * l - 4.0 * mass * l * l - rotary;
        let other = ((2.0 - phi) * stiff + load) * l * l + 3.0 * mass * l * l;
        let (near, far) = (lever - 22.0 * mass * l, -lever + 22.0 * mass * l);
        let straight = direct - 156.0 * mass;
        [
            [[straight, near], [near, own]],
            [
                [-direct - 54.0 * mass, lever + 13.0 * mass * l],
                [-lever - 13.0 * mass * l, other],
            ],
            [[straight, far], [far, own]],
        ]
    }

    /// The shape at the square of a circular frequency.
    fn shape(&self, square: f64) -> Vec<[f64; 2]> {
        let mut factored = self.matrix(square);
        factored.factor();
        // No mode has a node wherever this start has one.
        let mut shape: Vec<[f64; 2]> = (0..=ELEMENTS)
            .map(|node| [1.0 + 0.7 * node as f64 / ELEMENTS as f64, 0.0])
            .collect();
        for _ in 0..ITERATIONS {
            for (node, support) in [0, ELEMENTS].into_iter().zip(self.supports) {
                if support != Support::Free {
                    shape[node][0] = 0.0;
                }
                if support == Support::BuiltIn {
                    shape[node][1] = 0.0;
                }
            }
            factored.solve([&mut shape]);
            let most = shape.iter().fold(0.0_f64, |most, node| {
                if node[0].abs() > most.abs() {
                    node[0]
                } else {
                    most
                }
            });
            for value in shape.iter_mut().flatten() {
                *value /= most;
            }
        }
        shape
    }
}
