//! `column-twin export`: exports the messages of a recording as tables or as JSON.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::failure::{Exit, Failure, unless_closed};
use column_twin::recording::{Decoded, Decoder, Message, Reader, RecordingError};
use column_twin::whole_file::WholeFile;

/// Arguments of `column-twin export`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
#[command(group = clap::ArgGroup::new("format").required(true))]
pub struct ExportArgs {
    /// Directory of the recording, or an MCAP file
    #[arg(value_name = "RECORDING")]
    bag: PathBuf,
    /// Write a directory with one CSV table per topic, one row per message
    #[arg(long, group = "format")]
    csv: bool,
    /// Write one file with one JSON message per line
    #[arg(long, group = "format")]
    json: bool,
    /// Directory or file to write; default: next to the recording, with _csv or .jsonl appended to its name; with -,
    /// JSON goes to the standard output
    #[arg(long, short, value_name = "PATH")]
    output: Option<PathBuf>,
    /// Topics to export; default: all
    #[arg(long, value_name = "TOPIC", num_args = 1..)]
    topics: Vec<String>,
}

const EXAMPLE: &str = "\
Example: displacements and hinge forces for a spreadsheet
  column-twin export ~/.local/state/column_twin/recordings/column_twin_2026_11_21-07_40_00 --csv \\
    --topics /column_state /hinge_forces

In a CSV table, a text that a spreadsheet would take for a formula (it begins with =, +, -, @, a
tab or a carriage return) begins with an apostrophe, and control characters other than line
feeds are escaped. Times are in nanoseconds since 1970. Messages are decoded with the
definitions in the recording, so that every rosbag2 MCAP file can be exported. Nothing is
overwritten.
Exit codes: 0 done, 1 failed, 2 bad input or usage, 3 done, but some topics or messages could
not be decoded.";

/// Writes the messages and prints where they are.
pub fn run(arguments: &ExportArgs, out: &mut impl Write) -> Result<(), Failure> {
    let reader = Reader::open(&arguments.bag)?;
    let bag = arguments.bag.display();
    if !reader.wholeness().is_whole() {
        let reason = format!(
            "{bag} is {}; repair it first: column-twin repair {bag}",
            reader.wholeness()
        );
        return Err(Failure::plain(Exit::BadInput, reason));
    }
    let mut selection = Selection::new(&reader, &arguments.topics)?;
    let to_stdout = arguments.output.as_deref() == Some(Path::new("-"));
    if to_stdout && arguments.csv {
        return Err(Failure::plain(
            Exit::BadInput,
            "CSV tables need a directory; give --output DIR",
        ));
    }
    let output = arguments
        .output
        .clone()
        .unwrap_or_else(|| default_output(&arguments.bag, arguments.csv));
    if !to_stdout && output.symlink_metadata().is_ok() {
        return Err(RecordingError::Exists { path: output }.into());
    }
    let written = if to_stdout {
        let written = write_json(&reader, &mut selection, out).map(drop);
        unless_closed(written)
            .map(|()| 0)
            .map_err(|error| unwritable(&output, error))
    } else if arguments.csv {
        write_tables(&reader, &mut selection, &output)
    } else {
        write_json_file(&reader, &mut selection, &output)
    };
    let messages = written?;
    if !to_stdout {
        // A failure to print cannot be reported.
        let _ = writeln!(out, "{messages} messages written to {}", output.display());
    }
    selection.losses()
}

/// The topics and messages that are exported, and those that cannot be decoded.
struct Selection {
    /// By the index of the topic.
    decoders: BTreeMap<usize, Decoder>,
    undecodable_topics: Vec<String>,
    undecodable_messages: u64,
    first_fault: Option<String>,
}

impl Selection {
    fn new(reader: &Reader, wanted: &[String]) -> Result<Self, Failure> {
        if let Some(unknown) = wanted
            .iter()
            .find(|name| reader.topics().iter().all(|it| *it.name != ***name))
        {
            let names: Vec<&str> = reader.topics().iter().map(|it| &*it.name).collect();
            let reason = format!(
                "expected one of the topics {}, found {unknown}",
                names.join(", ")
            );
            return Err(Failure::plain(Exit::BadInput, reason));
        }
        let (mut decoders, mut undecodable_topics) = (BTreeMap::new(), Vec::new());
        for (index, topic) in reader.topics().iter().enumerate() {
            if !wanted.is_empty() && wanted.iter().all(|name| **name != *topic.name) {
                continue;
            }
            match Decoder::new(topic) {
                Ok(decoder) => drop(decoders.insert(index, decoder)),
                Err(error) => undecodable_topics.push(error.to_string()),
            }
        }
        if decoders.is_empty() {
            let reason = match undecodable_topics.is_empty() {
                true => "the recording has no topics to export".to_owned(),
                false => undecodable_topics.join("\n"),
            };
            return Err(Failure::plain(Exit::BadInput, reason));
        }
        Ok(Self {
            decoders,
            undecodable_topics,
            undecodable_messages: 0,
            first_fault: None,
        })
    }

    /// Decodes a message of a selected topic; counts it if it cannot be decoded.
    fn decode(&mut self, message: &Message) -> Option<(&Decoder, Decoded)> {
        let decoder = self.decoders.get(&message.topic_index)?;
        match decoder.decode(message) {
            Ok(content) => Some((decoder, content)),
            Err(error) => {
                self.undecodable_messages += 1;
                self.first_fault.get_or_insert_with(|| error.to_string());
                None
            }
        }
    }

    /// Reports what could not be decoded.
    fn losses(self) -> Result<(), Failure> {
        let mut lines = self.undecodable_topics;
        if let Some(first) = self.first_fault {
            lines.push(format!(
                "{} messages could not be decoded and are left out; the first: {first}",
                self.undecodable_messages
            ));
        }
        match lines.is_empty() {
            true => Ok(()),
            false => Err(Failure::plain(Exit::Lossy, lines.join("\n"))),
        }
    }
}

/// The default output, next to the recording.
fn default_output(bag: &Path, csv: bool) -> PathBuf {
    let whole = fs::canonicalize(bag).unwrap_or_else(|_| bag.to_path_buf());
    let name = if bag.is_dir() {
        whole.file_name()
    } else {
        whole.file_stem()
    };
    let name = name.unwrap_or_default().to_string_lossy();
    bag.with_file_name(format!("{name}{}", if csv { "_csv" } else { ".jsonl" }))
}

fn unwritable(path: &Path, error: impl std::fmt::Display) -> Failure {
    Failure::plain(
        Exit::Failed,
        format!("cannot write {}: {error}", path.display()),
    )
}

fn write_json_file(
    reader: &Reader,
    selection: &mut Selection,
    path: &Path,
) -> Result<u64, Failure> {
    let failed = |error: std::io::Error| unwritable(path, error);
    let mut file = WholeFile::create(path).map_err(failed)?;
    let messages = write_json(reader, selection, &mut file).map_err(failed)?;
    file.commit().map_err(failed)?;
    Ok(messages)
}

fn write_json(
    reader: &Reader,
    selection: &mut Selection,
    out: &mut impl Write,
) -> std::io::Result<u64> {
    let mut messages = 0;
    for message in reader.messages() {
        let message = message.map_err(std::io::Error::other)?;
        if let Some((_, content)) = selection.decode(&message) {
            let line = json!({
                "topic": &*message.topic,
                "type": &*message.type_name,
                "log_time": message.log_time,
                "publish_time": message.publish_time,
            });
            // The content keeps the order of its fields, which a map of values would not.
            let head = line.to_string();
            let head = head.trim_end_matches('}');
            writeln!(
                out,
                "{head},\"message\":{}}}",
                serde_json::to_string(&content)?
            )?;
            messages += 1;
        }
    }
    Ok(messages)
}

/// Writes to a temporary directory, which is renamed when it is complete.
fn write_tables(
    reader: &Reader,
    selection: &mut Selection,
    directory: &Path,
) -> Result<u64, Failure> {
    let failed = |error: std::io::Error| unwritable(directory, error);
    let parent = match directory.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let temporary = tempfile::Builder::new()
        .prefix(".column-twin-export-")
        .tempdir_in(parent)
        .map_err(failed)?;
    let unnamed = temporary.path().join("tables");
    fs::create_dir(&unnamed).map_err(failed)?;
    let mut tables = Tables::create(reader, selection, &unnamed).map_err(failed)?;
    let mut messages = 0;
    for message in reader.messages() {
        let message = message?;
        if let Some((decoder, content)) = selection.decode(&message) {
            tables
                .add(&message, decoder.cells(&content))
                .map_err(failed)?;
            messages += 1;
        }
    }
    tables.finish().map_err(failed)?;
    fs::rename(&unnamed, directory).map_err(failed)?;
    Ok(messages)
}

/// One table per topic.
struct Tables(BTreeMap<usize, csv::Writer<BufWriter<File>>>);

impl Tables {
    fn create(reader: &Reader, selection: &Selection, directory: &Path) -> std::io::Result<Self> {
        let mut tables = BTreeMap::new();
        for (index, decoder) in &selection.decoders {
            let name = reader.topics().get(*index).map_or("", |topic| &*topic.name);
            let path = file_for(directory, name);
            let file = File::options().write(true).create_new(true).open(path)?;
            let mut table = csv::Writer::from_writer(BufWriter::new(file));
            let times = ["log_time", "publish_time"].map(str::to_owned);
            table.write_record(times.into_iter().chain(decoder.columns()))?;
            tables.insert(*index, table);
        }
        Ok(Self(tables))
    }

    fn add(&mut self, message: &Message, cells: Vec<String>) -> std::io::Result<()> {
        let Some(table) = self.0.get_mut(&message.topic_index) else {
            return Ok(());
        };
        let times = [message.log_time, message.publish_time].map(|time| time.to_string());
        Ok(table.write_record(times.into_iter().chain(cells))?)
    }

    fn finish(self) -> std::io::Result<()> {
        for (_, table) in self.0 {
            let file = table
                .into_inner()
                .map_err(csv::IntoInnerError::into_error)?;
            file.into_inner()
                .map_err(std::io::IntoInnerError::into_error)?;
        }
        Ok(())
    }
}

/// An unused file name: for `/garage/column_state`, `garage.column_state.csv`.
fn file_for(directory: &Path, topic: &str) -> PathBuf {
    const MAX_LENGTH: usize = 200;
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || "_-".contains(c) {
            c
        } else {
            '.'
        }
    };
    let name: String = topic
        .trim_start_matches('/')
        .chars()
        .map(plain)
        .take(MAX_LENGTH)
        .collect();
    let name = if name.trim_matches('.').is_empty() {
        "topic"
    } else {
        &name
    };
    let first = directory.join(format!("{name}.csv"));
    let more = (2..).map(|number| directory.join(format!("{name}_{number}.csv")));
    std::iter::once(first.clone())
        .chain(more)
        .find(|path| !path.exists())
        .unwrap_or(first)
}
