//! The scalar problem of a return to the yield surface, whose derivative is monotone: a bracketed root search never fails,
//! corners and tips included.

use super::capped_moments::{CappedMoments, cap_moments};
use super::yield_surface::{Branch, CurvePoint, YieldSurface};

/// Bound of the scalar root search: bisection alone needs 105 iterations down to the square of the machine epsilon.
pub(crate) const MAX_RETURN_ITERATIONS: usize = 120;

/// The root search stops at a Newton step of this size, relative to the coordinate: the error after it is of the order of
/// its square, even where the curvature of the surface is infinite at `N = 0`. (The stress lies on the surface and the
/// energy balance holds whatever the error is.) A bisection step gives no such bound and goes on to the last bit.
pub(crate) const RETURN_TOLERANCE: f64 = 1e-9;

/// A step of the root search below this is nothing beside any stress. A root below it lies at the vertex: with an exponent
/// just above 1 the slope of the curve falls to zero so close to its end that no double resolves it (`n^0.001` is still
/// one half at `n = 1e-301`), and the vertex is a corner as it is with the exponent 1.
pub(crate) const NEGLIGIBLE_STEP: f64 = f64::EPSILON * f64::EPSILON;

/// Most Newton steps from the expected root before the root is bracketed.
const MAX_STEPS_NEAR: usize = 4;

/// The scalar problem of one return mapping, with `n = |N|/N^p >= 0`.
pub(crate) struct Search<'a> {
    pub surface: &'a YieldSurface,
    /// Stiffness of the moments against the hinge rotations \[N m/rad\], and the inverse of each stiffness alone.
    pub rotational: &'a [[f64; 2]; 2],
    pub flexibility: [f64; 2],
    /// Weighs moments times rotations against normal forces \[1/rad\].
    pub scale: f64,
    /// Trial moments \[N m\].
    pub moments: [f64; 2],
    /// `n` of the trial stress.
    pub trial: f64,
}

/// Where the returned stress lies.
pub(crate) enum Root {
    Vertex {
        axial: f64,
        cap: f64,
    },
    Curve {
        branch: Branch,
        t: f64,
        point: CurvePoint,
    },
}

impl Root {
    /// The vertex at which a branch begins.
    fn vertex(branch: Branch) -> Self {
        match branch {
            Branch::Axial => Self::Vertex {
                axial: 0.0,
                cap: 1.0,
            },
            Branch::Moment => Self::Vertex {
                axial: 1.0,
                cap: 0.0,
            },
        }
    }
}

impl Search<'_> {
    /// The plastic rotations that bring the trial moments within a cap \[N m\].
    #[inline(always)]
    fn cap_moments(&self, cap: f64) -> CappedMoments {
        cap_moments(self.rotational, self.flexibility, self.moments, [cap; 2])
    }

    /// Derivative of the problem along the curve, divided by `N^p^2/K`, and its own derivative, at the point `point` with
    /// coordinate `t`. Positive: the root lies at a smaller coordinate.
    #[inline(always)]
    fn derivative(&self, branch: Branch, t: f64, point: &CurvePoint) -> (f64, f64) {
        let surface = self.surface;
        let scale = self.scale;
        match branch {
            Branch::Axial => {
                let cap = point.other * surface.resistance_moment;
                let capped = self.cap_moments(cap);
                let value = t - self.trial + scale * capped.sum() * point.slope;
                let compliance = capped.compliance * surface.resistance_moment;
                let slope = 1.0
                    + scale * (compliance * point.slope * point.slope + capped.sum() * point.bend);
                (value, slope)
            }
            Branch::Moment => {
                let cap = t * surface.resistance_moment;
                let capped = self.cap_moments(cap);
                let short = self.trial - point.other;
                let value = short * point.slope - scale * capped.sum();
                let compliance = capped.compliance * surface.resistance_moment;
                let slope = point.slope * point.slope + short * point.bend + scale * compliance;
                (value, slope)
            }
        }
    }

    /// The root; `near` is the expected `n`, which only saves iterations.
    pub fn run(&self, near: f64) -> Root {
        let surface = self.surface;
        let split = surface.split();
        if let Some(root) = self.newton_near(near, split) {
            return root;
        }
        let derivative_at = |branch, t| self.derivative(branch, t, &surface.point(branch, t)).0;
        // The optimum has no larger n than the trial stress, which decides on which half of the curve it lies.
        if self.trial <= split || derivative_at(Branch::Axial, split) >= 0.0 {
            if surface.has_corner_at_zero_axial() && derivative_at(Branch::Axial, 0.0) >= 0.0 {
                return Root::vertex(Branch::Axial);
            }
            if self.trial <= NEGLIGIBLE_STEP && surface.is_sharp_at_zero_axial() {
                return Root::vertex(Branch::Axial);
            }
            return self.bisect_newton(Branch::Axial, self.trial.min(split), near);
        }
        if self.trial >= 1.0 && derivative_at(Branch::Moment, 0.0) >= 0.0 {
            return Root::vertex(Branch::Moment);
        }
        let near = if near >= split && near < 1.0 {
            surface.cap_of(near)
        } else {
            surface.point(Branch::Axial, split).other
        };
        self.bisect_newton(Branch::Moment, split, near)
    }

    /// Newton's method on the flat half of the curve from a normal force that is expected there. The derivative is monotone, so
    /// that a root within that half is the root; `None` where the iteration leaves it or needs more than a few steps.
    #[inline(always)]
    fn newton_near(&self, near: f64, split: f64) -> Option<Root> {
        let surface = self.surface;
        let high = self.trial.min(split);
        let mut t = near;
        for _ in 0..MAX_STEPS_NEAR {
            if !(t > NEGLIGIBLE_STEP && t < high) {
                return None;
            }
            let point = surface.point(Branch::Axial, t);
            let (value, slope) = self.derivative(Branch::Axial, t, &point);
            let newton = value / slope;
            if newton.abs() <= RETURN_TOLERANCE * t {
                t -= newton;
                let point = point.moved_by(-newton);
                let branch = Branch::Axial;
                return Some(Root::Curve { branch, t, point });
            }
            t -= newton;
        }
        None
    }

    /// Whether the root lies closer to the vertex at which the branch begins than any stress is resolved.
    #[cold]
    fn root_is_at_vertex(&self, branch: Branch) -> bool {
        let point = self.surface.point(branch, NEGLIGIBLE_STEP);
        self.derivative(branch, NEGLIGIBLE_STEP, &point).0 >= 0.0
    }

    /// Newton's method on the monotone derivative, kept within a shrinking bracket that begins as `0..high`.
    #[inline(always)]
    fn bisect_newton(&self, branch: Branch, mut high: f64, near: f64) -> Root {
        let surface = self.surface;
        let mut low = 0.0;
        let mut t = if near > low && near < high {
            near
        } else {
            0.5 * (low + high)
        };
        let mut last_step = high - low;
        let mut vertex_excluded = false;
        for _ in 0..MAX_RETURN_ITERATIONS {
            let point = surface.point(branch, t);
            let (value, slope) = self.derivative(branch, t, &point);
            if value > 0.0 {
                high = t;
            } else if value < 0.0 {
                low = t;
            } else {
                return Root::Curve { branch, t, point };
            }
            let newton = value / slope;
            let inside = t - newton >= low && t - newton <= high;
            if inside && newton.abs() <= 0.5 * last_step {
                last_step = newton.abs();
                t -= newton;
                if last_step <= (RETURN_TOLERANCE * t).max(NEGLIGIBLE_STEP) {
                    let point = point.moved_by(-newton);
                    return Root::Curve { branch, t, point };
                }
            } else {
                if low == 0.0 && !vertex_excluded {
                    vertex_excluded = true;
                    if self.root_is_at_vertex(branch) {
                        return Root::vertex(branch);
                    }
                }
                let middle = 0.5 * (low + high);
                last_step = (middle - t).abs();
                t = middle;
                if last_step <= NEGLIGIBLE_STEP {
                    break;
                }
            }
        }
        let point = surface.point(branch, t);
        Root::Curve { branch, t, point }
    }
}
