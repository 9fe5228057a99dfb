//! `docs/validation.md` and its figures: both schemes compared with the reference responses.
//! `UPDATE_DOCS=1 cargo test --release --lib validation` regenerates the page; otherwise the test checks it.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - analytic.rs: Comparison with analytic solutions for rigid-plastic columns and with a crash test against a wall
// - beam.rs: The fibre beam of the second opinion against other models, and where it and the two bars part
// - experiments.rs: Comparison with impact tests on members, the list of all the evidence for the model, and what is missing
// - fibre.rs: Comparison with a fibre beam model: what the two bars leave out, in numbers
// - slip.rs: Comparison of the slip of a base plate with that of an engineer's fibre beam on springs

mod analytic;
mod beam;
mod experiments;
mod fibre;
mod slip;

use std::fmt::Write as _;
use std::path::Path;

use crate::column::{Report, Sample, simulate};
use crate::figures::axis::PlotAxis;
use crate::figures::chart::{Curve, TimeChart, axes};
use crate::figures::page::{self, Drawn, LegendKey, Stroke, colour};
use crate::figures::raster::Raster;
use crate::figures::reference::Reference;
use crate::figures::units::Unit;
use crate::parameters::{Parameters, parse_override};

/// Exponents of a reference response.
type Exponents = [&'static str; 2];

const ELLIPSE: Exponents = ["yield_surface.alpha:=2.0", "yield_surface.beta:=2.0"];
const DUAN_CHEN: Exponents = ["yield_surface.alpha:=1.0", "yield_surface.beta:=1.3"];

/// Time steps of the convergence study \[s\].
const STEPS: [&str; 6] = ["2.0e-4", "1.0e-4", "5.0e-5", "2.0e-5", "1.0e-5", "5.0e-6"];

/// The value of `solver.scheme` for the conserving midpoint scheme, and its name here.
const CONSERVING: [&str; 2] = ["conserving_midpoint", "conserving midpoint"];

/// Both schemes: the value of `solver.scheme`, and the name here.
const SCHEMES: [[&str; 2]; 2] = [["midpoint", "midpoint"], CONSERVING];

/// Duration of the reference responses \[s\].
const DURATION: f64 = 0.06;

/// The paper's example: 1500 kg at 10 m/s.
fn response(scheme: &str, dt: &str, exponents: Exponents) -> (Report, Vec<Sample>) {
    let overrides = [
        format!("solver.scheme:={scheme}"),
        format!("solver.dt:={dt}"),
        exponents[0].to_owned(),
        exponents[1].to_owned(),
    ];
    let overrides = overrides.map(|text| parse_override(&text));
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/heb220_paper.yaml");
    let parameters = Parameters::load(&[file], &overrides).unwrap();
    let impact = parameters.impact();
    let mut samples = Vec::new();
    let properties = parameters.column_properties();
    let mut observe = |sample: &Sample| samples.push(*sample);
    let report = simulate(&properties, &impact, DURATION, &mut observe).unwrap();
    (report, samples)
}

/// Relative deviation.
fn deviation(found: f64, expected: f64) -> f64 {
    found / expected - 1.0
}

fn over_time(samples: &[Sample], value: impl Fn(&Sample) -> f64) -> Vec<(f64, f64)> {
    samples.iter().map(|it| (it.time, value(it))).collect()
}

/// Draws `v1` and `v_c` of the reference, dashed, over those of the default scheme.
fn displacement(reference: &Reference, samples: &[Sample], title: &str) -> Drawn<String> {
    let line = |name: &str, samples: &[Sample], value: fn(&Sample) -> f64, stroke| {
        Curve::line(name, over_time(samples, value), stroke)
    };
    TimeChart {
        title: "Displacement of impact point and impactor compared with the reference",
        lines: [
            title,
            "solid: conserving midpoint scheme, dt = 20 µs; dashed: reference",
        ],
        quantity: "displacement v",
        unit: Unit::length(0.1),
        span: (0.0, DURATION),
        bands: Vec::new(),
        curves: vec![
            line(
                "v₁",
                samples,
                |it| it.v1,
                Stroke::solid(colour::IMPACT_POINT, 18),
            ),
            line(
                "v_c",
                samples,
                |it| it.impactor_position,
                Stroke::solid(colour::IMPACTOR, 18),
            ),
            line(
                "reference",
                &reference.samples,
                |it| it.v1,
                Stroke::dashed(colour::INK, 8),
            ),
            line(
                "",
                &reference.samples,
                |it| it.impactor_position,
                Stroke::dashed(colour::INK, 8),
            ),
        ],
        marks: Vec::new(),
        arrows: Vec::new(),
        keys: Vec::new(),
        events: Vec::new(),
    }
    .draw()
}

/// Draws the error of the peak against the time step, both on logarithmic scales.
fn convergence(errors: &[(f64, [f64; 2])]) -> Drawn<String> {
    page::draw(|page| {
        let strokes = [
            Stroke::solid(colour::IMPACTOR, 18),
            Stroke::solid(colour::IMPACT_POINT, 18),
        ];
        let order = Stroke::dashed(colour::FAINT, 8);
        let legend = SCHEMES
            .into_iter()
            .zip(strokes)
            .map(|([_, name], stroke)| (LegendKey::Line(stroke), name.to_owned()))
            .chain([(LegendKey::Line(order), "second order".to_owned())])
            .collect::<Vec<_>>();
        let lines = [
            "HEB 220, paper's example, elliptical hinges: 1500 kg at 10 m/s",
            "relative error of the peak of v₁ compared with the reference (steps of 0.5 µs)",
        ];
        let title = "Convergence of both schemes with the time step";
        let top = page::heading(page, title, lines, &legend)?;
        let (_, below) = page.split_vertically(top + 40);
        let x = PlotAxis::between(-5.4, -3.6, 9);
        let y = PlotAxis::between(-7.0, -2.5, 9);
        let plot = axes(&below, &x, &y, ["log₁₀ (dt / s)", "log₁₀ |relative error|"])?;
        let place = |dt: f64, error: f64| plot.backend_coord(&(dt.log10(), error.abs().log10()));
        for (which, stroke) in strokes.into_iter().enumerate() {
            let points: Vec<_> = errors
                .iter()
                .map(|(dt, it)| place(*dt, it[which]))
                .collect();
            for point in &points {
                page::dot(page, *point, stroke.colour)?;
            }
            stroke.draw(page, points)?;
        }
        let (dt, error) = (errors[0].0, errors[0].1[0]);
        let last = errors[errors.len() - 1].0;
        let parallel = vec![
            place(dt, 2.0 * error),
            place(last, 2.0 * error * (last / dt).powi(2)),
        ];
        order.draw(page, parallel)
    })
}

/// Draws the residual of the energy ledger relative to the energy of the impactor.
fn ledger(runs: &[(&str, &[Sample], Stroke)]) -> Drawn<String> {
    const INPUT: f64 = 75_000.0;
    page::draw(|page| {
        let legend: Vec<_> = runs
            .iter()
            .map(|(name, _, stroke)| (LegendKey::Line(*stroke), (*name).to_owned()))
            .collect();
        let lines = [
            "HEB 220, paper's example, elliptical hinges, dt = 20 µs",
            "|supplied - stored - dissipated| / energy of the impactor, at every step",
        ];
        let top = page::heading(page, "Residual of the energy ledger", lines, &legend)?;
        let (_, below) = page.split_vertically(top + 40);
        let x = PlotAxis::between(0.0, 60.0, 10);
        let y = PlotAxis::between(-18.0, -2.0, 8);
        let plot = axes(&below, &x, &y, ["time t [ms]", "log₁₀ residual"])?;
        for (_, samples, stroke) in runs {
            let points = samples
                .iter()
                .step_by(10)
                .map(|it| {
                    let residual = (it.ledger_residual / INPUT).abs().max(1e-18);
                    plot.backend_coord(&(1e3 * it.time, residual.log10()))
                })
                .collect();
            stroke.draw(page, points)?;
        }
        Ok(())
    })
}

struct Validation {
    page: String,
    figures: Vec<(&'static str, String)>,
}

fn validation() -> Validation {
    let mut page = PREFACE.to_owned();
    let mut figures = Vec::new();
    let cases = [
        (
            "ellipse",
            "elliptical hinges (2, 2)",
            ELLIPSE,
            Reference::ellipse(),
        ),
        (
            "duan_chen",
            "Duan and Chen's hinges (1, 1.3)",
            DUAN_CHEN,
            Reference::duan_chen(),
        ),
    ];
    for (name, title, exponents, reference) in &cases {
        let (report, samples) = response(CONSERVING[0], "2.0e-5", *exponents);
        let file = match *name {
            "ellipse" => "validation_ellipse",
            _ => "validation_duan_chen",
        };
        let long = format!("HEB 220, paper's example, {title}: 1500 kg at 10 m/s");
        figures.push((file, displacement(reference, &samples, &long).unwrap()));
        let expected = &reference.report;
        let _ = write!(
            page,
            "\n### With {title}\n\n![{title}](images/{file}.png)\n\n"
        );
        page += "| quantity | reference | conserving midpoint, dt 20 µs | deviation |\n|---|---|---|---|\n";
        let release = |it: &Report| it.release_time.unwrap_or(f64::NAN);
        for (quantity, unit, expected, found) in [
            ("peak v1", "mm", 1e3 * expected.max_v1, 1e3 * report.max_v1),
            (
                "time of the peak",
                "ms",
                1e3 * expected.max_v1_time,
                1e3 * report.max_v1_time,
            ),
            (
                "last separation",
                "ms",
                1e3 * release(expected),
                1e3 * release(&report),
            ),
            (
                "peak contact force",
                "kN",
                1e-3 * expected.peak_contact_force,
                1e-3 * report.peak_contact_force,
            ),
            (
                "impulse",
                "kN s",
                1e-3 * expected.impulse,
                1e-3 * report.impulse,
            ),
            (
                "final velocity of the impactor",
                "m/s",
                expected.impactor_velocity,
                report.impactor_velocity,
            ),
            (
                "plastic work",
                "kJ",
                1e-3 * expected.plastic_work,
                1e-3 * report.plastic_work,
            ),
            (
                "lost in impact impulses",
                "kJ",
                1e-3 * expected.impact_loss,
                1e-3 * report.impact_loss,
            ),
        ] {
            let _ = writeln!(
                page,
                "| {quantity} | {expected:.5} {unit} | {found:.5} {unit} | {:+.1e} |",
                deviation(found, expected)
            );
        }
    }
    page += CONVERGENCE;
    let reference = &cases[0].3.report;
    let mut errors = Vec::new();
    for dt in STEPS {
        let [midpoint, conserving] = SCHEMES.map(|[scheme, _]| {
            let (report, _) = response(scheme, dt, ELLIPSE);
            deviation(report.max_v1, reference.max_v1)
        });
        let _ = writeln!(page, "| {dt} s | {midpoint:+.2e} | {conserving:+.2e} |");
        errors.push((dt.parse().unwrap(), [midpoint, conserving]));
    }
    figures.push(("validation_convergence", convergence(&errors).unwrap()));
    page += LEDGER;
    let midpoint = response("midpoint", "2.0e-5", ELLIPSE).1;
    let conserving = response(CONSERVING[0], "2.0e-5", ELLIPSE).1;
    let runs: [(&str, &[Sample], Stroke); 2] = [
        ("midpoint", &midpoint, Stroke::solid(colour::IMPACTOR, 10)),
        (
            CONSERVING[1],
            &conserving,
            Stroke::solid(colour::IMPACT_POINT, 10),
        ),
    ];
    figures.push(("validation_energy", ledger(&runs).unwrap()));
    page += &analytic::chapter();
    page += &fibre::chapter();
    page += &beam::chapter();
    page += &experiments::chapters();
    Validation { page, figures }
}

const PREFACE: &str = "\
# Validation

The tests write this page (`UPDATE_DOCS=1 cargo test --release --lib validation`) and fail if it differs from their results.
The reference responses (`tests/data/`) were computed independently with steps of 0.5 µs.
The first chapters validate the solution of the model's equations; the others compare the model itself with a crash test, a finer model and impact tests.
[The evidence in one table](#the-evidence-in-one-table) shows the scope of each comparison, and [data wanted](#data-wanted) the measurements that are missing.
Terms are explained in the [glossary](glossary.md).

## Comparison with the reference
";

const CONVERGENCE: &str = "
## Convergence

![Convergence](images/validation_convergence.png)

The table gives the relative error of the peak displacement with elliptical hinges.
The paper's midpoint scheme distributes the impact impulse over the first step, during which the column loses half of it.
The conserving midpoint scheme applies the impact impulse instantaneously; its error comes from hinges that change state within a step.

| dt | midpoint | conserving midpoint |
|---|---|---|
";

const LEDGER: &str = "
## Energy

![Energy](images/validation_energy.png)

With the conserving midpoint scheme the ledger closes at every step to round-off.
The paper's midpoint scheme does not conserve energy; here the residual is about 4e-9 of the energy of the impactor.
";

#[test]
fn the_validation_page_is_what_is_computed() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let Validation { page, figures } = validation();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        let raster = Raster::new();
        for (name, svg) in &figures {
            let png = raster.png(svg).unwrap();
            std::fs::write(docs.join(format!("images/{name}.png")), png).unwrap();
        }
        std::fs::write(docs.join("validation.md"), &page).unwrap();
    }
    for (name, _) in figures {
        let file = docs.join(format!("images/{name}.png"));
        assert!(file.exists(), "{} is missing", file.display());
    }
    let kept = std::fs::read_to_string(docs.join("validation.md")).unwrap_or_default();
    assert!(
        kept == page,
        "docs/validation.md differs from what is computed; regenerate it with\n    \
         UPDATE_DOCS=1 cargo test --release --lib validation\n\n{page}"
    );
}
