//! The fibre beam of the second opinion against other models, and where it and the two bars part.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::parameters::{Parameters, parse_override};
use crate::second_opinion::{JointVerdict, NoSecondOpinion};

/// A plane hit, a row of `plane.csv` and, without vehicle and hardening, of `edge.csv`.
#[derive(Debug, Deserialize)]
struct PlaneHit {
    case: String,
    #[serde(default)]
    vehicle: String,
    #[serde(default)]
    hardening: String,
    peak_m: f64,
    ratio: f64,
    residual_m: f64,
    residual_ratio: f64,
}

#[derive(Debug, Deserialize)]
struct ObliqueHit {
    case: String,
    torsion: String,
    along_m: f64,
    along_ratio: f64,
    across_m: f64,
    across_ratio: f64,
    residual_m: f64,
    residual_ratio: f64,
}

#[derive(Debug, Deserialize)]
struct PushedDown {
    case: String,
    bow: String,
    residual_stress: bool,
    capacity_n: f64,
    ratio: f64,
    tolerance: f64,
}

#[derive(Debug, Deserialize)]
struct LimitLoad {
    section: String,
    length_below_m: f64,
    axial_ratio: f64,
    bumper_m: f64,
    ratio: f64,
}

#[derive(Debug, Deserialize)]
struct Sheared {
    case: String,
    vehicle: String,
    threshold: bool,
    peak_m: f64,
    ratio: f64,
    residual_ratio: f64,
}

#[derive(Debug, Deserialize)]
struct Buckled {
    section: String,
    axis: String,
    length_m: f64,
    ratio: f64,
}

/// The least and the largest ratio of all sections, about an axis and with a length.
#[derive(Debug, Deserialize)]
struct BuckledOfAll {
    axis: String,
    length_m: f64,
    least: f64,
    least_section: String,
    most: f64,
    most_section: String,
}

/// What the tests of the beam have found, from the tables that they keep.
fn found<T: DeserializeOwned>(name: &str) -> Vec<T> {
    let file = format!("crates/beam/tests/data/found/{name}.csv");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(&file);
    let mut reader = csv::Reader::from_path(path).expect(&file);
    let rows: Result<Vec<T>, _> = reader.deserialize().collect();
    let rows = rows.expect(&file);
    assert!(!rows.is_empty(), "{file}");
    rows
}

/// The rows with the largest deviation from 1 first.
fn worst_first<T>(mut rows: Vec<T>, ratio: impl Fn(&T) -> f64) -> Vec<T> {
    let off = |row: &T| (ratio(row) - 1.0).abs();
    rows.sort_by(|one, other| off(other).total_cmp(&off(one)));
    rows
}

/// Mean, lowest and highest of ratios.
fn spread(ratios: &[f64]) -> [f64; 3] {
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    let low = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    [mean, low, ratios.iter().copied().fold(0.0, f64::max)]
}

pub(super) fn chapter() -> String {
    let mut text = CHAPTER.to_owned();
    text += &plane();
    text += &oblique();
    text += &push_downs();
    text += &sheared();
    text += &limit_loads();
    text += &buckling();
    text += &where_they_part();
    text
}

fn plane() -> String {
    let mut rows: Vec<PlaneHit> = found("plane");
    rows.extend(found::<PlaneHit>("edge").into_iter().map(|row| PlaneHit {
        vehicle: "edge of yielding".to_owned(),
        ..row
    }));
    let mut text = PLANE.to_owned();
    for row in worst_first(rows, |row| row.ratio) {
        let residual = match row.residual_m > 1e-4 {
            true => format!("{:.2} | {:.3}", 1e3 * row.residual_m, row.residual_ratio),
            false => "0.00 | -".to_owned(),
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.2} | {:.3} | {residual} |",
            row.case,
            row.vehicle,
            row.hardening,
            1e3 * row.peak_m,
            row.ratio,
        );
    }
    text
}

fn oblique() -> String {
    let off = |row: &ObliqueHit| {
        let across = if row.across_m > 1e-3 {
            row.across_ratio
        } else {
            1.0
        };
        let ratios = [row.along_ratio, across, row.residual_ratio];
        let worst = ratios
            .into_iter()
            .max_by(|one, other| (one - 1.0).abs().total_cmp(&(other - 1.0).abs()));
        worst.unwrap_or(1.0)
    };
    let mut text = OBLIQUE.to_owned();
    for row in worst_first(found("oblique"), off) {
        let torsion = match row.torsion.as_str() {
            "None" => "twist suppressed",
            _ => "St Venant",
        };
        let across = match row.across_ratio.is_finite() {
            true => format!("{:.1} | {:.3}", 1e3 * row.across_m, row.across_ratio),
            false => "0.0 | -".to_owned(),
        };
        let _ = writeln!(
            text,
            "| {} | {torsion} | {:.1} | {:.3} | {across} | {:.1} | {:.3} |",
            row.case,
            1e3 * row.along_m,
            row.along_ratio,
            1e3 * row.residual_m,
            row.residual_ratio,
        );
    }
    text
}

/// Mean, standard deviation and number of the ratios of the peaks along oblique hits.
pub(super) fn oblique_ratio() -> String {
    let rows: Vec<ObliqueHit> = found("oblique");
    let ratios: Vec<f64> = rows.iter().map(|row| row.along_ratio).collect();
    let [mean, ..] = spread(&ratios);
    let squares: f64 = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum();
    let deviation = (squares / ratios.len() as f64).sqrt();
    format!("{mean:.3} ± {deviation:.3} ({})", ratios.len())
}

fn push_downs() -> String {
    let mut text = PUSH_DOWN.to_owned();
    for row in worst_first(found("push_down"), |row: &PushedDown| row.ratio) {
        let bow = match row.bow.as_str() {
            "none" => "straight".to_owned(),
            "both" => "about both axes".to_owned(),
            axis => format!("about the {axis} axis"),
        };
        let _ = writeln!(
            text,
            "| {} | {bow} | {} | {:.0} | {:.3} | {:.1} % |",
            row.case,
            if row.residual_stress { "yes" } else { "no" },
            1e-3 * row.capacity_n,
            row.ratio,
            100.0 * row.tolerance,
        );
    }
    text
}

fn sheared() -> String {
    let rows: Vec<Sheared> = found("shear");
    let mut text = SHEAR.to_owned();
    for (name, of) in [
        ("rigid vehicle", ("rigid", false)),
        ("deformable front", ("deformable", false)),
        (
            "a front at the resistance of the web, where 2 % of strength decide",
            ("deformable", true),
        ),
    ] {
        let these = rows
            .iter()
            .filter(|row| (row.vehicle.as_str(), row.threshold) == of);
        let ratios: Vec<f64> = these.map(|row| row.ratio).collect();
        let [mean, low, high] = spread(&ratios);
        let _ = writeln!(
            text,
            "| {name} | {} | {mean:.3} | {low:.3} to {high:.3} |",
            ratios.len()
        );
    }
    text += SHEAR_WORST;
    let ordinary: Vec<Sheared> = rows.into_iter().filter(|row| !row.threshold).collect();
    for row in worst_first(ordinary, |row| row.ratio).iter().take(WORST) {
        let _ = writeln!(
            text,
            "| `{}` | {} | {:.1} | {:.3} | {:.3} |",
            row.case,
            row.vehicle,
            1e3 * row.peak_m,
            row.ratio,
            row.residual_ratio,
        );
    }
    text
}

/// How many of many rows a table shows.
const WORST: usize = 8;

fn limit_loads() -> String {
    let rows: Vec<LimitLoad> = found("limit_loads");
    let [mean, low, high] = spread(&rows.iter().map(|row| row.ratio).collect::<Vec<_>>());
    let mut text = LIMIT_LOADS.to_owned();
    let _ = write!(
        text,
        "Over {} limit loads the mean ratio is {mean:.3}; the lowest is {low:.3}, the highest {high:.3}.\n\n\
         | height of the impact | limit loads | mean | from | to |\n|---|---|---|---|---|\n",
        rows.len()
    );
    let mut by_height: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for row in &rows {
        let millimetres = (1e3 * row.length_below_m).round() as u64;
        by_height.entry(millimetres).or_default().push(row.ratio);
    }
    for (millimetres, ratios) in by_height {
        let [mean, low, high] = spread(&ratios);
        let _ = writeln!(
            text,
            "| {} m | {} | {mean:.3} | {low:.3} | {high:.3} |",
            millimetres as f64 * 1e-3,
            ratios.len()
        );
    }
    text += LIMIT_LOADS_WORST;
    for row in worst_first(rows, |row| row.ratio).iter().take(WORST) {
        let bumper = match row.bumper_m > 0.0 {
            true => format!("over {} m", row.bumper_m),
            false => "at a point".to_owned(),
        };
        let _ = writeln!(
            text,
            "| {} | {} m | {} | {bumper} | {:.3} |",
            row.section, row.length_below_m, row.axial_ratio, row.ratio
        );
    }
    text
}

fn buckling() -> String {
    let mut lines: Vec<(String, Vec<Buckled>)> = Vec::new();
    for row in found::<Buckled>("buckling") {
        let name = format!("{} | {}", row.section, row.axis.to_lowercase());
        match lines.iter_mut().find(|line| line.0 == name) {
            Some(line) => line.1.push(row),
            None => lines.push((name, vec![row])),
        }
    }
    let lengths: Vec<f64> = lines[0].1.iter().map(|row| row.length_m).collect();
    let mut text = BUCKLING.to_owned();
    let heads: String = lengths
        .iter()
        .map(|length| format!(" {length} m |"))
        .collect();
    let rules = "---|".repeat(lengths.len());
    let _ = writeln!(text, "| section | axis |{heads}\n|---|---|{rules}");
    let worst = |line: &(String, Vec<Buckled>)| {
        let ratios = line.1.iter().map(|row| row.ratio);
        let worst = ratios.max_by(|one, other| (one - 1.0).abs().total_cmp(&(other - 1.0).abs()));
        worst.unwrap_or(1.0)
    };
    for (name, rows) in worst_first(lines, worst) {
        assert_eq!(
            rows.iter().map(|row| row.length_m).collect::<Vec<_>>(),
            lengths
        );
        let ratios: String = rows
            .iter()
            .map(|row| format!(" {:.3} |", row.ratio))
            .collect();
        let _ = writeln!(text, "| {name} |{ratios}");
    }
    text += BUCKLING_OF_ALL;
    for row in found::<BuckledOfAll>("buckling_of_all") {
        let BuckledOfAll {
            least,
            least_section,
            most,
            most_section,
            ..
        } = &row;
        let _ = writeln!(
            text,
            "| {} | {} m | {least:.3} | {least_section} | {most:.3} | {most_section} |",
            row.axis.to_lowercase(),
            row.length_m
        );
    }
    text
}

/// Hits by which both models are compared: in words, and as parameters.
const PARTINGS: [(&str, &[&str]); 13] = [
    (
        "rigid, 1500 kg at 10 m/s, 0 degrees",
        &[RIGID, MASS, "impact.velocity:=10.0", AT_1_M],
    ),
    (
        "the same, 5 degrees",
        &[
            RIGID,
            MASS,
            "impact.velocity:=10.0",
            AT_1_M,
            "impact.direction:=0.0872665",
        ],
    ),
    (
        "the same, 10 degrees",
        &[
            RIGID,
            MASS,
            "impact.velocity:=10.0",
            AT_1_M,
            "impact.direction:=0.174533",
        ],
    ),
    (
        "the same, 30 degrees",
        &[
            RIGID,
            MASS,
            "impact.velocity:=10.0",
            AT_1_M,
            "impact.direction:=0.523599",
        ],
    ),
    (
        "the same, 90 degrees",
        &[
            RIGID,
            MASS,
            "impact.velocity:=10.0",
            AT_1_M,
            "impact.direction:=1.570796",
        ],
    ),
    ("`mid_car` at 10 m/s, 0 degrees", &["impact.velocity:=10.0"]),
    (
        "the same, 45 degrees",
        &["impact.velocity:=10.0", "impact.direction:=0.785398"],
    ),
    ("`mid_car` at 20 m/s, 0 degrees", &["impact.velocity:=20.0"]),
    (
        "the same, 45 degrees",
        &["impact.velocity:=20.0", "impact.direction:=0.785398"],
    ),
    (
        "`mid_car` at 26 m/s, 1 m above the base",
        &["impact.velocity:=26.0", AT_1_M],
    ),
    (
        "`lorry_8t` at 6 m/s, 0 degrees",
        &[LORRY, "impact.velocity:=6.0"],
    ),
    (
        "`lorry_8t` at 8 m/s, 0 degrees",
        &[LORRY, "impact.velocity:=8.0"],
    ),
    (
        "`lorry_8t` at 6 m/s, 10 degrees",
        &[LORRY, "impact.velocity:=6.0", "impact.direction:=0.174533"],
    ),
];

const RIGID: &str = "vehicle.name:=rigid";
const MASS: &str = "impact.mass:=1500.0";
const LORRY: &str = "vehicle.name:=lorry_8t";
const AT_1_M: &str = "geometry.length_below:=1.0";

fn where_they_part() -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/heb220_s355.yaml");
    let mut text = PARTING.to_owned();
    for (name, overrides) in PARTINGS {
        let overrides: Vec<_> = overrides.iter().map(|it| parse_override(it)).collect();
        let parameters =
            Parameters::load(std::slice::from_ref(&file), &overrides).expect("admissible");
        let judged = JointVerdict::of_parameters(&parameters).expect("a response");
        let report = &judged.report;
        let kept = |metres: f64| match metres.is_finite() {
            // Round-off below zero is 0.
            true => format!("{:.1}", 1e3 * metres).replace("-0.0", "0.0"),
            false => "collapse".to_owned(),
        };
        let bars = [report.max_v1, report.residual_v1.unwrap_or(f64::NAN)].map(kept);
        let beam: Result<_, NoSecondOpinion> = judged.second_opinion;
        let opinion = beam.expect("a second opinion");
        let [peak, remains] = opinion.from_undamaged();
        let ratio = opinion.ratio_to_two_bars;
        let why = match opinion.counts.is_empty() {
            true => "both agree".to_owned(),
            false => opinion.counts_because(),
        };
        let _ = writeln!(
            text,
            "| {name} | {} / {} | {} / {} | {} / {} | {} | {why} |",
            bars[0],
            bars[1],
            kept(peak[0]),
            kept(remains[0]),
            kept(peak[1]),
            kept(remains[1]),
            ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}")),
        );
    }
    text
}

const CHAPTER: &str = "
## The fibre beam of the second opinion

[The second opinion](second_opinion.md) computes each hit with a fibre beam in space.
The tests of `crates/beam` compare it with other models and keep their results in `crates/beam/tests/data/found/`, from which these tables are made; ratios are beam over reference, and the worst line comes first.
Agreement with OpenSees verifies the code, not the column: both have plane sections, and neither has local buckling or fracture.
[crates/beam/validation.md](../crates/beam/validation.md) states the tolerances and where they are missed.
";

const PLANE: &str = "
### Hits in the plane of the web

OpenSees computed them with the same section, without shear (`crates/beam/tests/data/fibre_cases.csv`, and eight cases at the edge of yielding in `crates/beam/tests/data/beam_reference.json`).
The two cases with the numbers of the paper are left out: no section of one yield strength has its area, second moment and plastic moment.

| case | vehicle | hardening | peak, OpenSees [mm] | ratio | residual, OpenSees [mm] | ratio |
|---|---|---|---|---|---|---|
";

const OBLIQUE: &str = "
### Oblique hits

OpenSees in space (`crates/beam/tests/data/beam_reference.json`), with St Venant's torsion alone and with the twist suppressed.
The program also takes into account the warping that built-in ends restrain, which no reference has.

| case | torsion | peak along the hit, OpenSees [mm] | ratio | peak across it [mm] | ratio | residual along the hit [mm] | ratio |
|---|---|---|---|---|---|---|---|
";

const PUSH_DOWN: &str = "
### Push-downs

The largest axial force of a column by OpenSees (`crates/beam/tests/data/beam_reference.json`), undamaged or after a hit.

| column | bow | residual stresses | OpenSees [kN] | ratio | stated tolerance |
|---|---|---|---|---|---|
";

const SHEAR: &str = "
### Hits that shear the web

Finite elements in plane stress received the same hits low above the base (`crates/mechanics/tests/data/shear_cases.jsonl`).

| vehicle | cases | mean ratio of the peaks | from, to |
|---|---|---|---|
";

const SHEAR_WORST: &str = "
The cases with the largest deviations, without the last line:

| case | vehicle | peak, finite elements [mm] | ratio | ratio of the residuals |
|---|---|---|---|---|
";

const LIMIT_LOADS: &str = "
### Limit loads

The lateral resistance of the beam over the middle of the bounds of limit analyses (`crates/mechanics/tests/data/limit_loads.jsonl`): columns of 4 m, pushed at a point or over a bumper of 0.2 m.
";

const LIMIT_LOADS_WORST: &str = "
The largest deviations:

| section | height of the impact | axial force over the squash load | pushed | ratio |
|---|---|---|---|---|
";

const BUCKLING: &str = "
### Buckling curves

The largest axial force of pinned columns in S355 with residual stresses and a bow of L/1000, over the buckling curves of EN 1993-1-1, by length.
Hollow sections have curve a, square corners and no residual stresses.
The target is 0.95 to 1.15; 21 of 930 slender columns lie above it, by at most 0.6 %, and not because of the mesh: 120 elements change HEB220 and HEA220 of 8 m and HEB140 of 6 m by 0.06 %.
Those about the strong axis lie above their curve b because a bow of L/1000 and the residual stresses are smaller imperfections than those of the curve: with the bow of L/250 that EN 1993-1-1, table 5.1, puts in their place for this curve, the same columns lie 3 to 5 % below it.
The residual stresses do not grow with the yield strength either: at the same slenderness these columns lie at 1.07 to 1.08 in S235, for which the curves were made, and at 1.08 in S460, to which the code gives the next curve, a.

";

const BUCKLING_OF_ALL: &str = "
The extremes of all 90 rolled sections of `config/sections.csv` and of the three hollow ones:

| axis | length | least | section | largest | section |
|---|---|---|---|---|---|
";

const PARTING: &str = "
### Where the two bars and the beam part

The column of `config/heb220_s355.yaml`, hit at the height of the vehicle in the catalogue unless a height is given.
The beam counts its displacements along the hit, the two bars in their plane.
Both models part where the hit is not in the plane of the web and at the edge of yielding; the last column states why the verdict of the beam counts.

| hit | two bars, peak / residual [mm] | beam along the hit [mm] | beam across the hit [mm] | ratio of the peaks | why the verdict of the beam counts |
|---|---|---|---|---|---|
";
