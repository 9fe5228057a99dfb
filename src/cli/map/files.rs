//! The files of a map: each appears complete, or as complete as an interrupted map is, and never half written.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::arguments::MapArgs;
use super::error::MapFileError;
use super::table_writer::{ArrowTable, CsvTable, JsonTable, Metadata, ParquetTable, TableWriter};
use crate::cli::simulate::is_standard_output;
use column_twin::study::{TableColumn, TableValue};
use column_twin::whole_file::WholeFile;

/// Where a table goes.
enum Target<'a> {
    File(Box<WholeFile>),
    Output(&'a mut dyn Write),
}

impl Write for Target<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::File(file) => file.write(bytes),
            Self::Output(output) => output.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::File(file) => file.flush(),
            Self::Output(output) => output.flush(),
        }
    }
}

impl Target<'_> {
    fn commit(mut self) -> io::Result<()> {
        self.flush()?;
        match self {
            Self::File(file) => file.commit(),
            Self::Output(_) => Ok(()),
        }
    }
}

/// A table with its place.
struct Table<W> {
    /// What the summary calls it.
    kind: &'static str,
    path: PathBuf,
    writer: Box<dyn TableWriter<W> + Send>,
}

/// The tables that were asked for.
pub(super) struct Files<'a> {
    /// CSV and JSON, of which one may go to the standard output.
    texts: Vec<TextTable<'a>>,
    /// Parquet and Arrow.
    binaries: Vec<Table<WholeFile>>,
}

struct TextTable<'a> {
    kind: &'static str,
    path: PathBuf,
    writer: Box<dyn TableWriter<Target<'a>> + 'a>,
}

impl<'a> Files<'a> {
    /// Opens the files, so that a folder that is missing ends the command before anything is computed.
    pub fn create(
        arguments: &MapArgs,
        columns: &[TableColumn],
        metadata: &Metadata,
        list: &str,
        output: &'a mut dyn Write,
    ) -> Result<Self, MapFileError> {
        let mut files = Self {
            texts: Vec::new(),
            binaries: Vec::new(),
        };
        let mut output = Some(output);
        let texts = [("CSV", &arguments.csv), ("JSON", &arguments.json)];
        for (kind, path) in texts
            .into_iter()
            .filter_map(|(kind, path)| Some((kind, path.as_ref()?)))
        {
            let failed = |reason| failed(path, reason);
            let target = match output.take_if(|_| is_standard_output(path)) {
                Some(output) => Target::Output(output),
                None => Target::File(Box::new(WholeFile::create(path).map_err(failed)?)),
            };
            let writer: Box<dyn TableWriter<Target<'a>> + 'a> = match kind {
                "CSV" => Box::new(CsvTable::new(target, columns).map_err(failed)?),
                _ => Box::new(JsonTable::new(target, columns, metadata, list).map_err(failed)?),
            };
            files.texts.push(TextTable {
                kind,
                path: path.clone(),
                writer,
            });
        }
        let binaries = [("Parquet", &arguments.parquet), ("Arrow", &arguments.arrow)];
        for (kind, path) in binaries
            .into_iter()
            .filter_map(|(kind, path)| Some((kind, path.as_ref()?)))
        {
            let failed = |reason| failed(path, reason);
            let target = WholeFile::create(path).map_err(failed)?;
            let writer: Box<dyn TableWriter<WholeFile> + Send> = match kind {
                "Parquet" => {
                    Box::new(ParquetTable::new(target, columns, metadata).map_err(failed)?)
                }
                _ => Box::new(ArrowTable::new(target, columns, metadata).map_err(failed)?),
            };
            files.binaries.push(Table {
                kind,
                path: path.clone(),
                writer,
            });
        }
        Ok(files)
    }

    /// Writes a row into every file.
    pub fn row(&mut self, values: &[TableValue<'_>]) -> Result<(), MapFileError> {
        for table in &mut self.texts {
            table
                .writer
                .row(values)
                .map_err(|reason| failed(&table.path, reason))?;
        }
        for table in &mut self.binaries {
            table
                .writer
                .row(values)
                .map_err(|reason| failed(&table.path, reason))?;
        }
        Ok(())
    }

    /// Completes the files and gives them their names; returns the lines of the summary about them.
    pub fn finish(self, closing: &Metadata) -> Result<String, MapFileError> {
        let mut lines = String::new();
        let mut line = |kind: &str, path: &Path| {
            if !is_standard_output(path) {
                let _ = writeln!(lines, "{kind:<10} {}", path.display());
            }
        };
        for table in self.texts {
            let written = table.writer.finish(closing).and_then(Target::commit);
            match written.map_err(|reason| failed(&table.path, reason)) {
                Err(error) if error.is_closed() => {}
                other => other?,
            }
            line(table.kind, &table.path);
        }
        for table in self.binaries {
            let written = table.writer.finish(closing).and_then(WholeFile::commit);
            written.map_err(|reason| failed(&table.path, reason))?;
            line(table.kind, &table.path);
        }
        Ok(lines)
    }
}

fn failed(path: &Path, reason: io::Error) -> MapFileError {
    MapFileError {
        path: path.to_owned(),
        reason,
    }
}
