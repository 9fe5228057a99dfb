//! Shear of the web of a bar: a plastic slider in series with its two hinges.
//!
//! A web that yields turns both ends of its bar by the same angle `gamma_p`, against the sum of both end moments:
//! `|M_i + M_j| <= V_s l v(n)`, where `V_s = V_w + 2 m_f / l` ([`ShearProperties`](super::ShearProperties)). It resists
//! with the shear flow of the web through both fillets, not with the shear area of a code, and with both flanges, which
//! bend about their own axes.
//!
//! Up to half the squash load the normal force takes nothing of it, `v = 1`: the flanges bear it. Beyond, the web takes
//! part, with the stress `sigma / f_y = 2 n - 1`. The yield criterion of von Mises would leave `sqrt(1 - (2 n - 1)^2)`;
//! `v = 1 - (2 n - 1)^2 = 4 n (1 - n)` is a lower bound of that. It is concave, so that the return of a stress remains
//! convex, has no kink where it begins, and, unlike the root, a finite slope at the squash load. The flow is associated:
//! beyond half the squash load a web that yields in shear also shortens.
//!
//! The web hardens linearly with its shear angle, and kinematically: what it gains in one direction it loses in the other
//! (the effect of Bauschinger), but for a small rest, so that an unloaded web never yields. Either direction has its own
//! resistance, of which `v(n)` is the share that the normal force leaves.
//!
//! A foot that slips upon its base plate turns the lower bar as its web does, so that one slider serves both. Under a web that never
//! yields it has a slider of its own, of which a normal force takes no share.

use super::yield_surface::Jet;

/// `n` up to which a normal force takes nothing of the resistance against shear.
pub(crate) const FREE_AXIAL: f64 = 0.5;

/// By how much a sum of moments exceeds its resistance, relative to it, before the web yields: the round-off of the sum.
const YIELD_TOLERANCE: f64 = 4.0 * f64::EPSILON;

/// `-dv/dn` at `n = 1`.
const TIP_SLOPE: f64 = 4.0;

/// The whole share, at every normal force.
pub(crate) const WHOLE: Jet = Jet {
    value: 1.0,
    first: 0.0,
    second: 0.0,
};

/// What the web of one bar bears or, where no web yields, the foot of the lower bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slider {
    /// `V_s l`: the largest sum of the end moments of an undamaged bar at rest without normal force \[N m\].
    pub resistance: f64,
    /// `C (1, 1)`: by how much the moments fall with the angle of shear \[N m/rad\].
    pub turning: [f64; 2],
    /// Their sum.
    pub stiffness: f64,
    /// Whether a normal force takes a share of the resistance, as of a web; not of a foot under a web that does not yield.
    pub is_web: bool,
}

/// Strength of the web of a bar over one part of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SliderStrength {
    /// Factor of the resistance against a positive and against a negative sum of the moments, >= 0.
    pub factor: [f64; 2],
    /// Growth of each factor with the angle of shear in its direction \[1/rad\].
    pub growth: [f64; 2],
    /// The largest factor that it grows to.
    pub most: f64,
}

impl SliderStrength {
    /// That of an undamaged column at rest, which does not harden.
    pub const UNDAMAGED: Self = Self {
        factor: [1.0; 2],
        growth: [0.0; 2],
        most: f64::INFINITY,
    };

    /// The factor in the direction of `sign`, before the web flows.
    pub fn towards(&self, sign: f64) -> f64 {
        self.factor[usize::from(sign < 0.0)]
    }

    /// The growth of the factor in the direction of `sign` \[1/rad\].
    pub fn growth_towards(&self, sign: f64) -> f64 {
        self.growth[usize::from(sign < 0.0)]
    }

    /// The factor after an angle of shear \[rad\], in its direction.
    pub fn hardened(&self, angle: f64) -> f64 {
        let factor = self.towards(angle);
        (factor + self.growth_towards(angle) * angle.abs()).min(self.most.max(factor))
    }

    /// Whether the web reaches the cap of its hardening within an angle of shear \[rad\].
    pub fn is_capped(&self, angle: f64) -> bool {
        self.towards(angle) + self.growth_towards(angle) * angle.abs() > self.most
    }

    /// The integral of [`SliderStrength::hardened`] over the angle \[rad\].
    pub fn integral(&self, angle: f64) -> f64 {
        let (factor, size) = (self.towards(angle), angle.abs());
        let growth = self.growth_towards(angle);
        if !self.is_capped(angle) {
            return size * (factor + 0.5 * growth * size);
        }
        let until = if growth > 0.0 {
            ((self.most - factor) / growth).max(0.0)
        } else {
            0.0
        };
        until * (factor + 0.5 * growth * until) + self.most.max(factor) * (size - until)
    }
}

/// `v(n)`, the share of its resistance that a normal force `n >= 0`, relative to the squash load, leaves to a web.
pub(crate) fn axial_share(n: f64) -> f64 {
    if n <= FREE_AXIAL {
        1.0
    } else if n < 1.0 {
        4.0 * n * (1.0 - n)
    } else {
        0.0
    }
}

/// `v` and its first two derivatives by `n`, `0 <= n <= 1`.
fn axial_share_jet(n: f64) -> Jet {
    if n <= FREE_AXIAL {
        WHOLE
    } else {
        Jet {
            value: 4.0 * n * (1.0 - n),
            first: 4.0 - 8.0 * n,
            second: -8.0,
        }
    }
}

impl Slider {
    /// The slider of a bar of clear length `length` \[m\] with the rotational stiffness `rotational` \[N m/rad\], whose web
    /// and flanges bear `force` \[N\].
    pub fn of_web(force: f64, length: f64, rotational: &[[f64; 2]; 2]) -> Self {
        let turning = rotational.map(|row| row[0] + row[1]);
        Self {
            resistance: force * length,
            turning,
            stiffness: turning[0] + turning[1],
            is_web: true,
        }
    }

    /// As [`Slider::of_web`], of a bar whose web does not yield, and whose foot slips under a multiple of `force` \[N\].
    pub fn of_foot(force: f64, length: f64, rotational: &[[f64; 2]; 2]) -> Self {
        Self {
            is_web: false,
            ..Self::of_web(force, length, rotational)
        }
    }

    /// The share of the resistance that a normal force `n >= 0`, relative to the squash load, leaves.
    pub fn share(&self, n: f64) -> f64 {
        match self.is_web {
            true => axial_share(n),
            false => 1.0,
        }
    }

    /// Minus its derivative at the squash load.
    pub fn tip_slope(&self) -> f64 {
        match self.is_web {
            true => TIP_SLOPE,
            false => 0.0,
        }
    }

    /// It and its first two derivatives by `n`, `0 <= n <= 1`.
    pub fn share_jet(&self, n: f64) -> Jet {
        match self.is_web {
            true => axial_share_jet(n),
            false => WHOLE,
        }
    }

    /// The largest sum of the end moments \[N m\] of a web whose resistance is `factor` times that of an undamaged one, with the
    /// normal force `n >= 0` relative to the squash load.
    pub fn limit(&self, factor: f64, n: f64) -> f64 {
        self.resistance * factor * self.share(n)
    }

    /// Whether the sum of the end moments \[N m\] exceeds what a web of this strength bears.
    pub fn is_exceeded(&self, moment: [f64; 2], strength: &SliderStrength, n: f64) -> bool {
        let sum = moment[0] + moment[1];
        sum.abs() > self.limit(strength.towards(sum), n) * (1.0 + YIELD_TOLERANCE)
    }

    /// Share of the resistance in the direction of the moments that is used, with `n` as in [`Slider::limit`].
    pub fn utilisation(&self, moment: [f64; 2], strength: &SliderStrength, n: f64) -> f64 {
        let sum = moment[0] + moment[1];
        if sum == 0.0 {
            0.0
        } else {
            sum.abs() / self.limit(strength.towards(sum), n)
        }
    }
}
