//! What can be observed of a column at an instant, and at which hinges and webs: one table of quantities and one of places.
//! Columns of histories, figures and plots select from them.

use std::fmt::{self, Display, Formatter};

use crate::column::{
    HINGE_NAMES, HINGES, HingeSample, HingeState, MAX_MASSES, Phase, Sample, VehicleSample,
    WEB_NAMES, WEBS,
};

/// The end of a bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BarEnd {
    /// Towards the base.
    Lower,
    /// Towards the top.
    Upper,
    /// Neither: the whole bar.
    Whole,
}

/// Where a hinge, or the web of a bar, is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Its name in the model.
    pub name: &'static str,
    /// Where it is in the column.
    pub words: &'static str,
    /// The same in a sentence.
    pub in_sentence: &'static str,
    /// Its bar: 0 is the lower one, 1 the upper one.
    pub bar: u8,
    /// Its end of the bar.
    pub end: BarEnd,
}

const BELOW: [&str; 2] = ["below the impact", "below the impact point"];
const ABOVE: [&str; 2] = ["above the impact", "above the impact point"];

/// The hinges, in the order of [`HINGE_NAMES`].
pub const HINGE_PLACES: [Place; HINGES] = [
    place(HINGE_NAMES[0], BELOW, 0, BarEnd::Upper),
    place(HINGE_NAMES[1], ABOVE, 1, BarEnd::Lower),
    place(HINGE_NAMES[2], ["top", "at the top"], 1, BarEnd::Upper),
    place(HINGE_NAMES[3], ["base", "at the base"], 0, BarEnd::Lower),
];

/// The numbers of the hinges, from the base upwards.
#[must_use]
pub fn hinges_upwards() -> [usize; HINGES] {
    let mut numbers = std::array::from_fn(|number| number);
    numbers.sort_by_key(|number: &usize| {
        let Place { bar, end, .. } = HINGE_PLACES[*number];
        (bar, end == BarEnd::Upper)
    });
    numbers
}

/// The webs, in the order of [`WEB_NAMES`].
pub const WEB_PLACES: [Place; WEBS] = [
    place(WEB_NAMES[0], BELOW, 0, BarEnd::Whole),
    place(WEB_NAMES[1], ABOVE, 1, BarEnd::Whole),
];

const fn place(
    name: &'static str,
    [words, in_sentence]: [&'static str; 2],
    bar: u8,
    end: BarEnd,
) -> Place {
    Place {
        name,
        words,
        in_sentence,
        bar,
        end,
    }
}

/// Such as `1a (below the impact)`.
impl Display for Place {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.name, self.words)
    }
}

impl Place {
    /// Its joint, of a web the lower one of its bar: 0 is the base, 1 the impact point, 2 the top.
    #[must_use]
    pub fn joint(&self) -> usize {
        usize::from(self.bar) + usize::from(self.end == BarEnd::Upper)
    }
}

/// What is measured, which says the units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // words of mechanics
pub enum Kind {
    Time,
    Length,
    Angle,
    Velocity,
    Force,
    Moment,
    Impulse,
    Energy,
    Number,
}

impl Kind {
    /// The SI unit as it ends the name of a column, the unit of a plot, and the factor from one to the other.
    #[must_use]
    pub const fn units(self) -> (&'static str, &'static str, f64) {
        match self {
            Self::Time => ("_s", "s", 1.0),
            Self::Length => ("_m", "mm", 1e3),
            Self::Angle => ("_rad", "rad", 1.0),
            Self::Velocity => ("_m_s", "m/s", 1.0),
            Self::Force => ("_N", "kN", 1e-3),
            Self::Moment => ("_Nm", "kN m", 1e-3),
            Self::Impulse => ("_Ns", "N s", 1.0),
            Self::Energy => ("_J", "kJ", 1e-3),
            Self::Number => ("", "", 1.0),
        }
    }
}

/// What has a quantity, with its value in SI units.
#[derive(Debug, Clone, Copy)]
enum Of {
    /// The column with its impactor.
    Column(fn(&Sample) -> f64),
    /// Every hinge.
    Hinges(fn(&HingeSample) -> f64),
    /// Both bars, the lower one first; of a web that does not yield in shear it is 0.
    Bars(fn(&Sample) -> [f64; WEBS]),
    /// Every mass of a deformable vehicle with the spring in front of it, front first.
    Masses(fn(&VehicleSample) -> [f64; MAX_MASSES]),
    /// A deformable vehicle.
    Vehicle(fn(&VehicleSample) -> f64),
}

/// A quantity that can be observed.
#[derive(Debug, Clone, Copy)]
pub struct Observable {
    /// Empty for what follows from other columns of a history.
    name: &'static str,
    /// What is measured.
    pub kind: Kind,
    of: Of,
    in_figures: &'static str,
    in_plots: &'static str,
}

// Name in histories, kind, what has it, value; meaning; names in figures and in plots, where it has them.
macro_rules! observables {
    ($($id:ident $name:literal $kind:ident $of:ident $value:expr, $meaning:literal $(, $figures:literal, $plots:literal)?;)*) => {
        $(
            #[doc = $meaning]
            pub const $id: Observable = Observable {
                name: $name,
                kind: Kind::$kind,
                of: Of::$of($value),
                in_figures: concat!($($figures)?),
                in_plots: concat!($($plots)?),
            };
        )*
        const TABLE: &[Observable] = &[$($id),*];
    };
}

observables! {
    TIME "t" Time Column |it| it.time, "Time since the event.";
    V1 "v1" Length Column |it| it.v1, "Displacement of the impact point.", "v₁ impact point", "column";
    U1 "u1" Length Column |it| it.u1, "Axial displacement of the impact point, down.", "u₁ impact point", "at the impact";
    BETA1 "beta1" Angle Column |it| it.beta1, "Rotation of the impact point.";
    U2 "u2" Length Column |it| it.u2, "Axial displacement of the top, down.", "u₂ top", "at the top";
    IMPACTOR "vc" Length Column |it| it.impactor_position, "Position of the impactor.", "v_c impactor", "vehicle";
    V1_RATE "v1dot" Velocity Column |it| it.v1_rate, "Rate of `v1`.";
    U1_RATE "u1dot" Velocity Column |it| it.u1_rate, "Rate of `u1`.";
    U2_RATE "u2dot" Velocity Column |it| it.u2_rate, "Rate of `u2`.";
    IMPACTOR_VELOCITY "vcdot" Velocity Column |it| it.impactor_velocity, "Velocity of the impactor.";
    GAP "gap" Length Column |it| it.gap, "Distance between impactor and column.";
    NORMAL_FORCE "N" Force Bars |it| it.normal_forces(), "Normal force, tension positive.", "N", "";
    CONTACT_FORCE "contact_force" Force Column |it| it.contact_force, "Smooth contact force.", "contact force", "contact force";
    IMPACT_IMPULSE "impact_impulse" Impulse Column |it| it.impact_impulse,
        "Impulse of an instant.", "impact impulse (instantaneous impulse, not to scale)", "impact impulse (not to scale)";
    IMPULSE "impulse" Impulse Column |it| it.impulse, "Impulse since the event, impact impulses included.";
    KINETIC_ENERGY "kinetic_energy" Energy Column |it| it.kinetic_energy, "Of column and impactor.", "kinetic", "motion";
    ELASTIC_ENERGY "elastic_energy" Energy Column |it| it.elastic_energy, "Of the hinges and the top spring.", "elastic", "";
    PLASTIC_WORK "plastic_work" Energy Column |it| it.plastic_work, "Work dissipated in the hinges.", "plastic work", "plastic work";
    IMPACT_LOSS "impact_loss" Energy Column |it| it.impact_loss,
        "Energy lost in impact impulses.", "lost in impact impulses", "impact impulses";
    DAMPING_WORK "damping_work" Energy Column |it| it.damping_work, "Work of the damping.", "damping", "damping";
    LOAD_WORK "load_work" Energy Column |it| it.load_work, "Work of the load.";
    LEDGER_RESIDUAL "ledger_residual" Energy Column |it| it.ledger_residual, "Error of the energy balance.";
    IN_CONTACT "in_contact" Number Column |it| f64::from(u8::from(it.phase == Phase::Contact)), "1 in contact, 0 otherwise.";
    MOMENT "M" Moment Hinges |it| it.moment, "Bending moment.", "hinge", "hinge";
    ROTATION "theta" Angle Hinges |it| it.rotation, "Rotation.";
    ELONGATION "delta" Length Hinges |it| it.elongation, "Elongation.";
    PLASTIC_ROTATION "theta_p" Angle Hinges |it| it.plastic_rotation, "Plastic rotation.";
    PLASTIC_ELONGATION "delta_p" Length Hinges |it| it.plastic_elongation, "Plastic elongation.";
    UTILISATION "utilisation" Number Hinges |it| it.utilisation, "1 on the yield surface.";
    DYNAMIC_FACTOR "dynamic_factor" Number Hinges |it| it.dynamic_factor, "Dynamic increase factor of the resistances.";
    STATE "state" Number Hinges |it| state_number(it.state), "0 elastic, 1 plastic, 2 unloaded.";
    SHEAR_FORCE "V" Force Bars |it| it.webs.map(|it| it.shear_force), "Shear force.";
    SHEAR_ANGLE "gamma_p" Angle Bars |it| it.webs.map(|it| it.plastic_angle), "Plastic shear angle.";
    SHEAR_UTILISATION "shear_utilisation" Number Bars |it| it.webs.map(|it| it.utilisation), "1 where the web yields.";
    SHEAR_FACTOR "shear_dynamic_factor" Number Bars |it| it.webs.map(|it| it.dynamic_factor), "Dynamic increase factor of the resistance.";
    SHEAR_STATE "shear_state" Number Bars |it| it.webs.map(|it| state_number(it.state)), "0 elastic, 1 plastic, 2 unloaded.";
    BASE_SHEAR "base_shear" Force Column |it| it.base.shear, "Shear force upon the base, with the inertia of the lower bar.";
    BASE_MOMENT "base_moment" Moment Column |it| it.base.moment, "Moment upon the base.";
    BASE_NORMAL_FORCE "base_normal_force" Force Column |it| it.base.normal_force, "Force along the column upon the base.";
    CRUSH "crush" Length Masses |it| it.crush, "Crush of a spring; negative where it is open.", "crush d", "";
    PERMANENT_CRUSH "permanent_crush" Length Masses |it| it.permanent_crush, "Permanent crush of a spring.";
    SPRING_FORCE "crush_force" Force Masses |it| it.force, "Force of a spring.", "force of the spring", "spring";
    DISSIPATED "vehicle_dissipated" Energy Masses |it| it.dissipated, "Energy dissipated in a spring.";
    MASS_VELOCITY "vehicle_velocity" Velocity Masses |it| it.velocity, "Velocity of a mass.";
    SPRING_ENERGY "vehicle_elastic_energy" Energy Vehicle |it| it.elastic_energy,
        "Elastic energy of all springs.", "elastic in the vehicle", "";
    OPEN_OR_CRUSHED "" Length Masses |it| it.crush.map(|it| it.max(0.0)), "Crush of a spring; 0 where it is open.", "", "spring";
    CRUSH_WORK "" Energy Column |it| it.vehicle.dissipated.iter().sum(), "Dissipated in all springs.", "crush of the vehicle", "";
    CRUSH_ENERGY "" Energy Column |it| it.vehicle.dissipated.iter().sum::<f64>() + it.vehicle.elastic_energy,
        "Dissipated and stored in all springs.", "", "vehicle's crush";
    POTENTIAL_ENERGY "" Energy Column |it| it.elastic_energy - it.load_work, "Of the column and the load.", "", "elastic - load";
}

/// 0 elastic, 1 plastic, 2 unloaded.
fn state_number(state: HingeState) -> f64 {
    match state {
        HingeState::Elastic => 0.0,
        HingeState::Plastic => 1.0,
        HingeState::Unloaded => 2.0,
    }
}

/// The columns of a history, in their order, where a vehicle of so many masses hits the column, 0 for a rigid one. Their names are a
/// stable interface, and among them are those of `tests/data/heb220_ellipse.csv`.
pub fn history(masses: usize) -> impl Iterator<Item = (&'static Observable, usize)> {
    each(TABLE, masses).filter(|(it, _)| !it.name.is_empty())
}

/// Each value of these observables: which of them, and of which hinge, bar or mass.
pub fn each(what: &[Observable], masses: usize) -> impl Iterator<Item = (&Observable, usize)> {
    what.iter().flat_map(move |it| {
        let count = match it.of {
            Of::Column(_) => 1,
            Of::Hinges(_) => HINGES,
            Of::Bars(_) => WEBS,
            Of::Masses(_) => masses,
            Of::Vehicle(_) => masses.min(1),
        };
        (0..count).map(move |index| (it, index))
    })
}

impl Observable {
    /// The value with this index, in the SI unit; the index is 0 where there is only one.
    #[must_use]
    pub fn value(&self, sample: &Sample, index: usize) -> f64 {
        match self.of {
            Of::Column(value) => value(sample),
            Of::Hinges(value) => value(&sample.hinges[index]),
            Of::Bars(values) => values(sample)[index],
            Of::Masses(values) => values(&sample.vehicle)[index],
            Of::Vehicle(value) => value(&sample.vehicle),
        }
    }

    /// Name of its column in a history.
    #[must_use]
    pub fn in_histories(&self, index: usize) -> String {
        let (unit, ..) = self.kind.units();
        let part = match self.of {
            Of::Column(_) | Of::Vehicle(_) => return format!("{}{unit}", self.name),
            Of::Hinges(_) => HINGE_NAMES[index],
            Of::Bars(_) => WEB_NAMES[index],
            Of::Masses(_) => ["1", "2", "3"][index],
        };
        match unit {
            "" => format!("{}_{part}", self.name),
            _ => format!("{}{part}{unit}", self.name),
        }
    }

    /// Name of its curve in a figure, with symbols; empty where no figure names it.
    #[must_use]
    pub fn in_figures(&self, index: usize) -> String {
        let symbol = self.in_figures;
        match self.of {
            Of::Hinges(_) => {
                let Place { name, words, .. } = HINGE_PLACES[index];
                format!("{symbol} {name} {words}")
            }
            Of::Bars(_) => {
                let Place {
                    name, words, bar, ..
                } = WEB_PLACES[index];
                let hinges = HINGE_PLACES.iter().filter(|it| it.bar == bar);
                let hinges: Vec<_> = hinges.map(|it| it.name).collect();
                format!("{symbol}_{name} {words} (hinges {})", hinges.join(", "))
            }
            _ => symbol.to_owned(),
        }
    }

    /// Name of its curve in a plot, in plain words; empty where no plot shows it.
    #[must_use]
    pub fn in_plots(&self, index: usize) -> String {
        let words = self.in_plots;
        match self.of {
            Of::Hinges(_) => format!("{words} {}", HINGE_NAMES[index]),
            Of::Bars(_) => WEB_PLACES[index].words.to_owned(),
            Of::Masses(_) if index == 0 => format!("{words} 1, front"),
            Of::Masses(_) => format!("{words} {}", index + 1),
            _ => words.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_column_of_a_history_has_a_name_of_its_own() {
        for masses in 0..=MAX_MASSES {
            let names = history(masses).map(|(it, index)| it.in_histories(index));
            let distinct: BTreeSet<String> = names.collect();
            assert_eq!(distinct.len(), history(masses).count());
            for last in ["crush3_m", "vehicle_velocity3_m_s"] {
                assert_eq!(distinct.contains(last), masses == MAX_MASSES, "{last}");
            }
        }
    }
}
