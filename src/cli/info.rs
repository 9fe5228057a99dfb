//! `column-twin info`: summarises a recording.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use serde_json::{Value as Json, json};

use super::failure::{Exit, Failure, printed};
use column_twin::column::{End, Outcome};
use column_twin::messages::words::mass_in_words;
use column_twin::recording::{
    self, EventSummary, FLUSH_WITHIN, Reader, RecordedTopic, RecordingError, SealFinding, instant,
};
use column_twin::report::end_in_words;
use column_twin::results::outcome_word;
use printable::PrintableWriter;

/// Arguments of `column-twin info`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct InfoArgs {
    /// Directory of the recording, or an MCAP file
    #[arg(value_name = "RECORDING")]
    bag: PathBuf,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

/// Maximum width of a column of the table of topics \[characters\].
const MAX_WIDTH: usize = 80;

const EXAMPLE: &str = "\
Example: list the impacts of a recording and their outcomes
  column-twin info ~/.local/state/column_twin/recordings/column_twin_2026_11_21-07_40_00

Reads recordings of this program and any other MCAP file; impacts are listed if the file contains
messages of column_twin. The seal is checked, the messages are not: column-twin verify does both.
Exit codes: 0 everything in the file can be read, 1 failed, 2 bad input, or the file is cut off or
damaged.";

/// Prints the summary of the recording.
pub fn run(arguments: &InfoArgs, out: &mut impl Write) -> Result<(), Failure> {
    let reader = Reader::open(&arguments.bag)?;
    let events = recording::summarise_events(&reader);
    let written = match arguments.json {
        true => writeln!(out, "{:#}", as_json(&reader, &events)),
        false => print(&reader, &events, &mut PrintableWriter(out)),
    };
    printed(written)?;
    events?;
    if !reader.wholeness().is_whole() {
        let bag = arguments.bag.display();
        let advice = format!(
            "{bag} is {}; everything listed above can be read and saved with: column-twin repair {bag}",
            reader.wholeness()
        );
        return Err(Failure::plain(Exit::BadInput, advice));
    }
    Ok(())
}

type EventSummaries = Result<(Vec<EventSummary>, u64), RecordingError>;

fn print(reader: &Reader, events: &EventSummaries, out: &mut impl Write) -> io::Result<()> {
    print_head(reader, out)?;
    writeln!(out, "\nTopics")?;
    // A longer name moves its own line only. Rust accepts no width above 65 535.
    let width_of = |text: fn(&RecordedTopic) -> &str| {
        let widths = reader.topics().iter().map(|it| text(it).chars().count());
        widths.max().unwrap_or(0).min(MAX_WIDTH)
    };
    let width = width_of(|it| &it.name);
    let type_width = width_of(|it| &it.type_name);
    for topic in reader.topics() {
        let RecordedTopic {
            name,
            type_name,
            messages,
            ..
        } = topic;
        write!(
            out,
            "  {name:width$}  {type_name:type_width$}  {messages:>9}"
        )?;
        match note(topic) {
            Some(note) => writeln!(out, "  {note}")?,
            None => writeln!(out)?,
        }
    }
    if let Err(error) = recording::check_version(reader) {
        return writeln!(out, "\n{error}");
    }
    let Ok((events, beyond)) = events else {
        return Ok(());
    };
    writeln!(
        out,
        "\nImpacts{}",
        if events.is_empty() { "\n  none" } else { "" }
    )?;
    for event in events {
        print_event(event, out)?;
    }
    if *beyond > 0 {
        writeln!(out, "  and {beyond} messages of further events")?;
    }
    Ok(())
}

fn print_head(reader: &Reader, out: &mut impl Write) -> io::Result<()> {
    let mut line = |name: &str, text: String| writeln!(out, "{name:<12}{text}");
    line("Recording", reader.path().display().to_string())?;
    let compression = format!("{:?}", reader.compression()).to_lowercase();
    line(
        "Size",
        format!(
            "{} bytes in {} file(s), compression {compression}",
            reader.bytes(),
            reader.files().len()
        ),
    )?;
    line("Written by", writer(reader))?;
    match reader.span() {
        Some((first, last)) => {
            line("Begins", instant(first))?;
            line(
                "Ends",
                format!(
                    "{}, after {:.3} s",
                    instant(last),
                    (last - first) as f64 * 1e-9
                ),
            )?;
        }
        None => line("Begins", "never: there are no messages".to_owned())?,
    }
    line("Messages", reader.message_count().to_string())?;
    line(
        "Complete",
        recording::incompleteness(reader).map_or("yes".to_owned(), |why| format!("no: {why}")),
    )?;
    if let Some(repair) = reader.repair_notes() {
        let noted = |key: &str| repair.get(key).map_or("?", String::as_str);
        // A recorder that noted how it ended had written everything before.
        let rest = match reader.was_cut_off() {
            true => format!(
                "; messages of its last {} ms may be missing",
                FLUSH_WITHIN.as_millis()
            ),
            false => String::new(),
        };
        let (source, fault) = (noted("source"), noted("fault"));
        line(
            "Repaired",
            format!("from {source}, which was {fault}{rest}"),
        )?;
    }
    line("Lost", losses(reader))?;
    for (index, text) in SealFinding::of(reader).texts().iter().enumerate() {
        line(if index == 0 { "Seal" } else { "" }, text.clone())?;
    }
    Ok(())
}

fn writer(reader: &Reader) -> String {
    let notes = reader.start_notes();
    let noted = notes.and_then(|it| Some(format!("{} {}", it.get("program")?, it.get("version")?)));
    let library = || format!("{} (profile {:?})", reader.library(), reader.profile());
    noted.unwrap_or_else(library)
}

fn losses(reader: &Reader) -> String {
    let ended = reader
        .ended()
        .map(|reason| format!("; ended: {reason}"))
        .unwrap_or_default();
    match reader.lost_messages() {
        Some(lost) if reader.was_cut_off() => {
            format!("at least {lost} messages according to the recorder{ended}")
        }
        Some(lost) => format!("{lost} messages according to the recorder{ended}"),
        None => format!("unknown{ended}"),
    }
}

/// Explains why a topic cannot be read as one of column_twin.
fn note(topic: &RecordedTopic) -> Option<String> {
    if recording::is_of_earlier_version(topic) {
        return Some("of an earlier version".to_owned());
    }
    if !topic.type_name.starts_with("column_twin_msgs/") {
        return None;
    }
    recording::check_definition(topic)
        .err()
        .map(|error| error.to_string())
}

fn print_event(event: &EventSummary, out: &mut impl Write) -> io::Result<()> {
    write!(out, "  {} on {}", event.event_id, event.column_id)?;
    if let Some(stamp) = event.stamp {
        write!(out, ", {}", instant(stamp))?;
    }
    if let (Some(mass), Some(velocity)) = (event.mass, event.velocity) {
        write!(out, ": {} at {velocity} m/s", mass_in_words(mass))?;
    }
    writeln!(out)?;
    match event.outcome {
        Some(outcome) => print_outcome(event, outcome, out),
        None => writeln!(out, "    {}", event.without_outcome()),
    }
}

fn print_outcome(event: &EventSummary, outcome: Outcome, out: &mut impl Write) -> io::Result<()> {
    let millimetres =
        |value: Option<f64>| value.map_or("none".to_owned(), |it| format!("{:.2} mm", 1e3 * it));
    let word = outcome_word(outcome);
    write!(out, "    {word}: peak v1 {}", millimetres(event.max_v1))?;
    if let Some(time) = event.max_v1_time {
        write!(out, " after {:.2} ms", 1e3 * time)?;
    }
    if event.forecast_max_v1.is_some() {
        write!(out, " (forecast {})", millimetres(event.forecast_max_v1))?;
    }
    write!(out, ", residual {}", millimetres(event.residual_v1))?;
    if let Some(force) = event.peak_contact_force {
        write!(out, ", peak contact force {:.1} kN", 1e-3 * force)?;
    }
    match event.end {
        Some(end @ (End::DurationReached | End::NotConverged)) => {
            writeln!(out, "; {}", end_in_words(end))
        }
        _ => writeln!(out),
    }
}

fn as_json(reader: &Reader, events: &EventSummaries) -> Json {
    let topics = reader.topics().iter().map(|topic| {
        json!({
            "name": &*topic.name,
            "type": &*topic.type_name,
            "messages": topic.messages,
            "note": note(topic),
        })
    });
    json!({
        "path": reader.path().display().to_string(),
        "bytes": reader.bytes(),
        "files": reader.files().len(),
        "compression": format!("{:?}", reader.compression()).to_lowercase(),
        "written_by": writer(reader),
        "begins": reader.span().map(|it| it.0),
        "ends": reader.span().map(|it| it.1),
        "messages": reader.message_count(),
        "complete": recording::incompleteness(reader).is_none(),
        "whole": reader.wholeness().is_whole(),
        "not_whole_because": (!reader.wholeness().is_whole()).then(|| reader.wholeness().to_string()),
        "cut_off_before_repair": reader.was_cut_off(),
        "lost": reader.lost_messages(),
        "ended": reader.ended(),
        "seals": SealFinding::of(reader).json(),
        "topics": topics.collect::<Vec<_>>(),
        "impacts": events.as_ref().map(|it| &it.0).ok(),
    })
}
