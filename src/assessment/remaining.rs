//! The remaining axial capacity of a column, beside the buckling resistances of the code.

use serde::{Deserialize, Serialize};

use crate::column::{
    BendingAxis, BucklingCurve, BucklingResistance, Capacity, CapacityEnd, CapacityError, Model,
    RolledSection, State, buckling_resistance, capacity, carried_load, effective_length_factor,
};
use crate::parameters::Parameters;

/// Curve of a section whose dimensions are not known: the less favourable one of rolled sections about their strong axis
/// with flanges up to 100 mm, or up to 40 mm where they are deeper than 1.2 times their width (an assumption).
const CURVE_OF_UNKNOWN_SECTION: BucklingCurve = BucklingCurve::B;

/// Remaining axial capacity: virgin against now, and what it means for the load.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RemainingCapacity {
    /// `N_u` of the virgin column.
    pub virgin: Capacity,
    /// `N_u` of the column as it is.
    pub now: Capacity,
    /// `N_u` now over `N_u` virgin.
    pub ratio: f64,
    /// `D = 1 - ratio`, not below 0.
    pub damage: f64,
    /// `N_Ed`: the compressive force that the column carries, without the share of the spring at its top \[N\].
    pub carried_load: f64,
    /// `N_u / N_Ed`; `None` where the column carries no compressive force.
    pub reserve: Option<f64>,
    /// Resistance of the virgin column in the plane of the impact, about its strong axis.
    pub strong: BucklingResistance,
    /// About the weak axis; `None` where the dimensions of the section are not known.
    pub weak: Option<BucklingResistance>,
    /// The smaller of `ratio` times the strong-axis resistance and the weak-axis resistance \[N\]: the model is plane, so
    /// that the weak axis keeps its virgin value. `None` where that is not known.
    pub resistance: Option<f64>,
}

impl RemainingCapacity {
    /// Puts the capacities of the virgin column and of the column as it is into relation with the load that it carries
    /// (`N_Ed`, see [`carried_load`]).
    #[must_use]
    pub fn new(parameters: &Parameters, virgin: Capacity, now: Capacity, carried: f64) -> Self {
        Self::with_resistances(buckling_resistances(parameters), virgin, now, carried)
    }

    /// As [`RemainingCapacity::new`], with the [`buckling_resistances`] of the virgin column.
    pub(super) fn with_resistances(
        [strong, weak]: [Option<BucklingResistance>; 2],
        virgin: Capacity,
        now: Capacity,
        carried: f64,
    ) -> Self {
        let ratio = if virgin.force > 0.0 {
            now.force / virgin.force
        } else {
            0.0
        };
        let strong = strong.expect("the strong axis needs no dimensions");
        Self {
            virgin,
            now,
            ratio,
            damage: (1.0 - ratio).max(0.0),
            carried_load: carried,
            reserve: (carried > 0.0).then(|| now.force / carried),
            strong,
            weak,
            resistance: weak.map(|weak| weak.force.min(ratio * strong.force)),
        }
    }

    /// Computes both capacities. `state` is the column at rest as it is, `None` if it has collapsed or is severed: it then
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
        let virgin_state = State::at_rest(model);
        let virgin = capacity(model, &virgin_state, imperfection)?;
        let (now, carried) = match state {
            Some(state) => (
                capacity(model, state, imperfection)?,
                carried_load(model, state),
            ),
            None => (
                Capacity::none(CapacityEnd::NoEquilibrium),
                carried_load(model, &virgin_state),
            ),
        };
        Ok(Self::new(parameters, virgin, now, carried))
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
        None => (axis == BendingAxis::Strong).then_some(CURVE_OF_UNKNOWN_SECTION),
    }
}

/// `e0` \[m\]: as given, or by the buckling curve about the strong axis.
#[must_use]
pub fn imperfection(parameters: &Parameters) -> f64 {
    let given = parameters.settings().capacity.imperfection;
    if given > 0.0 {
        return given;
    }
    let curve = buckling_curve(parameters, BendingAxis::Strong).unwrap_or(CURVE_OF_UNKNOWN_SECTION);
    curve.relative_bow() * height(parameters)
}

/// Resistances of the virgin column about the strong and the weak axis, with the buckling lengths of its supports, which
/// are assumed to hold both axes alike.
#[must_use]
pub fn buckling_resistances(parameters: &Parameters) -> [Option<BucklingResistance>; 2] {
    let p = parameters.column_properties();
    let height = height(parameters);
    let resistance = |axis, bending_stiffness: f64| {
        let factor = effective_length_factor(p.base, p.top, bending_stiffness, height);
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
