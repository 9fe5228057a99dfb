//! The arguments of `column-twin map`, and the map that they describe.

use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::error::MapCommandError;
use crate::cli::failure::Failure;
use crate::cli::fleet_study::FleetStudyArgs;
use crate::cli::impact_args::ImpactSpecificationArgs;
use crate::cli::simulate::{is_standard_output, parameters_of};
use crate::cli::threads;
use column_twin::parameters::Parameters;
use column_twin::study::{
    AxisValues, Batch, DamageMap, MapAxis, MapError, Threads, Variant, VerdictModel,
};

/// Arguments of `column-twin map`.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true, after_help = EXAMPLE)]
pub struct MapArgs {
    /// Parameter file (ROS 2 YAML), may be repeated: later files win; default: the built-in column
    #[arg(long, short, value_name = "FILE")]
    config: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) fleet: FleetStudyArgs,
    /// Any parameter in the notation of ROS 2, for example -p top.load:=2.0e6; may be repeated
    #[arg(long = "param", short, value_name = "NAME:=VALUE")]
    parameter: Vec<String>,
    /// Vehicle: rigid, or one that `column-twin vehicles` lists; default: parameter vehicle.name
    #[arg(long, value_name = "NAME")]
    vehicle: Option<String>,
    /// Total mass of the vehicle [kg]: one number, or an axis as from:to:number of points
    #[arg(long, value_name = "KG")]
    mass: Option<String>,
    /// Speed of the vehicle over the ground [m/s]: one number, or an axis as from:to:number of points; for a fleet, the range of the search as from:to
    #[arg(long, value_name = "M/S")]
    velocity: Option<String>,
    /// Height of the impact point above the base [m]: one number, or an axis as from:to:number of points
    #[arg(long, value_name = "M")]
    height: Option<String>,
    /// Direction of travel [degrees], 0: in the plane of the web: one number, or an axis as from:to:number of points
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    direction: Option<String>,
    /// By which model an impact is judged: bars, the two bars; beam, the fibre beam alone, which takes tens of milliseconds for each; both, the more severe verdict of both as in a node
    #[arg(long, value_name = "MODEL", value_parser = ["bars", "beam", "both"], default_value = "bars")]
    model: String,
    /// Axis of any other number among the parameters as NAME=from:to:number of points, or of sections or vehicles as
    /// section=NAME,NAME or vehicle=NAME,NAME; may be repeated
    #[arg(long, value_name = "NAME=VALUES")]
    vary: Vec<String>,
    /// Several columns in one map: section=HEB200,HEB240, any parameter with its values, or config=FILE,FILE, each of which is read after the files of --config
    #[arg(long, value_name = "NAME=VALUES")]
    compare: Option<String>,
    /// Compute only the boundaries of the classes, to 1 %, with a small part of the responses
    #[arg(long, conflicts_with = "shard")]
    refine: bool,
    /// Compute the values between which each boundary lies if uncertain data differ, as the range of a verdict does; with
    /// --refine in the files, otherwise in figures alone
    #[arg(long, conflicts_with = "shard")]
    pub bands: bool,
    /// Compute one of several contiguous parts of the map, such as 3/16, for batch systems
    #[arg(long, value_name = "PART/PARTS")]
    pub shard: Option<String>,
    /// Number of threads, at most one per computation and four per processor; default: one per processor. The results do not depend on it
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Write the impacts as CSV, one row each; with -, they go to the standard output and the summary to the standard error
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Write the impacts as JSON; without FILE, to the standard output
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-")]
    pub json: Option<PathBuf>,
    /// Write the impacts as Parquet
    #[arg(long, value_name = "FILE")]
    pub parquet: Option<PathBuf>,
    /// Write the impacts as an Arrow file
    #[arg(long, value_name = "FILE")]
    pub arrow: Option<PathBuf>,
    /// Draw the figures into this folder, as SVG and PNG
    #[arg(long, value_name = "FOLDER")]
    pub figures: Option<PathBuf>,
    /// Write a file for the Rerun viewer: the map with its boundaries
    #[cfg(feature = "viewer")]
    #[arg(long, value_name = "FILE")]
    pub rrd: Option<PathBuf>,
}

const EXAMPLE: &str = "\
A map has two axes. Quantities that are not axes have the value of their option or parameter.
docs/study.md describes the map, its files and its boundaries.

Example: action over mass and velocity, with figures and a table
  column-twin map --config config/heb220_paper.yaml --mass 1000:12000:30 --velocity 1:25:30 --figures figures --csv map.csv
Example: which velocity of a lorry the column survives, by load; boundaries alone, to 1 %
  column-twin map --config config/heb220_s355.yaml --vehicle lorry_8t --vary top.load=1e5:1e6:40 --velocity 1:25:100 --refine
Example: a heavier section in comparison
  column-twin map --vehicle mid_car --mass 1200:2500:20 --velocity 2:25:40 --compare section=HEB200,HEB240 --refine --figures figures
Example: how the direction of a car matters, by the fibre beam and the two bars
  column-twin map --config config/heb220_s355.yaml --vehicle mid_car --direction 0:90:4 --velocity 4:10:4 --model both
Example: the third of 16 parts of a large map, for a batch system
  column-twin map --mass 1000:12000:200 --velocity 1:25:200 --shard 3/16 --parquet part-03.parquet

Example: the weakest columns of a fleet for a lorry, one row for each
  column-twin map --params-file config/fleet.yaml --columns config/fleet.csv --vehicle lorry_8t --csv weakest.csv

Exit codes: 0 done, 1 failed, 2 bad input or usage, 3 done in part: interrupted, or some impacts
could not be computed.";

/// Metadata of the files, in order.
pub(super) type MapMetadata = Vec<(&'static str, String)>;

/// An option that is one number or an axis.
enum NumberOrAxis {
    Number(f64),
    Axis(MapAxis),
}

impl MapArgs {
    /// The map.
    pub fn map(&self) -> Result<DamageMap, Failure> {
        self.check_outputs()?;
        let mut axes = Vec::new();
        let mut numbers = [None; 6];
        let options = [
            ("mass", &self.mass, "2000:12000:100", 0),
            ("velocity", &self.velocity, "1:25:100", 1),
            ("height", &self.height, "0.5:1.5:20", 4),
            ("direction", &self.direction, "0:90:10", 5),
        ];
        for (name, text, example, place) in options {
            let Some(text) = text else {
                continue;
            };
            match number_or_axis(name, text, example)? {
                NumberOrAxis::Number(number) => numbers[place] = Some(number),
                NumberOrAxis::Axis(axis) => {
                    // The impact of the parameters has to be admissible, too: a rigid mass has none of its own.
                    if place < 4 {
                        numbers[place] = axis.number(axis.len() - 1);
                    }
                    axes.push(axis);
                }
            }
        }
        for text in &self.vary {
            axes.push(MapAxis::parse(text).map_err(|fault| MapCommandError::Map(fault.into()))?);
        }
        let axes: [MapAxis; 2] = axes.try_into().map_err(|axes: Vec<MapAxis>| {
            let names = axes.iter().map(|axis| axis.quantity().name().to_owned());
            MapCommandError::NotTwoAxes {
                found: axes.len(),
                names: names.collect(),
            }
        })?;
        let impact = ImpactSpecificationArgs::given(self.vehicle.clone(), numbers);
        let load = |files: &[PathBuf]| parameters_of(files, &self.parameter, &impact);
        let map = match self.compare.as_deref() {
            None => DamageMap::new(&load(&self.config)?, None, axes),
            Some(text) => match text.strip_prefix("config=") {
                Some(files) => {
                    DamageMap::of_variants(self.files_to_compare(text, files, load)?, axes)
                }
                None => {
                    let compared =
                        MapAxis::parse(text).map_err(|fault| match text.contains('=') {
                            true => MapCommandError::Map(fault.into()),
                            false => MapCommandError::Compare {
                                given: text.to_owned(),
                            },
                        })?;
                    DamageMap::comparing(&load(&self.config)?, None, &[compared], axes)
                }
            },
        };
        let map = map.and_then(|map| map.judged_by(self.model()));
        Ok(map.map_err(MapCommandError::from)?)
    }

    /// By which model an impact is judged.
    fn model(&self) -> VerdictModel {
        VerdictModel::named(&self.model).unwrap_or_default()
    }

    /// One column for each file.
    fn files_to_compare(
        &self,
        given: &str,
        files: &str,
        load: impl Fn(&[PathBuf]) -> Result<Parameters, Failure>,
    ) -> Result<Vec<Variant>, Failure> {
        let names: Vec<&str> = files.split(',').map(str::trim).collect();
        if names.len() < 2 || names.contains(&"") {
            let given = given.to_owned();
            return Err(MapCommandError::Compare { given }.into());
        }
        let mut variants = Vec::new();
        for name in names {
            let mut files = self.config.clone();
            files.push(PathBuf::from(name));
            let parameters = load(&files)?;
            variants.push(Variant {
                label: parameters.settings().column_id.clone(),
                parameters,
            });
        }
        Ok(variants)
    }

    pub(super) fn check_outputs(&self) -> Result<(), MapCommandError> {
        let takes = |path: &Option<PathBuf>| path.as_deref().is_some_and(is_standard_output);
        if takes(&self.csv) && takes(&self.json) {
            return Err(MapCommandError::OneOutput("--csv and --json"));
        }
        if self.bands && self.model() != VerdictModel::Bars {
            return Err(MapCommandError::BandsOfBars);
        }
        Ok(())
    }

    /// Whether a table goes to the standard output.
    pub fn takes_standard_output(&self) -> bool {
        [&self.csv, &self.json]
            .into_iter()
            .flatten()
            .any(|path| is_standard_output(path))
    }

    /// Whether the map is written into files.
    pub fn writes_files(&self) -> bool {
        [
            &self.csv,
            &self.json,
            &self.parquet,
            &self.arrow,
            &self.figures,
        ]
        .iter()
        .any(|path| path.is_some())
    }

    /// Whether figures are drawn.
    pub fn wants_figures(&self) -> bool {
        #[cfg(feature = "viewer")]
        let has_viewer = self.rrd.is_some();
        #[cfg(not(feature = "viewer"))]
        let has_viewer = false;
        self.figures.is_some() || has_viewer
    }

    /// Whether only the boundaries are asked for.
    pub fn refines(&self) -> bool {
        self.refine
    }

    /// The cells to compute.
    pub(super) fn cells(&self, map: &DamageMap) -> Result<Range<u64>, MapCommandError> {
        let Some((number, count)) = self.shard_numbers()? else {
            return Ok(0..map.len());
        };
        Ok(map.shard(number, count))
    }

    /// The number of the part that `--shard` names, and the number of parts.
    pub(super) fn shard_numbers(&self) -> Result<Option<(u64, u64)>, MapCommandError> {
        let Some(text) = &self.shard else {
            return Ok(None);
        };
        let parts = text.split_once('/').and_then(|(number, count)| {
            let number: u64 = number.trim().parse().ok()?;
            let count: u64 = count.trim().parse().ok()?;
            (1..=count).contains(&number).then_some((number, count))
        });
        parts.map(Some).ok_or_else(|| MapCommandError::Shard {
            given: text.chars().take(60).collect(),
        })
    }

    /// The options that belong to a map of one column, and whether they are given.
    pub(super) fn options_of_one_column(&self) -> Vec<(&'static str, bool)> {
        let is_axis = |it: &Option<String>| it.as_deref().is_some_and(|it| it.contains([':', ',']));
        let mut options = vec![
            ("--config", !self.config.is_empty()),
            ("an axis of --mass", is_axis(&self.mass)),
            ("--height", self.height.is_some()),
            ("an axis of --direction", is_axis(&self.direction)),
            ("--model", self.model() != VerdictModel::Bars),
            ("--vary", !self.vary.is_empty()),
            ("--compare", self.compare.is_some()),
            ("--refine", self.refine),
            ("--figures", self.figures.is_some()),
        ];
        #[cfg(feature = "viewer")]
        options.push(("--rrd", self.rrd.is_some()));
        options.retain(|(_, is_given)| *is_given);
        options
    }

    /// The overrides for every column of a fleet.
    pub(super) fn fleet_overrides(&self) -> Result<Vec<String>, Failure> {
        let number = |name, text: Option<&str>, example| match text {
            None => Ok(None),
            Some(text) => number_or_axis(name, text, example).map(|it| match it {
                NumberOrAxis::Number(number) => Some(number),
                NumberOrAxis::Axis(_) => None, // rejected before
            }),
        };
        let mass = number("mass", self.mass.as_deref(), "2000")?;
        let direction = number("direction", self.direction.as_deref(), "10")?;
        let numbers = [mass, None, None, None, None, direction];
        let impact = ImpactSpecificationArgs::given(self.vehicle.clone(), numbers);
        let mut all: Vec<_> = impact.implied_override().into_iter().collect();
        all.extend(self.parameter.iter().cloned());
        all.extend(impact.overrides());
        Ok(all)
    }

    /// The option `--velocity`.
    pub(super) fn velocity(&self) -> Option<&str> {
        self.velocity.as_deref()
    }

    /// The batch for so many computations with its threads.
    pub fn batch(&self, computations: u64) -> Batch {
        threads::batch(self.threads, computations)
    }

    /// Number of threads for so many computations.
    pub fn thread_count(&self, computations: u64) -> NonZeroUsize {
        Threads::new(self.threads, computations).used
    }

    /// What the files say about the map, so that they can be put together again.
    pub fn metadata(&self, map: &DamageMap, cells: &Range<u64>) -> MapMetadata {
        let variants: Vec<_> = map
            .variants()
            .iter()
            .map(|it| json!({"label": it.label, "parameters": it.parameters.to_yaml()}))
            .collect();
        vec![
            ("format", "column_twin map 1".to_owned()),
            ("column_twin", format!("\"{}\"", env!("CARGO_PKG_VERSION"))),
            ("row_axis", axis_json(map.rows())),
            ("column_axis", axis_json(map.columns())),
            ("variants", json!(variants).to_string()),
            ("model", map.model().name().to_owned()),
            ("cells_of_the_map", map.len().to_string()),
            (
                "shard",
                self.shard.clone().unwrap_or_else(|| "1/1".to_owned()),
            ),
            ("first_cell", cells.start.to_string()),
        ]
    }
}

fn axis_json(axis: &MapAxis) -> String {
    let quantity = axis.quantity();
    let (name, unit) = (quantity.name(), quantity.unit());
    match axis.values() {
        AxisValues::Range { from, to, count } => {
            json!({"quantity": name, "unit": unit, "from": from, "to": to, "points": count})
        }
        AxisValues::Numbers(numbers) => json!({"quantity": name, "unit": unit, "values": numbers}),
        AxisValues::Names(names) => json!({"quantity": name, "values": names}),
    }
    .to_string()
}

/// A number, or a range with colons.
fn number_or_axis(
    name: &'static str,
    text: &str,
    example: &'static str,
) -> Result<NumberOrAxis, MapCommandError> {
    if let Ok(number) = text.trim().parse() {
        return Ok(NumberOrAxis::Number(number));
    }
    if !text.contains([':', ',']) && !text.trim().is_empty() {
        return Err(MapCommandError::NotANumber {
            name,
            given: text.chars().take(60).collect(),
            example,
        });
    }
    let axis = MapAxis::parse(&format!("{name}={text}"));
    Ok(NumberOrAxis::Axis(axis.map_err(MapError::from)?))
}
