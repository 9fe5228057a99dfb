//! The arguments of the commands that look at recorded readings, and the table that they name.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use clap::Args;

use super::failure::{Exit, Failure};
use super::impact_args::ImpactSpecificationArgs;
use super::simulate::parameters_of;
use column_twin::estimation::{Readings, ReadingsError};
use column_twin::parameters::Parameters;
use column_twin::sensors::Sensor;

/// A column with sensors, and what they have read.
#[derive(Debug, Args)]
pub struct RecordedReadingsArgs {
    /// Parameter file (ROS 2 YAML), may be repeated: later files win; one of them declares the sensors
    #[arg(long, short, value_name = "FILE", required = true)]
    config: Vec<PathBuf>,
    /// Any parameter in the notation of ROS 2, for example -p top.load:=2.0e6; may be repeated
    #[arg(long = "param", short, value_name = "NAME:=VALUE")]
    parameter: Vec<String>,
    /// Readings as CSV: a column `time` [s] and one column for each sensor, by its name; - is the standard input
    #[arg(long, value_name = "FILE")]
    readings: PathBuf,
}

/// Why there are no readings.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
enum RecordedReadingsError {
    #[error("cannot read {}: {reason}", path.display())]
    #[diagnostic(help("name a readable CSV file"))]
    Unreadable { path: PathBuf, reason: io::Error },
    #[error("{}: {fault}", path.display())]
    #[diagnostic(help(
        "the first line names the columns: time, and the sensors as in sensors.names"
    ))]
    Table { path: PathBuf, fault: ReadingsError },
}

impl From<RecordedReadingsError> for Failure {
    fn from(fault: RecordedReadingsError) -> Self {
        Self::new(Exit::BadInput, fault)
    }
}

impl RecordedReadingsArgs {
    /// The column's parameters.
    pub fn parameters(&self) -> Result<Parameters, Failure> {
        let impact = ImpactSpecificationArgs::default();
        parameters_of(&self.config, &self.parameter, &impact)
    }

    /// The table's path; `-` is the standard input.
    pub fn path(&self) -> &Path {
        &self.readings
    }

    /// Reads the table.
    pub fn read(&self, sensors: &[Sensor]) -> Result<Readings, Failure> {
        let path = || self.readings.clone();
        let read = |source: &mut dyn io::Read| Readings::from_csv(source, sensors);
        let readings = if self.path() == Path::new("-") {
            read(&mut io::stdin().lock())
        } else {
            let file = File::open(self.path()).map_err(|reason| {
                let path = path();
                RecordedReadingsError::Unreadable { path, reason }
            })?;
            read(&mut BufReader::new(file))
        };
        let readings = readings.map_err(|fault| {
            let path = path();
            RecordedReadingsError::Table { path, fault }
        })?;
        Ok(readings)
    }
}
