//! The residual axial capacity of a column, beside the buckling resistances of the code.

use serde::{Deserialize, Serialize};

use crate::column::{
    BendingAxis, BucklingCurve, BucklingResistance, Capacity, CapacityEnd, CapacityError, Model,
    RolledSection, State, buckling_resistance, capacity, carried_load, effective_length_factor,
};
use crate::parameters::{Parameters, SectionShape};

/// Curve of a section whose dimensions are not known: the less favourable one of rolled sections about their strong axis
/// with flanges up to 100 mm, or up to 40 mm where they are deeper than 1.2 times their width (an assumption).
const CURVE_OF_UNKNOWN_SECTION: BucklingCurve = BucklingCurve::B;

/// Curve of a hollow section: that of cold-formed ones, which is less favourable than that of hot-finished ones (EN 1993-1-1,
/// table 6.2), because it is not known how the section was made.
const CURVE_OF_HOLLOW_SECTION: BucklingCurve = BucklingCurve::C;

/// Residual axial capacity: undamaged against now, and what it means for the load. Nothing that it tells of the column as it is
/// exceeds the same of the new column.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResidualCapacity {
    /// Push-down of the undamaged column.
    pub undamaged: Capacity,
    /// Push-down of the column as it is, with at most the force of the undamaged one.
    pub now: Capacity,
    /// The force of the push-down now over that of the undamaged column, at most 1.
    pub ratio: f64,
    /// `D = 1 - ratio`, not below 0.
    pub damage: f64,
    /// `N`: the load on the column before any help, `top.load`, less what the structure above is proven to take
    /// (`top.redistribution_limit`) \[N\].
    pub carried_load: f64,
    /// `N` of the new column \[N\].
    pub undamaged_load: f64,
    /// What the spring at the top takes of `top.load`, whether the structure above is proven to bear it or not \[N\]; `None` without a
    /// spring, and where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub taken_load: Option<f64>,
    /// `N_u`: `ratio` times the strong-axis resistance \[N\]. The push-down alone is too stiff for slender columns: its ratio is
    /// right, and the code knows the slenderness.
    pub axial_capacity: f64,
    /// `N_u / N`, at most that of the new column; `None` where there is no compressive load.
    pub reserve: Option<f64>,
    /// Resistance of the undamaged column in the plane of the impact, about its strong axis.
    pub strong: BucklingResistance,
    /// About the weak axis; `None` where the dimensions of the section are not known.
    pub weak: Option<BucklingResistance>,
    /// `ratio` times the smaller of both resistances \[N\]: hinges that have flowed about the strong axis have lost their
    /// stiffness about the weak one, too, so that as much of it is taken to be left (an assumption). `None` where the weak axis
    /// is not known.
    pub resistance: Option<f64>,
}

/// What verdicts need of the parameters, beside the push-downs.
#[derive(Debug, Clone, Copy)]
pub(super) struct VerdictBasis {
    resistances: [Option<BucklingResistance>; 2],
    /// What the structure above is proven to take at most \[N\].
    redistribution_limit: f64,
}

/// `N` of the new column and of the column as it is, and what the spring at the top takes of the load of the latter \[N\].
#[derive(Debug, Clone, Copy)]
pub(super) struct VerdictLoads {
    undamaged: f64,
    now: f64,
    taken: Option<f64>,
}

impl VerdictBasis {
    pub fn of(parameters: &Parameters) -> Self {
        Self {
            resistances: buckling_resistances(parameters),
            redistribution_limit: parameters.settings().top.redistribution_limit,
        }
    }

    /// `state` is the column at rest as it is, `None` if it carries nothing: the load is then that of the new column.
    pub fn loads(&self, model: &Model, state: Option<&State>) -> VerdictLoads {
        let undamaged = self.load(model, &State::at_rest(model));
        let (now, taken) = match state {
            Some(state) => (self.load(model, state), taken_load(model, state)),
            None => (undamaged, None),
        };
        VerdictLoads {
            undamaged,
            now,
            taken,
        }
    }

    /// The load at the top, less what the spring takes of it as far as that counts. What the spring adds to it counts wholly.
    fn load(&self, model: &Model, state: &State) -> f64 {
        let taken = taken_load(model, state).unwrap_or(0.0);
        model.properties.top_load - taken.min(self.redistribution_limit)
    }
}

/// What the spring at the top takes of the load, negative where it presses on the column \[N\]; `None` without a spring, so that the load
/// has no round-off of the equilibrium.
fn taken_load(model: &Model, state: &State) -> Option<f64> {
    let properties = &model.properties;
    (properties.top_spring_stiffness != 0.0)
        .then(|| properties.top_load - carried_load(model, state))
}

impl ResidualCapacity {
    /// Puts the push-downs of the undamaged column and of the column as it is into relation with its load. `state` is the column
    /// at rest as it is, `None` if it carries nothing.
    #[must_use]
    pub fn new(
        parameters: &Parameters,
        model: &Model,
        state: Option<&State>,
        undamaged: Capacity,
        now: Capacity,
    ) -> Self {
        let basis = VerdictBasis::of(parameters);
        Self::with(&basis, basis.loads(model, state), undamaged, now)
    }

    /// As [`ResidualCapacity::new`], with what has been computed before.
    pub(super) fn with(
        basis: &VerdictBasis,
        loads: VerdictLoads,
        undamaged: Capacity,
        now: Capacity,
    ) -> Self {
        let [strong, weak] = basis.resistances;
        let strong = strong.expect("the strong axis needs no dimensions");
        // A push-down of a damaged column may carry more than that of the new one, because its steel has hardened or its bow
        // opposes the imperfection. Nobody may rely on it.
        let now = match now.force > undamaged.force {
            true => Capacity {
                force: undamaged.force,
                ..now
            },
            false => now,
        };
        let ratio = if undamaged.force > 0.0 {
            now.force / undamaged.force
        } else {
            0.0
        };
        let remaining = Self {
            undamaged,
            now,
            ratio,
            damage: (1.0 - ratio).max(0.0),
            carried_load: loads.now,
            undamaged_load: loads.undamaged,
            taken_load: loads.taken,
            axial_capacity: ratio * strong.force,
            reserve: None,
            strong,
            weak,
            resistance: weak.map(|weak| ratio * weak.force.min(strong.force)),
        };
        remaining.counting(loads.now)
    }

    /// The same, where `N` counts with this load at least \[N\].
    pub(super) fn counting(&self, least: f64) -> Self {
        let counted = Self {
            carried_load: self.carried_load.max(least),
            ..*self
        };
        let reserve = counted.times_the_load(counted.axial_capacity, counted.strong.force);
        Self {
            reserve: (counted.carried_load > 0.0).then_some(reserve),
            ..counted
        }
    }

    /// The same with the push-downs of another model \[N\], which bear on the same load and the same resistances.
    pub(super) fn by_another_model(&self, [undamaged, now]: [f64; 2]) -> Self {
        let capacity = |force: f64| Capacity {
            force,
            ..Capacity::none(CapacityEnd::NoEquilibrium)
        };
        let basis = VerdictBasis {
            resistances: [Some(self.strong), self.weak],
            redistribution_limit: 0.0,
        };
        let loads = VerdictLoads {
            undamaged: self.undamaged_load,
            now: self.carried_load,
            // How far its top is lowered is not known.
            taken: None,
        };
        Self::with(&basis, loads, capacity(undamaged), capacity(now))
    }

    /// `resistance / N`, at most that of the new column; `None` where there is no compressive load or the weak axis is not
    /// known.
    #[must_use]
    pub fn resistance_over_load(&self) -> Option<f64> {
        let (resistance, weak) = (self.resistance?, self.weak?);
        let of_new = weak.force.min(self.strong.force);
        (self.carried_load > 0.0).then(|| self.times_the_load(resistance, of_new))
    }

    /// What the column resists about the weaker of its known axes \[N\].
    pub(super) fn least_resistance(&self) -> f64 {
        self.resistance
            .map_or(self.axial_capacity, |it| it.min(self.axial_capacity))
    }

    /// Whether the weak axis governs; `None` where it is not known.
    #[must_use]
    pub fn weak_axis_governs(&self) -> Option<bool> {
        self.weak.map(|weak| weak.force < self.strong.force)
    }

    /// How many times its load a column resists that resists `now`; at most as often as the new one, which resists `of_new`.
    fn times_the_load(&self, now: f64, of_new: f64) -> f64 {
        let (times, new) = (now / self.carried_load, of_new / self.undamaged_load);
        match self.undamaged_load > 0.0 && times > new {
            true => new,
            false => times,
        }
    }

    /// Computes both push-downs. `state` is the column at rest as it is, `None` if it has collapsed or is fractured: it then
    /// carries nothing.
    ///
    /// # Errors
    /// An imperfection out of its range, which validation of the parameters excludes.
    pub fn compute(
        parameters: &Parameters,
        model: &Model,
        state: Option<&State>,
    ) -> Result<Self, CapacityError> {
        let imperfection = imperfection(parameters);
        let undamaged = capacity(model, &State::at_rest(model), imperfection)?;
        let now = match state {
            Some(state) => capacity(model, state, imperfection)?,
            None => Capacity::none(CapacityEnd::NoEquilibrium),
        };
        Ok(Self::new(parameters, model, state, undamaged, now))
    }
}

/// Dimensions of a named section whose properties are not overridden.
#[must_use]
pub fn section_dimensions(parameters: &Parameters) -> Option<RolledSection> {
    parameters.section_dimensions()
}

/// Dimensions of a section whose plates are given by numbers \[m\]; `None` where one of them is not given (0) or they do not
/// fit into one another. Its fillets are not known and count as none, so that its plates are taken as more slender than they
/// are.
#[must_use]
pub fn dimensions_by_numbers(
    height: f64,
    width: f64,
    web_thickness: f64,
    flange_thickness: f64,
) -> Option<RolledSection> {
    let given = [height, width, web_thickness, flange_thickness];
    let fits = height > 2.0 * flange_thickness && width > web_thickness;
    (fits && given.into_iter().all(|it| it > 0.0)).then_some(RolledSection {
        depth: height,
        width,
        web_thickness,
        flange_thickness,
        root_radius: 0.0,
    })
}

/// The buckling curve about an axis; about the weak one `None` where the dimensions of the section are not known.
#[must_use]
pub fn buckling_curve(parameters: &Parameters, axis: BendingAxis) -> Option<BucklingCurve> {
    match section_dimensions(parameters) {
        Some(section) => Some(BucklingCurve::of_rolled(
            &section,
            parameters.steel().yield_strength,
            axis,
        )),
        None => (axis == BendingAxis::Strong).then_some(curve_by_numbers(parameters)),
    }
}

/// The buckling curve about the strong axis of a section whose dimensions are not known.
fn curve_by_numbers(parameters: &Parameters) -> BucklingCurve {
    match parameters.settings().section.shape {
        SectionShape::IOrH => CURVE_OF_UNKNOWN_SECTION,
        SectionShape::RectangularHollow | SectionShape::CircularHollow => CURVE_OF_HOLLOW_SECTION,
    }
}

/// `e0` \[m\]: as given, or by the buckling curve about the strong axis.
#[must_use]
pub fn imperfection(parameters: &Parameters) -> f64 {
    let given = parameters.settings().capacity.imperfection;
    if given > 0.0 {
        return given;
    }
    let curve = buckling_curve(parameters, BendingAxis::Strong);
    let curve = curve.unwrap_or_else(|| curve_by_numbers(parameters));
    curve.relative_bow() * height(parameters)
}

/// Resistances of the undamaged column about the strong and the weak axis, with the buckling lengths that are given, or those of
/// its supports, which are assumed to hold both axes alike.
#[must_use]
pub fn buckling_resistances(parameters: &Parameters) -> [Option<BucklingResistance>; 2] {
    let p = parameters.column_properties();
    let height = height(parameters);
    let given = &parameters.settings().capacity;
    let resistance = |axis, bending_stiffness: f64| {
        let given = match axis {
            BendingAxis::Strong => given.buckling_factor_strong,
            BendingAxis::Weak => given.buckling_factor_weak,
        };
        let factor = match given > 0.0 {
            true => given,
            false => effective_length_factor(p.base, p.top, bending_stiffness, height),
        };
        buckling_curve(parameters, axis).map(|curve| {
            buckling_resistance(
                curve,
                p.resistance_axial,
                bending_stiffness,
                factor * height,
            )
        })
    };
    let weak = section_dimensions(parameters).and_then(|section| {
        let stiffness = parameters.steel().young_modulus * section.weak_second_moment();
        resistance(BendingAxis::Weak, stiffness)
    });
    [resistance(BendingAxis::Strong, p.bending_stiffness), weak]
}

fn height(parameters: &Parameters) -> f64 {
    let geometry = &parameters.settings().geometry;
    geometry.length_below + geometry.length_above
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Value;

    /// EN 1993-1-1, table 6.2: cold-formed hollow sections have curve c about any axis, and hot-finished ones a more favourable one.
    #[test]
    fn a_hollow_section_has_the_curve_of_cold_formed_ones() {
        let curve = |shape: &str| {
            let by_numbers = [
                ("section.name", Value::from("")),
                ("section.shape", shape.into()),
                ("section.area", 65.7e-4.into()),
                ("section.second_moment", 3598e-8.into()),
                ("section.mass_per_length", 51.6.into()),
                ("section.height", 0.2191.into()),
                ("section.web_thickness", 0.01.into()),
                ("resistance.moment", 1.555e5.into()),
                ("softening.model", "none".into()),
            ];
            let column = Parameters::default().with_changes(by_numbers);
            let column = column.expect("consistent");
            assert_eq!(buckling_curve(&column, BendingAxis::Weak), None);
            buckling_curve(&column, BendingAxis::Strong)
        };
        assert_eq!(curve("circular_hollow"), Some(BucklingCurve::C));
        assert_eq!(curve("i_or_h"), Some(BucklingCurve::B));
    }
}
