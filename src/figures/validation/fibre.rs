//! Comparison with a fibre beam model: what the two bars leave out, in numbers.

use std::fmt::Write as _;
use std::path::Path;

use serde::Deserialize;

use crate::column::{
    CrushCurve, CrushSpring, ElasticLaw, Impact, Report, Vehicle, YieldExponents, respond,
};
use crate::parameters::{Parameters, parse_override};
use crate::report::{FIBRE_AGREEMENT, FibreAgreement};

/// One response of the fibre beam model, a row of `tests/data/fibre_cases.csv`.
#[derive(Debug, Deserialize)]
struct FibreCase {
    case: String,
    section: String,
    yield_strength_pa: f64,
    length_below_m: f64,
    length_above_m: f64,
    base: String,
    top: String,
    spring_n_m: f64,
    load_n: f64,
    mass_kg: f64,
    speed_m_s: f64,
    vehicle: String,
    stiffness_n_m: Option<f64>,
    crush_force_n: Option<f64>,
    hardening: String,
    max_v1_m: f64,
    max_v1_time_s: f64,
    residual_v1_m: f64,
    release_s: f64,
    impactor_end_m_s: f64,
}

/// Strain hardening that the fibre beam needs to localise plastic strain nowhere in particular: none in effect.
const NEARLY_NONE: &str = "b=1e-4";

impl FibreCase {
    fn read_all() -> Vec<Self> {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/fibre_cases.csv");
        let mut reader = csv::Reader::from_path(file).expect("tests/data/fibre_cases.csv");
        let cases: Result<Vec<Self>, _> = reader.deserialize().collect();
        cases.expect("tests/data/fibre_cases.csv")
    }

    /// `b`, the slope after yield relative to the elastic one.
    fn hardening_ratio(&self) -> f64 {
        let number = self.hardening.strip_prefix("b=");
        number.expect("b=number").parse().expect("b=number")
    }

    /// The response of the two bars: the coupled elastic law and the surface of Duan and Chen.
    fn two_bars(&self) -> Report {
        // The cases named after the paper have the numbers of its Table 1.
        let file = match self.case.starts_with("paper") {
            true => "config/heb220_paper.yaml",
            false => "config/heb220_s355.yaml",
        };
        let mut overrides = vec![
            format!("geometry.length_below:={:?}", self.length_below_m),
            format!("geometry.length_above:={:?}", self.length_above_m),
            format!("support.base:={}", self.base),
            format!("support.top:={}", self.top),
            format!("top.spring_stiffness:={:?}", self.spring_n_m),
            format!("top.load:={:?}", self.load_n),
        ];
        if !self.case.starts_with("paper") {
            overrides.push(format!("section.name:={}", self.section));
            overrides.push(format!(
                "steel.yield_strength:={:?}",
                self.yield_strength_pa
            ));
        }
        let overrides: Vec<_> = overrides.iter().map(|it| parse_override(it)).collect();
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        let parameters = Parameters::load(&[file], &overrides).expect("a column");
        let mut column = parameters.column_properties();
        column.elastic_law = ElasticLaw::Coupled;
        column.yield_surface = YieldExponents {
            alpha: 1.0,
            beta: 1.3,
            gamma: 1.0,
        };
        column.rate = None;
        column.hardening_ratio = self.hardening_ratio();
        column.softening = None;
        column.ultimate_rotation = 0.0;
        // The fibre beam does not shear.
        column.shear = None;
        let impact = Impact {
            vehicle: self.vehicle(),
            ..Impact::rigid(self.mass_kg, self.speed_m_s)
        };
        respond(&column, &impact, 0.5).expect("a response")
    }

    /// A spring of one slope, with a plateau where the case has a crush force.
    fn vehicle(&self) -> Option<Vehicle> {
        if self.vehicle == "rigid" {
            return None;
        }
        let stiffness = self.stiffness_n_m.expect("a stiffness");
        let points = match self.crush_force_n {
            Some(force) => vec![[force / stiffness, force], [10.0, force]],
            None => vec![[1.0, stiffness]],
        };
        let spring = CrushSpring {
            envelope: CrushCurve::new(&points).expect("a curve"),
            unloading_stiffness: stiffness,
            slack: 0.0,
        };
        Some(Vehicle::new(&[self.mass_kg], &[spring]).expect("a vehicle"))
    }
}

/// Mean and root mean square of `ratio - 1`.
fn scatter(ratios: &[f64]) -> (f64, f64) {
    let count = ratios.len() as f64;
    let mean = ratios.iter().sum::<f64>() / count;
    let square = ratios.iter().map(|it| (it - 1.0).powi(2)).sum::<f64>() / count;
    (mean, square.sqrt())
}

/// The chapter of the page. Asserts what it states.
pub(super) fn chapter() -> String {
    let mut text = CHAPTER.to_owned();
    let mut rigid: [Vec<f64>; 2] = Default::default();
    let mut rows = Vec::new();
    for case in FibreCase::read_all() {
        let found = case.two_bars();
        let ratio = found.max_v1 / case.max_v1_m;
        let residual = found.residual_v1.unwrap_or(f64::NAN);
        let struck = match case.vehicle() {
            None => "rigid",
            Some(_) => "soft",
        };
        // In thousandths, as the table shows it; the largest deviation comes first.
        let deviation = ((1e3 * ratio).round() - 1e3).abs();
        let line = format!(
            "| {} | {struck} | {} | {:.2} | {:.2} | {ratio:.3} | {:.2} | {:.2} | {:.2} | {:.2} |\n",
            case.case,
            case.hardening,
            1e3 * case.max_v1_m,
            1e3 * found.max_v1,
            1e3 * case.residual_v1_m,
            1e3 * residual,
            1e3 * case.max_v1_time_s,
            1e3 * found.max_v1_time,
        );
        rows.push((deviation, ratio, line));
        if struck == "rigid" && case.hardening == NEARLY_NONE {
            rigid[0].push(ratio);
            rigid[1].push(residual / case.residual_v1_m);
        }
        if struck == "rigid" {
            let release = found.release_time.expect("a release");
            assert!((release / case.release_s - 1.0).abs() < 0.1, "{case:?}");
            assert!(
                (found.impactor_velocity - case.impactor_end_m_s).abs() < 0.3,
                "{case:?}"
            );
        }
    }
    rows.sort_by(|one, other| other.0.total_cmp(&one.0));
    text.extend(rows.iter().map(|(.., line)| line.as_str()));
    let ratios = || rows.iter().map(|(_, ratio, _)| *ratio);
    let _ = write!(
        text,
        "\nOver all {} cases the peak of the two bars is {:.2} to {:.2} times the peak of the fibre beam.\n",
        rows.len(),
        ratios().fold(f64::INFINITY, f64::min),
        ratios().fold(0.0, f64::max),
    );
    let (mean, square) = scatter(&rigid[0]);
    let (residual_mean, residual_square) = scatter(&rigid[1]);
    // Reports print these figures, too.
    let rounded = |value: f64, factor: f64| (factor * value).round() / factor;
    let agreement = FibreAgreement {
        cases: rigid[0].len(),
        peak: rounded(100.0 * square, 10.0),
        residual: rounded(100.0 * residual_square, 10.0),
        lowest: rounded(rigid[0].iter().copied().fold(f64::INFINITY, f64::min), 1e3),
        ..FIBRE_AGREEMENT
    };
    assert_eq!(agreement, FIBRE_AGREEMENT, "src/report/limits.rs");
    assert!(
        (mean - 1.0).abs() < 0.02 && square < 0.03,
        "{mean} {square}"
    );
    let count = rigid[0].len();
    let _ = writeln!(
        text,
        "Over the {count} rigid impacts with b = 1e-4 the mean ratio of peak v1 is {mean:.3} with a root mean square deviation of {:.1} %; \
         for the residual displacement they are {residual_mean:.3} and {:.1} %.",
        100.0 * square,
        100.0 * residual_square,
    );
    text + &limits()
}

const CHAPTER: &str = "
## Comparison with a fibre beam model

The chapters above validate the solution of the model's equations.
This one shows how well the model itself describes a column.
A beam of 44 elements with distributed mass and distributed plasticity, written independently, received the same impacts (`tests/data/fibre_cases.csv`).
The two bars have the coupled elastic law, the yield surface of Duan and Chen, and a third of the column's mass at the impact point.
`b` is the ratio of the slope after yield to the elastic one; the two bars use it as `hardening.ratio`.
The largest deviation comes first.

| case | vehicle | hardening | fibre peak v1 [mm] | two bars [mm] | ratio | fibre residual [mm] | two bars [mm] | fibre time of peak v1 [ms] | two bars [ms] |
|---|---|---|---|---|---|---|---|---|---|
";

/// Where the model is off, with the figures that reports print, too.
fn limits() -> String {
    let FibreAgreement {
        first_force: [low, high],
        collapse_speed,
        ..
    } = FIBRE_AGREEMENT;
    format!(
        "
Where the two-bar model is off:

- The first millisecond: bending waves do not exist in two rigid bars; the contact force averaged over 1 ms is {low} to {high} times the force in the fibre beam.
- The peak contact force of a rigid vehicle has no limit as the step shrinks; only its average over 1 ms means something.
- The moment at the base under a high load: axial inertia is missing.
- The speed at which the column collapses is about {collapse_speed:.0} % too high, which is on the unsafe side; no case of the table shows it.
- A soft vehicle at the edge of yielding: 1 % of strength changes v1 by several per cent, and a hardening of 1 % divides it by 5 to 13; both models differ there most. There the report prints a band, not a number.
"
    )
}
