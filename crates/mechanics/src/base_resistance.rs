//! What the base of a column bears, moment with normal force and shear, whatever connects it.

use serde::{Deserialize, Serialize};

/// What fails first at a base.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BaseFailure {
    /// Anchors that are sheared off.
    AnchorsInShear,
    /// Anchors that are fractured.
    AnchorsInTension,
    /// The plate bends between anchors and flange.
    Plate,
    /// The concrete under a flange is crushed.
    Concrete,
}

impl BaseFailure {
    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::AnchorsInShear => "anchors in shear",
            Self::AnchorsInTension => "anchors in tension",
            Self::Plate => "bending of the base plate",
            Self::Concrete => "concrete under the base plate",
        }
    }
}

/// What a base plate bears and how stiff it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BaseResistance {
    /// `T_R` of one line of anchors \[N\].
    pub tension: f64,
    /// What limits it: anchors or plate.
    pub tension_limit: BaseFailure,
    /// `C_R` under one flange \[N\].
    pub compression: f64,
    /// `z_T` of the anchors and `z_C` of the flanges \[m\].
    pub lever: [f64; 2],
    /// Shear of all anchors \[N\].
    pub anchor_shear: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// `S_j,ini` \[N m/rad\].
    pub stiffness: f64,
    /// Slip of the base at which its anchors are sheared off \[m\], >= 0; 0 for no limit.
    #[serde(default)]
    pub ultimate_slip: f64,
    /// Plastic elongation of an anchor at which it is fractured \[m\], >= 0; 0 for no limit, as where the plate yields first.
    #[serde(default)]
    pub ultimate_elongation: f64,
}

impl BaseResistance {
    /// The four lines of `M(N)` \[N m\] for a normal force \[N\], tension positive, with what limits each.
    fn lines(&self, normal_force: f64) -> [(f64, BaseFailure); 4] {
        let ([anchors, flange], n) = (self.lever, -normal_force);
        let (t, c) = (self.tension, self.compression);
        [
            (anchors * (2.0 * t + n), self.tension_limit),
            (t * (anchors + flange) + n * flange, self.tension_limit),
            (c * (anchors + flange) - n * anchors, BaseFailure::Concrete),
            (flange * (2.0 * c - n), BaseFailure::Concrete),
        ]
    }

    /// `M_j(N)` \[N m\] for a normal force \[N\], tension positive; concave, 0 where the base cannot bear the normal force.
    #[must_use]
    pub fn moment(&self, normal_force: f64) -> f64 {
        let least = self
            .lines(normal_force)
            .into_iter()
            .map(|(moment, _)| moment);
        least.fold(f64::INFINITY, f64::min).max(0.0)
    }

    /// What limits the moment at a normal force \[N\], tension positive.
    #[must_use]
    pub fn moment_limit(&self, normal_force: f64) -> BaseFailure {
        let [first, rest @ ..] = self.lines(normal_force);
        let least = rest.into_iter().fold(
            first,
            |least, next| if next.0 < least.0 { next } else { least },
        );
        least.1
    }

    /// Shear resistance \[N\] at a normal force \[N\], tension positive: anchors, and the friction of a compressed base.
    #[must_use]
    pub fn shear(&self, normal_force: f64) -> f64 {
        self.anchor_shear + self.friction * (-normal_force).max(0.0)
    }

    /// The same base without a limit of its deformation.
    #[must_use]
    pub fn without_limits(self) -> Self {
        Self {
            ultimate_slip: 0.0,
            ultimate_elongation: 0.0,
            ..self
        }
    }

    /// By how much a plastic rotation of the base \[rad\] has stretched the anchors of the side that it lifts, at a normal force
    /// \[N\], tension positive; 0 where something else than anchors gives way. The plate turns about the flange that presses on
    /// the concrete.
    pub(crate) fn elongation(&self, rotation: f64, normal_force: f64) -> f64 {
        match self.moment_limit(normal_force) {
            BaseFailure::AnchorsInTension => rotation.abs() * (self.lever[0] + self.lever[1]),
            _ => 0.0,
        }
    }

    /// The largest tension that all anchors bear \[N\].
    #[must_use]
    pub fn uplift(&self) -> f64 {
        2.0 * self.tension
    }
}
