//! The options that specify an impact.

use clap::Args;

#[cfg(feature = "ros")]
use super::failure::{Exit, Failure};
#[cfg(feature = "ros")]
use column_twin::column::ImpactSpecification;
use column_twin::parameters::{CatalogueVehicle, Value};
#[cfg(feature = "ros")]
use column_twin::parameters::{Parameters, Problem};

/// The impact of a vehicle, as far as it is given on the command line; parameters give the rest.
#[derive(Debug, Clone, Default, Args)]
#[command(allow_negative_numbers = true)]
pub(super) struct ImpactSpecificationArgs {
    /// Vehicle: rigid, or one that `column-twin vehicles` lists; default: parameter vehicle.name
    #[arg(long, value_name = "NAME")]
    vehicle: Option<String>,
    /// Total mass of the vehicle [kg]; default: with --vehicle its own mass, otherwise parameter impact.mass
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Speed of the vehicle over the ground [m/s]
    #[arg(long, value_name = "M/S")]
    velocity: Option<f64>,
    /// Distance between vehicle and column at the event [m]; default: parameter impact.gap
    #[arg(long, value_name = "M")]
    gap: Option<f64>,
    /// Coefficient of restitution [-], 0 to 1; default: parameter impact.restitution
    #[arg(long, value_name = "E")]
    restitution: Option<f64>,
    /// Height of the impact point above the base [m]; default: the height of the vehicle where geometry.height gives the column, otherwise
    /// parameter geometry.length_below
    #[arg(long, value_name = "M")]
    height: Option<f64>,
    /// Direction of travel [degrees], above -180 to 180: 0 bends the column about its strong axis, positive turns towards the positive
    /// weak-axis direction; default: parameter impact.direction
    #[arg(long, value_name = "DEGREES")]
    direction: Option<f64>,
}

impl ImpactSpecificationArgs {
    /// The options of a command that gives them another form; the direction in degrees.
    pub fn given(
        vehicle: Option<String>,
        [mass, velocity, gap, restitution, height, direction]: [Option<f64>; 6],
    ) -> Self {
        Self {
            vehicle,
            mass,
            velocity,
            gap,
            restitution,
            height,
            direction,
        }
    }

    /// Whether any of the options is given.
    pub fn is_given(&self) -> bool {
        self.height.is_some() || !self.overrides().is_empty()
    }

    /// The height of the impact point above the base \[m\], if given.
    pub fn height(&self) -> Option<f64> {
        self.height
    }

    /// The name of the vehicle, if given.
    #[cfg(feature = "ros")]
    pub fn vehicle(&self) -> Option<&str> {
        self.vehicle.as_deref()
    }

    /// The override that the options imply and that any other one takes precedence over: a vehicle named without a mass has
    /// its own, whatever mass a parameter file gives to another one.
    pub fn implied_override(&self) -> Option<String> {
        let deformable = CatalogueVehicle::named(self.vehicle.as_deref()?).is_some();
        (deformable && self.mass.is_none()).then(|| "impact.mass:=0.0".to_owned())
    }

    /// The options as overrides of parameters, so that the one table of parameters validates them. The height, which two
    /// parameters determine, is not among them.
    pub fn overrides(&self) -> Vec<String> {
        let options = [
            ("impact.mass", self.mass),
            ("impact.velocity", self.velocity),
            ("impact.gap", self.gap),
            ("impact.restitution", self.restitution),
            ("impact.direction", self.direction.map(f64::to_radians)),
        ];
        let vehicle = self.vehicle.as_ref();
        let vehicle = vehicle.map(|name| format!("vehicle.name:={}", Value::from(name.as_str())));
        let numbers = options
            .into_iter()
            .filter_map(|(name, value)| Some(format!("{name}:={}", yaml(value?))));
        vehicle.into_iter().chain(numbers).collect()
    }

    /// The options as an impact for a twin, for a command that requires a velocity.
    ///
    /// # Errors
    /// A number that no twin accepts.
    #[cfg(feature = "ros")]
    pub fn specification(&self) -> Result<ImpactSpecification, Failure> {
        let ranged = [
            ("--mass", "impact.mass", self.mass),
            ("--velocity", "impact.velocity", self.velocity),
            ("--gap", "impact.gap", self.gap),
            ("--restitution", "impact.restitution", self.restitution),
        ];
        let of_range = |(option, name, number): (&str, &str, Option<f64>)| {
            let number = number?;
            let faults = Parameters::from_values([(name, Value::Double(number))]).err()?;
            // How it goes with the rest of the column, only the twin knows.
            let mut problems = faults.faults().iter().map(|it| &it.problem);
            let problem = problems
                .find(|it| matches!(it, Problem::NotFinite { .. } | Problem::OutOfRange { .. }))?;
            Some(format!("{option} {number} {problem}"))
        };
        let of_direction = self.direction.filter(|it| !(*it > -180.0 && *it <= 180.0));
        let of_direction = of_direction.map(|it| {
            format!("--direction {it} is out of range; allowed: above -180 to 180 degrees")
        });
        let of_height = self.height.filter(|it| !(*it > 0.0 && it.is_finite()));
        let of_height = of_height.map(|it| {
            format!(
                "--height {it} is out of range; allowed: above 0 and below the top of the column"
            )
        });
        let fault = ranged.into_iter().find_map(of_range);
        if let Some(fault) = fault.or(of_direction).or(of_height) {
            return Err(Failure::plain(Exit::BadInput, fault));
        }
        Ok(ImpactSpecification {
            // clap requires a velocity. Without a mass, the vehicle of the event or of the twin has its own.
            mass: self.mass.unwrap_or(f64::NAN),
            velocity: self.velocity.unwrap_or(f64::NAN),
            gap: self.gap,
            restitution: self.restitution,
            height: self.height,
            direction: self.direction.map(f64::to_radians),
        })
    }
}

/// A number in YAML, always with a decimal point.
pub(super) fn yaml(value: f64) -> String {
    match value {
        value if value.is_nan() => ".nan".into(),
        f64::INFINITY => ".inf".into(),
        f64::NEG_INFINITY => "-.inf".into(),
        value => {
            let text = format!("{value:?}");
            // YAML 1.1 reads 1e-7, as Rust writes it, as a string.
            match text.split_once('e') {
                Some((digits, power)) if !digits.contains('.') => format!("{digits}.0e{power}"),
                _ => text,
            }
        }
    }
}
