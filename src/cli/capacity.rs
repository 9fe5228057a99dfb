//! `column-twin capacity`: the axial capacity of the column, undamaged and as it is, and what follows for its load.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use bounded_file::read_text_at_most;
use clap::Args;

use super::failure::{Exit, Failure, unless_closed};
use super::impact_args::ImpactSpecificationArgs;
use super::simulate::parameters_of;
use column_twin::assessment::{
    Assessment, AssessmentInput, ResidualCapacity, assess, imperfection, respond_and_rest,
};
use column_twin::column::{
    BucklingResistance, Capacity, CapacityEnd, CapacityError, Impact, Model, Outcome,
    PushDownPoint, Report, SimulationError, State, push_down, residual_state,
};
use column_twin::figures::units::{Unit, significant};
use column_twin::figures::{FigureError, PushDownCurves, push_down_svg};
use column_twin::parameters::{Parameters, Value, component_in_words};
use column_twin::report::short;
use column_twin::results::CapacityFields;
use column_twin::twin::state_file::MAX_STATE_FILE_BYTES;
use column_twin::twin::{Condition, SavedState, SavedStateError};
use column_twin::whole_file;

/// Arguments of `column-twin capacity`.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true, after_help = EXAMPLE)]
pub struct CapacityArgs {
    /// Parameter file (ROS 2 YAML), may be repeated: later files win; default: the built-in column
    #[arg(long, short, value_name = "FILE")]
    config: Vec<PathBuf>,
    /// Any parameter in the notation of ROS 2, for example -p top.load:=2.0e6; may be repeated
    #[arg(long = "param", short, value_name = "NAME:=VALUE")]
    parameter: Vec<String>,
    /// The damage that a node has saved (a file of its state.directory); with the same parameters as the node
    #[arg(long, value_name = "FILE", conflicts_with = "after_impact")]
    state: Option<PathBuf>,
    /// Simulate an impact on the undamaged column first; the options below and the parameters impact.* specify it
    #[arg(long)]
    after_impact: bool,
    #[command(flatten)]
    impact: ImpactSpecificationArgs,
    /// Print the result as JSON (SI units), and nothing else
    #[arg(long)]
    json: bool,
    /// Draw the push-down curves, undamaged and as it is, into this SVG file
    #[arg(long, visible_alias = "svg", value_name = "FILE")]
    figure: Option<PathBuf>,
}

const EXAMPLE: &str = "\
Without --state and --after-impact, the column is undamaged.
docs/assessment.md describes the push-down, the criteria and their sources.

Example: the capacity of the paper's column after a rigid mass of 1.5 t at 36 km/h
  column-twin capacity --config config/heb220_paper.yaml --after-impact --mass 1500 --velocity 10

Exit codes: 0 done, with any assessment, 1 failed, 2 bad input or usage.";

/// Why the capacity cannot be computed.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
enum CapacityCommandError {
    #[error("--mass, --velocity, --gap, --restitution and --height describe an impact")]
    #[diagnostic(help("add --after-impact to simulate it first"))]
    ImpactWithoutSimulation,
    #[error("cannot read the state file {}: {reason}", path.display())]
    #[diagnostic(help("name a file that a node has saved in its state.directory"))]
    Unreadable { path: PathBuf, reason: io::Error },
    #[error("cannot use the state file {}: {reason}", path.display())]
    #[diagnostic(help("give the parameters of the node with --config and -p"))]
    State {
        path: PathBuf,
        reason: SavedStateError,
    },
    #[error("the saved column cannot be assessed: {0}")]
    #[diagnostic(help("reset the node, or name the state of another column"))]
    Faulted(String),
    #[error("the column cannot be simulated: {0}")]
    #[diagnostic(help("check the parameters of the column and of the impact"))]
    Simulation(#[from] SimulationError),
    #[error(transparent)]
    #[diagnostic(help("set capacity.imperfection, or 0 for the value of the buckling curve"))]
    Capacity(#[from] CapacityError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Figure(#[from] FigureError),
    #[error("cannot write to the standard output: {0}")]
    Output(io::Error),
}

impl From<CapacityCommandError> for Failure {
    fn from(fault: CapacityCommandError) -> Self {
        let exit = match &fault {
            CapacityCommandError::Figure(_) | CapacityCommandError::Output(_) => Exit::Failed,
            CapacityCommandError::Simulation(SimulationError::Step(_)) => Exit::Failed,
            _ => Exit::BadInput,
        };
        Self::new(exit, fault)
    }
}

/// The column at rest, as it is.
struct Column {
    /// What has happened to it.
    history: String,
    parameters: Parameters,
    model: Model,
    /// `None` if it carries nothing.
    state: Option<State>,
    damaged: bool,
    response: Option<(Impact, Report)>,
}

/// Computes both capacities and prints the result to `output`.
pub(super) fn run(arguments: &CapacityArgs, output: &mut dyn Write) -> Result<(), Failure> {
    if !arguments.after_impact && arguments.impact.is_given() {
        return Err(CapacityCommandError::ImpactWithoutSimulation.into());
    }
    let parameters = parameters_of(&arguments.config, &arguments.parameter, &arguments.impact)?;
    let column = match &arguments.state {
        Some(path) => Column::saved(parameters, path)?,
        None if arguments.after_impact => Column::after_impact(parameters)?,
        None => Column::undamaged(parameters)?,
    };
    let result = column.result()?;
    let mut text = if arguments.json {
        let json = serde_json::to_string_pretty(&CapacityFields::of(
            &column.history,
            &result.remaining,
            &result.assessment,
        ));
        json.map_err(|fault| CapacityCommandError::Output(fault.into()))? + "\n"
    } else {
        column.summary(&result)
    };
    if let Some(path) = &arguments.figure {
        column.draw(&result, path)?;
        if !arguments.json {
            let _ = writeln!(text, "Figure     {}", path.display());
        }
    }
    let written = output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush());
    Ok(unless_closed(written).map_err(CapacityCommandError::Output)?)
}

/// Capacities and assessment, with the curves for a figure.
struct CapacityResult {
    remaining: ResidualCapacity,
    assessment: Assessment,
    undamaged: Vec<PushDownPoint>,
    now: Vec<PushDownPoint>,
}

impl Column {
    fn undamaged(parameters: Parameters) -> Result<Self, CapacityCommandError> {
        let model = model_of(&parameters)?;
        Ok(Self {
            history: "undamaged".into(),
            state: Some(State::at_rest(&model)),
            damaged: false,
            response: None,
            parameters,
            model,
        })
    }

    fn after_impact(parameters: Parameters) -> Result<Self, CapacityCommandError> {
        let impact = parameters.impact();
        let mut column = Self::undamaged(parameters)?;
        let (properties, duration) = (
            column.parameters.column_properties(),
            column.parameters.response_duration(),
        );
        let (report, rest) = respond_and_rest(&properties, &impact, duration)?;
        column.state = rest;
        let outcome = match report.outcome {
            Outcome::Elastic => "elastic".to_owned(),
            Outcome::Plastic => format!(
                "plastic, residual v1 {}",
                length(report.residual_v1.unwrap_or(f64::NAN))
            ),
            Outcome::Collapsed => "collapsed".to_owned(),
            Outcome::Fractured => "fractured".to_owned(),
        };
        column.history = format!(
            "after {} kg at {} m/s, {} m above the base: {outcome}",
            short(impact.mass),
            short(impact.velocity),
            short(column.model.properties.length_below),
        );
        if let Some(component) = component_in_words(column.parameters.direction()) {
            column.history += "; ";
            column.history += &component;
        }
        column.damaged = report.outcome != Outcome::Elastic;
        column.response = Some((impact, report));
        Ok(column)
    }

    fn saved(parameters: Parameters, path: &Path) -> Result<Self, CapacityCommandError> {
        let unreadable = |reason| CapacityCommandError::Unreadable {
            path: path.to_owned(),
            reason,
        };
        let text = read_text_at_most(path, MAX_STATE_FILE_BYTES).map_err(unreadable)?;
        let saved = SavedState::from_json(&text, &parameters).map_err(|reason| {
            CapacityCommandError::State {
                path: path.to_owned(),
                reason,
            }
        })?;
        let whole = parameters.column_properties();
        let height = whole.length_below + whole.length_above;
        let moved = [
            ("geometry.length_below", Value::Double(saved.impact_height)),
            (
                "geometry.length_above",
                Value::Double(height - saved.impact_height),
            ),
        ];
        let parameters = parameters
            .with_changes(moved)
            .map_err(|faults| CapacityCommandError::Faulted(faults.to_string()))?;
        let mut column = Self::undamaged(parameters)?;
        let mut state = State::settled(&column.model, saved.displacement, saved.plastic);
        state.set_accumulated_rotation(&column.model, &saved.accumulated_rotation);
        if let Some(webs) = &saved.webs {
            state.set_webs(&column.model, webs);
        }
        column.state = match &saved.condition {
            Condition::Standing => residual_state(&column.model, &state),
            Condition::Collapsed | Condition::Fractured => None,
            Condition::Faulted(reason) => {
                return Err(CapacityCommandError::Faulted(reason.to_string()));
            }
        };
        column.history = match saved.impacts_since_reset {
            1 => "saved state after 1 impact".into(),
            count => format!("saved state after {count} impacts"),
        };
        column.damaged = true;
        Ok(column)
    }

    fn result(&self) -> Result<CapacityResult, CapacityCommandError> {
        let bow = imperfection(&self.parameters);
        let remaining =
            ResidualCapacity::compute(&self.parameters, &self.model, self.state.as_ref())?;
        let curve = |state: &State| {
            let mut curve = Vec::new();
            push_down(&self.model, state, bow, &mut |point| curve.push(*point)).map(|_| curve)
        };
        let undamaged = curve(&State::at_rest(&self.model))?;
        let now = match &self.state {
            Some(state) if self.damaged => curve(state)?,
            _ => Vec::new(),
        };
        Ok(CapacityResult {
            assessment: assess(&self.input(remaining)),
            remaining,
            undamaged,
            now,
        })
    }

    fn input(&self, remaining: ResidualCapacity) -> AssessmentInput {
        match (&self.response, &self.state) {
            (Some((impact, report)), _) => AssessmentInput::of_response(
                &self.parameters,
                &self.model,
                impact,
                report,
                remaining,
            ),
            (None, Some(state)) => {
                AssessmentInput::of_state(&self.parameters, &self.model, state, remaining)
            }
            (None, None) => {
                let undamaged = State::at_rest(&self.model);
                AssessmentInput {
                    collapsed: true,
                    ..AssessmentInput::of_state(
                        &self.parameters,
                        &self.model,
                        &undamaged,
                        remaining,
                    )
                }
            }
        }
    }

    fn title(&self) -> String {
        let p = &self.model.properties;
        format!(
            "{}, {} m high: {}",
            self.parameters
                .section()
                .name
                .unwrap_or(&self.parameters.settings().column_id),
            short(p.length_below + p.length_above),
            self.history
        )
    }

    fn draw(&self, result: &CapacityResult, path: &Path) -> Result<(), CapacityCommandError> {
        let title = self.title();
        let svg = push_down_svg(&PushDownCurves {
            title: &title,
            undamaged: &result.undamaged,
            now: &result.now,
            remaining: &result.remaining,
        })?;
        whole_file::write(path, svg.as_bytes()).map_err(|reason| {
            FigureError::Write {
                path: path.to_owned(),
                reason,
            }
            .into()
        })
    }

    fn summary(&self, result: &CapacityResult) -> String {
        let remaining = &result.remaining;
        let mut text = format!("{}\n\n", self.title());
        let mut line = |name: &str, value: String| {
            let _ = writeln!(text, "  {name:<24}{value}");
        };
        line(
            "Push-down undamaged",
            format!(
                "{} (bow {})",
                capacity_text(&remaining.undamaged),
                length(remaining.undamaged.imperfection)
            ),
        );
        line(
            "Push-down now",
            format!(
                "{}, {} % of the undamaged column",
                capacity_text(&remaining.now),
                significant(100.0 * remaining.ratio, 3)
            ),
        );
        line(
            "N_u",
            format!(
                "{}: this ratio times the strong-axis resistance",
                force(remaining.axial_capacity)
            ),
        );
        line(
            "Applied load N",
            format!(
                "{}; N_u / N = {}",
                force(remaining.carried_load),
                remaining
                    .reserve
                    .map_or("none: no compressive load".into(), |it| significant(it, 3))
            ),
        );
        line(
            "Strong-axis resistance",
            resistance_text(&remaining.strong, self),
        );
        line(
            "Weak-axis resistance",
            match &remaining.weak {
                Some(weak) => resistance_text(weak, self),
                None => "not known: the section is user-defined".into(),
            },
        );
        line(
            "Remaining resistance",
            match (remaining.resistance, remaining.weak_axis_governs()) {
                (Some(resistance), Some(true)) => {
                    format!("{}; the weak axis governs", force(resistance))
                }
                (Some(resistance), _) => {
                    format!("{}; the plane of the impact governs", force(resistance))
                }
                (None, _) => "not known without the weak axis".into(),
            },
        );
        let assessment = &result.assessment;
        let _ = write!(text, "\nAction: {}\n\n", assessment.in_words());
        for criterion in &assessment.criteria {
            let mark = match criterion.exceeded {
                Some(true) => "!",
                Some(false) => " ",
                None => "?",
            };
            let decides = if criterion.decides { "*" } else { " " };
            let _ = writeln!(
                text,
                "{mark}{decides} {:<26}{}",
                criterion.name, criterion.statement
            );
        }
        text.push_str("\n! exceeded, ? not evaluated, * decides the action\n");
        text.push_str(
            "[T] read in the source, [C] computed, [M] recalled and not verified, [A] assumption of this program; \
             see docs/assessment.md\n",
        );
        text
    }
}

fn model_of(parameters: &Parameters) -> Result<Model, CapacityCommandError> {
    Model::new(&parameters.column_properties())
        .map_err(|fault| CapacityCommandError::Simulation(fault.into()))
}

fn force(newtons: f64) -> String {
    Unit::force(newtons).show(newtons)
}

fn length(metres: f64) -> String {
    Unit::length(metres).show(metres)
}

fn capacity_text(capacity: &Capacity) -> String {
    match capacity.end {
        CapacityEnd::NoEquilibrium => {
            "0 kN: the column has no equilibrium and carries nothing".into()
        }
        CapacityEnd::Fractured if capacity.force == 0.0 => {
            "0 kN: a hinge, a web or the base is fractured and the column carries nothing".into()
        }
        CapacityEnd::NotFollowed | CapacityEnd::BoundReached => format!(
            "at least {} (the push-down could not be followed to its end)",
            force(capacity.force)
        ),
        CapacityEnd::ForceFell
        | CapacityEnd::Plateau
        | CapacityEnd::Folded
        | CapacityEnd::Fractured => {
            format!("{} at v1 {}", force(capacity.force), length(capacity.v1))
        }
    }
}

fn resistance_text(resistance: &BucklingResistance, column: &Column) -> String {
    let p = &column.model.properties;
    format!(
        "{} (EN 1993-1-1, 6.3.1: curve {}, K = {}, slenderness {})",
        force(resistance.force),
        format!("{:?}", resistance.curve).to_lowercase(),
        significant(
            resistance.buckling_length / (p.length_below + p.length_above),
            3
        ),
        significant(resistance.slenderness, 3)
    )
}
