//! The rows of the table about the direction of a hit and the fibre beam, and what follows from them.

use super::parameter::{Admissible, Applies, DefaultValue, Parameter};
use super::settings::{BeamMode, BeamSettings, BeamSteel, BowAxes, TorsionModel};
use super::value::readable;
use crate::column::share_in_plane;

/// Numbers of the beam that it chooses itself.
const AUTOMATIC: &str = "automatic";

const fn row(
    name: &'static str,
    unit: &'static str,
    default: DefaultValue,
    admissible: Admissible,
    meaning: &'static str,
) -> Parameter {
    Parameter {
        name,
        unit,
        default,
        admissible,
        applies: Applies::AtOnce,
        meaning,
    }
}

/// From where the vehicle comes.
pub(super) const DIRECTION: Parameter = row(
    "impact.direction",
    "rad",
    DefaultValue::Double(0.0),
    Admissible::Real {
        min: -1000.0,
        max: 1000.0,
    },
    "phi: direction of travel of the vehicle in (-pi, pi]; 0 bends the column about its strong axis, positive turns towards the positive \
     weak-axis direction. The two bars are plane and take the component of the motion in their plane, v cos phi; the fibre beam \
     takes all of it. A number beyond (-pi, pi] is no direction: the two bars then take the whole velocity, and there is no second \
     opinion",
);

pub(super) const MODE: Parameter = row(
    "beam.mode",
    "",
    DefaultValue::Text("second_opinion"),
    Admissible::Choice(&["off", "second_opinion", "governing"]),
    "whether the fibre beam computes impacts, too: in `simulate` and nodes, and in maps and risk studies with `--model`. second_opinion: \
     its verdict counts where the two models differ (docs/second_opinion.md lists when); governing: it always counts. The more severe \
     action of the two models then applies",
);

pub(super) const ELEMENTS: Parameter = row(
    "beam.elements",
    "",
    DefaultValue::Integer(0),
    Admissible::Integer { min: 0, max: 200 },
    "elements of the fibre beam along the column; 0: automatic",
);

pub(super) const FIBRES: Parameter = row(
    "beam.fibres",
    "",
    DefaultValue::Integer(0),
    Admissible::Integer { min: 0, max: 64 },
    "layers of fibres of the web, and at least as many fibres across a flange; 0: automatic",
);

pub(super) const DT: Parameter = row(
    "beam.dt",
    "s",
    DefaultValue::Double(0.0),
    Admissible::WholeNanoseconds {
        min: 1e-6,
        max: 1e-3,
        zero: AUTOMATIC,
    },
    "time step of the fibre beam",
);

pub(super) const SHEAR: Parameter = row(
    "beam.shear",
    "",
    DefaultValue::Bool(true),
    Admissible::Switch,
    "whether the web of the fibre beam deforms and yields in shear",
);

pub(super) const TORSION: Parameter = row(
    "beam.torsion",
    "",
    DefaultValue::Text("warping"),
    Admissible::Choice(&["warping", "saint_venant", "none"]),
    "how the fibre beam resists twist. warping: St Venant's torsion and restrained warping; saint_venant: that torsion alone; none: the \
     twist is suppressed",
);

pub(super) const RESIDUAL_STRESS: Parameter = row(
    "beam.residual_stress",
    "",
    DefaultValue::Bool(true),
    Admissible::Switch,
    "whether the fibre beam has the residual stresses of rolling (ECCS)",
);

pub(super) const BOW: Parameter = row(
    "beam.bow",
    "m",
    DefaultValue::Double(-1.0),
    Admissible::Real {
        min: -1.0,
        max: 10.0,
    },
    "initial bow of the fibre beam about each axis of `beam.bow_axes`, at most a twentieth of its height; 0: straight; negative: a \
     thousandth of the height",
);

pub(super) const BOW_AXES: Parameter = row(
    "beam.bow_axes",
    "",
    DefaultValue::Text("both"),
    Admissible::Choice(&["both", "strong", "weak"]),
    "axes about which the fibre beam is bowed before the impact, and about which its capacity counts",
);

pub(super) const STEEL: Parameter = row(
    "beam.steel",
    "",
    DefaultValue::Text("bilinear"),
    Admissible::Choice(&["bilinear", "plateau"]),
    "stress of the steel of the fibre beam over its strain. bilinear: it hardens from the first yield on, with `hardening.ratio`; \
     plateau: it yields at the same stress at first and then hardens up to the tensile strength of `steel.grade` (EN 1993-1-14, after \
     Yun and Gardner 2017)",
);

impl Default for BeamSettings {
    /// The defaults of the table.
    fn default() -> Self {
        Self {
            mode: BeamMode::SecondOpinion,
            elements: 0,
            fibres: 0,
            dt: 0.0,
            shear: true,
            torsion: TorsionModel::Warping,
            residual_stress: true,
            bow: -1.0,
            bow_axes: BowAxes::Both,
            steel: BeamSteel::Bilinear,
        }
    }
}

impl BeamSettings {
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// What the two bars see of a vehicle that travels in this direction \[rad\]; `None` where they see all of it.
///
/// ```
/// use column_twin::parameters::component_in_words;
///
/// let words = component_in_words(45.0_f64.to_radians()).expect("out of the plane");
/// assert_eq!(
///     words,
///     "the vehicle travels at 45 degrees to the plane of the two bars, which see the component in it, 0.7071 of the whole"
/// );
/// for in_plane in [0.0, std::f64::consts::PI] {
///     assert_eq!(component_in_words(in_plane), None);
/// }
/// ```
#[must_use]
pub fn component_in_words(direction: f64) -> Option<String> {
    let leaves_the_plane = share_in_plane(direction) < 1.0;
    leaves_the_plane.then(|| {
        let rounded = |value: f64| readable((value * 1e4).round() / 1e4);
        format!(
            "the vehicle travels at {} degrees to the plane of the two bars, which see the component in it, {} of the whole",
            rounded(direction.to_degrees()),
            rounded(share_in_plane(direction)),
        )
    })
}
