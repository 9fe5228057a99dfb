//! `column-twin vehicles`: the catalogue of vehicles with the source of every number.

use std::fmt::Write as _;
use std::io::Write;

use clap::Args;

use super::failure::{Exit, Failure, printed};
use column_twin::parameters::{
    CatalogueVehicle, Parameter, Parameters, Provenance, RIGID, Value, vehicle_catalogue,
};

/// Arguments of `column-twin vehicles`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct VehiclesArgs {
    /// Only this vehicle, followed by the parameters of the same vehicle as a user-defined one, for you to change
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

const EXAMPLE: &str = "\
Example: the column is hit by a van of its own mass at 50 km/h
  column-twin simulate --vehicle van --velocity 13.9

Exit codes: 0 done, 1 failed, 2 no such vehicle.";

/// Prints the catalogue.
pub fn run(arguments: &VehiclesArgs, out: &mut impl Write) -> Result<(), Failure> {
    let text = match &arguments.name {
        None => list(),
        Some(name) => one(name)?,
    };
    printed(out.write_all(text.as_bytes()))
}

fn list() -> String {
    let mut text = format!("{RIGID}\n  The paper's rigid mass, which needs impact.mass.\n");
    for vehicle in vehicle_catalogue() {
        text += &format!("\n{}", Described(vehicle).text());
    }
    text += "\nTags:";
    for tag in Provenance::ALL {
        let _ = write!(text, " [{tag}] {};", tag.meaning());
    }
    text.truncate(text.len() - 1);
    text + ".\n"
}

fn one(name: &str) -> Result<String, Failure> {
    // The parameters reject an unknown name and suggest the nearest one.
    if let Err(fault) = Parameters::default().vehicle_named(name) {
        return Err(Failure::plain(Exit::BadInput, fault));
    }
    let Some(vehicle) = CatalogueVehicle::named(name) else {
        return Ok(format!(
            "{RIGID}\n  The paper's rigid mass, which needs impact.mass.\n"
        ));
    };
    Ok(format!(
        "{}\nThe same vehicle as a user-defined one, as parameters of a node:\n{}",
        Described(vehicle).text(),
        by_numbers(vehicle)
    ))
}

/// A vehicle of the catalogue for people.
struct Described<'a>(&'a CatalogueVehicle);

impl Described<'_> {
    fn text(&self) -> String {
        let vehicle = self.0;
        let mut text = format!("{}: {}\n", vehicle.name, vehicle.description);
        let mut line = |what: &str, value: String, tag: Provenance, source: &str| {
            let _ = writeln!(text, "  {what:<16}{value}\n  {:<16}[{}] {source}", "", tag);
        };
        let masses: Vec<_> = vehicle.masses.value.kg.iter().map(f64::to_string).collect();
        line(
            "mass",
            format!("{} kg", masses.join(" + ")),
            vehicle.masses.tag,
            &vehicle.masses.source,
        );
        for (index, spring) in vehicle.springs.iter().enumerate() {
            let points: Vec<_> = spring
                .value
                .points
                .iter()
                .map(|[crush, force]| format!("{crush:.3} m: {:.0} kN", force / 1e3))
                .collect();
            line(
                &format!("spring {}", index + 1),
                format!(
                    "{}; unloading {} MN/m",
                    points.join(", "),
                    spring.value.unloading_stiffness_n_m / 1e6
                ),
                spring.tag,
                &spring.source,
            );
        }
        let narrow = &vehicle.narrow_object;
        let reduced = if narrow.value.on {
            "half of the force at first"
        } else {
            "all of the force"
        };
        line(
            "on a column",
            reduced.to_owned(),
            narrow.tag,
            &narrow.source,
        );
        line(
            "contact height",
            format!("{} m", vehicle.contact_height.value.height_m),
            vehicle.contact_height.tag,
            &vehicle.contact_height.source,
        );
        line(
            "scatter",
            format!(
                "{:.0} % of the force",
                100.0 * vehicle.force_variation.value.coefficient
            ),
            vehicle.force_variation.tag,
            &vehicle.force_variation.source,
        );
        let size = &vehicle.size.value;
        line(
            "size",
            format!(
                "{} x {} x {} m, wheelbase {} m",
                size.length_m, size.width_m, size.height_m, size.wheelbase_m
            ),
            vehicle.size.tag,
            &vehicle.size.source,
        );
        text
    }
}

/// The parameters that describe the vehicle by numbers.
fn by_numbers(vehicle: &CatalogueVehicle) -> String {
    let mut values = vec![
        ("vehicle.name".to_owned(), Value::from("")),
        (
            "vehicle.masses".to_owned(),
            vehicle.masses.value.kg.clone().into(),
        ),
    ];
    let slack: Vec<f64> = vehicle
        .springs
        .iter()
        .skip(1)
        .map(|it| it.value.slack_m)
        .collect();
    if !slack.is_empty() {
        values.push(("vehicle.slack".to_owned(), slack.into()));
    }
    for (index, spring) in vehicle.springs.iter().enumerate() {
        let column =
            |k: usize| -> Vec<f64> { spring.value.points.iter().map(|it| it[k]).collect() };
        let name = |last: &str| format!("vehicle.spring_{}.{last}", index + 1);
        values.extend([
            (name("crush"), column(0).into()),
            (name("force"), column(1).into()),
            (
                name("unloading_stiffness"),
                spring.value.unloading_stiffness_n_m.into(),
            ),
        ]);
    }
    values.push((
        "vehicle.narrow_object".to_owned(),
        vehicle.narrow_object.value.on.into(),
    ));
    let mut text = "/**:\n  ros__parameters:\n".to_owned();
    for (name, value) in values {
        let unit = Parameter::named(&name).map_or("", |it| it.unit);
        let unit = if unit.is_empty() {
            String::new()
        } else {
            format!(" # [{unit}]")
        };
        let _ = writeln!(text, "    {name}: {value}{unit}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn typed(name: Option<&str>) -> Result<String, Failure> {
        let mut out = Vec::new();
        let name = name.map(str::to_owned);
        run(&VehiclesArgs { name }, &mut out)?;
        Ok(String::from_utf8(out).expect("text"))
    }

    #[test]
    fn the_list_names_every_vehicle_with_its_sources() {
        let list = typed(None).expect("printed");
        for vehicle in vehicle_catalogue() {
            assert!(list.contains(&format!("{}: ", vehicle.name)));
            assert!(
                list.contains(&format!("[C] {}", vehicle.springs[0].source))
                    || vehicle.springs[0].tag != Provenance::Computed
            );
        }
        assert!(
            list.ends_with("[A] assumption of this project.\n"),
            "{list}"
        );
    }

    /// What is printed as parameters is the same vehicle, to the last bit.
    #[test]
    fn the_parameters_of_a_vehicle_are_that_vehicle() {
        for vehicle in vehicle_catalogue() {
            let printed = typed(Some(&vehicle.name)).expect("known");
            let start = printed.find("/**:").expect("parameters");
            let by_numbers = Parameters::from_yaml(Path::new("printed.yaml"), &printed[start..])
                .expect("right")
                .vehicle_named("");
            let named = Parameters::default().vehicle_named(&vehicle.name);
            assert_eq!(by_numbers, named, "{}", vehicle.name);
        }
    }

    #[test]
    fn an_unknown_vehicle_is_rejected_with_a_suggestion() {
        let failure = typed(Some("midcar")).expect_err("unknown");
        assert_eq!(failure.exit, Exit::BadInput);
        let text = failure.report.to_string();
        assert!(text.contains("did you mean mid_car?"), "{text}");
    }
}
