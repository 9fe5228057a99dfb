//! `column-twin map`: what impacts on a column lead to, over a plane of two quantities.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - arguments.rs: The arguments of `column-twin map`, and the map that they describe
// - boundaries.rs: The refined boundaries of a map as a table, for files and for people
// - error.rs: Why there is no map, and how a map ends
// - files.rs: The files of a map: each appears complete, or as complete as an interrupted map is, and never half written
// - fleet.rs: `column-twin map` of a fleet: the critical velocities of one vehicle for each of its columns
// - summary.rs: What a map shows, for people and as JSON: classes with their shares, critical velocities, the largest numbers
// - table_writer.rs: Tables as CSV, JSON, Parquet and Arrow, row by row, in a memory that does not depend on the number of rows

mod arguments;
mod boundaries;
mod error;
mod files;
mod fleet;
mod summary;
mod table_writer;

use std::fmt::Write as _;
use std::io::{self, Write};
use std::time::Instant;

pub use arguments::MapArgs;

use super::failure::Failure;
use super::interruption::Interruption;
use boundaries::{boundary_columns, boundary_rows, show_bands, show_boundaries};
use column_twin::column::Support;
use column_twin::figures::{self, MapFigures};
use column_twin::study::{Batch, BatchEnd, DamageMap, MapBands, MapGrid, RefinedMap, TableValue};
use error::{Ended, MapCommandError, MapFileError};
use files::Files;
use summary::{MapSummary, extent};

/// Computes the map and writes the requested files; the summary goes to `output`, unless a file does.
pub(super) fn run(arguments: &MapArgs, output: &mut dyn Write) -> Result<(), Failure> {
    if arguments.fleet.is_given() {
        return fleet::run(arguments, output);
    }
    arguments.fleet.check(&[])?;
    let map = arguments.map()?;
    match arguments.refines() {
        true => refine(arguments, &map, output),
        false => compute(arguments, &map, output),
    }
}

fn compute(arguments: &MapArgs, map: &DamageMap, output: &mut dyn Write) -> Result<(), Failure> {
    let cells = arguments.cells(map)?;
    let to_error = arguments.takes_standard_output();
    let metadata = arguments.metadata(map, &cells);
    let mut files = Files::create(
        arguments,
        &map.table_columns(),
        &metadata,
        "cells",
        &mut *output,
    )
    .map_err(MapCommandError::from)?;
    let mut grid = (arguments.wants_figures()).then(|| MapGrid::of(map));
    let mut summary = MapSummary::new(map);
    let start = Instant::now();
    let mut end_cell = cells.start;
    let batch = arguments.batch(cells.end - cells.start);
    let interruption = Interruption::listen();
    let result = interruption.watch(&batch, cells.end - cells.start, "impacts", || {
        map.compute(&batch, cells.clone(), |part| {
            for cell in &part {
                let values: Vec<TableValue<'_>> = map.table_values(cell).collect();
                files.row(&values)?;
                summary.add(cell);
                if let Some(grid) = &mut grid {
                    grid.push(cell);
                }
                end_cell = cell.index + 1;
            }
            Ok::<(), MapCommandError>(())
        })
    });
    // A reader that stops reading early is not a failure.
    let end = match result {
        Err(MapCommandError::File(error)) if error.is_closed() => BatchEnd::Complete,
        other => other?,
    };
    let elapsed = start.elapsed();
    let is_complete = end == BatchEnd::Complete;

    // The figures draw boundaries more exactly than the cells show them.
    let mut refined = None;
    if grid.is_some() && is_complete && arguments.shard.is_none() && map.columns().ends().is_some()
    {
        refined = interruption
            .watch(&batch, 0, "impacts", || map.refine(&batch))
            .ok();
        if let Some(refined) = &refined {
            summary.refine(refined);
        }
    }
    let bands = match &refined {
        Some(refined) => bands(arguments, map, refined, &batch, &interruption)?,
        None => None,
    };
    drop(interruption);
    let closing = [
        ("end_cell", end_cell.to_string()),
        ("complete", is_complete.to_string()),
        (
            "summary",
            summary
                .json()
                .map_err(io::Error::other)
                .map_err(MapCommandError::Output)?,
        ),
    ];
    let written = files.finish(&closing).map_err(MapCommandError::from)?;
    let mut text = arguments.heading(map);
    let count = end_cell - cells.start;
    let _ = writeln!(
        text,
        "{count} responses in {:.1} s on {} threads\n",
        elapsed.as_secs_f64(),
        arguments.thread_count(cells.end - cells.start),
    );
    let _ = write!(text, "{summary}");
    text.push_str(&written);
    if let Some(bands) = &bands {
        text.push_str(&show_bands(map, bands));
    }
    if let Some(grid) = &grid {
        let (refined, bands) = (refined.as_ref(), bands.as_ref());
        text.push_str(&draw(arguments, map, Some(grid), refined, bands)?);
    }
    let mut missing = Vec::new();
    if !is_complete {
        missing.push(interrupted(map, &cells, end_cell, arguments.writes_files()));
    }
    if let Some(fault) = summary.first_fault() {
        missing.push(format!(
            "{} of the impacts could not be computed; the first one: {fault}",
            summary.faults()
        ));
    }
    let missing = (!missing.is_empty()).then(|| missing.join("\n"));
    Ended { text, missing }.print(to_error, output)
}

/// What an interrupted map has.
fn interrupted(map: &DamageMap, cells: &std::ops::Range<u64>, end: u64, has_files: bool) -> String {
    let total = cells.end - cells.start;
    let place = map.place(end.min(map.len() - 1));
    let variant = match map.variants() {
        [_] => String::new(),
        variants => format!(" of {}", variants[place.variant].label),
    };
    let files = if has_files {
        "; the files contain these"
    } else {
        ""
    };
    format!(
        "interrupted: {} of {total} impacts are done, the cells {} to {}, up to column {} of row {} of {}{variant}{files}",
        end - cells.start,
        cells.start,
        end.saturating_sub(1),
        place.column,
        place.row + 1,
        map.rows().len(),
    )
}

fn refine(arguments: &MapArgs, map: &DamageMap, output: &mut dyn Write) -> Result<(), Failure> {
    let to_error = arguments.takes_standard_output();
    let metadata = arguments.metadata(map, &(0..map.len()));
    let mut files = Files::create(
        arguments,
        &boundary_columns(map),
        &metadata,
        "boundaries",
        &mut *output,
    )
    .map_err(MapCommandError::from)?;
    let batch = arguments.batch(map.len());
    let start = Instant::now();
    let interruption = Interruption::listen();
    let refined = interruption.watch(&batch, 0, "impacts", || map.refine(&batch));
    let refined: RefinedMap = refined.map_err(MapCommandError::from)?;
    let elapsed = start.elapsed();
    let bands = match refined.complete {
        true => bands(arguments, map, &refined, &batch, &interruption)?,
        false => None,
    };
    drop(interruption);
    let bands = bands.as_ref();
    boundary_rows(map, &refined, bands, |values| files.row(values))
        .map_err(MapCommandError::from)?;
    let closing = [
        ("responses", refined.responses.to_string()),
        ("complete", refined.complete.to_string()),
    ];
    let written = files.finish(&closing).map_err(MapCommandError::from)?;
    let mut text = arguments.heading(map);
    let _ = writeln!(
        text,
        "Boundaries to 1 % with {} responses in {:.2} s on {} threads; a map of all cells takes {}\n",
        refined.responses,
        elapsed.as_secs_f64(),
        arguments.thread_count(map.len()),
        map.len(),
    );
    text.push_str(&show_boundaries(map, &refined));
    if let Some(bands) = bands {
        text.push_str(&show_bands(map, bands));
    }
    text.push_str(&written);
    if arguments.wants_figures() {
        text.push_str(&draw(arguments, map, None, Some(&refined), bands)?);
    }
    let mut missing = Vec::new();
    if arguments.bands && bands.is_none_or(|it| !it.complete) {
        missing.push("interrupted: the bands of the boundaries are not complete".to_owned());
    }
    if !refined.complete {
        missing.push(
            "interrupted: the boundaries are known in the rows that were done, and not to 1 % between them".to_owned(),
        );
    }
    if let Some(fault) = refined.faults.first() {
        missing.push(format!(
            "{} of the rows could not be computed, or not in whole; the first one: {}",
            refined.faults.len(),
            fault.reason
        ));
    }
    let missing = (!missing.is_empty()).then(|| missing.join("\n"));
    Ended { text, missing }.print(to_error, output)
}

/// The bands of the boundaries, if they are asked for.
fn bands(
    arguments: &MapArgs,
    map: &DamageMap,
    refined: &RefinedMap,
    batch: &Batch,
    interruption: &Interruption,
) -> Result<Option<MapBands>, MapCommandError> {
    if !arguments.bands {
        return Ok(None);
    }
    let found = interruption.watch(batch, 0, "rows", || map.bands(refined, batch));
    Ok(Some(found?))
}

/// Draws the figures and the file of the viewer, and says where they are.
fn draw(
    arguments: &MapArgs,
    map: &DamageMap,
    grid: Option<&MapGrid>,
    refined: Option<&RefinedMap>,
    bands: Option<&MapBands>,
) -> Result<String, MapCommandError> {
    let mut text = String::new();
    let figures = MapFigures {
        map,
        grid,
        refined,
        bands,
        subject: &arguments.subject(map),
        assumptions: &assumptions(map),
    };
    if let Some(folder) = &arguments.figures {
        let count = figures::draw_map(folder, &figures)?.len();
        let _ = writeln!(text, "Figures    {count} files in {}", folder.display());
    }
    #[cfg(feature = "viewer")]
    if let Some(path) = &arguments.rrd {
        column_twin::viewer::write_map_rrd(path, map, grid, refined)?;
        let _ = writeln!(text, "Viewer     rerun {}", path.display());
    }
    Ok(text)
}

/// What the first column of the map assumes beside its axes, in one line.
fn assumptions(map: &DamageMap) -> String {
    let axes = [map.rows(), map.columns()].map(|axis| axis.quantity().name());
    let parameters = &map.variants()[0].parameters;
    let p = parameters.column_properties();
    let support = |support| match support {
        Support::BuiltIn => "built in",
        Support::Pinned => "pinned",
        Support::Free => "free",
        Support::SemiRigid { .. } => "semi-rigid",
    };
    let mut parts = Vec::new();
    if !axes.contains(&"top.load") {
        let load = 1e-3 * p.top_load;
        parts.push(format!("{} kN", column_twin::report::short(load)));
    }
    parts.push(match p.base == p.top {
        true => format!("{} at base and top", support(p.base)),
        false => format!("{} base, {} top", support(p.base), support(p.top)),
    });
    let strength = 1e-6 * parameters.steel().yield_strength;
    parts.push(format!("f_y {} MPa", column_twin::report::short(strength)));
    parts.push(match p.hardening_ratio {
        0.0 => "no hardening".to_owned(),
        ratio => format!("{} % hardening", column_twin::report::short(100.0 * ratio)),
    });
    parts.push(match p.rate {
        Some(_) => "strain rate".to_owned(),
        None => "no strain rate".to_owned(),
    });
    parts.push(match p.shear {
        Some(_) => "web shear".to_owned(),
        None => "no web shear".to_owned(),
    });
    parts.push(match p.softening {
        Some(_) => "local buckling".to_owned(),
        None => "no local buckling".to_owned(),
    });
    format!("Assumes {}", parts.join(", "))
}

/// The parameters that nobody has given and whose defaults are assumed, of the first column of the map.
fn assumed(map: &DamageMap) -> Vec<&'static str> {
    let base = &map.variants()[0].parameters;
    let of_axes = [map.rows(), map.columns()].map(|axis| axis.changes(base, axis.value(0)));
    // A section along an axis may be given without the rest.
    let first = base.with_changes(of_axes.concat());
    let first = first.as_ref().unwrap_or(base).settings();
    let assumed = first.assessment.assumed.iter();
    assumed.map(|it| it.name()).collect()
}

impl MapArgs {
    /// What the map is about, in one line.
    fn subject(&self, map: &DamageMap) -> String {
        let settings = map.variants()[0].parameters.settings();
        let column = match map.variants() {
            [only] => only.label.clone(),
            variants => {
                let labels: Vec<_> = variants.iter().map(|it| it.label.as_str()).collect();
                format!("{} ({})", settings.column_id, labels.join(", "))
            }
        };
        let axes = [map.rows(), map.columns()].map(|axis| axis.quantity().name());
        let is_varied = |name: &str| axes.contains(&name);
        let mut text = column;
        if !is_varied("vehicle") {
            let vehicle = match settings.vehicle.name.as_str() {
                "" => "user-defined vehicle",
                "rigid" => "rigid mass",
                name => name,
            };
            let _ = write!(text, ", {vehicle}");
        }
        let impact = map.variants()[0].parameters.whole_impact();
        if !is_varied("mass") && !is_varied("vehicle") {
            let _ = write!(text, ", {} kg", column_twin::report::short(impact.mass));
        }
        if !is_varied("velocity") {
            let _ = write!(
                text,
                ", {} m/s",
                column_twin::report::short(impact.velocity)
            );
        }
        if !is_varied("height") && !is_varied("geometry.length_below") {
            let height = settings.geometry.length_below;
            let _ = write!(
                text,
                ", {} m above the base",
                column_twin::report::short(height)
            );
        }
        let component = column_twin::parameters::component_in_words(settings.impact.direction);
        if let Some(component) = component.filter(|_| !is_varied("direction")) {
            let _ = write!(text, "; {component}");
        }
        let is_oblique = is_varied("direction")
            || column_twin::second_opinion::is_out_of_plane(settings.impact.direction);
        match map.model().in_words() {
            Some(model) => {
                let _ = write!(text, "; judged {model}");
            }
            None if is_oblique => {
                text += "; lower bounds by the two bars alone (see --model)";
            }
            None => (),
        }
        let assumed = assumed(map);
        let assumed: Vec<_> = assumed
            .into_iter()
            .filter(|it| !axes.contains(it))
            .collect();
        if !assumed.is_empty() {
            let _ = write!(text, "; assumed inputs: {}", assumed.join(", "));
        }
        text
    }

    fn heading(&self, map: &DamageMap) -> String {
        let count = match map.variants().len() {
            1 => String::new(),
            count => format!("{count} x "),
        };
        format!(
            "{}\n{}, {}: {count}{} x {} impacts\n",
            self.subject(map),
            extent(map.rows()),
            extent(map.columns()),
            map.rows().len(),
            map.columns().len(),
        )
    }
}
