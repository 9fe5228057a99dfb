//! The value that takes the place of a parameter whose 0 stands for what follows from others.

use crate::column::{ColumnProperties, Model, ShearProperties};
use crate::parameters::{CatalogueSection, DeclaredParameter, Parameters, Value};

use super::imperfection;

impl Parameters {
    /// The value of the parameter of this name that is computed with: where 0 stands for what follows from other parameters, such as
    /// the area of a named section, that number. A 0 that means "none" or "no limit" remains. `None` if there is no such parameter.
    ///
    /// ```
    /// use column_twin::parameters::{Parameters, Value};
    ///
    /// let column = Parameters::default();
    /// assert_eq!(column.get("section.area"), Some(Value::Double(0.0)));
    /// assert_eq!(column.effective("section.height"), Some(Value::Double(0.22)));
    /// ```
    #[must_use]
    pub fn effective(&self, name: &str) -> Option<Value> {
        let given = self.get(name)?;
        Some(self.in_effect(name, given, &self.column_properties()))
    }

    /// All parameters with the values that are computed with, see [`effective`](Self::effective), in the order of the table. It takes
    /// little longer than one of them.
    pub fn effective_values(&self) -> impl Iterator<Item = (DeclaredParameter<'_>, Value)> {
        let properties = self.column_properties();
        self.iter()
            .map(move |(it, given)| (it, self.in_effect(it.name, given, &properties)))
    }

    fn in_effect(&self, name: &str, given: Value, properties: &ColumnProperties) -> Value {
        match given == Value::Double(0.0) {
            true => self
                .in_place_of_zero(name, properties)
                .map_or(given, Value::Double),
            false => given,
        }
    }

    /// What is computed with where the parameter is 0; `None` where that is 0.
    fn in_place_of_zero(&self, name: &str, properties: &ColumnProperties) -> Option<f64> {
        let settings = self.settings();
        let dimensions = || Some(CatalogueSection::named(&settings.section.name)?.dimensions);
        let found = match name {
            "geometry.height" => properties.length_below + properties.length_above,
            "section.area" => self.section().area,
            "section.second_moment" => self.section().second_moment,
            "section.mass_per_length" => properties.mass_per_length,
            "section.height" => self.section().height,
            "section.width" => dimensions()?.width,
            "section.web_thickness" => dimensions()?.web_thickness,
            "section.flange_thickness" => dimensions()?.flange_thickness,
            "steel.young_modulus" => self.steel().young_modulus,
            "steel.yield_strength" => self.steel().yield_strength,
            "resistance.moment" => properties.resistance_moment,
            "resistance.axial" => properties.resistance_axial,
            "resistance.shear" => {
                smallest_resistance(&properties.shear?, properties.clear_lengths())
            }
            "rate.c" | "rate.max_factor" | "rate.hinge_length" => {
                let rate = properties.rate?;
                match (name, rate.law) {
                    ("rate.max_factor", _) => rate.max_factor,
                    ("rate.hinge_length", _) => rate.hinge_length,
                    (_, crate::column::RateLaw::Logarithmic { c, .. }) => c,
                    _ => return None,
                }
            }
            "softening.capping_rotation" => properties.softening?.capping_rotation,
            "softening.post_capping_rotation" => properties.softening?.post_capping_rotation,
            "softening.residual" => properties.softening?.residual,
            "solver.dt" => Model::new(properties).ok()?.step_secs,
            "impact.mass" => self.impact().mass,
            "capacity.imperfection" => imperfection(self),
            _ => return None,
        };
        Some(found)
    }
}

/// That of the longer bar, whose flanges bear less.
fn smallest_resistance(shear: &ShearProperties, lengths: [f64; 2]) -> f64 {
    lengths
        .map(|length| shear.resistance(length))
        .into_iter()
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `column["section.area"]` read 0.0 of a column whose section has a name.
    #[test]
    fn what_follows_from_a_name_is_its_value() {
        let column = Parameters::from_values([
            ("section.name", Value::from("HEB 300")),
            ("steel.grade", Value::from("S355")),
            ("vehicle.name", Value::from("mid_car")),
            ("rate.law", Value::from("logarithmic")),
        ])
        .expect("a column");
        // EN 10365, and the mass of the catalogue.
        for (name, expected, tolerance) in [
            ("section.area", 149.1e-4, 1e-3),
            ("section.second_moment", 25170e-8, 1e-3),
            ("section.mass_per_length", 117.0, 2e-3),
            ("section.height", 0.3, 1e-9),
            ("section.width", 0.3, 1e-9),
            ("section.web_thickness", 0.011, 1e-9),
            ("section.flange_thickness", 0.019, 1e-9),
            ("steel.yield_strength", 355e6, 1e-9),
            ("resistance.moment", 1869e-6 * 355e6, 1e-3),
            ("resistance.axial", 149.1e-4 * 355e6, 1e-3),
            ("geometry.height", 4.0, 1e-9),
            ("impact.mass", 1719.0, 1e-9),
            ("rate.c", 6.0 / 355.0, 1e-9),
            ("rate.max_factor", 1.25, 1e-9),
        ] {
            assert_eq!(column.get(name), Some(Value::Double(0.0)), "{name}");
            let Some(Value::Double(found)) = column.effective(name) else {
                panic!("{name} is a number");
            };
            assert!(
                (found / expected - 1.0).abs() < tolerance,
                "{name}: {found}"
            );
        }
        for name in [
            "solver.dt",
            "resistance.shear",
            "capacity.imperfection",
            "softening.capping_rotation",
        ] {
            assert!(
                matches!(column.effective(name), Some(Value::Double(it)) if it > 0.0),
                "{name}"
            );
        }
        // What is given stays, and so does a 0 that means none.
        assert_eq!(column.effective("top.mass"), column.get("top.mass"));
        assert_eq!(
            column.effective("section.name"),
            Some(Value::from("HEB300"))
        );
        assert_eq!(column.effective("section.aera"), None);
    }

    #[test]
    fn all_effective_values_are_those_of_each_name() {
        let column = Parameters::from_values([("vehicle.name", Value::from("mid_car"))]);
        let column = column.expect("a column");
        for (it, value) in column.effective_values() {
            assert_eq!(column.effective(it.name), Some(value), "{}", it.name);
        }
        assert_eq!(column.effective_values().count(), column.iter().count());
    }
}
