//! The cross-section as fibres: their strains, stresses and plastic strains.
//!
//! Axes: x along the column, y in the plane of the web (bending about the strong axis moves the column along y), z along the
//! flanges. The strain of a fibre is `e - y kz + z ky`; fibres of the web also shear by `g`.

use column_mechanics::RolledSection;
use serde::{Deserialize, Serialize};

use super::curve::{Curve, Steel};

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

impl Shape {
    /// An I or H section welded from plates, without fillets; dimensions in \[m\].
    ///
    /// Where residual stresses are asked for, it has those of rolling.
    #[must_use]
    pub const fn plates(depth: f64, width: f64, web: f64, flange: f64) -> Self {
        Self::Rolled(RolledSection {
            depth,
            width,
            web_thickness: web,
            flange_thickness: flange,
            root_radius: 0.0,
        })
    }
}

/// Fibres whose stress is normal only; the arrays are padded with fibres without area to a multiple of [`LANES`].
#[derive(Debug, Clone, Default)]
pub(crate) struct Fibres {
    pub y: Vec<f64>,
    pub z: Vec<f64>,
    pub area: Vec<f64>,
    /// Strain that the residual stress of rolling stands for.
    pub initial: Vec<f64>,
    /// Share of the shear angle of the section that the fibre has, where it bears shear.
    pub share: Vec<f64>,
}

/// Sums are formed in so many lanes, which fixes their order whatever the processor can do at once.
pub(crate) const LANES: usize = 4;

/// Parts of half a flange with residual stresses in the plane of the web.
const HALF_FLANGE: usize = 4;

/// A cross-section divided into fibres.
#[derive(Debug, Clone)]
pub(crate) struct Section {
    pub steel: Steel,
    pub plain: Fibres,
    /// Fibres of the web, which bear shear along y, too; none where shear is left out.
    pub web: Fibres,
    /// Hardening of a steel with a yield plateau: of normal and of shear stress.
    pub curves: Option<[Curve; 2]>,
    /// `sum A (1, -y, z)` and their products: the elastic stiffness without `E`, in the order of [`PointForces`].
    elastic: [f64; 4],
    /// The same of the fibres without shear.
    plain_elastic: [f64; 3],
    /// `G A` of the web fibres \[N\].
    pub web_rigidity: f64,
    /// By how much the hardening may shift the shear stress of the web \[Pa\]; infinite for any amount.
    pub largest_back_stress: f64,
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
#[derive(Debug, Clone, PartialEq, Default)]
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
        self.share.push(1.0);
    }

    fn pad(&mut self) {
        while !self.y.len().is_multiple_of(LANES) {
            self.push(0.0, 0.0, 0.0, 0.0);
        }
    }

    pub fn len(&self) -> usize {
        self.y.len()
    }

    /// Place y, z of each fibre \[m\] and its area \[m²\].
    fn places(&self) -> impl Iterator<Item = ([f64; 2], f64)> {
        let places = self.y.iter().zip(&self.z);
        let places = places.map(|(y, z)| [*y, *z]);
        places.zip(self.area.iter().copied())
    }
}

/// The sum of lanes.
pub(crate) fn total(lanes: [f64; LANES]) -> f64 {
    (lanes[0] + lanes[2]) + (lanes[1] + lanes[3])
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
            curves: steel.tensile_strength.map(|tensile| {
                let normal = Curve::plateau(&steel, tensile);
                let sheared = normal.in_shear(steel.shear_modulus());
                [normal, sheared]
            }),
            elastic: [0.0; 4],
            plain_elastic: [0.0; 3],
            web_rigidity: 0.0,
            largest_back_stress: f64::INFINITY,
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
            } => section.divide_circular(diameter, thickness, division, with_shear),
        }
        section.plain.pad();
        section.web.pad();
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
                // In the plane of the web both halves of a flange are one.
                let (count, from, width) = match division.across {
                    1 if peak > 0.0 => (HALF_FLANGE, 0.0, 0.5 * b),
                    1 => (1, -0.5 * b, b),
                    across => (across, -0.5 * b, b),
                };
                for part in 0..count {
                    let z = from + width * (part as f64 + 0.5) / count as f64;
                    let residual = match count {
                        1 => 0.0,
                        _ => peak * (1.0 - 4.0 * z.abs() / b),
                    };
                    let area = b * tf / (division.layers * count) as f64;
                    self.plain.push(y, z, area, residual);
                }
            }
            if r > 0.0 {
                // Each fillet is a square less a quarter disc, with its centroid 0.2234 r from the corner.
                let area = (1.0 - 0.25 * std::f64::consts::PI) * r * r;
                let y = side * (0.5 * web_depth - 0.223_416 * r);
                let z = 0.5 * tw + 0.223_416 * r;
                if division.across == 1 {
                    self.plain.push(y, z, 2.0 * area, peak);
                } else {
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
        self.balance();
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

    /// Shifts the residual stresses so that they have no resultant, which the fillets, in tension, would leave.
    fn balance(&mut self) {
        let (mut force, mut area) = (0.0, 0.0);
        for fibres in [&self.plain, &self.web] {
            for (part, initial) in fibres.area.iter().zip(&fibres.initial) {
                force += part * initial;
                area += part;
            }
        }
        for fibres in [&mut self.plain, &mut self.web] {
            for initial in &mut fibres.initial {
                *initial -= force / area;
            }
        }
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
            self.flanges = [width * t * t * t / 6.0, 0.25 * width * t * t];
        }
        // Bredt.
        let (a, b) = (depth - t, width - t);
        self.torsion = [2.0 * a * a * b * b * t / (a + b), 0.0];
    }

    /// The shear flow of a thin ring is in proportion to the sine of the angle from the plane of bending, and the same on both sides
    /// of that plane, so that a fibre has its share without a sign: damage in the plane is carried over to fibres of either side.
    fn divide_circular(&mut self, diameter: f64, t: f64, division: Division, with_shear: bool) {
        let count = 4 * division.web;
        let radius = 0.5 * (diameter - t);
        let area = std::f64::consts::TAU * radius * t / count as f64;
        for k in 0..count {
            let angle = std::f64::consts::TAU * (k as f64 + 0.5) / count as f64;
            let (cos, sin) = (libm::cos(angle), libm::sin(angle));
            let (y, z) = (radius * cos, radius * sin);
            if with_shear {
                self.web.push(y, z, area, 0.0);
                self.web.share[k] = sin.abs();
            } else {
                self.plain.push(y, z, area, 0.0);
            }
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
        let sheared = self.web.area.iter().zip(&self.web.share);
        self.web_rigidity = g * sheared
            .map(|(area, share)| area * share * share)
            .sum::<f64>();
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

    /// Number of fibres without and with shear.
    pub fn fibres(&self) -> [usize; 2] {
        [self.plain.len(), self.web.len()]
    }

    /// Plastic strains of the fibres without shear.
    pub fn plastic_strains(&self, point: &PointState) -> impl Iterator<Item = f64> {
        let e = self.steel.young_modulus;
        let per = 1.0 / (e + self.steel.plastic_modulus());
        let fibres = point.plain.iter().zip(&self.plain.initial);
        fibres.map(move |(middle, initial)| match &self.curves {
            None => per * (middle + e * initial),
            Some([curve, _]) => curve.plastic(middle + e * initial),
        })
    }

    /// Magnitude of the plastic strain of each fibre, those without shear first, after von Mises where it bears shear.
    fn plastic_magnitudes(&self, point: &PointState) -> impl Iterator<Item = f64> {
        let plain = self.plastic_strains(point).map(f64::abs);
        let web = point.web.iter();
        plain.chain(web.map(|[normal, shear]| (normal * normal + shear * shear / 3.0).sqrt()))
    }

    /// Place y, z of each fibre \[m\] and the magnitude of its plastic strain.
    pub fn yielded(&self, point: &PointState) -> impl Iterator<Item = ([f64; 2], f64)> {
        let places = self.plain.places().chain(self.web.places());
        // What fills the lanes has no area.
        let all = places.zip(self.plastic_magnitudes(point));
        all.filter_map(|((place, area), strain)| (area > 0.0).then_some((place, strain)))
    }

    /// Whether a fibre has flowed further than its residual stress alone makes it flow: a section without residual stresses would have
    /// yielded, too. One that such a section would have borne elastically strains a fibre plastically by its residual stress over
    /// `E` at most.
    pub fn has_yielded_beyond_residual_stress(&self, point: &PointState) -> bool {
        let initial = self.plain.initial.iter().chain(&self.web.initial);
        let mut both = self.plastic_magnitudes(point).zip(initial);
        both.any(|(strain, initial)| strain > initial.abs())
    }

    /// A section whose fibres have these plastic strains.
    pub fn point(&self, plain: &[f64], web: Vec<[f64; 2]>) -> PointState {
        let mut state = self.undamaged();
        state.web = web;
        let e = self.steel.young_modulus;
        let f = &self.plain;
        for (k, strain) in plain.iter().enumerate() {
            state.plain[k] += match &self.curves {
                None => (e + self.steel.plastic_modulus()) * strain,
                Some([curve, _]) => curve.middle(*strain),
            };
            let force = e * f.area[k] * strain;
            for (sum, lever) in state.locked.iter_mut().zip([1.0, -f.y[k], f.z[k]]) {
                *sum += lever * force;
            }
        }
        state
    }

    /// For each fibre, without and with shear, the fibre of the section in the plane of the web at the same height and nearly
    /// the same distance from the web.
    pub fn counterparts(&self, plane: &Self) -> [Vec<usize>; 2] {
        let find = |from: &Fibres, to: &Fibres| {
            let nearest = |k: usize| {
                let far = |other: usize| {
                    let height = (from.y[other] - to.y[k]).abs();
                    let distance = (from.z[other].abs() - to.z[k].abs()).abs();
                    // Fibres at another height are far away.
                    1e3 * height + distance
                };
                let filled = (0..from.len()).filter(|other| from.area[*other] > 0.0);
                filled
                    .min_by(|one, two| far(*one).total_cmp(&far(*two)))
                    .unwrap_or(0)
            };
            (0..to.len()).map(nearest).collect()
        };
        [find(&plane.plain, &self.plain), find(&plane.web, &self.web)]
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

    /// Share of the stress beyond the yield surface by which the stress falls, where it is the same for all fibres.
    fn kept(&self) -> f64 {
        match self.curves {
            None => 1.0 - self.steel.hardening_ratio,
            Some(_) => 1.0,
        }
    }

    /// Returns every fibre to its yield surface `|xi| <= strength` or, in the web,
    /// `xi_s^2 + 3 xi_t^2 <= strength^2`. Returns the forces, the stiffness, and whether any fibre flows.
    #[inline(always)]
    pub fn respond<const SPACE: bool>(
        &self,
        strain: &[f64; 4],
        strength: f64,
        from: &PointState,
    ) -> (PointForces, PointStiffness, bool) {
        let e = self.steel.young_modulus;
        let kept = self.kept();
        let [axial, bent, weak] = [e * strain[0], e * strain[1], e * strain[2]];
        // N, Mz, My that flow; area that flows, its first and second moments Ay, Az, Ayy, Ayz, Azz.
        let mut sums = [[0.0; LANES]; 3];
        let mut soft = [[0.0; LANES]; 6];
        let mut flows = false;
        let f = &self.plain;
        let arrays = f.y.chunks_exact(LANES).zip(f.z.chunks_exact(LANES));
        let arrays = arrays.zip(f.area.chunks_exact(LANES));
        let arrays = arrays.zip(f.initial.chunks_exact(LANES));
        for ((((y, z), area), initial), old) in arrays.zip(from.plain.chunks_exact(LANES)) {
            let mut beyond = [0.0; LANES];
            let mut any = 0;
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
                any |= value.to_bits();
            }
            if any == 0 {
                continue;
            }
            flows = true;
            let (mut stress, mut shares) = (beyond, [1.0; LANES]);
            if let Some([curve, _]) = &self.curves {
                for lane in 0..LANES {
                    if beyond[lane] != 0.0 {
                        let middle = old[lane] + e * initial[lane];
                        [stress[lane], shares[lane]] = curve.relieved(middle, beyond[lane]);
                    }
                }
            }
            for lane in 0..LANES {
                let (y, z, area) = (y[lane], z[lane], area[lane]);
                let force = area * stress[lane];
                let part = if beyond[lane] == 0.0 {
                    0.0
                } else {
                    area * shares[lane]
                };
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
        let rigidity = self.plain_elastic;
        let mut forces = [0.0; 4];
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
        let stiffness = [
            [all[0] - a, ay, -az, 0.0],
            [ay, all[1] - ayy, ayz, 0.0],
            [-az, ayz, all[2] - azz, 0.0],
            [0.0, 0.0, 0.0, all[3]],
        ];
        if self.web.len() > 0 {
            // Copies, so that without a sheared web all of this stays in registers.
            let (mut forces, mut stiffness) = (forces, stiffness);
            flows |= self.respond_web(strain, strength, from, &mut forces, &mut stiffness);
            return (forces, stiffness, flows);
        }
        (forces, stiffness, flows)
    }

    /// Takes the flow of the fibres under this strain over into their state.
    pub fn flow(&self, strain: &[f64; 4], strength: f64, state: &mut PointState) {
        let e = self.steel.young_modulus;
        let kept = self.kept();
        let f = &self.plain;
        for k in 0..f.len() {
            let xi = e * (strain[0] - f.y[k] * strain[1] + f.z[k] * strain[2]) - state.plain[k];
            let beyond = xi - xi.clamp(-strength, strength);
            if beyond != 0.0 {
                let stress = match &self.curves {
                    None => beyond,
                    Some([curve, _]) => {
                        curve.relieved(state.plain[k] + e * f.initial[k], beyond)[0]
                    }
                };
                state.plain[k] += beyond;
                let force = kept * f.area[k] * stress;
                for (sum, lever) in state.locked.iter_mut().zip([1.0, -f.y[k], f.z[k]]) {
                    *sum += lever * force;
                }
            }
        }
        for first in (0..self.web.len()).step_by(LANES) {
            let trial = self.web_trial(strain, &state.web, first);
            if let Some(returned) = self.return_web(&trial, strength) {
                for lane in 0..LANES {
                    let [p, q] = &mut state.web[first + lane];
                    *p += returned.flow[0][lane];
                    *q += returned.flow[1][lane];
                }
            }
        }
    }
}
