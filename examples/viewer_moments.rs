//! Writes what the viewer shows at four moments of an impact, for the pictures of the README: before, at the first yield, at
//! the peak, at rest. `docs/pictures.sh` makes the pictures.
//!
//! ```sh
//! cargo run --release --example viewer_moments -- config/heb220_paper.yaml FOLDER
//! ```

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

use column_twin::column::{Impact, simulate};
use column_twin::parameters::Parameters;
use column_twin::viewer::{Item, from_samples, write_rrd};

/// How far the vehicle is away at the first moment \[m\].
const GAP: f64 = 0.5;

/// The event's stamp, so that the files are the same each time: 2026-01-01, 12:00 UTC.
const STAMP: i64 = 1_767_268_800_000_000_000;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(config), Some(folder)) = (arguments.next(), arguments.next()) else {
        return Err("expected two arguments: a parameter file, and a folder for the files".into());
    };
    let parameters = Arc::new(Parameters::load(&[config], &[])?);
    let given = parameters.impact();
    let car = Impact {
        mass: given.mass,
        velocity: given.velocity,
        gap: GAP,
        restitution: given.restitution,
    };
    let mut samples = Vec::new();
    let duration = parameters.response_duration();
    let report = simulate(
        &parameters.column_properties(),
        &car,
        duration,
        &mut |sample| samples.push(*sample),
    )?;
    let contact = report
        .first_contact_time
        .ok_or("the vehicle does not reach the column")?;
    let yields = report.hinges.iter().filter_map(|hinge| hinge.first_yield);
    let first_yield = yields.fold(f64::INFINITY, f64::min);
    for (name, time) in [
        ("before", 0.3 * contact),
        ("first_yield", first_yield + 2e-5),
        ("peak", report.max_v1_time),
        ("rest", f64::INFINITY),
    ] {
        let until = samples.iter().take_while(|it| it.time <= time).copied();
        let mut items = from_samples("car", STAMP, until, &report);
        if time.is_finite() {
            items.retain(|it| !matches!(it, Item::Result(_)));
        }
        let path = folder.join(format!("{name}.rrd"));
        write_rrd(&path, &parameters, items, true)?;
    }
    Ok(())
}
