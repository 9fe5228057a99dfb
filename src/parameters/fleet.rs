//! The parameters of a fleet: many columns from one parameter file with wildcards, or from a table with one row per column.
//!
//! In a parameter file a section named without a wildcard (`/garage/a3`) is a column, and a section with one (`/**`,
//! `/garage/*`) is for every column whose name it matches; later sections and later sources win. A section that names the node
//! (`column_twin`) is for every column. A table is CSV: `namespace`, `column_id` and names of parameters in its first row, one
//! column of the fleet in every further row; an empty field leaves the parameter as it is.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::draft::Draft;
use super::fault::{Fault, Origin, ParameterFaults, Problem, SourceFile};
use super::file::{self, Section};
use super::given::{self, Assignment, Content};
use super::node_name::NodeName;
use super::overrides::{Override, given_in_text};
use super::yaml::Location;
use super::{Parameter, Parameters, Source};
use ros_interface::names::{namespace_fault, with_slashes};

/// Maximum number of columns of one fleet.
pub const MAX_COLUMNS: usize = 2_000;

/// Maximum number of sections with a wildcard in all files of a fleet: each is compared with every column.
pub const MAX_WILDCARD_SECTIONS: usize = 1_000;

/// Maximum size of a table of columns \[bytes\].
pub const MAX_TABLE_BYTES: u64 = 16 << 20;

/// Maximum number of faults that are listed; the last line counts the others.
const MAX_FAULTS: usize = 100;

/// The field of a table with the namespace of a column.
const NAMESPACE: &str = "namespace";

/// The parameter with the name of a column.
const COLUMN_ID: &str = "column_id";

/// Parameters, and groups of parameters, that all columns of a fleet share, because they belong to the node.
const OF_THE_NODE: [&str; 11] = [
    "use_sim_time",
    "start_type_description_service",
    "senders",
    "state",
    "real_time",
    "record",
    "viewer",
    "alarm",
    "metrics",
    "foxglove",
    "qos_overrides",
];

/// Whether a parameter belongs to the node of a fleet, and not to each of its columns.
#[must_use]
pub fn is_of_the_fleet(name: &str) -> bool {
    OF_THE_NODE.contains(&name.split('.').next().unwrap_or_default())
}

/// A column of a fleet.
#[derive(Debug, Clone, PartialEq)]
pub struct FleetColumn {
    /// Its full name, such as `/garage/a3`.
    pub name: String,
    /// Its parameters, among them its `column_id`.
    pub parameters: Arc<Parameters>,
}

/// Where the columns of a fleet come from. Sources that come later win over earlier ones.
#[derive(Debug, Clone, Default)]
pub struct FleetSources {
    /// Parameter files.
    pub files: Vec<PathBuf>,
    /// A table of columns.
    pub table: Option<PathBuf>,
    /// The sources among the ROS arguments, in their order.
    pub arguments: Vec<Source>,
}

/// The columns of a fleet in the order of their names, with the parameters of its node and with warnings.
#[derive(Debug, Clone)]
pub struct FleetColumns {
    /// At least one.
    pub columns: Vec<FleetColumn>,
    /// The parameters that hold for the node: those of sections for any column.
    pub node: Parameters,
    /// About deprecated values and names of other nodes.
    pub warnings: Vec<Fault>,
}

/// What one source assigns to a column, in the order of the sources.
enum Given {
    /// A section of a file.
    Section(Section),
    /// A row of the table.
    Row(Vec<Assignment>),
    /// An argument, for every column.
    All(Assignment),
}

impl FleetColumns {
    /// Reads all sources for a fleet whose node has the name `node`.
    ///
    /// # Errors
    /// All faults of all sources; a fault in a section that several columns share is listed once.
    pub fn load(node: &NodeName, sources: &FleetSources) -> Result<Self, ParameterFaults> {
        let mut reader = Reader::new(node);
        for path in &sources.files {
            reader.file(path);
        }
        if let Some(path) = &sources.table {
            reader.table(path);
        }
        for source in &sources.arguments {
            match source {
                Source::File(path) => reader.file(path),
                Source::Override(one) => reader.argument(one),
                Source::Value(name, value) => {
                    let assignment = Assignment::direct((name.clone(), value.clone()));
                    reader.given.push(Given::All(assignment));
                }
            }
        }
        reader.finish()
    }

    /// Whether parameter files name several columns and not this node: each of their sections without a wildcard is empty or has a
    /// parameter of a column. A file with parameters of other nodes has sections without any.
    #[must_use]
    pub fn are_named_in<'a>(node: &NodeName, files: impl IntoIterator<Item = &'a Path>) -> bool {
        let reader = Reader::new(node);
        let is_of_column = |it: &Assignment| {
            let is_known = it.name.starts_with("sensors.") || Parameter::named(&it.name).is_some();
            is_known && !is_of_the_fleet(&it.name)
        };
        let mut names = HashSet::new();
        for path in files {
            for section in file::read_sections(path, node).0 {
                if is_wildcard(&section.name) {
                    continue;
                }
                let given = &section.assignments;
                let is_column = given.is_empty() || given.iter().any(is_of_column);
                if !is_column || reader.is_for_all(&section) {
                    return false;
                }
                names.insert(reader.column_of(&section.name).to_owned());
            }
        }
        names.len() > 1
    }
}

/// A column that some source names, and where.
struct Named {
    place: Origin,
    /// Indices of what is given for this column by its name.
    own: Vec<usize>,
}

struct Reader<'a> {
    node: &'a NodeName,
    given: Vec<Given>,
    /// By full name.
    columns: BTreeMap<String, Named>,
    /// The columns that rows of tables name.
    rows: HashSet<String>,
    faults: Vec<Fault>,
    is_too_many_told: bool,
    is_misnamed_told: bool,
}

impl<'a> Reader<'a> {
    fn new(node: &'a NodeName) -> Self {
        Self {
            node,
            given: Vec::new(),
            columns: BTreeMap::new(),
            rows: HashSet::new(),
            faults: Vec::new(),
            is_too_many_told: false,
            is_misnamed_told: false,
        }
    }

    fn fault(&mut self, name: Option<&str>, place: Origin, message: String) {
        self.faults.push(Fault {
            name: name.map(str::to_owned),
            value: None,
            place,
            problem: Problem::Inconsistent(message),
        });
    }

    fn file(&mut self, path: &Path) {
        let (sections, faults) = file::read_sections(path, self.node);
        self.faults.extend(faults);
        for section in sections {
            let index = self.given.len();
            if !self.is_for_all(&section) && !is_wildcard(&section.name) {
                let name = self.column_of(&section.name).to_owned();
                self.column(name, section.place.clone(), index);
            }
            self.given.push(Given::Section(section));
        }
    }

    /// Whether a section names the node, which is the same as every column.
    fn is_for_all(&self, section: &Section) -> bool {
        !is_wildcard(&section.name) && self.node.is_meant_by(&section.name)
    }

    /// Whether a section is for every column, whatever its name: `/**`, or the node in any namespace.
    fn is_for_any(&self, section: &Section) -> bool {
        let name = section.name.strip_suffix(self.node.bare());
        let name = name.unwrap_or(&section.name);
        is_wildcard(name) && name.split('/').all(|part| part.is_empty() || part == "**")
    }

    /// The name of the column that a section names: a section for its node, as `column-twin run` reads it, names its namespace.
    fn column_of<'s>(&self, section: &'s str) -> &'s str {
        let namespace = section.strip_suffix(self.node.bare());
        let namespace = namespace.and_then(|it| it.strip_suffix('/'));
        namespace.filter(|it| !it.is_empty()).unwrap_or(section)
    }

    fn column(&mut self, name: String, place: Origin, index: usize) {
        if let Some(known) = self.columns.get_mut(&name) {
            known.own.push(index);
            return;
        }
        if let Some(reason) = namespace_fault(&name) {
            let message =
                format!("{name:?} is not a namespace of ROS: {reason}; rename the column");
            self.fault(None, place, message);
            self.is_misnamed_told = true;
            return;
        }
        if self.columns.len() == MAX_COLUMNS {
            if !std::mem::replace(&mut self.is_too_many_told, true) {
                let message = format!(
                    "{name} is column {}, but a fleet has at most {MAX_COLUMNS}; run the others as another fleet",
                    MAX_COLUMNS + 1
                );
                self.fault(None, place, message);
            }
            return;
        }
        let own = vec![index];
        self.columns.insert(name, Named { place, own });
    }

    fn argument(&mut self, one: &Override) {
        match one.assignment(self.node) {
            Ok(assignment) => self.given.push(Given::All(assignment)),
            Err(fault) => self.faults.push(*fault),
        }
    }

    fn table(&mut self, path: &Path) {
        match file::source(path, MAX_TABLE_BYTES) {
            Ok(source) => Table {
                text: Arc::clone(&source.text),
                source,
            }
            .read(self),
            Err(fault) => self.faults.push(*fault),
        }
    }

    fn finish(mut self) -> Result<FleetColumns, ParameterFaults> {
        let wildcards: Vec<usize> = (0..self.given.len())
            .filter(|&index| match &self.given[index] {
                Given::Section(section) => is_wildcard(&section.name),
                Given::Row(_) | Given::All(_) => false,
            })
            .collect();
        if let Some(&index) = wildcards.get(MAX_WILDCARD_SECTIONS)
            && let Given::Section(section) = &self.given[index]
        {
            let place = section.place.clone();
            let message = format!(
                "this is section {} with a wildcard, but a fleet has at most {MAX_WILDCARD_SECTIONS}; give these parameters in a \
                 table of columns",
                MAX_WILDCARD_SECTIONS + 1
            );
            self.fault(None, place, message);
            return self.failed();
        }
        self.report_misplaced();
        if self.columns.is_empty() && !self.is_misnamed_told {
            let message = "the fleet has no column; name each in a parameter file as a section without a wildcard, such as \
                           `/garage/a3:`, or in a row of a table (--columns)";
            self.fault(None, Origin::Direct, message.to_owned());
        }
        let shared: Vec<usize> = (0..self.given.len())
            .filter(|index| match &self.given[*index] {
                Given::All(_) => true,
                Given::Section(section) => self.is_for_all(section),
                Given::Row(_) => false,
            })
            .collect();
        let mut columns = Vec::with_capacity(self.columns.len());
        let mut faults = Vec::new();
        let (node, mut warnings) = match self.node_parameters() {
            Ok((node, warnings)) => (Some(node), warnings),
            Err(found) => {
                faults.extend(found.into_faults());
                (None, Vec::new())
            }
        };
        let mut warned: HashSet<String> = warnings.iter().map(ToString::to_string).collect();
        let mut told: HashSet<String> = faults.iter().map(ToString::to_string).collect();
        for (name, named) in &self.columns {
            let (namespace, bare) = name.rsplit_once('/').unwrap_or(("", name));
            let as_node = NodeName::new(name, self.node.bare());
            let as_column = NodeName::new(namespace, bare);
            let matching = wildcards.iter().filter(|&&index| match &self.given[index] {
                Given::Section(section) => {
                    as_column.is_meant_by(&section.name) || as_node.is_meant_by(&section.name)
                }
                Given::Row(_) | Given::All(_) => false,
            });
            let mut indices: Vec<usize> =
                matching.chain(&named.own).chain(&shared).copied().collect();
            indices.sort_unstable();
            let mut draft = Draft::of_defaults();
            let own_name = Assignment::direct((COLUMN_ID, bare.into()));
            draft.take(vec![own_name], Vec::new());
            for index in indices {
                draft.take(self.assignments(index), Vec::new());
            }
            match draft.finish() {
                Ok((settings, more)) => {
                    let new = more.into_iter().filter(|it| warned.insert(it.to_string()));
                    warnings.extend(new);
                    columns.push(FleetColumn {
                        name: name.clone(),
                        parameters: Arc::new(Parameters::of(settings)),
                    });
                }
                Err(found) => {
                    for mut fault in found.into_faults() {
                        if matches!(fault.place, Origin::Direct) {
                            fault.place = named.place.clone();
                        }
                        if told.insert(fault.to_string()) {
                            faults.push(fault);
                        }
                    }
                }
            }
        }
        self.faults.extend(faults);
        self.report_equal_names(&columns);
        match node {
            Some(node) if self.faults.is_empty() => Ok(FleetColumns {
                columns,
                node,
                warnings,
            }),
            _ => self.failed(),
        }
    }

    fn assignments(&self, index: usize) -> Vec<Assignment> {
        match &self.given[index] {
            Given::Section(section) => section.assignments.clone(),
            Given::Row(assignments) => assignments.clone(),
            Given::All(assignment) => vec![assignment.clone()],
        }
    }

    /// The parameters of the node: what sections for any column and arguments give for it.
    fn node_parameters(&self) -> Result<(Parameters, Vec<Fault>), ParameterFaults> {
        let mut draft = Draft::of_defaults();
        for (index, given) in self.given.iter().enumerate() {
            let applies = match given {
                Given::Section(section) => self.is_for_any(section) || self.is_for_all(section),
                Given::Row(_) => false,
                Given::All(_) => true,
            };
            if applies {
                let mut assignments = self.assignments(index);
                assignments.retain(|it| is_of_the_fleet(&it.name));
                draft.take(assignments, Vec::new());
            }
        }
        let (settings, warnings) = draft.finish()?;
        Ok((Parameters::of(settings), warnings))
    }

    /// Parameters of the node that are given for some columns only, and names that are given for several columns.
    fn report_misplaced(&mut self) {
        let mut wrong = Vec::new();
        for (index, given) in self.given.iter().enumerate() {
            let (is_for_all, is_for_one) = match given {
                Given::Section(it) => {
                    let is_for_all = self.is_for_any(it) || self.is_for_all(it);
                    (is_for_all, !is_for_all && !is_wildcard(&it.name))
                }
                Given::Row(_) => (false, true),
                Given::All(_) => (true, false),
            };
            for it in self.assignments(index) {
                if it.name == COLUMN_ID && !is_for_one {
                    let message = "is given for several columns; give it in the section or row of each column";
                    wrong.push((it.name, it.name_place, message));
                } else if is_of_the_fleet(&it.name) && !is_for_all {
                    let message = "belongs to the node, which all columns share; give it in the section `/**:`";
                    wrong.push((it.name, it.name_place, message));
                }
            }
        }
        for (name, place, message) in wrong {
            self.fault(Some(&name), place, message.to_owned());
        }
    }

    /// Two columns with one `column_id`.
    fn report_equal_names(&mut self, columns: &[FleetColumn]) {
        let mut first: HashMap<&str, &str> = HashMap::new();
        let mut wrong = Vec::new();
        for column in columns {
            let id = &*column.parameters.settings().column_id;
            match first.get(id) {
                None => {
                    first.insert(id, &column.name);
                }
                Some(other) => {
                    wrong.push((column.name.clone(), id.to_owned(), (*other).to_owned()))
                }
            }
        }
        for (name, id, other) in wrong {
            let place = self.columns.get(&name).map(|it| it.place.clone());
            let message = format!(
                "{name} has the column_id {id:?}, which {other} has too; give each column its own"
            );
            self.fault(None, place.unwrap_or(Origin::Direct), message);
        }
    }

    fn failed(mut self) -> Result<FleetColumns, ParameterFaults> {
        self.faults.sort_by_key(|fault| match &fault.place {
            Origin::File { path, position, .. } => (0, path.clone(), *position),
            Origin::CommandLine(_) => (1, PathBuf::new(), None),
            Origin::Direct => (2, PathBuf::new(), None),
        });
        if self.faults.len() > MAX_FAULTS {
            let more = self.faults.len() - MAX_FAULTS;
            self.faults.truncate(MAX_FAULTS);
            let message = format!("{more} more faults; mend these first");
            self.fault(None, Origin::Direct, message);
        }
        Err(ParameterFaults::of(self.faults))
    }
}

fn is_wildcard(name: &str) -> bool {
    name.contains('*')
}

/// A table of columns that is being read.
struct Table {
    text: Arc<str>,
    source: SourceFile,
}

/// A row of a table.
struct Row {
    fields: csv::StringRecord,
    /// From 1.
    line: usize,
    /// The bytes of each field.
    spans: Vec<Range<usize>>,
}

/// A field of the first row that names what is below it.
enum Field {
    Namespace,
    Parameter(String),
    /// It was reported.
    Wrong,
}

impl Table {
    /// The place of some bytes in a line.
    fn place(&self, line: usize, bytes: Range<usize>) -> Origin {
        let before = &self.text[..bytes.start];
        let begin = before.rfind('\n').map_or(0, |at| at + 1);
        let column = before[begin..].chars().count() + 1;
        let at = Location {
            line,
            column,
            bytes,
        };
        self.source.place(&at)
    }

    fn syntax(&self, reader: &mut Reader<'_>, line: usize, at: usize, message: String) {
        let at = at.min(self.text.len());
        reader.faults.push(Fault {
            name: None,
            value: None,
            place: self.place(line, at..at),
            problem: Problem::Syntax(message),
        });
    }

    fn read(&self, reader: &mut Reader<'_>) {
        let mut records = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .from_reader(self.text.as_bytes());
        let mut named: Option<Vec<Field>> = None;
        for record in records.records() {
            let fields = match record {
                Ok(fields) => fields,
                Err(error) => {
                    let (line, at) = position(error.position());
                    let message = format!("is not valid CSV: {error}");
                    return self.syntax(reader, line, at, message);
                }
            };
            let (line, start) = position(fields.position());
            let spans = self.spans(start, fields.len());
            let row = Row {
                fields,
                line,
                spans,
            };
            match &named {
                None => named = Some(self.first_row(reader, &row)),
                Some(named) if named.len() != row.fields.len() => {
                    let message = format!(
                        "the row has {} fields, but the first row has {}; add or remove commas",
                        row.fields.len(),
                        named.len()
                    );
                    self.syntax(reader, line, start, message);
                }
                Some(named) => self.row(reader, named, &row),
            }
        }
        if named.is_none() {
            let message = format!(
                "the table is empty; begin it with the row `{NAMESPACE},{COLUMN_ID}` and names of parameters"
            );
            self.syntax(reader, 1, 0, message);
        }
    }

    /// The bytes of each field of a record that begins at `start`, with its quotes.
    fn spans(&self, start: usize, count: usize) -> Vec<Range<usize>> {
        let bytes = self.text.as_bytes();
        let mut spans = Vec::with_capacity(count);
        let (mut begin, mut quoted) = (start, false);
        for (at, &byte) in bytes.iter().enumerate().skip(start) {
            match byte {
                b'"' => quoted = !quoted,
                b',' | b'\r' | b'\n' if !quoted => {
                    spans.push(begin..at);
                    begin = at + 1;
                    if byte != b',' || spans.len() == count {
                        break;
                    }
                }
                _ => {}
            }
        }
        spans.resize_with(count, || begin.min(bytes.len())..bytes.len());
        spans
    }

    fn first_row(&self, reader: &mut Reader<'_>, row: &Row) -> Vec<Field> {
        let mut seen = HashSet::new();
        let mut named = Vec::with_capacity(row.fields.len());
        for (name, span) in row.fields.iter().zip(&row.spans) {
            let name = name.trim_start_matches('\u{feff}').trim();
            named.push(match name {
                _ if !seen.insert(name.to_owned()) => {
                    let message = format!("{name:?} is given a second time; remove one of the two");
                    self.syntax(reader, row.line, span.start, message);
                    Field::Wrong
                }
                NAMESPACE => Field::Namespace,
                _ => Field::Parameter(name.to_owned()),
            });
        }
        for required in [NAMESPACE, COLUMN_ID] {
            if !seen.contains(required) {
                let message = format!(
                    "the first row does not name {required}; begin it with `{NAMESPACE},{COLUMN_ID},`"
                );
                self.syntax(reader, row.line, 0, message);
                return named.iter().map(|_| Field::Wrong).collect();
            }
        }
        named
    }

    fn row(&self, reader: &mut Reader<'_>, named: &[Field], row: &Row) {
        let mut assignments = Vec::new();
        let mut column = None;
        for ((field, text), span) in named.iter().zip(&row.fields).zip(&row.spans) {
            let place = || self.place(row.line, span.clone());
            let text = text.trim();
            match field {
                Field::Wrong => {}
                Field::Namespace => {
                    let name = with_slashes(text);
                    if name.is_empty() || is_wildcard(&name) {
                        let message =
                            "is not the name of one column; write it as /garage/a3".to_owned();
                        reader.fault(Some(NAMESPACE), place(), message);
                    } else {
                        column = Some((name, place()));
                    }
                }
                Field::Parameter(_) if text.is_empty() => {}
                Field::Parameter(name) => match given_in_text(text, place()) {
                    Ok(given) => assignments.push(Assignment {
                        name: name.clone(),
                        given: as_given(name, text, given),
                        name_place: place(),
                        for_any_node: false,
                        section: 0,
                    }),
                    Err(problem) => reader.faults.push(Fault {
                        name: Some(name.clone()),
                        value: Some(text.to_owned()),
                        place: place(),
                        problem,
                    }),
                },
            }
        }
        let Some((name, place)) = column else {
            return;
        };
        let index = reader.given.len();
        if !reader.rows.insert(name.clone()) {
            let message = format!("there are two rows of the column {name}; remove one of them");
            reader.fault(None, place, message);
            return;
        }
        reader.column(name, place, index);
        reader.given.push(Given::Row(assignments));
    }
}

/// Line and byte of a position in a table.
fn position(of: Option<&csv::Position>) -> (usize, usize) {
    let number = |it: u64| usize::try_from(it).unwrap_or(usize::MAX);
    of.map_or((1, 0), |it| (number(it.line()), number(it.byte())))
}

/// The name of a column is text, whatever it looks like: `12` and `1e3` are names too.
fn as_given(name: &str, text: &str, given: given::Given) -> given::Given {
    if name != COLUMN_ID {
        return given;
    }
    given::Given {
        content: Content::Scalar(text.into()),
        text: Some(text.to_owned()),
        place: given.place,
    }
}
