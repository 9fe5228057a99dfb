//! The columns of a fleet as the object of a study.

use std::path::PathBuf;

use clap::Args;

use super::failure::{Exit, Failure};
use column_twin::parameters::{
    FleetColumn, FleetColumns, FleetSources, NodeName, Source, parse_override,
};
use printable::Printable;

/// The columns of a fleet, as `column-twin fleet` reads them.
#[derive(Debug, Args)]
pub struct FleetStudyArgs {
    /// Parameter file of a fleet, as of `column-twin fleet`, may be repeated: one result for each of its columns; columns that
    /// differ by their names only are computed once
    #[arg(long, value_name = "FILE")]
    params_file: Vec<PathBuf>,
    /// Table of the columns of a fleet (CSV), as of `column-twin fleet`; wins over the parameter files
    #[arg(long, value_name = "FILE")]
    columns: Option<PathBuf>,
    /// For a fleet, only the columns with these identifiers, separated by commas
    #[arg(long, value_name = "ID,ID", value_delimiter = ',')]
    column: Vec<String>,
}

impl FleetStudyArgs {
    /// Whether the study is one of a fleet.
    pub fn is_given(&self) -> bool {
        !self.params_file.is_empty() || self.columns.is_some()
    }

    /// # Errors
    /// Columns are named without a fleet, or an option is given that a study of a fleet does not have: its name and whether it is
    /// given.
    pub fn check(&self, others: &[(&str, bool)]) -> Result<(), Failure> {
        if !self.is_given() {
            return match self.column.is_empty() {
                true => Ok(()),
                false => Err(bad_input(
                    "--column names columns of a fleet; give the fleet with --params-file or --columns".to_owned(),
                )),
            };
        }
        let given: Vec<_> = others
            .iter()
            .filter(|(_, is_given)| *is_given)
            .map(|(name, _)| *name)
            .collect();
        match given.is_empty() {
            true => Ok(()),
            false => Err(bad_input(format!(
                "a study of a fleet (--params-file, --columns) does not have {}; leave it out, or name one column with --config",
                given.join(", ")
            ))),
        }
    }

    /// The columns that are wanted, with these overrides for each.
    ///
    /// # Errors
    /// All faults of the files, or columns that the fleet does not have.
    pub fn load(&self, overrides: &[String]) -> Result<Vec<FleetColumn>, Failure> {
        let overrides = overrides
            .iter()
            .map(|text| Source::Override(parse_override(text)));
        let sources = FleetSources {
            files: self.params_file.clone(),
            table: self.columns.clone(),
            arguments: overrides.collect(),
        };
        let FleetColumns {
            mut columns,
            warnings,
            ..
        } = FleetColumns::load(&NodeName::default(), &sources)?;
        for warning in &warnings {
            tell!("Warning: {warning}");
        }
        let is_of =
            |column: &FleetColumn, id: &String| column.parameters.settings().column_id == *id;
        let wanted = &self.column;
        let missing: Vec<_> = wanted
            .iter()
            .filter(|id| !columns.iter().any(|it| is_of(it, id)))
            .map(|it| Printable(it).to_string())
            .collect();
        if !missing.is_empty() {
            return Err(bad_input(format!(
                "the fleet of {} columns has no {}; --column takes values of column_id",
                columns.len(),
                missing.join(", ")
            )));
        }
        if !wanted.is_empty() {
            columns.retain(|column| wanted.iter().any(|id| is_of(column, id)));
        }
        Ok(columns)
    }
}

fn bad_input(text: String) -> Failure {
    Failure::plain(Exit::BadInput, text)
}

/// Number of columns that a summary lists.
pub(super) const LISTED_COLUMNS: usize = 20;

/// The lines of a table for people: each field as wide as its longest text, the first one to the left.
pub(super) fn aligned(rows: &[Vec<String>]) -> String {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |field: usize| {
        let texts = rows.iter().filter_map(|row| row.get(field));
        texts.map(|it| it.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<_> = (0..count).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let fields = row.iter().zip(&widths).enumerate();
        let fields: Vec<_> = fields
            .map(|(index, (field, width))| match index {
                0 => format!("{field:width$}"),
                _ => format!("{field:>width$}"),
            })
            .collect();
        text.push_str(fields.join("  ").trim_end());
        text.push('\n');
    }
    text
}
