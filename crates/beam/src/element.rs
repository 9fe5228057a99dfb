//! The deformations of an element between two nodes, which turn and move by any amount.
//!
//! With the direction of the chord `t = (x2 - x1) / |x2 - x1|` and the directors `a`, `b` of its nodes, an element has the
//! deformations `|x2 - x1| - l0`, `-a2.t`, `-b2.t` (rotations about z against the chord), `a3.t`, `b3.t` (about y) and the
//! twist `(b2.a3 - b3.a2) / 2`. All but the first are products of two unknowns, whose increments over a step are exactly those
//! of the middle: `d(a.t) = a_m.dt + (a_m x t_m).psi`, because Cayley's rotation moves a director by `psi x a_m`; `dt` is a
//! matrix times the increment of the chord. So the work of the mean forces is exactly the work of the fibres.
//!
//! These products are the sines of the rotations. The fibres strain with the angles, `s + s^3 / 6` for a sine `s`, whose
//! increments are exactly known as well: against a sine, a hinge that turns by 0.25 rad within one element would resist with 3 %
//! less than its moment.
//!
//! The length of the chord must not enter the rotations: the moment of an element that shortens plastically would fall with
//! its length, and the column would soften in the shortest element.

/// Three vectors: along the column, along y and along z of the section.
pub(crate) type Triad = [[f64; 3]; 3];

/// A triad that is not turned.
pub(crate) const UPRIGHT: Triad = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

pub(crate) fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The same of vectors that lie in the plane if there are three deformations.
fn inner<const R: usize>(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let in_plane = a[0] * b[0] + a[1] * b[1];
    if R == 3 {
        in_plane
    } else {
        in_plane + a[2] * b[2]
    }
}

/// A vector of these components, the last of which is 0 in the plane.
fn vector<const R: usize>(component: impl Fn(usize) -> f64) -> [f64; 3] {
    let last = if R == 3 { 0.0 } else { component(2) };
    [component(0), component(1), last]
}

/// The triad in the middle and at the end of Cayley's rotation by `psi`, which is twice the tangent of half the angle.
pub(crate) fn turned(triad: &Triad, psi: &[f64; 3]) -> (Triad, Triad) {
    let per = 1.0 / (1.0 + 0.25 * dot(psi, psi));
    let (mut middle, mut end) = (*triad, *triad);
    for (k, a) in triad.iter().enumerate() {
        let turn = cross(psi, a);
        let along = 0.25 * dot(psi, a);
        for i in 0..3 {
            middle[k][i] = per * (a[i] + 0.5 * turn[i] + along * psi[i]);
            end[k][i] = 2.0 * middle[k][i] - a[i];
        }
    }
    (middle, end)
}

/// The same for a rotation about z alone, of the directors in the plane; the rest of both triads is upright already.
pub(crate) fn turn_in_plane(triad: &Triad, psi: f64, middle: &mut Triad, end: &mut Triad) {
    let per = 1.0 / (1.0 + 0.25 * psi * psi);
    let half = 0.5 * psi;
    for k in 0..2 {
        let [x, y, _] = triad[k];
        let (mx, my) = (per * (x - half * y), per * (y + half * x));
        (middle[k][0], middle[k][1]) = (mx, my);
        (end[k][0], end[k][1]) = (2.0 * mx - x, 2.0 * my - y);
    }
}

/// Where the ends of an element are.
#[derive(Clone, Copy)]
pub(crate) struct Ends<'a> {
    /// Vector from the first node to the second \[m\].
    pub chord: [f64; 3],
    /// Its length \[m\] and the inverse of it \[1/m\].
    pub length: f64,
    pub inverse: f64,
    pub triads: [&'a Triad; 2],
}

impl<'a> Ends<'a> {
    #[inline(always)]
    pub fn new<const R: usize>(chord: [f64; 3], triads: [&'a Triad; 2]) -> Self {
        let length = length::<R>(&chord);
        Self {
            chord,
            length,
            inverse: 1.0 / length,
            triads,
        }
    }
}

fn length<const R: usize>(chord: &[f64; 3]) -> f64 {
    inner::<R>(chord, chord).sqrt()
}

/// The deformations, from a straight element of length `l0`, with the sines of the rotations.
pub(crate) fn deformations<const R: usize>(ends: &Ends<'_>, l0: f64) -> [f64; R] {
    let [a, b] = ends.triads;
    let u = vector::<R>(|k| ends.chord[k] * ends.inverse);
    let mut d = [0.0; R];
    d[0] = ends.length - l0;
    d[1] = -inner::<R>(&a[1], &u);
    d[2] = -inner::<R>(&b[1], &u);
    if R == 6 {
        d[3] = dot(&a[2], &u);
        d[4] = dot(&b[2], &u);
        d[5] = 0.5 * (dot(&b[1], &a[2]) - dot(&b[2], &a[1]));
    }
    d
}

/// Rows of the sines, and of the angles, of one end about z and y; the second one exists in space only.
fn bending<const R: usize>(end: usize) -> [usize; 2] {
    [1 + end, R - 3 + end]
}

/// The deformations with the angles of the rotations in place of their sines.
pub(crate) fn angles<const R: usize>(sines: &[f64; R]) -> [f64; R] {
    let mut angles = *sines;
    for [z, y] in [0, 1].map(bending::<R>) {
        let in_space = if R == 6 { sines[y] * sines[y] } else { 0.0 };
        let per = 1.0 + (sines[z] * sines[z] + in_space) / 6.0;
        angles[z] *= per;
        if R == 6 {
            angles[y] *= per;
        }
    }
    angles
}

/// Turns the gradient of the sines into that of the angles, which makes their increments exact from these sines to those, or is
/// their derivative where both are equal. Adds to the `stiffness` what the change of that gradient contributes, and returns the
/// forces of the sines.
pub(crate) fn turn_to_angles<const R: usize, const Q: usize>(
    [from, to]: [&[f64; R]; 2],
    forces: &[f64; R],
    rows: &mut [[f64; Q]; R],
    stiffness: &mut [[f64; R]; R],
) -> [f64; R] {
    let mut of_sines = *forces;
    // The increment of a cube over that of its root.
    let cube = |k: usize| from[k] * from[k] + from[k] * to[k] + to[k] * to[k];
    // The derivative of a sixth of that by the end of an increment, over the share of the increment that reaches the place where
    // forces are in balance: by that place.
    let slope = |k: usize| (from[k] + 2.0 * to[k]) / 3.0;
    for [z, y] in [0, 1].map(bending::<R>) {
        if R == 3 {
            let per = 1.0 + cube(z) / 6.0;
            rows[z] = rows[z].map(|value| per * value);
            of_sines[z] = per * forces[z];
            stiffness[z][z] += forces[z] * slope(z);
            continue;
        }
        let [mean_z, mean_y] = [z, y].map(|k| 0.5 * (from[k] + to[k]));
        let square = |k: usize| 0.5 * (from[k] * from[k] + to[k] * to[k]);
        let about_z = 1.0 + (cube(z) + square(y)) / 6.0;
        let about_y = 1.0 + (cube(y) + square(z)) / 6.0;
        let both = mean_z * mean_y / 3.0;
        for k in 0..Q {
            let (one, other) = (rows[z][k], rows[y][k]);
            rows[z][k] = about_z * one + both * other;
            rows[y][k] = both * one + about_y * other;
        }
        let [moment_z, moment_y] = [forces[z], forces[y]];
        of_sines[z] = about_z * moment_z + both * moment_y;
        of_sines[y] = both * moment_z + about_y * moment_y;
        let mixed = (moment_z * mean_y + moment_y * mean_z) / 3.0;
        stiffness[z][z] += moment_z * slope(z) + moment_y * mean_y / 3.0;
        stiffness[y][y] += moment_y * slope(y) + moment_z * mean_z / 3.0;
        stiffness[z][y] += mixed;
        stiffness[y][z] += mixed;
    }
    of_sines
}

/// A chord over an increment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chord {
    /// The chord at the middle or, in statics, at the end \[m\].
    at: [f64; 3],
    /// Mean of its directions at both ends of the increment.
    direction: [f64; 3],
    /// Gradient of its length that makes the increment of the length exact.
    stretch: [f64; 3],
    /// Mean of the inverse lengths \[1/m\], inverse of the product of the lengths \[1/m²\].
    inverse: [f64; 2],
}

impl Chord {
    /// From one chord to another, with the inverses of their lengths; `from` equal to `to` gives the derivatives there.
    #[inline(always)]
    pub fn new<const R: usize>([from, to]: [&[f64; 3]; 2], [one, two]: [f64; 2]) -> Self {
        let at = vector::<R>(|k| 0.5 * (from[k] + to[k]));
        let per = 2.0 * one * two / (one + two);
        Self {
            at,
            direction: vector::<R>(|k| 0.5 * (from[k] * one + to[k] * two)),
            stretch: vector::<R>(|k| at[k] * per),
            inverse: [0.5 * (one + two), one * two],
        }
    }

    /// The gradient of `director.t` by the chord.
    #[inline(always)]
    fn across<const R: usize>(&self, director: &[f64; 3]) -> [f64; 3] {
        let along = self.inverse[1] * inner::<R>(&self.at, director);
        vector::<R>(|k| self.inverse[0] * director[k] - along * self.stretch[k])
    }
}

/// The gradient of the deformations, with the sines of the rotations, by the chord and the rotations of both ends, with the
/// triads of the middle of a step or, in statics, of its end.
pub(crate) fn gradient<const R: usize, const Q: usize>(
    chord: &Chord,
    [a, b]: [&Triad; 2],
) -> [[f64; Q]; R] {
    let t = &chord.direction;
    let mut rows = [[0.0; Q]; R];
    if R == 3 {
        rows[0][..2].copy_from_slice(&chord.stretch[..2]);
        for (row, (director, place)) in [(&a[1], 2), (&b[1], 3)].into_iter().enumerate() {
            let across = chord.across::<R>(director);
            rows[row + 1][0] = -across[0];
            rows[row + 1][1] = -across[1];
            rows[row + 1][place] = t[0] * director[1] - t[1] * director[0];
        }
        return rows;
    }
    rows[0][..3].copy_from_slice(&chord.stretch);
    let bending = [
        (&a[1], 3, -1.0),
        (&b[1], 6, -1.0),
        (&a[2], 3, 1.0),
        (&b[2], 6, 1.0),
    ];
    for (row, (director, place, sign)) in bending.into_iter().enumerate() {
        let lever = cross(director, t);
        let across = chord.across::<R>(director);
        for i in 0..3 {
            rows[row + 1][i] = sign * across[i];
            rows[row + 1][place + i] = sign * lever[i];
        }
    }
    let (first, second) = (cross(&b[1], &a[2]), cross(&b[2], &a[1]));
    for i in 0..3 {
        let axis = 0.5 * (first[i] - second[i]);
        rows[5][3 + i] = -axis;
        rows[5][6 + i] = axis;
    }
    rows
}

/// The derivative of `gradient' S` with the forces `S` held, symmetric; `share` is the share of an increment that reaches
/// the place where the gradient is taken.
pub(crate) fn geometric<const R: usize, const Q: usize>(
    chord: &Chord,
    [a, b]: [&Triad; 2],
    forces: &[f64; R],
    share: f64,
    into: &mut [[f64; Q]; Q],
) {
    let per = 1.0 / length::<R>(&chord.at);
    let t = vector::<R>(|k| chord.at[k] * per);
    let dim = if R == 3 { 2 } else { 3 };
    let bending: [(&[f64; 3], usize, f64); 4] = if R == 3 {
        [
            (&a[1], 2, -forces[1]),
            (&b[1], 3, -forces[2]),
            (&a[1], 2, 0.0),
            (&a[1], 2, 0.0),
        ]
    } else {
        [
            (&a[1], 3, -forces[1]),
            (&b[1], 6, -forces[2]),
            (&a[2], 3, forces[3]),
            (&b[2], 6, forces[4]),
        ]
    };
    // By the chord twice: `N (I - t t') / l` and, for each `F a.t`, `-F (p t' + t p' + (a.t) (I - t t')) / l^2`.
    let mut pull = share * forces[0] * per;
    let mut across = [0.0; 3];
    let bending = &bending[..if R == 3 { 2 } else { 4 }];
    for &(director, _, force) in bending {
        let force = share * force * (per * per);
        let along = inner::<R>(director, &t);
        pull -= force * along;
        for k in 0..dim {
            across[k] += force * (director[k] - along * t[k]);
        }
    }
    for i in 0..dim {
        for j in 0..dim {
            let unit = if i == j { 1.0 } else { 0.0 };
            into[i][j] += pull * (unit - t[i] * t[j]) - across[i] * t[j] - t[i] * across[j];
        }
    }
    for &(director, place, force) in bending {
        let force = share * force;
        let along = force * inner::<R>(director, &t);
        if R == 3 {
            // d(director) = psi x director, across the chord.
            let turned = [-director[1] * (force * per), director[0] * (force * per)];
            let part = turned[0] * t[0] + turned[1] * t[1];
            for i in 0..2 {
                let value = turned[i] - part * t[i];
                into[i][place] += value;
                into[place][i] += value;
            }
            into[place][place] -= along;
            continue;
        }
        let [x, y, z] = director.map(|x| x * (force * per));
        let by_rotation = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]];
        for j in 0..3 {
            let part =
                by_rotation[0][j] * t[0] + by_rotation[1][j] * t[1] + by_rotation[2][j] * t[2];
            for i in 0..3 {
                let value = by_rotation[i][j] - part * t[i];
                into[i][place + j] += value;
                into[place + j][i] += value;
                into[place + i][place + j] +=
                    0.5 * force * (director[i] * t[j] + t[i] * director[j]);
            }
            into[place + j][place + j] -= along;
        }
    }
}

/// `rows' C rows` of an element in the plane: the blocks of the chord and of the rotations, those on and above the diagonal.
pub(crate) fn add_in_plane<const R: usize, const Q: usize>(
    rows: &[[f64; Q]; R],
    stiffness: &[[f64; R]; R],
    share: f64,
    into: &mut [[f64; Q]; Q],
) {
    for i in 0..R {
        let mut row = [0.0; Q];
        for j in 0..R {
            let value = share * stiffness[i][j];
            for k in 0..Q {
                row[k] += value * rows[j][k];
            }
        }
        for a in 0..Q {
            for k in a - a % 2..Q {
                into[a][k] += rows[i][a] * row[k];
            }
        }
    }
}

/// The same in space, where the bending of an end depends on the chord and the rotation of that end, and the twist on both
/// rotations; the same blocks.
pub(crate) fn add_in_space<const R: usize, const Q: usize>(
    rows: &[[f64; Q]; R],
    stiffness: &[[f64; R]; R],
    share: f64,
    into: &mut [[f64; Q]; Q],
) {
    let mut products = [[0.0; Q]; 5];
    for (i, product) in products.iter_mut().enumerate() {
        let c: [f64; 5] = std::array::from_fn(|j| share * stiffness[i][j]);
        for k in 0..3 {
            product[k] = c[0] * rows[0][k]
                + (c[1] * rows[1][k] + c[2] * rows[2][k])
                + (c[3] * rows[3][k] + c[4] * rows[4][k]);
            product[3 + k] = c[1] * rows[1][3 + k] + c[3] * rows[3][3 + k];
            product[6 + k] = c[2] * rows[2][6 + k] + c[4] * rows[4][6 + k];
        }
    }
    for a in 0..3 {
        for (row, product) in rows.iter().zip(&products) {
            for k in 0..Q {
                into[a][k] += row[a] * product[k];
            }
        }
        for k in 3..Q {
            into[3 + a][k] += rows[1][3 + a] * products[1][k] + rows[3][3 + a] * products[3][k];
        }
        for k in 6..Q {
            into[6 + a][k] += rows[2][6 + a] * products[2][k] + rows[4][6 + a] * products[4][k];
        }
    }
    let twist = share * stiffness[R - 1][R - 1];
    for a in 3..Q {
        let part = twist * rows[R - 1][a];
        for k in a - a % 3..Q {
            into[a][k] += part * rows[R - 1][k];
        }
    }
}

/// Unknowns of an element in space: its chord and the rotations of both ends.
pub(crate) const ROW: usize = 9;

/// What the stiffness needs of an element.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part<const R: usize> {
    /// Gradient of the deformations; in the plane its rows are shorter.
    pub rows: [[f64; ROW]; R],
    pub chord: Chord,
    /// Forces in balance of the sines, and derivatives of those of the angles by the deformations.
    pub forces: [f64; R],
    pub stiffness: [[f64; R]; R],
    /// Derivatives of the force of the shear angle by itself and by the deformations.
    pub own: f64,
    pub mixed: [f64; R],
}

impl<const R: usize> Part<R> {
    /// Before the first evaluation.
    pub fn nothing() -> Self {
        let unit = [1.0, 0.0, 0.0];
        Self {
            rows: [[0.0; ROW]; R],
            chord: Chord::new::<R>([&unit, &unit], [1.0, 1.0]),
            forces: [0.0; R],
            stiffness: [[0.0; R]; R],
            own: 0.0,
            mixed: [0.0; R],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Work over an increment in which every rotation changes: by the angles, and by the rows that the solver takes.
    fn works<const R: usize>(from: [f64; R], to: [f64; R], forces: [f64; R]) -> [f64; 3] {
        // Rows of the sines themselves.
        let mut rows: [[f64; R]; R] =
            std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
        let mut stiffness = [[0.0; R]; R];
        let of_sines = turn_to_angles([&from, &to], &forces, &mut rows, &mut stiffness);
        let change: [f64; R] = std::array::from_fn(|k| to[k] - from[k]);
        let (begin, end) = (angles(&from), angles(&to));
        let by_angles = (0..R).map(|k| forces[k] * (end[k] - begin[k])).sum();
        let by_sines = (0..R).map(|k| of_sines[k] * change[k]).sum();
        let pairs = (0..R).flat_map(|i| (0..R).map(move |j| (i, j)));
        let by_rows = pairs.map(|(i, j)| forces[i] * rows[i][j] * change[j]).sum();
        [by_angles, by_sines, by_rows]
    }

    #[test]
    fn the_angles_of_an_increment_do_exactly_the_work_of_its_sines() {
        let plane = works([1e-3, 0.1, -0.3], [2e-3, 0.4, 0.2], [3.0, 5.0, -7.0]);
        let space = works(
            [1e-3, 0.1, -0.3, 0.25, 0.05, 0.01],
            [2e-3, 0.4, 0.2, -0.1, 0.3, 0.02],
            [3.0, 5.0, -7.0, 11.0, 13.0, 17.0],
        );
        for [by_angles, by_sines, by_rows] in [plane, space] {
            assert!((by_sines - by_angles).abs() < 1e-13 * by_angles.abs());
            assert!((by_rows - by_angles).abs() < 1e-13 * by_angles.abs());
        }
    }

    #[test]
    fn angles_are_those_of_a_rotation_about_any_axis_across_the_chord() {
        for (angle, about) in [(0.3, 0.0_f64), (0.3, 0.7), (-0.2, 1.2)] {
            let (about_z, about_y) = (libm::cos(about), libm::sin(about));
            let sine = libm::sin(angle);
            let mut sines = [0.0; 6];
            (sines[1], sines[3]) = (sine * about_z, sine * about_y);
            let found = angles(&sines);
            for (k, share) in [(1, about_z), (3, about_y)] {
                let error = (found[k] - angle * share).abs();
                assert!(error < 7e-4 * angle.abs(), "{angle} {about}: {error}");
            }
        }
    }

    #[test]
    fn the_stiffness_of_the_angles_is_the_derivative_of_their_forces() {
        let forces = [3.0, 5.0, -7.0, 11.0, 13.0, 17.0];
        let sines = [1e-3, 0.1, -0.3, 0.25, 0.05, 0.01];
        let turn = |sines: &[f64; 6]| {
            let mut stiffness = [[0.0; 6]; 6];
            let mut rows = [[0.0; 6]; 6];
            let forces = turn_to_angles([sines; 2], &forces, &mut rows, &mut stiffness);
            (forces, stiffness)
        };
        let (_, stiffness) = turn(&sines);
        for j in 0..6 {
            let moved = |by: f64| {
                let mut sines = sines;
                sines[j] += by;
                turn(&sines).0
            };
            let (low, high) = (moved(-1e-5), moved(1e-5));
            for i in 0..6 {
                let slope = (high[i] - low[i]) / 2e-5;
                assert!((stiffness[i][j] - slope).abs() < 1e-8, "{i} {j}");
            }
        }
    }
}
