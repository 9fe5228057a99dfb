//! The pages of the reference that follow from files of the repository: messages and limits, and the statuses of `/diagnostics`.
//! `UPDATE_DOCS=1 cargo test --test tidy` writes the generated ones.

use std::fmt::Write;
use std::fs;

use super::{files_below, read, root};

/// Fails if a generated page differs from what it follows from, or writes it with `UPDATE_DOCS=1`.
fn compare(path: &str, generated: &str) {
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::write(root().join(path), generated).expect("the page can be written");
    }
    assert!(
        fs::read_to_string(root().join(path)).unwrap_or_default() == generated,
        "{path} differs from its sources; update it with\n    UPDATE_DOCS=1 cargo test --test tidy"
    );
}

/// An endpoint as a line of the macro in `src/endpoints.rs` has it.
struct Endpoint {
    name: String,
    type_name: String,
    direction: &'static str,
    qos: String,
    meaning: String,
}

/// The quality of service in words, of an expression of `src/endpoints.rs`.
fn qos_in_words(expression: &str, source: &str) -> String {
    let constant = format!("const {expression}: Qos = ");
    if let Some((_, rest)) = source.split_once(&constant) {
        let value = rest.split_once(';').expect("the end of a constant").0;
        return qos_in_words(value, source);
    }
    let number_after = |start: &str| {
        let rest = expression.split_once(start)?.1;
        rest.split_once(')').map(|(number, _)| number)
    };
    let (kept, depth) = match number_after("Qos::latched(") {
        Some(depth) => ("transient local", depth),
        None => (
            "volatile",
            number_after("Qos::reliable(").expect("a known quality of service"),
        ),
    };
    let delivery = match expression.contains("reliable: false") {
        true => "best effort",
        false => "reliable",
    };
    let lifespan = number_after("lifespan: Some(").map(|it| format!(", for {it} s"));
    format!(
        "{delivery}, {kept}, keep last {depth}{}",
        lifespan.unwrap_or_default()
    )
}

fn endpoints() -> Vec<Endpoint> {
    let source = read("src/endpoints.rs");
    let table = source.split_once("endpoints! {\n").expect("the table").1;
    let mut found = Vec::new();
    let mut meaning = String::new();
    for line in table.lines().map(str::trim).take_while(|line| *line != "}") {
        if let Some(words) = line.strip_prefix("/// ") {
            meaning = format!("{meaning} {words}").trim().to_owned();
            continue;
        }
        let parts: Vec<_> = line.split('"').collect();
        let [_, name, _, type_name, rest] = parts[..] else {
            panic!("{line}: expected a name and a type");
        };
        let (direction, qos) = rest.trim().split_once(' ').expect("a direction");
        let mut qos = qos.trim_end_matches(';');
        // The properties behind it.
        while let Some((before, property)) = qos.rsplit_once(", ")
            && property
                .bytes()
                .all(|it| it == b'_' || it.is_ascii_lowercase())
        {
            qos = before;
        }
        found.push(Endpoint {
            name: name.to_owned(),
            type_name: type_name.to_owned(),
            direction: match direction {
                "In" => "subscribed",
                "Out" => "published",
                _ => "service",
            },
            qos: qos_in_words(qos, &source),
            meaning: std::mem::take(&mut meaning),
        });
    }
    assert!(found.len() > 20, "{} endpoints", found.len());
    found
}

const MESSAGES: &str = "\
# Topics, services and messages

This page is generated from `src/endpoints.rs`, `msg/` and `srv/`; do not edit it.
[launch_notes.md](../launch_notes.md#topics-and-services) describes how the topics are used, and `column-twin idl` prints them for DDS programs without ROS.
All names are relative to the namespace of the node, except for those that begin with a slash; `~` is the name of the node.
In a fleet, a reader of the topics that all columns share needs a longer history, for which [node.md](node.md#histories-and-requests) has the numbers.

## Topics and services

| name | type | direction | QoS | meaning |
|---|---|---|---|---|
";

fn messages() -> String {
    let endpoints = endpoints();
    let mut text = MESSAGES.to_owned();
    for endpoint in &endpoints {
        let Endpoint {
            name,
            type_name,
            direction,
            qos,
            meaning,
        } = endpoint;
        writeln!(
            text,
            "| `{name}` | `{type_name}` | {direction} | {qos} | {meaning} |"
        )
        .expect("text");
    }
    for (kind, heading) in [("msg", "Messages"), ("srv", "Services")] {
        writeln!(text, "\n## {heading}").expect("text");
        for path in files_below(kind) {
            // The definitions of other packages are in folders of their own.
            if path.components().count() != 2 {
                continue;
            }
            let name = path.file_stem().expect("a name").to_string_lossy();
            let type_name = format!("column_twin_msgs/{kind}/{name}");
            let used: Vec<_> = endpoints
                .iter()
                .filter(|it| it.type_name == type_name)
                .map(|it| format!("`{}`", it.name))
                .collect();
            let used = match used.is_empty() {
                true => "part of other messages".to_owned(),
                false => used.join(", "),
            };
            writeln!(
                text,
                "\n### {name}\n\n`{type_name}`, {used}\n\n```text\n{}\n```",
                read(&path).trim()
            )
            .expect("text");
        }
    }
    text
}

#[test]
fn the_page_of_the_messages_is_up_to_date() {
    compare("docs/messages.md", &messages());
}

/// A number that a user can meet: the file and the constant that has it, and its meaning with its unit.
type Number = (&'static str, &'static str, &'static str);

const LIMITS: [(&str, &[Number]); 5] = [
    (
        "The node",
        &[
            (
                "src/twin/registry.rs",
                "MAX_IMPACTS_AHEAD",
                "accepted impacts that may still be to come on one column; a further one is rejected",
            ),
            (
                "src/twin/seen_ids.rs",
                "MAX_SEEN_IDS",
                "remembered values of `event_id` for each column; an event with an older one is rejected for its stamp",
            ),
            (
                "src/twin/registry.rs",
                "MAX_EVENT_ID_CHARS",
                "characters of an `event_id`",
            ),
            (
                "src/twin/what_if.rs",
                "MAX_VEHICLE_NAME_CHARS",
                "characters of the name of a vehicle",
            ),
            (
                "src/twin/forecast.rs",
                "MAX_SUPERSEDED_FORECASTS",
                "forecasts of overtaken impacts that wait to be computed",
            ),
            (
                "src/live/inbox.rs",
                "MAX_COMMANDS",
                "inputs that wait for the solver of a single twin; a further one is rejected",
            ),
            (
                "src/ros/senders.rs",
                "MAX_SENDERS",
                "senders whose rates are tracked at a time",
            ),
            (
                "src/twin/state_file.rs",
                "MAX_STATE_FILE_BYTES",
                "bytes of a state file",
            ),
            (
                "src/twin/rejection.rs",
                "MAX_REASON_CHARS",
                "characters of the reason of a rejection",
            ),
            (
                "crates/sros2_keystore/src/domain_ranges.rs",
                "MAX_DOMAIN_ID",
                "highest `ROS_DOMAIN_ID`",
            ),
        ],
    ),
    (
        "A fleet",
        &[
            (
                "src/parameters/fleet.rs",
                "MAX_COLUMNS",
                "columns of a fleet",
            ),
            (
                "src/parameters/fleet.rs",
                "MAX_TABLE_BYTES",
                "bytes of the table of columns",
            ),
            (
                "src/fleet/demand.rs",
                "MAX_OPEN_COLUMNS",
                "columns with separate topics at a time",
            ),
            (
                "src/fleet/row.rs",
                "MAX_ROWS",
                "rows of columns in progress at a time (`row_impact_event`)",
            ),
            ("src/fleet/row.rs", "MAX_ROW_COLUMNS", "columns of one row"),
            (
                "src/fleet/row.rs",
                "MAX_ROW_OFFSET",
                "largest offset of an impact in a row [s]",
            ),
            (
                "src/ros/live_columns.rs",
                "MAX_SENSOR_TOPICS",
                "separate topics of sensors",
            ),
            (
                "src/live/libraries.rs",
                "MAX_LIBRARIES",
                "different columns with sensors whose responses are prepared before an impact",
            ),
            (
                "src/parameters/ranges.rs",
                "MAX_SELECTED_COLUMNS",
                "columns that the viewer shows in full (`viewer.select`)",
            ),
            (
                "src/live/recent_batches.rs",
                "MAX_SAMPLES_OF_ALL",
                "newest samples of all columns together that are kept for the viewer",
            ),
        ],
    ),
    (
        "Sensors and estimation",
        &[
            (
                "src/parameters/sensors.rs",
                "MAX_SENSOR_NAME_CHARS",
                "characters of the name of a sensor",
            ),
            (
                "src/estimation/intake/measurement_intake.rs",
                "MAX_BATCH_SAMPLES",
                "samples in one message on `measurements`",
            ),
            (
                "src/live/measurements.rs",
                "MAX_QUEUED_BATCHES",
                "batches that wait for the estimation of a single twin",
            ),
            (
                "src/live/sensing.rs",
                "MAX_ESTIMATED_AT_ONCE",
                "impacts that one thread estimates at a time; further ones wait",
            ),
            (
                "src/estimation/inference/event_evidence.rs",
                "MAX_EVENTS",
                "impact events that count as evidence for one detected impact",
            ),
            (
                "src/estimation/intake/readings.rs",
                "MAX_ROWS",
                "rows of a table of readings (`estimate --readings`)",
            ),
            (
                "src/estimation/inference/estimate.rs",
                "FEWEST_RESPONSES",
                "effective sample size below which an estimate is not `reliable`",
            ),
            (
                "src/estimation/inference/estimate.rs",
                "COLLAPSE_TOLD_FROM",
                "probability of a collapse from which on an estimate tells it",
            ),
            (
                "src/estimation/inference/estimate.rs",
                "COLLAPSE_POSSIBLE_FROM",
                "the same from which on estimates follow one another every 10 ms",
            ),
            (
                "src/estimation/inference/estimator.rs",
                "UNCONFIRMED_SCALE",
                "standard deviation of the scale of a sensor that no other one confirms",
            ),
            (
                "src/estimation/inference/contradiction.rs",
                "SCALE_DOUBT",
                "standard deviations of its scale from which on a sensor is in doubt",
            ),
            (
                "src/estimation/inference/contradiction.rs",
                "NOTICED_SCALE_ERROR",
                "error of the scale of a sensor that others have to notice if they are to confirm it",
            ),
            (
                "src/estimation/inference/contradiction.rs",
                "SCALE_AGREEMENT",
                "standard deviations within which the scales of sensors that confirm each other agree",
            ),
            (
                "src/estimation/inference/extremes.rs",
                "LIMIT_OVER_NEXT",
                "times that the largest reading comes as often as the next one if the sensor is cut off there",
            ),
            (
                "src/estimation/inference/peak.rs",
                "CONTRADICTED",
                "probability of the responses where a displacement sensor at the impact point contradicts all others",
            ),
            (
                "src/estimation/inference/peak.rs",
                "MISSED_PEAK",
                "factor between its peak and the peak of the responses from which on such a sensor is broken",
            ),
            (
                "src/estimation/inference/statement.rs",
                "STRAY",
                "standard deviations from what is predicted from which on two means of a sensor are in doubt",
            ),
            (
                "src/twin/damage_correction.rs",
                "CORRECTION_FACTORS",
                "range of the factor of `~/correct_damage`; outside, the correction is rejected",
            ),
        ],
    ),
    (
        "Commands",
        &[
            (
                "src/parameters/file.rs",
                "MAX_FILE_BYTES",
                "bytes of a parameter file",
            ),
            ("src/study/axis_problem.rs", "MAX_CELLS", "cells of a map"),
            (
                "src/study/map_error.rs",
                "MAX_VARIANTS",
                "columns that a map compares by the values of one or more parameters",
            ),
            (
                "src/study/threads.rs",
                "MAX_THREADS_PER_PROCESSOR",
                "threads per processor of a study",
            ),
            (
                "src/study/vehicle_limits.rs",
                "LIMIT_VELOCITIES",
                "range in which `twin_status` seeks critical velocities [m/s]",
            ),
            (
                "src/study/critical.rs",
                "CRITICAL_TOLERANCE",
                "relative tolerance of a critical velocity",
            ),
            (
                "src/study/critical.rs",
                "SCAN_RATIO",
                "ratio of neighbouring velocities of the scan that brackets it",
            ),
            ("src/cli/risk/case.rs", "MAX_SAMPLES", "samples of `risk`"),
            (
                "src/study/risk/scenario.rs",
                "MAX_CLASSES",
                "classes of vehicles in a scenario",
            ),
            (
                "src/ros/measure.rs",
                "MAX_DURATION",
                "longest table that `measure` publishes [s]",
            ),
            (
                "src/report/recorded.rs",
                "MAX_SECTIONS",
                "impacts with a section in a report; the last ones, if there are more",
            ),
            (
                "src/report/details.rs",
                "MAX_DETAIL_CHARS",
                "characters of a detail in the title block of a report",
            ),
        ],
    ),
    (
        "The prior of the estimation",
        &[
            (
                "src/estimation/inference/hypothesis.rs",
                "VELOCITY_RANGE",
                "range of the speed of the vehicle [m/s]",
            ),
            (
                "src/estimation/inference/hypothesis.rs",
                "LEAST_MASS",
                "least mass of the vehicle [kg]",
            ),
            (
                "src/estimation/inference/hypothesis.rs",
                "VELOCITY",
                "speed: median [m/s], and standard deviation of its logarithm",
            ),
            (
                "src/estimation/inference/hypothesis.rs",
                "YIELD_SCATTER",
                "standard deviation of the logarithm of the yield strength, about the given one",
            ),
            (
                "src/estimation/inference/hypothesis.rs",
                "JCSS_STIFFNESS",
                "front of `en1991_elastic`: median stiffness [N/m], and standard deviation of its logarithm",
            ),
            (
                "src/estimation/inference/hypothesis.rs",
                "ANY_STIFFNESS",
                "elastic front of an unknown vehicle: median stiffness [N/m], and standard deviation of its logarithm",
            ),
            (
                "src/estimation/inference/hypothesis.rs",
                "ANY_MASS",
                "mass of an unknown vehicle with a deformable front: median [kg], and standard deviation of its logarithm",
            ),
            (
                "src/estimation/inference/estimator.rs",
                "WIDE_BANK",
                "responses prepared for each of the kinds `rigid` and `elastic`",
            ),
            (
                "src/estimation/inference/estimator.rs",
                "MIDDLE_BANK",
                "responses prepared for each of the kinds `plateau`, `two_slopes`, `two_masses` and `en1991_elastic`",
            ),
            (
                "src/estimation/inference/estimator.rs",
                "NARROW_BANK",
                "responses prepared for each other kind of vehicle",
            ),
        ],
    ),
];

const LIMITS_HEAD: &str = "\
# Limits of the program, and prior distributions

These are the limits of the program. [The range of validity](start/engineer.md#range-of-validity) has the limits of the model.

This page is generated from the constants of the source; do not edit it.
An input beyond a limit is rejected, with the limit in the error; a longer output is shortened.
[parameters.md](parameters.md) has the ranges of the parameters, and [ARCHITECTURE.md](../ARCHITECTURE.md#queues) the queues.
";

const PRIOR: &str = "
The estimation assumes these distributions before it has read anything; they are assumptions [A], except for the stiffness of the JCSS Probabilistic Model Code [T].
The median of the mass is 1500 kg for `rigid` (with a standard deviation of 1 of its logarithm), 4000 kg for `elastic`, `plateau`, `two_slopes` and `two_masses` (1.2), and 1700 kg for `en1991_elastic` (0.5); a vehicle of the catalogue has its own mass (0.3), and a user-defined vehicle the mass of its parameters (0.5).
The kinds have the weights 2 (`rigid`), 1 (`elastic`, `plateau`, `two_slopes`), 0.3 (`two_masses`), 1.5 (`en1991_elastic`) and 0.6 (each vehicle of the catalogue); the vehicle of the parameters has the weight 5.
";

/// The value of a constant as it is written, in digits that a reader knows.
fn value_of(file: &str, name: &str) -> String {
    let source = read(file);
    let start = format!("const {name}: ");
    let (_, rest) = source
        .split_once(&start)
        .unwrap_or_else(|| panic!("{file} has no constant {name}"));
    let written = rest
        .split_once(" = ")
        .and_then(|(_, it)| it.split_once(';'))
        .expect("its value")
        .0;
    let written = written.replace('_', "");
    match written.split_once(" << ") {
        Some((factor, power)) => {
            let [factor, power] = [factor, power].map(|it| it.parse::<u32>().expect("a number"));
            (u64::from(factor) << power).to_string()
        }
        None => written
            .trim_matches(['[', ']'])
            .split(", ")
            .map(|number| number.parse::<f64>().expect("a number").to_string())
            .collect::<Vec<_>>()
            .join("; "),
    }
}

fn limits() -> String {
    let mut text = LIMITS_HEAD.to_owned();
    for (heading, numbers) in LIMITS {
        writeln!(text, "\n## {heading}").expect("text");
        if heading.starts_with("The prior") {
            text += PRIOR;
        }
        text += "\n| number | meaning | constant |\n|---|---|---|\n";
        for (file, name, meaning) in numbers {
            writeln!(
                text,
                "| {} | {meaning} | `{name}` in `{file}` |",
                value_of(file, name)
            )
            .expect("text");
        }
    }
    text
}

#[test]
fn the_page_of_the_limits_is_up_to_date() {
    compare("docs/limits.md", &limits());
}

/// The numbers in the words about the prior are those of the hypotheses.
#[test]
fn the_prior_in_words_is_that_of_the_code() {
    let code = read("src/estimation/inference/hypothesis.rs");
    for written in [
        "2.0, [1500.0, 1.0]",
        "Front::Elastic, 1.0, ANY_MASS",
        "5.0 } else { 0.6 }",
        "5.0 } else { 1.5 }",
        "[1700.0, 0.5]",
        "[vehicle.total_mass(), 0.3]",
        "[vehicle.total_mass(), 0.5]",
    ] {
        assert!(
            code.contains(written),
            "src/estimation/inference/hypothesis.rs no longer has {written}; mend the words in tests/tidy/reference.rs"
        );
    }
}

/// The names and keys of the page are literals of the code, and every status has its row.
#[test]
fn the_page_of_the_diagnostics_names_the_statuses_and_keys_of_the_code() {
    let page = read("docs/diagnostics.md");
    let files = [
        "src/ros/alarms.rs",
        "src/ros/diagnostics.rs",
        "src/ros/sensor_watch.rs",
        "src/ros/security_health.rs",
        "src/ros/fleet/diagnostics.rs",
        "src/ros/fleet/sensors.rs",
    ];
    let code: String = files
        .iter()
        .map(|path| super::code_of(&read(path)))
        .collect();
    let rows = page.lines().filter(|line| line.starts_with("| `"));
    let mut faults = Vec::new();
    let mut statuses = Vec::new();
    for row in rows {
        let cells: Vec<_> = row.trim_matches('|').split('|').collect();
        let quoted = |cell: &str| -> Vec<String> {
            cell.split('`')
                .skip(1)
                .step_by(2)
                .map(str::to_owned)
                .collect()
        };
        statuses.extend(quoted(cells[0]));
        let keys = quoted(cells.last().expect("a cell"));
        for key in keys.iter().chain(&statuses) {
            if !code.contains(&format!("\"{key}\"")) && !key.contains('<') {
                faults.push(format!("docs/diagnostics.md: the code has no {key:?}"));
            }
        }
    }
    for part in code.split("entry(").skip(1) {
        let name = part
            .trim_start()
            .strip_prefix('"')
            .and_then(|it| it.split_once('"'));
        if let Some((name, _)) = name.filter(|(name, _)| !statuses.iter().any(|it| it == name)) {
            faults.push(format!(
                "docs/diagnostics.md has no row of the status {name:?}"
            ));
        }
    }
    assert!(statuses.len() >= 10 && faults.is_empty(), "{faults:#?}");
}

/// The names of the options in words.
fn options<'a>(words: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    words
        .take_while(|word| *word != "--ros-args")
        .filter(|word| word.starts_with("--") && word.len() > 2)
        .map(|word| word.split(['=', ',', '`', ')']).next().unwrap_or_default())
        .collect()
}

/// The options that a document gives to one of the subcommands, and those that stand alone in backticks, with an empty subcommand.
fn documented_options(text: &str, subcommands: &[&str]) -> Vec<(String, String)> {
    let joined = text.replace("\\\n", " ");
    let mut commands = Vec::new();
    for (index, part) in joined.split("```").enumerate() {
        match index % 2 {
            0 => commands.extend(part.split('`').skip(1).step_by(2).map(str::to_owned)),
            _ if part.starts_with("sh\n") => commands.extend(part.lines().map(str::to_owned)),
            _ => {}
        }
    }
    let mut found = Vec::new();
    for command in commands.iter().flat_map(|it| it.split("&&")) {
        let command = command.split("  #").next().unwrap_or_default().trim();
        let ours = command.strip_prefix("column-twin ").or_else(|| {
            command
                .strip_prefix("cargo run ")
                .and_then(|it| it.split_once(" -- "))
                .map(|it| it.1)
        });
        let name = match ours {
            Some(arguments) => arguments.split(' ').next().unwrap_or_default(),
            None if command.starts_with("--") => "",
            None if subcommands
                .iter()
                .any(|it| command.starts_with(&format!("{it} --"))) =>
            {
                command.split(' ').next().unwrap_or_default()
            }
            None => continue,
        };
        let words = ours.unwrap_or(command).split_whitespace();
        found.extend(
            options(words)
                .into_iter()
                .map(|it| (name.to_owned(), it.to_owned())),
        );
    }
    found
}

/// Options of other programs and of `keystore` that documents name alone.
const OPTIONS_OF_OTHERS: [&str; 10] = [
    "--namespace",
    "--cmake-args",
    "--qos-durability",
    "--qos-reliability",
    "--no-default-features",
    "--ros-args",
    "--params-file",
    "--log-level",
    "--enclave",
    "--data-protection",
];

/// The documents once named `replay --viewer`, which had become `--rrd`.
#[test]
fn the_options_in_documents_exist() {
    let help = read("docs/commands.md");
    let headings = help.split("\n## column-twin ").skip(1);
    let subcommands: Vec<_> = headings.filter_map(|it| it.lines().next()).collect();
    let mut faults = Vec::new();
    let mut count = 0;
    for page in super::pages() {
        if [
            "CHANGELOG.md",
            "docs/commands.md",
            "docs/python_reference.md",
        ]
        .contains(&page.as_str())
        {
            continue;
        }
        for (command, option) in documented_options(&read(&page), &subcommands) {
            count += 1;
            let section = format!("\n## column-twin {command}\n");
            let known = match command.as_str() {
                // Its help is that of a program without the feature `security`.
                "keystore" | "--version" | "SUBCOMMAND" => continue,
                // That of a program without the feature `foxglove` lacks one.
                "replay" | "" if option == "--foxglove" => continue,
                "" if OPTIONS_OF_OTHERS.contains(&option.as_str()) => continue,
                "" => Some(help.as_str()),
                _ => help
                    .split_once(&section)
                    .map(|(_, rest)| rest.split("\n## ").next().unwrap_or_default()),
            };
            let is_known = known.is_some_and(|text| super::contains_word(text, &option));
            if !is_known && option != "--help" {
                faults.push(format!("{page}: column-twin {command} {option}"));
            }
        }
    }
    assert!(count > 100, "{count} options");
    assert!(
        faults.is_empty(),
        "docs/commands.md has no such option: {faults:#?}"
    );
}

#[test]
fn options_are_found_in_code_and_not_behind_ros_arguments() {
    let text = "Use `replay --viewer` or `--plain`.\n```sh\ncolumn-twin map --csv a \\\n  --bands && cargo run --release -- info x --ros-args --not\n```\n";
    let found: Vec<_> = documented_options(text, &["replay"])
        .into_iter()
        .map(|(command, option)| command + " " + &option)
        .collect();
    assert_eq!(
        found,
        ["replay --viewer", " --plain", "map --csv", "map --bands"]
    );
}
