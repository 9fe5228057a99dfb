//! Comparison with impact tests on members, the list of all the evidence for the model, and what is missing.

use std::fmt::Write as _;
use std::path::Path;

use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::column::{Report, respond};
use crate::parameters::{Parameters, parse_override};

/// Standard acceleration of free fall \[m/s²\].
const GRAVITY: f64 = 9.81;

/// A series of members that were struck by a falling weight at mid-span, a file in `tests/data/experiments/`.
#[derive(Debug, Deserialize)]
struct Series {
    name: String,
    citation: String,
    provenance: String,
    left_out: String,
    /// By how much the measured displacements may be wrong \[m\].
    displacement_error_m: f64,
    member: Member,
    tests: Vec<Test>,
}

/// What all members of a series share.
#[derive(Debug, Deserialize)]
struct Member {
    static_load_n: f64,
    static_span_m: f64,
    static_source: String,
    young_modulus_pa: f64,
    second_moment_m4: f64,
    second_moment_source: String,
    area_m2: f64,
    mass_per_length_kg_m: f64,
    mass_source: String,
    height_m: f64,
    yield_strength_pa: f64,
    squash_load_n: f64,
    /// 0: that of the program.
    max_rate_factor: f64,
}

#[derive(Debug, Deserialize)]
struct Test {
    id: String,
    span_m: f64,
    mass_kg: f64,
    velocity_m_s: f64,
    peak_m: f64,
    residual_m: f64,
}

/// The dynamic and the quasi-static test of one collision post.
#[derive(Debug, Deserialize)]
struct CollisionPost {
    citation: String,
    mass_kg: f64,
    velocity_m_s: f64,
    dynamic_absorbed_j: f64,
    dynamic_deformation_m: f64,
    static_absorbed_j: f64,
    static_deformation_m: f64,
}

fn read<T: DeserializeOwned>(name: &str) -> T {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/experiments")
        .join(name);
    let text = std::fs::read_to_string(&file).expect("the data of an experiment");
    serde_json::from_str(&text).unwrap_or_else(|fault| panic!("{}: {fault}", file.display()))
}

impl Series {
    /// `M` of a member whose hinge at mid-span carries the static load: `P L / 4` \[N m\].
    fn moment(&self) -> f64 {
        0.25 * self.member.static_load_n * self.member.static_span_m
    }

    /// The response of the program; `has_weight` is whether the striker has its weight.
    fn respond(&self, test: &Test, has_weight: bool) -> Report {
        let member = &self.member;
        let numbers = [
            ("geometry.length_below", 0.5 * test.span_m),
            ("geometry.length_above", 0.5 * test.span_m),
            ("section.area", member.area_m2),
            ("section.second_moment", member.second_moment_m4),
            ("section.mass_per_length", member.mass_per_length_kg_m),
            ("section.height", member.height_m),
            ("steel.young_modulus", member.young_modulus_pa),
            ("steel.yield_strength", member.yield_strength_pa),
            ("resistance.moment", self.moment()),
            ("resistance.axial", member.squash_load_n),
            ("rate.max_factor", member.max_rate_factor),
            ("top.spring_stiffness", 0.0),
            ("top.load", 0.0),
            ("impact.mass", test.mass_kg),
            ("impact.velocity", test.velocity_m_s),
            (
                "impact.transverse_force",
                if has_weight {
                    test.mass_kg * GRAVITY
                } else {
                    0.0
                },
            ),
        ];
        let words = [
            "support.base:=pinned",
            "support.top:=pinned",
            "rate.law:=logarithmic",
        ];
        let numbers = numbers.map(|(name, value)| format!("{name}:={value:?}"));
        let overrides: Vec<_> = numbers
            .iter()
            .map(String::as_str)
            .chain(words)
            .map(parse_override)
            .collect();
        let parameters = Parameters::load(&[], &overrides).expect("a member");
        let duration = parameters.response_duration();
        respond(
            &parameters.column_properties(),
            &parameters.impact(),
            duration,
        )
        .expect("a response")
    }
}

/// Largest deviation of one simulated peak from the measured one. The program's inputs alone (moment 5 %, stiffness a third,
/// speed 2 %) move a peak by some 10 %, and two of the light strikes of Saatci, on beams that differ in their stirrups only,
/// gave peaks that differ by 21 %.
const TOLERANCE_OF_ONE: f64 = 0.22;

/// Largest deviation of the mean over all falling weights.
const TOLERANCE_OF_MEAN: f64 = 0.10;

fn mean(ratios: &[f64]) -> f64 {
    ratios.iter().sum::<f64>() / ratios.len() as f64
}

/// Standard deviation of a sample.
fn deviation(ratios: &[f64]) -> f64 {
    let mean = mean(ratios);
    let square: f64 = ratios.iter().map(|it| (it - mean).powi(2)).sum();
    (square / (ratios.len() - 1) as f64).sqrt()
}

/// The chapters of the page. Assert what they state.
pub(super) fn chapters() -> String {
    let mut text = CHAPTER.to_owned();
    let mut ratios: Vec<(String, Vec<f64>)> = Vec::new();
    let mut all = Vec::new();
    let mut sources = String::new();
    for file in ["ando_2000.json", "saatci_2007.json"] {
        let series: Series = read(file);
        let mut of_series = Vec::new();
        for test in &series.tests {
            let [without, with] = [false, true].map(|weight| series.respond(test, weight));
            let ratio = with.max_v1 / test.peak_m;
            assert!(
                (ratio - 1.0).abs() <= TOLERANCE_OF_ONE,
                "{} {}: {ratio}",
                series.name,
                test.id
            );
            // The weight of the striker is a few per cent of the resistance.
            assert!(with.max_v1 >= without.max_v1 && with.ledger_residual < 1e-10);
            let residual = |report: &Report| match report.residual_v1 {
                Some(residual) => format!("{:.1}", 1e3 * residual),
                None => "none".to_owned(),
            };
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {:.1} / {:.1} | {:.1} / {} | {:.1} / {} | {ratio:.2} |",
                series.name,
                test.id,
                test.mass_kg,
                test.velocity_m_s,
                1e3 * test.peak_m,
                1e3 * test.residual_m,
                1e3 * without.max_v1,
                residual(&without),
                1e3 * with.max_v1,
                residual(&with),
            );
            of_series.push((test.mass_kg, ratio));
            all.push(ratio);
        }
        let _ = write!(
            sources,
            "\n**{}.** {}.\nProvenance: {}\nLeft out: {}.\nInputs: plastic moment {:.1} kN m from {}; {}; {}.\n\
             The measured displacements may be wrong by {} mm.\n",
            series.name,
            series.citation,
            series.provenance,
            series.left_out,
            1e-3 * series.moment(),
            series.member.static_source,
            series.member.second_moment_source,
            series.member.mass_source,
            1e3 * series.displacement_error_m,
        );
        let mut masses: Vec<f64> = of_series.iter().map(|(mass, _)| *mass).collect();
        masses.dedup();
        for mass in masses {
            let of_mass = of_series.iter().filter(|(other, _)| *other == mass);
            ratios.push((
                series.name.clone(),
                of_mass.map(|(_, ratio)| *ratio).collect(),
            ));
        }
    }
    let (total, spread) = (mean(&all), deviation(&all));
    assert!((total - 1.0).abs() <= TOLERANCE_OF_MEAN, "{total}");
    let _ = write!(
        text,
        "\nOver the {} falling weights the mean of simulated over measured peak is {total:.3}, with a standard deviation of {spread:.3}; \
         the largest is {:.2}, the smallest {:.2}.\n{READING}{sources}",
        all.len(),
        all.iter().copied().fold(0.0, f64::max),
        all.iter().copied().fold(f64::INFINITY, f64::min),
    );
    let (post_chapter, post_ratio) = collision_post();
    text += &post_chapter;
    let (slip_chapter, slips) = super::slip::chapter();
    text += &slip_chapter;
    text + &evidence(&ratios, post_ratio, slips) + WANTED
}

/// The ratio of the absorbed energies of one post, struck and pressed, beside the increase that the rate law alone gives to a
/// stand-in of about the same strength.
fn collision_post() -> (String, f64) {
    let post: CollisionPost = read("fra_2008.json");
    let measured = post.dynamic_absorbed_j / post.static_absorbed_j;
    let per_way = measured * post.static_deformation_m / post.dynamic_deformation_m;
    let force = |law: &str| {
        let overrides = [
            "section.name:=HEB220".to_owned(),
            "geometry.length_below:=0.76".to_owned(),
            "geometry.length_above:=1.24".to_owned(),
            "top.load:=0.0".to_owned(),
            "top.spring_stiffness:=0.0".to_owned(),
            // Of the stand-in only the bending counts.
            "shear.model:=none".to_owned(),
            "hardening.ratio:=0.0".to_owned(),
            "assessment.ultimate_rotation:=0".to_owned(),
            format!("rate.law:={law}"),
            format!("impact.mass:={:?}", post.mass_kg),
            format!("impact.velocity:={:?}", post.velocity_m_s),
        ];
        let overrides = overrides.map(|text| parse_override(&text));
        let parameters = Parameters::load(&[], &overrides).expect("a post");
        let column = parameters.column_properties();
        let duration = parameters.response_duration();
        let report = respond(&column, &parameters.impact(), duration).expect("a response");
        report.plastic_work / report.residual_v1.expect("an equilibrium")
    };
    let simulated = force("logarithmic") / force("none");
    assert!((1.0..measured * 1.1).contains(&simulated), "{simulated}");
    let text = format!(
        "{POST}\nMeasured: {:.0} kJ over {:.0} mm when struck, {:.0} kJ over {:.0} mm when pressed: {measured:.2} times the energy, \
         and {per_way:.2} times the energy per way.\nSimulated: the rate law raises the energy per way of the stand-in to {simulated:.2} times.\n\
         The rate law thus explains most of the difference of the energies, but not the difference of the energies per way; the abstracts do not state how comparable the two deformations are.\nSource: {}.\n",
        1e-3 * post.dynamic_absorbed_j,
        1e3 * post.dynamic_deformation_m,
        1e-3 * post.static_absorbed_j,
        1e3 * post.static_deformation_m,
        post.citation,
    );
    (text, simulated / measured)
}

/// One row of the list of the evidence.
struct Evidence<'a> {
    what: &'a str,
    area: &'a str,
    evidence: &'a str,
    confidence: &'a str,
    ratio: String,
    shows: &'a str,
    does_not: &'a str,
}

fn evidence(falling: &[(String, Vec<f64>)], post: f64, slips: [f64; 3]) -> String {
    let of = |index: usize| {
        let ratios = &falling[index].1;
        match ratios.len() {
            0..=2 => format!("{:.2} (mean of {})", mean(ratios), ratios.len()),
            count => format!("{:.2} ± {:.2} ({count})", mean(ratios), deviation(ratios)),
        }
    };
    let rows = [
        Evidence {
            what: "Ando 2000, 300 kg, 3 to 6 m/s",
            area: "peak and residual of a member that bends",
            evidence: "measured; typed second-hand",
            confidence: "medium: plots read to 2 mm, restraint of the ends not stated",
            ratio: of(0),
            shows: "impact impulse, a third of the mass, two bars with a hinge, rate law, energy balance",
            does_not: "steel, axial load, shear, built-in ends, a soft vehicle",
        },
        Evidence {
            what: "Saatci 2007, 211 kg, 8 m/s",
            area: "peak of a light strike that hardly yields",
            evidence: "measured; typed second-hand",
            confidence: "low: the two tests differ by 21 %",
            ratio: of(1),
            shows: "impact impulse of a striker lighter than the member, elastic stiffness",
            does_not: "anything beyond the first yield",
        },
        Evidence {
            what: "Saatci 2007, 600 kg, 8 m/s",
            area: "peak and residual of a heavy strike",
            evidence: "measured; typed second-hand",
            confidence: "medium: the three tests differ by 12 %",
            ratio: of(2),
            shows: "as Ando, with a deeper member and stirrups",
            does_not: "steel, axial load; the residual is overestimated by more than a third",
        },
        Evidence {
            what: "FRA 2008, collision post",
            area: "dynamic over static energy of a steel post",
            evidence: "measured; read in two abstracts",
            confidence: "low: the section is not known, the deformations differ",
            ratio: format!("{post:.2} (of the ratio of the energies)"),
            shows: "the rate law of steel has the right size",
            does_not: "displacements, forces, tearing",
        },
        Evidence {
            what: "Nakashima 1990, H columns pushed at 0.05 rad under up to 67 % of the squash load",
            area: "moment of a plastic hinge with hardening",
            evidence: "measured; derived from a database",
            confidence: "high for columns 100 mm deep; quasi-static",
            // `crates/mechanics/tests/column_tests.rs` holds the figures of these three rows.
            ratio: "0.89, from 0.80 to 1.05 (11)".to_owned(),
            shows: "interaction of moment and axial force, `hardening.ratio` of a named section",
            does_not: "strain rate, shear, deep sections",
        },
        Evidence {
            what: "Nakashima 1990, sway at which the column no longer carries its load",
            area: "loss of the axial load: collapse",
            evidence: "measured; derived from a database",
            confidence: "medium: the one test that is overestimated is 3 % on the unsafe side, 5 % at its last point, at which it still took 0.5 kN to push it",
            ratio: "0.77 to 1.03 (6, `n` at least 0.42, hardening), 0.72 and 0.73 (`n` = 0.21 and 0.22, softening)".to_owned(),
            shows: "second-order moments, hardening, softening of columns that buckle locally",
            does_not: "impact, shear, torsion",
        },
        Evidence {
            what: "Cravero 2019, wide-flange cantilevers at 30 and 50 % of the squash load",
            area: "rotation at which flanges and web buckle locally",
            evidence: "measured; derived from a database",
            confidence: "low for slender webs: W360x91 buckles at about half of the rotation of the formula, on the unsafe side",
            ratio: "0.70 to 1.25 (4), **1.28 and 1.91** (W360x91)".to_owned(),
            shows: "limits of rotation of stocky sections",
            does_not: "slender webs under high axial load; impact",
        },
        Evidence {
            what: "NHTSA 10146, car against a wall",
            area: "force of a car's front",
            evidence: "measured",
            confidence: "high for this car and a wide obstacle",
            ratio: "0.96 (peak force)".to_owned(),
            shows: "the front spring of `mid_car`, from which it was taken",
            does_not: "a narrow column, other cars, lorries, forklifts",
        },
        Evidence {
            what: "Cofone, Rich and Scott, two vehicles against poles",
            area: "force of a front behind a narrow object",
            evidence: "measured; read in an excerpt",
            confidence: "low: the masses are not stated, the vehicles are of other makes, one pole moved",
            ratio: format!(
                "{:.2} (mean of 2)",
                mean(&super::analytic::pole_ratios().map(|it| it[0]))
            ),
            shows: "`vehicle.narrow_object` has the right size",
            does_not: "the forces themselves, lorries, forklifts, a column that gives way",
        },
        Evidence {
            what: "fibre beam, rigid strikers",
            area: "the two bars against distributed mass and plasticity",
            evidence: "computed",
            confidence: "high for bending; same assumptions on the material",
            ratio: "1.00 ± 0.02 (9)".to_owned(),
            shows: "reduction to two bars and four hinges under axial load",
            does_not: "shear, connections, local buckling, fracture",
        },
        Evidence {
            what: "an engineer's fibre beam on the springs of a base plate",
            area: "slip of a base whose anchors give way",
            evidence: "computed; read in a review",
            confidence: "low: three slips, and the resistance of the springs is not stated",
            ratio: slips.map(|ratio| format!("{ratio:.2}")).join(", "),
            shows: "the slider of the foot in series with the column, its catenary and its load",
            does_not: "anchors, grout, holes of the plate, fracture",
        },
        Evidence {
            what: "second opinion, oblique hits in OpenSees",
            area: "the fibre beam in space against another program",
            evidence: "computed",
            confidence: "high for the code; same assumptions on sections and material",
            ratio: super::beam::oblique_ratio(),
            shows: "bending about both axes with twist, large rotations",
            does_not: "restrained warping, local buckling, fracture, a struck column",
        },
        Evidence {
            what: "reference responses, analytic solutions",
            area: "solution of the model's equations",
            evidence: "computed",
            confidence: "high",
            ratio: "1.00".to_owned(),
            shows: "the program solves the equations of the model",
            does_not: "whether the model is right",
        },
    ];
    let mut text = EVIDENCE.to_owned();
    for row in rows {
        let Evidence {
            what,
            area,
            evidence,
            confidence,
            ratio,
            shows,
            does_not,
        } = row;
        let _ = writeln!(
            text,
            "| {what} | {area} | {evidence} | {confidence} | {ratio} | {shows} | {does_not} |"
        );
    }
    text
}

const CHAPTER: &str = "
## Falling weights

Weights fell on the middle of horizontal beams of reinforced concrete that lie on two supports (`tests/data/experiments/`).
They are no steel columns and carry no axial load, but the same mechanics decides: impact impulse, a third of the member's mass, two bars with hinges, resistance at the rate of strain, energy.
Nothing is fitted to the impacts: the plastic moment comes from static strength, the rate of strain from the law of the CEB, `f_y + 6 MPa ln(rate / 5e-5)`, the stiffness from the cracked section.
The ends are pinned and slide, and the weight of the striker is `impact.transverse_force`.
The weight of the beam is left out, because it acts in the static tests as well.
The residual displacement is the displacement of the beam after the striker has been taken off; under the striker it would be larger by its weight over the elastic stiffness, at most 0.4 mm here.

| series | test | mass [kg] | speed [m/s] | measured peak / residual [mm] | simulated without the weight [mm] | simulated [mm] | peak, simulated / measured |
|---|---|---|---|---|---|---|---|
";

const READING: &str = "\
The simulated peaks of Ando's beams are too large by 9 to 15 %.
The uncertainty of the inputs moves a peak by that much: 5 % more moment lowers it by 4 %, a hardening of 0.3 % by 7 %, and the jig in which the ends turn restrains them by an unknown amount.
The residual displacements of the heavy strikes of Saatci are too large by more than a third: the model gives back only the part of the peak that the cracked section stores elastically.
";

const POST: &str = "
## A collision post

The post of a railway car was struck by 6350 kg at 8.36 m/s; an equal one was pressed slowly.
Its section is not known. The stand-in is HEB 220 in S355, 2 m high, built in at both ends and struck 0.76 m above the floor, which stops the mass after about the same way; its hinges may turn as far as they need.
";

const EVIDENCE: &str = "
## The evidence in one table

*Measured* is a test, *typed second-hand* a test whose numbers somebody else copied from the publication, *computed* another model.
The ratio is simulated over measured, or over the other model, with its standard deviation and the number of cases.

| comparison | area | evidence | confidence | simulated / measured | shows | does not show |
|---|---|---|---|---|---|---|
";

const WANTED: &str = "
## Data wanted

No published test covers the mechanisms that decide most strikes on steel columns. These measurements would; help is welcome.

| measurement | part of the model | why it matters |
|---|---|---|
| A steel column struck at 0.4 to 0.7 m, the height of cars: force, displacement above and below the bumper, shear strain of the web, angle that remains in the lower bar | shear of the web (`crates/mechanics/src/shear.rs`) | below about 1 m the web yields before the hinges form; no test of it is known |
| Anchor forces, uplift and rotation of a base plate under a lateral strike, with and without axial load | the hinge at the base, which the model builds in or makes an elastic spring | every column of a building stands on one |
| A column under 20 to 60 % of its squash load, struck: load, shortening, displacement over time | the yield surface, the load's work, collapse | all falling weights here have no axial load |
| The axial resistance of a column after a strike, pressed to failure | the residual capacity | people decide by it whether to evacuate |
| Force and crush of cars, lorries and forklifts against a rigid post of a column's width | the crush curves of the catalogue, `vehicle.narrow_object` | the catalogue halves the force of a wide wall, which is an assumption that two tests with poles support |
| Strikes about the weak axis and oblique ones, with the twist | the fibre beam of the second opinion (`crates/beam`), which has been compared with other models alone | the direction of a parking car is arbitrary |
| A bollard or cantilever: force, displacement of its top, angle that remains, rotation of the foundation | `support.top: free`, its mass | crash tests of bollards publish the penetration alone |
| Strain over time at the hinge of a struck steel member, and coupons of the same steel at those rates | the rate law, apart from hardening | both raise the moment, and the peak shows only their sum |
| Rotation at which flanges buckle and tear under impact | `assessment.ultimate_rotation`, the limits of rotation | the limits come from slow and cyclic tests |
| The originals of the two series above: force and displacement over time, restraint of Ando's ends; the section of the FRA post (RTDF2008-74020) | the numbers above | they were typed second-hand |
";
