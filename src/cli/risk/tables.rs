//! The fragility curves and the samples as tables.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use column_twin::assessment::Action;
use column_twin::study::risk::{Basis, Estimate, RiskResult, RiskSample, Scenario};
use column_twin::whole_file::WholeFile;

/// The fragility curves as CSV: one row for each vehicle (`all`: the whole traffic), action and interval of the speed.
pub(super) fn fragility(result: &RiskResult) -> String {
    let mut text = String::from(
        "vehicle,action,speed_from_m_s,speed_to_m_s,samples,probability,low,high,fit_median_m_s,fit_dispersion,no_fit_because\n",
    );
    for curve in &result.fragility {
        for point in &curve.points {
            let Some(Estimate { value, low, high }) = point.probability else {
                continue;
            };
            let [from, to] = point.speed;
            let rejected = || curve.rejected.map_or(String::new(), |it| it.to_string());
            let fit = match curve.fit {
                Some(fit) => format!("{},{},", fit.median, fit.dispersion),
                None => format!(",,\"{}\"", rejected()),
            };
            let _ = writeln!(
                text,
                "{},{},{from},{to},{},{value},{low},{high},{fit}",
                curve.vehicle.unwrap_or("all"),
                curve.action,
                point.samples,
            );
        }
    }
    text
}

/// Writes every sample as CSV. The file gets its name when it is finished.
pub(super) struct SampleWriter {
    out: WholeFile,
    vehicles: Vec<&'static str>,
    /// Whether the samples have a direction of their own.
    have_direction: bool,
}

impl SampleWriter {
    pub fn create(path: &Path, scenario: &Scenario) -> io::Result<Self> {
        let mut out = WholeFile::create(path)?;
        let have_direction = scenario.orientation.is_some();
        let direction = if have_direction { ",direction_deg" } else { "" };
        writeln!(
            out,
            "sample,vehicle,mass_kg,road_speed_m_s,angle_deg,deceleration_m_s2,distance_m,speed_m_s,force_factor,\
             yield_strength_factor,top_load_factor,action,basis{direction}"
        )?;
        Ok(Self {
            out,
            vehicles: scenario.classes.iter().map(|class| class.vehicle).collect(),
            have_direction,
        })
    }

    pub fn write(&mut self, sample: &RiskSample) -> io::Result<()> {
        let it = &sample.departure;
        let basis = match sample.basis {
            Basis::Stopped => "stopped",
            Basis::Computed(_) => "computed",
            Basis::Undetermined => "undetermined",
            Basis::Predicted(_) => "predicted",
            Basis::Control { .. } => "control",
        };
        let action = sample
            .basis
            .action()
            .map_or(String::new(), |action: Action| action.to_string());
        let direction = match self.have_direction {
            true => format!(",{}", it.direction.unwrap_or(0.0).to_degrees()),
            false => String::new(),
        };
        writeln!(
            self.out,
            "{},{},{},{},{},{},{},{},{},{},{},{action},{basis}{direction}",
            it.index,
            self.vehicles[it.class],
            it.mass,
            it.speed,
            it.angle.to_degrees(),
            it.deceleration,
            it.distance,
            it.velocity,
            it.force_factor,
            it.yield_factor,
            it.load_factor,
        )
    }

    pub fn finish(self) -> io::Result<()> {
        self.out.commit()
    }
}
