//! The torsional rigidity with which uniform torsion gives the twist that restrained warping leaves at the impact point.

/// `G I_t` times the twist of a bar of uniform torsion over the twist of the bar with warping rigidity `E I_w`, both under a
/// torque at `below` from the base and `above` from the top. Ends that are built in hold the warping, others do not.
///
/// Each part twists by `A (cosh kx - 1) + B (sinh kx - kx)` from an end that holds the warping and by `A x + B sinh kx` from
/// another, `k^2 = G I_t / E I_w`. At the impact point twist, its first and second derivative agree, and the torques differ by
/// the one applied.
pub(crate) fn effective_rigidity(
    rigidity: f64,
    warping: f64,
    [below, above]: [f64; 2],
    holds: [bool; 2],
) -> f64 {
    let k = (rigidity / warping).sqrt();
    if !k.is_finite() || k * below.max(above) > 30.0 {
        return rigidity;
    }
    // Twist and its three derivatives of both functions of one part, at its end.
    let part = |x: f64, holds: bool| {
        let (c, s) = (libm::cosh(k * x), libm::sinh(k * x));
        if holds {
            [
                [c - 1.0, k * s, k * k * c, k * k * k * s],
                [s - k * x, k * (c - 1.0), k * k * s, k * k * k * c],
            ]
        } else {
            [[x, 1.0, 0.0, 0.0], [s, k * c, k * k * s, k * k * k * c]]
        }
    };
    let (low, high) = (part(below, holds[0]), part(above, holds[1]));
    let torque = |f: &[f64; 4]| rigidity * f[1] - warping * f[3];
    // Columns: A, B of the lower part, A, B of the upper; the last is the right-hand side.
    let mut m = [
        [low[0][0], low[1][0], -high[0][0], -high[1][0], 0.0],
        [low[0][1], low[1][1], high[0][1], high[1][1], 0.0],
        [low[0][2], low[1][2], -high[0][2], -high[1][2], 0.0],
        [
            torque(&low[0]),
            torque(&low[1]),
            torque(&high[0]),
            torque(&high[1]),
            1.0,
        ],
    ];
    for column in 0..4 {
        let pivot = (column..4)
            .max_by(|&a, &b| m[a][column].abs().total_cmp(&m[b][column].abs()))
            .unwrap_or(column);
        m.swap(column, pivot);
        let row = m[column];
        for (index, other) in m.iter_mut().enumerate() {
            if index != column {
                let factor = other[column] / row[column];
                for (value, by) in other.iter_mut().zip(row) {
                    *value -= factor * by;
                }
            }
        }
    }
    let [a, b] = [m[0][4] / m[0][0], m[1][4] / m[1][1]];
    let twist = a * low[0][0] + b * low[1][0];
    below * above / ((below + above) * twist)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_warping_is_uniform_torsion_only_far_from_the_ends() {
        // Without restraint and with little warping rigidity the bar twists as Saint-Venant's.
        let free = effective_rigidity(5e4, 1.0, [1.0, 3.0], [false; 2]);
        assert!((free / 5e4 - 1.0).abs() < 0.02, "{free}");
        // HEB220 of 4 m: about seven times stiffer with warping held (E I_w = 210e9 * 295.4e-9).
        let held = effective_rigidity(5.3e4, 62_034.0, [1.0, 3.0], [true; 2]);
        assert!((4.0..9.0).contains(&(held / 5.3e4)), "{}", held / 5.3e4);
    }
}
