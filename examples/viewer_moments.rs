//! Writes viewer files of four moments of an impact, for the pictures of the documents: before the contact, at the first yield,
//! at the peak, and at rest. `docs/pictures.sh` makes the pictures.
//!
//! ```sh
//! cargo run --release --example viewer_moments -- config/heb220_s355.yaml FOLDER
//! ```

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use column_twin::assessment::{ImpactEvaluation, respond_and_rest};
use column_twin::column::{Impact, simulate};
use column_twin::messages::column_twin_msgs::ImpactReport;
use column_twin::parameters::Parameters;
use column_twin::viewer::{ViewerItem, from_samples, write_rrd};

/// Initial distance of the vehicle \[m\].
const GAP: f64 = 0.5;

/// The stamp of the event, fixed so that the files are reproducible: 2026-01-01, 12:00 UTC.
const STAMP: i64 = 1_767_268_800_000_000_000;

#[allow(dead_code)] // the test of the pictures includes this file
fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(config), Some(folder)) = (arguments.next(), arguments.next()) else {
        return Err("expected two arguments: a parameter file and a folder for the files".into());
    };
    write(&config, &folder)
}

/// Writes `before.rrd`, `first_yield.rrd`, `peak.rrd` and `rest.rrd` to a folder.
///
/// # Errors
/// The parameters are invalid, the vehicle does not reach the column, or the folder is not writable.
pub fn write(config: &Path, folder: &Path) -> Result<(), Box<dyn Error>> {
    let parameters = Arc::new(Parameters::load(&[config.to_owned()], &[])?);
    let car = Impact {
        gap: GAP,
        ..parameters.impact()
    };
    let mut samples = Vec::new();
    let duration = parameters.response_duration();
    let report = simulate(
        &parameters.column_properties(),
        &car,
        duration,
        &mut |sample| samples.push(*sample),
    )?;
    let properties = parameters.column_properties();
    let ended = respond_and_rest(&properties, &car, duration)?;
    let evaluation = ImpactEvaluation::complete(&parameters, &properties, &car, ended)?;
    let vehicle = &parameters.settings().vehicle.name;
    let announced = ImpactReport::evaluated(&evaluation, vehicle, &car, parameters.direction());
    let contact = report
        .first_contact_time
        .ok_or("the vehicle does not reach the column")?;
    let hinges = report.hinges.iter().map(|hinge| hinge.first_yield);
    let webs = report.webs.iter().map(|web| web.first_yield);
    let yields = hinges.chain(webs).flatten();
    let first_yield = yields.fold(f64::INFINITY, f64::min);
    for (name, time) in [
        ("before", 0.3 * contact),
        ("first_yield", first_yield + 2e-5),
        ("peak", report.max_v1_time),
        ("rest", report.end_time),
    ] {
        // Every tenth step up to the moment, so that the viewer loads the file quickly; every step just before it.
        let mut items = from_samples("car", STAMP, samples.iter().copied(), &announced);
        let mut count = 0;
        items.retain(|item| match item {
            ViewerItem::State(state) => {
                count += 1;
                let near = time - state.sample.time < 1e-3 || state.sample.impact_impulse > 0.0;
                state.sample.time <= time && (count % 10 == 1 || near)
            }
            ViewerItem::Result(_) => time == report.end_time,
            _ => true,
        });
        let path = folder.join(format!("{name}.rrd"));
        write_rrd(&path, &parameters, items, true)?;
    }
    Ok(())
}
