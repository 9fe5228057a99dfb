//! The cross-section as fibres: their strains, stresses and plastic strains.
//!
//! Axes: x along the column, y in the plane of the web (bending about the strong axis moves the column along y), z along the
//! flanges. The strain of a fibre is `e - y kz + z ky`; fibres of the web also shear by `g`.

use column_mechanics::RolledSection;
use serde::{Deserialize, Serialize};

/// Steel of the column: bilinear with kinematic hardening, so that a fibre that has yielded one way yields earlier the other
/// way (Bauschinger's effect).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Steel {
    /// `E`: Young's modulus \[Pa\].
    pub young_modulus: f64,
    /// `nu`: Poisson's ratio.
    pub poisson_ratio: f64,
    /// `f_y`: yield strength \[Pa\].
    pub yield_strength: f64,
    /// `b`: slope after yield over Young's modulus, above 0: without hardening the length that yields depends on the mesh.
    pub hardening_ratio: f64,
    /// Density \[kg/m³\].
    pub density: f64,
}

impl Steel {
    /// `G` \[Pa\].
    #[must_use]
    pub fn shear_modulus(&self) -> f64 {
        0.5 * self.young_modulus / (1.0 + self.poisson_ratio)
    }

    /// `H`: slope of the stress over the plastic strain \[Pa\].
    pub(crate) fn plastic_modulus(&self) -> f64 {
        self.hardening_ratio * self.young_modulus / (1.0 - self.hardening_ratio)
    }
}

/// Shape of the cross-section.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// Rolled I or H profile with root fillets.
    Rolled(RolledSection),
    /// Rectangular hollow section, corners square.
    Rectangular {
        /// Outer height along y \[m\].
        depth: f64,
        /// Outer width along z \[m\].
        width: f64,
        /// Thickness of the walls \[m\].
        thickness: f64,
    },
    /// Circular hollow section.
    Circular {
        /// Outer diameter \[m\].
        diameter: f64,
        /// Thickness of the wall \[m\].
        thickness: f64,
    },
}

/// Fibres whose stress is normal only; the arrays are padded with fibres without area to a multiple of [`LANES`].
#[derive(Debug, Clone, Default)]
pub(crate) struct Fibres {
    pub y: Vec<f64>,
    pub z: Vec<f64>,
    pub area: Vec<f64>,
    /// Strain that the residual stress of rolling stands for.
    pub initial: Vec<f64>,
}

/// Sums are formed in so many lanes, which fixes their order whatever the processor can do at once.
const LANES: usize = 4;

/// Iterations of the return of a fibre under normal and shear stress; five are usual.
const MAX_RETURNS: usize = 60;

/// A cross-section divided into fibres.
#[derive(Debug, Clone)]
pub(crate) struct Section {
    pub steel: Steel,
    pub plain: Fibres,
    /// Fibres of the web, which bear shear along y, too; none where shear is left out.
    pub web: Fibres,
    /// `sum A (1, -y, z)` and their products: the elastic stiffness without `E`, in the order of [`PointForces`].
    elastic: [f64; 4],
    /// The same of the fibres without shear.
    plain_elastic: [f64; 3],
    /// `G A` of the web fibres \[N\].
    pub web_rigidity: f64,
    /// Largest distances from the axes \[m\].
    reach: [f64; 2],
    /// Largest residual stress \[Pa\].
    largest_initial: f64,
    pub area: f64,
    /// Second moments of area about the strong and the weak axis \[m⁴\].
    pub second_moment: [f64; 2],
    /// Area of web between flange and its middle plane, which bears shear alone \[m²\].
    pub shear_only_area: f64,
    /// `b t_f^3 / 12` of both flanges \[m⁴\], `b t_f^2 / 4` of one \[m³\]: the frame of the flanges.
    pub flanges: [f64; 2],
    /// `I_t` \[m⁴\], `I_w` \[m⁶\].
    pub torsion: [f64; 2],
}

/// `N`, `M_z` (strong), `M_y` (weak), `V`.
pub(crate) type PointForces = [f64; 4];

/// The stiffness of a section.
pub(crate) type PointStiffness = [[f64; 4]; 4];

/// What the fibres at one section have been through.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct PointState {
    /// `(E + H) e_p - E e_r` of each fibre without shear \[Pa\]: the middle of its elastic range, a stress.
    pub plain: Vec<f64>,
    /// Plastic strains of the fibres of the web, normal and shear.
    pub web: Vec<[f64; 2]>,
    /// `N`, `M_z`, `M_y` that the plastic strains of the fibres without shear take from those of an elastic section.
    pub locked: [f64; 3],
}

impl Fibres {
    fn push(&mut self, y: f64, z: f64, area: f64, initial: f64) {
        self.y.push(y);
        self.z.push(z);
        self.area.push(area);
        self.initial.push(initial);
    }

    fn pad(&mut self) {
        while !self.y.len().is_multiple_of(LANES) {
            self.push(0.0, 0.0, 0.0, 0.0);
        }
    }

    pub fn len(&self) -> usize {
        self.y.len()
    }
}

/// How finely a section is divided.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Division {
    /// Layers of the web.
    pub web: usize,
    /// Layers of a flange.
    pub layers: usize,
    /// Parts across a flange; 1 for bending about the strong axis alone.
    pub across: usize,
}

impl Section {
    /// The fibres of a shape.
    pub fn new(
        shape: &Shape,
        steel: Steel,
        division: Division,
        with_shear: bool,
        with_residual_stress: bool,
    ) -> Self {
        let mut section = Self {
            steel,
            plain: Fibres::default(),
            web: Fibres::default(),
            elastic: [0.0; 4],
            plain_elastic: [0.0; 3],
            web_rigidity: 0.0,
            reach: [0.0; 2],
            largest_initial: 0.0,
            area: 0.0,
            second_moment: [0.0; 2],
            shear_only_area: 0.0,
            flanges: [0.0; 2],
            torsion: [0.0; 2],
        };
        match shape {
            Shape::Rolled(rolled) => {
                section.divide_rolled(rolled, division, with_shear, with_residual_stress);
            }
            &Shape::Rectangular {
                depth,
                width,
                thickness,
            } => section.divide_rectangular([depth, width, thickness], division, with_shear),
            &Shape::Circular {
                diameter,
                thickness,
            } => section.divide_circular(diameter, thickness, division),
        }
        section.plain.pad();
        section.sum_up();
        section
    }

    fn divide_rolled(
        &mut self,
        rolled: &RolledSection,
        division: Division,
        with_shear: bool,
        with_residual_stress: bool,
    ) {
        let RolledSection {
            depth: h,
            width: b,
            web_thickness: tw,
            flange_thickness: tf,
            root_radius: r,
        } = *rolled;
        // ECCS: linear over flanges and web, compression at the tips and in the middle of the web.
        let peak = match (with_residual_stress, h / b <= 1.2) {
            (false, _) => 0.0,
            (true, true) => 0.5 * 235e6,
            (true, false) => 0.3 * 235e6,
        } / self.steel.young_modulus;
        let web_depth = h - 2.0 * tf;
        for side in [-1.0, 1.0] {
            for layer in 0..division.layers {
                let share = (layer as f64 + 0.5) / division.layers as f64;
                let y = side * (0.5 * h - tf * share);
                for part in 0..division.across {
                    let z = b * ((part as f64 + 0.5) / division.across as f64 - 0.5);
                    let residual = match division.across {
                        1 => 0.0,
                        _ => peak * (1.0 - 4.0 * z.abs() / b),
                    };
                    let area = b * tf / (division.layers * division.across) as f64;
                    self.plain.push(y, z, area, residual);
                }
            }
            if r > 0.0 {
                // Each fillet is a square less a quarter disc, with its centroid 0.2234 r from the corner.
                let area = (1.0 - 0.25 * std::f64::consts::PI) * r * r;
                let y = side * (0.5 * web_depth - 0.223_416 * r);
                if division.across == 1 {
                    self.plain.push(y, 0.0, 2.0 * area, 0.0);
                } else {
                    let z = 0.5 * tw + 0.223_416 * r;
                    self.plain.push(y, -z, area, peak);
                    self.plain.push(y, z, area, peak);
                }
            }
        }
        for layer in 0..division.web {
            let y = web_depth * ((layer as f64 + 0.5) / division.web as f64 - 0.5);
            let residual = peak * (4.0 * y.abs() / web_depth - 1.0);
            let area = web_depth * tw / division.web as f64;
            let fibres = match with_shear {
                true => &mut self.web,
                false => &mut self.plain,
            };
            if division.across == 1 {
                fibres.push(y, 0.0, area, residual);
            } else {
                fibres.push(y, -0.25 * tw, 0.5 * area, residual);
                fibres.push(y, 0.25 * tw, 0.5 * area, residual);
            }
        }
        if with_shear {
            self.shear_only_area = tw * tf;
            self.flanges = [b * tf * tf * tf / 6.0, 0.25 * b * tf * tf];
        }
        // El Darwish and Johnston's formula for profiles with root fillets [M].
        let cube = |x: f64| x * x * x;
        let alpha = -0.042 + 0.2204 * tw / tf + 0.1355 * r / tf
            - 0.0865 * r * tw / (tf * tf)
            - 0.0725 * tw * tw / (tf * tf);
        let disc = ((tf + r) * (tf + r) + tw * (r + 0.25 * tw)) / (2.0 * r + tf);
        self.torsion = [
            2.0 / 3.0 * b * cube(tf) + web_depth * cube(tw) / 3.0 + 2.0 * alpha * disc * cube(disc)
                - 0.420 * tf * cube(tf),
            tf * cube(b) * (h - tf) * (h - tf) / 24.0,
        ];
    }

    fn divide_rectangular(
        &mut self,
        [depth, width, t]: [f64; 3],
        division: Division,
        with_shear: bool,
    ) {
        let across = division.across.max(2);
        let inner = depth - 2.0 * t;
        for side in [-1.0, 1.0] {
            for layer in 0..division.layers {
                let y = side * (0.5 * depth - t * (layer as f64 + 0.5) / division.layers as f64);
                for part in 0..across {
                    let z = width * ((part as f64 + 0.5) / across as f64 - 0.5);
                    let area = width * t / (division.layers * across) as f64;
                    self.plain.push(y, z, area, 0.0);
                }
            }
            for layer in 0..division.web {
                let y = inner * ((layer as f64 + 0.5) / division.web as f64 - 0.5);
                let area = inner * t / division.web as f64;
                let fibres = match with_shear {
                    true => &mut self.web,
                    false => &mut self.plain,
                };
                fibres.push(y, side * 0.5 * (width - t), area, 0.0);
            }
        }
        if with_shear {
            self.shear_only_area = 2.0 * t * t;
        }
        // Bredt.
        let (a, b) = (depth - t, width - t);
        self.torsion = [2.0 * a * a * b * b * t / (a + b), 0.0];
    }

    fn divide_circular(&mut self, diameter: f64, t: f64, division: Division) {
        let count = 4 * division.web;
        let radius = 0.5 * (diameter - t);
        let area = std::f64::consts::TAU * radius * t / count as f64;
        for k in 0..count {
            let angle = std::f64::consts::TAU * (k as f64 + 0.5) / count as f64;
            let (y, z) = (radius * libm::cos(angle), radius * libm::sin(angle));
            self.plain.push(y, z, area, 0.0);
        }
        let cube = radius * radius * radius;
        self.torsion = [std::f64::consts::TAU * cube * t, 0.0];
    }

    fn sum_up(&mut self) {
        let g = self.steel.shear_modulus();
        for fibres in [&self.plain, &self.web] {
            for k in 0..fibres.len() {
                let (y, z, area) = (fibres.y[k], fibres.z[k], fibres.area[k]);
                self.area += area;
                self.second_moment[0] += area * y * y;
                self.second_moment[1] += area * z * z;
                self.reach[0] = self.reach[0].max(y.abs());
                self.reach[1] = self.reach[1].max(z.abs());
                let stress = self.steel.young_modulus * fibres.initial[k].abs();
                self.largest_initial = self.largest_initial.max(stress);
            }
        }
        self.web_rigidity = g * self.web.area.iter().sum::<f64>();
        let e = self.steel.young_modulus;
        let f = &self.plain;
        for k in 0..f.len() {
            let (y, z, area) = (f.y[k], f.z[k], e * f.area[k]);
            self.plain_elastic[0] += area;
            self.plain_elastic[1] += area * y * y;
            self.plain_elastic[2] += area * z * z;
        }
        let [strong, weak] = self.second_moment;
        self.elastic = [e * self.area, e * strong, e * weak, self.web_rigidity];
    }

    /// Largest distances of a fibre from the strong and the weak axis \[m\].
    pub fn reach(&self) -> [f64; 2] {
        self.reach
    }

    /// The state of a section that has never yielded.
    pub fn undamaged(&self) -> PointState {
        let e = self.steel.young_modulus;
        let mut state = PointState {
            plain: self
                .plain
                .initial
                .iter()
                .map(|strain| -e * strain)
                .collect(),
            web: vec![[0.0; 2]; self.web.len()],
            locked: [0.0; 3],
        };
        let f = &self.plain;
        for k in 0..f.len() {
            let force = e * f.area[k] * f.initial[k];
            for (sum, lever) in state.locked.iter_mut().zip([1.0, -f.y[k], f.z[k]]) {
                *sum -= lever * force;
            }
        }
        state
    }

    /// Whether a section that has never yielded stays elastic under this strain, by a bound from outside.
    pub fn stays_elastic(&self, strain: &[f64; 4], strength: f64) -> bool {
        let e = self.steel.young_modulus;
        let bent = self.reach[0] * strain[1].abs() + self.reach[1] * strain[2].abs();
        let normal = e * (strain[0].abs() + bent) + self.largest_initial;
        let shear = self.steel.shear_modulus() * strain[3];
        normal * normal + 3.0 * shear * shear <= strength * strength
    }

    /// `EA`, `EI` about the strong and the weak axis, `GA` of the web.
    pub fn elastic(&self) -> &[f64; 4] {
        &self.elastic
    }

    /// Elastic and hardening energy per length \[J/m\].
    pub fn stored_energy(&self, strain: &[f64; 4], from: &PointState) -> f64 {
        let (e, h) = (self.steel.young_modulus, self.steel.plastic_modulus());
        let g = self.steel.shear_modulus();
        let mut sum = 0.0;
        for k in 0..self.plain.len() {
            let f = &self.plain;
            let total = strain[0] - f.y[k] * strain[1] + f.z[k] * strain[2] + f.initial[k];
            let plastic = (from.plain[k] + e * f.initial[k]) / (e + h);
            let elastic = total - plastic;
            sum += 0.5 * f.area[k] * (e * elastic * elastic + h * plastic * plastic);
        }
        for k in 0..self.web.len() {
            let f = &self.web;
            let total = strain[0] - f.y[k] * strain[1] + f.z[k] * strain[2] + f.initial[k];
            let [p, q] = from.web[k];
            let (elastic, shear) = (total - p, strain[3] - q);
            sum += 0.5
                * f.area[k]
                * (e * elastic * elastic + h * p * p + g * shear * shear + h / 3.0 * q * q);
        }
        sum
    }

    /// Returns every fibre to its yield surface `|xi| <= strength` or, in the web,
    /// `xi_s^2 + 3 xi_t^2 <= strength^2`. Tells whether any flows.
    pub fn respond<const SPACE: bool>(
        &self,
        strain: &[f64; 4],
        strength: f64,
        from: &PointState,
        forces: &mut PointForces,
        stiffness: &mut PointStiffness,
    ) -> bool {
        let e = self.steel.young_modulus;
        let kept = 1.0 - self.steel.hardening_ratio;
        let [axial, bent, weak] = [e * strain[0], e * strain[1], e * strain[2]];
        // N, Mz, My that flow; area that flows, its first and second moments Ay, Az, Ayy, Ayz, Azz.
        let mut sums = [[0.0; LANES]; 3];
        let mut soft = [[0.0; LANES]; 6];
        let mut flows = false;
        let f = &self.plain;
        let arrays = f.y.chunks_exact(LANES).zip(f.z.chunks_exact(LANES));
        let arrays = arrays.zip(f.area.chunks_exact(LANES));
        for (((y, z), area), old) in arrays.zip(from.plain.chunks_exact(LANES)) {
            let mut beyond = [0.0; LANES];
            let mut any = 0.0;
            for lane in 0..LANES {
                let mut xi = (axial - y[lane] * bent) - old[lane];
                if SPACE {
                    xi += z[lane] * weak;
                }
                // Two selections, which the compiler does for all lanes at once.
                let over = if xi > strength { xi - strength } else { 0.0 };
                let under = if xi < -strength { xi + strength } else { 0.0 };
                beyond[lane] = over + under;
            }
            for value in beyond {
                any += value * value;
            }
            if any == 0.0 {
                continue;
            }
            flows = true;
            for lane in 0..LANES {
                let (y, z, area) = (y[lane], z[lane], area[lane]);
                let force = area * beyond[lane];
                let part = if beyond[lane] == 0.0 { 0.0 } else { area };
                let ys = y * part;
                sums[0][lane] += force;
                sums[1][lane] -= y * force;
                soft[0][lane] += part;
                soft[1][lane] += ys;
                soft[3][lane] += y * ys;
                if SPACE {
                    let zs = z * part;
                    sums[2][lane] += z * force;
                    soft[2][lane] += zs;
                    soft[4][lane] += y * zs;
                    soft[5][lane] += z * zs;
                }
            }
        }
        let total = |lanes: [f64; LANES]| (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
        let rigidity = self.plain_elastic;
        *forces = [0.0; 4];
        for k in 0..3 {
            forces[k] = rigidity[k] * strain[k] - from.locked[k];
            if flows {
                forces[k] -= kept * total(sums[k]);
            }
        }
        let [a, ay, az, ayy, ayz, azz] = if flows {
            soft.map(|lanes| kept * e * total(lanes))
        } else {
            [0.0; 6]
        };
        let all = self.elastic;
        *stiffness = [
            [all[0] - a, ay, -az, 0.0],
            [ay, all[1] - ayy, ayz, 0.0],
            [-az, ayz, all[2] - azz, 0.0],
            [0.0, 0.0, 0.0, all[3]],
        ];
        if self.web.len() > 0 {
            flows |= self.respond_web(strain, strength, from, forces, stiffness);
        }
        flows
    }

    /// Takes the flow of the fibres under this strain over into their state.
    pub fn flow(&self, strain: &[f64; 4], strength: f64, state: &mut PointState) {
        let (e, h) = (self.steel.young_modulus, self.steel.plastic_modulus());
        let g = self.steel.shear_modulus();
        let kept = 1.0 - self.steel.hardening_ratio;
        let f = &self.plain;
        for k in 0..f.len() {
            let xi = e * (strain[0] - f.y[k] * strain[1] + f.z[k] * strain[2]) - state.plain[k];
            let beyond = xi - xi.clamp(-strength, strength);
            if beyond != 0.0 {
                state.plain[k] += beyond;
                let force = kept * f.area[k] * beyond;
                for (sum, lever) in state.locked.iter_mut().zip([1.0, -f.y[k], f.z[k]]) {
                    *sum += lever * force;
                }
            }
        }
        let f = &self.web;
        for k in 0..f.len() {
            let total = strain[0] - f.y[k] * strain[1] + f.z[k] * strain[2] + f.initial[k];
            let [p, q] = state.web[k];
            let trial = [e * (total - p) - h * p, g * (strain[3] - q) - h / 3.0 * q];
            if trial[0] * trial[0] + 3.0 * trial[1] * trial[1] > strength * strength {
                let returned = return_to_surface(trial, strength, [e + h, 3.0 * g + h]);
                let [ns, nt] = returned.stress;
                state.web[k] = [
                    p + returned.multiplier * ns,
                    q + 3.0 * returned.multiplier * nt,
                ];
            }
        }
    }

    fn respond_web(
        &self,
        strain: &[f64; 4],
        strength: f64,
        from: &PointState,
        forces: &mut PointForces,
        stiffness: &mut PointStiffness,
    ) -> bool {
        let (e, h) = (self.steel.young_modulus, self.steel.plastic_modulus());
        let g = self.steel.shear_modulus();
        let f = &self.web;
        let mut flows = false;
        for k in 0..f.len() {
            let (y, z, area) = (f.y[k], f.z[k], f.area[k]);
            let total = strain[0] - y * strain[1] + z * strain[2] + f.initial[k];
            let [p, q] = from.web[k];
            let mut normal = e * (total - p);
            let mut shear = g * (strain[3] - q);
            let (xs, xt) = (normal - h * p, shear - h / 3.0 * q);
            let size = xs * xs + 3.0 * xt * xt;
            if size > strength * strength {
                flows = true;
                let returned = return_to_surface([xs, xt], strength, [e + h, 3.0 * g + h]);
                let [ns, nt] = returned.stress;
                let flow = [returned.multiplier * ns, 3.0 * returned.multiplier * nt];
                normal -= e * flow[0];
                shear -= g * flow[1];
                // d flow / d (strain, shear strain).
                let by = returned.flow_by_trial;
                let lost = [
                    [e * by[0][0] * e, e * by[0][1] * g],
                    [g * by[1][0] * e, g * by[1][1] * g],
                ];
                let row = [1.0, -y, z];
                for i in 0..3 {
                    for j in 0..3 {
                        stiffness[i][j] -= area * lost[0][0] * row[i] * row[j];
                    }
                    let mixed = 0.5 * (lost[0][1] + lost[1][0]);
                    stiffness[i][3] -= area * mixed * row[i];
                    stiffness[3][i] -= area * mixed * row[i];
                }
                stiffness[3][3] -= area * lost[1][1];
            }
            let force = area * normal;
            forces[0] += force;
            forces[1] -= y * force;
            forces[2] += z * force;
            forces[3] += area * shear;
        }
        flows
    }
}

struct Returned {
    /// Relative stress on the surface.
    stress: [f64; 2],
    /// Plastic multiplier over the strength.
    multiplier: f64,
    /// Derivative of the plastic strains by the trial stresses.
    flow_by_trial: [[f64; 2]; 2],
}

/// Returns a relative stress `(xs, xt)` to `xs^2 + 3 xt^2 = strength^2` along the gradient of the surface. The function
/// whose root is sought is convex and falls, so that Newton's method from 0 approaches it from one side.
fn return_to_surface(trial: [f64; 2], strength: f64, moduli: [f64; 2]) -> Returned {
    let target = strength * strength;
    let mut r = 0.0;
    let (mut s, mut t) = (1.0, 1.0);
    for _ in 0..MAX_RETURNS {
        s = 1.0 / (1.0 + moduli[0] * r);
        t = 1.0 / (1.0 + moduli[1] * r);
        let (a, b) = (trial[0] * s, trial[1] * t);
        let size = a * a + 3.0 * b * b;
        let excess = size - target;
        if excess.abs() <= 4e-15 * target {
            break;
        }
        let slope = -2.0 * (a * a * moduli[0] * s + 3.0 * b * b * moduli[1] * t);
        // Newton's method on sqrt(size) instead of size: nearly straight where the trial is far outside.
        let root = size.sqrt();
        let step = (root - strength) * 2.0 * root / -slope;
        r = (r + step).max(0.0);
    }
    let stress = [trial[0] * s, trial[1] * t];
    // d r / d trial from the consistency of the surface.
    let slope =
        2.0 * (stress[0] * stress[0] * moduli[0] * s + 3.0 * stress[1] * stress[1] * moduli[1] * t);
    let by = [2.0 * stress[0] * s / slope, 6.0 * stress[1] * t / slope];
    let grown = [s - moduli[0] * r * s * s, t - moduli[1] * r * t * t];
    // flow = (r trial_s s, 3 r trial_t t) with s, t functions of r.
    Returned {
        stress,
        multiplier: r,
        flow_by_trial: [
            [
                r * s + trial[0] * grown[0] * by[0],
                trial[0] * grown[0] * by[1],
            ],
            [
                3.0 * trial[1] * grown[1] * by[0],
                3.0 * (r * t + trial[1] * grown[1] * by[1]),
            ],
        ],
    }
}
