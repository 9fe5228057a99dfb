//! Residual capacity of the undamaged column, for any yield strength near the given one.

use crate::assessment::imperfection;
use crate::column::{Capacity, ColumnProperties, Model, State, capacity};
use crate::parameters::Parameters;

use crate::estimation::inference::population::with_yield_factor;

/// Factors of the yield strength for which the capacity is computed: from 0.8 to 1.2, four standard deviations.
const FACTORS: usize = 9;

/// The first of them.
const FIRST: f64 = 0.8;

/// Distance between them. Between two of them the capacity is straight within 5e-4.
const DISTANCE: f64 = 0.05;

/// The capacities for some factors of the yield strength; `None` where it cannot be computed.
#[derive(Debug, Clone)]
pub(crate) struct UndamagedCapacities([Option<Capacity>; FACTORS]);

impl UndamagedCapacities {
    pub fn new(parameters: &Parameters, properties: &ColumnProperties) -> Self {
        let imperfection = imperfection(parameters);
        Self(std::array::from_fn(|k| {
            let factor = FIRST + DISTANCE * k as f64;
            let model = Model::new(&with_yield_factor(properties, factor)).ok()?;
            capacity(&model, &State::at_rest(&model), imperfection).ok()
        }))
    }

    /// The capacity with this factor of the yield strength; `None` where it is not known.
    pub fn at(&self, factor: f64) -> Option<Capacity> {
        let place = (factor - FIRST) / DISTANCE;
        let index = place.floor();
        if !(index >= 0.0 && index < (FACTORS - 1) as f64) {
            return None;
        }
        let (low, high) = (self.0[index as usize]?, self.0[index as usize + 1]?);
        let share = place - index;
        Some(Capacity {
            force: low.force + share * (high.force - low.force),
            ..low
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_the_factors_it_is_the_computed_capacity() {
        let parameters = Parameters::default();
        let properties = parameters.column_properties();
        let capacities = UndamagedCapacities::new(&parameters, &properties);
        for factor in [0.81, 0.924, 0.999, 1.0, 1.077, 1.19] {
            let model = Model::new(&with_yield_factor(&properties, factor)).expect("a column");
            let imperfection = imperfection(&parameters);
            let computed = capacity(&model, &State::at_rest(&model), imperfection);
            let computed = computed.expect("a capacity").force;
            let known = capacities.at(factor).expect("known").force;
            assert!(
                (known / computed - 1.0).abs() < 1e-3,
                "{factor}: {known} {computed}"
            );
        }
        assert!(capacities.at(0.7).is_none() && capacities.at(f64::NAN).is_none());
    }
}
