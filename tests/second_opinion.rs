//! The fibre beam through the program: reference cases of OpenSees, where its verdict counts, and why there may be none.
#![cfg(feature = "cli")]

#[allow(dead_code)] // other tests interrupt it
mod program;

use std::path::Path;

use column_twin::assessment::{Assumption, OpenVerdict, Variation};
use column_twin::parameters::{Parameters, parse_override};
use column_twin::second_opinion::{
    BeamDamageBefore, EarlierHit, JointVerdict, ObliqueHit, beam_damage_after,
};
use column_twin::study::StudyColumn;
use program::run;
use serde_json::Value as Json;

/// `column-twin simulate --json` with these arguments.
fn simulated(arguments: &[String]) -> Json {
    let mut all = vec!["simulate", "--json"];
    all.extend(arguments.iter().map(String::as_str));
    let ended = run(Path::new(env!("CARGO_MANIFEST_DIR")), &all);
    let errors = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.success(), "{all:?}: {errors}");
    serde_json::from_slice(&ended.stdout).unwrap_or_else(|fault| panic!("{all:?}: {fault}"))
}

/// What `column-twin simulate` with these arguments prints for people, in one line.
fn summary(arguments: &[String]) -> String {
    let mut all = vec!["simulate"];
    all.extend(arguments.iter().map(String::as_str));
    let ended = run(Path::new(env!("CARGO_MANIFEST_DIR")), &all);
    assert!(ended.status.success(), "{all:?}");
    let text = String::from_utf8(ended.stdout).expect("text");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The arguments of a line, and of parameters as the references have them: without what OpenSees does not know.
fn arguments(line: &str) -> Vec<String> {
    line.split_whitespace().map(str::to_owned).collect()
}

fn number(value: &Json) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// A reference case of `crates/beam/tests/data/beam_reference.json`, by its name; a star stands for anything.
fn case(name: &str) -> Json {
    let text = include_str!("../crates/beam/tests/data/beam_reference.json");
    let all: Json = serde_json::from_str(text).expect("JSON");
    let cases = all["cases"].as_array().expect("a list");
    let (beginning, end) = name.split_once('*').unwrap_or((name, ""));
    let found = cases.iter().find(|case| {
        let whole = case["name"].as_str().unwrap_or_default();
        whole == name || name.contains('*') && whole.starts_with(beginning) && whole.ends_with(end)
    });
    found.unwrap_or_else(|| panic!("{name}")).clone()
}

/// The options that describe a reference case.
fn described(case: &Json, further: &[&str]) -> Vec<String> {
    let p = &case["parameters"];
    let float = |value: f64| format!("{value:?}");
    let mut options: Vec<(&str, String)> = vec![
        (
            "section.name",
            p["section"].as_str().expect("a name").into(),
        ),
        ("steel.grade", "S355".into()),
        ("hardening.ratio", float(number(&p["hardening_ratio"]))),
        (
            "geometry.length_below",
            float(number(&p["length_below_impact_m"])),
        ),
        (
            "geometry.length_above",
            float(number(&p["length_above_impact_m"])),
        ),
        (
            "top.spring_stiffness",
            float(number(&p["vertical_spring_top_N_m"])),
        ),
        ("top.load", float(number(&p["axial_load_N"]))),
        ("rate.law", "none".into()),
        ("beam.shear", "false".into()),
        ("beam.residual_stress", "false".into()),
        ("beam.bow", "0.0".into()),
    ];
    for (name, key) in [("support.base", "base"), ("support.top", "top")] {
        let is_pinned = p[key].as_str().expect("words").starts_with("pinned");
        options.push((name, if is_pinned { "pinned" } else { "built_in" }.into()));
    }
    let vehicle = &p["vehicle"];
    let mut all = Vec::new();
    match vehicle["stiffness_N_m"].as_f64() {
        Some(stiffness) => {
            let mass = number(&vehicle["mass_kg"]);
            let force = vehicle["crush_force_N"].as_f64();
            let curve = match force {
                None => ("[1.0]".to_owned(), format!("[{stiffness:?}]")),
                Some(force) => (
                    format!("[{:?}, 10.0]", force / stiffness),
                    format!("[{force:?}, {force:?}]"),
                ),
            };
            options.extend([
                ("vehicle.masses", format!("[{mass:?}]")),
                ("vehicle.spring_1.crush", curve.0),
                ("vehicle.spring_1.force", curve.1),
                ("vehicle.spring_1.unloading_stiffness", float(stiffness)),
                ("vehicle.narrow_object", "false".into()),
            ]);
        }
        None => options.push(("vehicle.name", "rigid".into())),
    }
    // An undamaged column is hardly touched.
    let (mass, velocity) = match vehicle.is_null() {
        true => (1.0, 1e-3),
        false => (number(&vehicle["mass_kg"]), number(&vehicle["speed_m_s"])),
    };
    let degrees = p["angle_from_strong_axis_bending_deg"].as_f64();
    all.extend(["--mass".to_owned(), float(mass)]);
    all.extend(["--velocity".to_owned(), float(velocity)]);
    all.extend(["--direction".to_owned(), float(degrees.unwrap_or(0.0))]);
    let options = options
        .into_iter()
        .map(|(name, value)| format!("{name}:={value}"));
    for option in options.chain(further.iter().map(|it| (*it).to_owned())) {
        all.extend(["-p".to_owned(), option]);
    }
    all
}

/// Compares fields of `beam` with the reference, and says which differ by more than their tolerance.
fn compared(
    name: &str,
    further: &[&str],
    reference: &str,
    fields: &[(&str, &str, f64)],
) -> Vec<String> {
    let case = case(name);
    let found = simulated(&described(&case, further));
    let beam = &found["beam"];
    let mut wrong = Vec::new();
    for (field, key, tolerance) in fields {
        let ratio = number(&beam[field]) / number(&case[reference][key]);
        println!("{name} {further:?} {field}: {ratio:.4} of {reference}");
        // A NaN is wrong, too.
        if ratio.is_nan() || (ratio - 1.0).abs() > *tolerance {
            wrong.push(format!("{name} {further:?} {field}: {ratio}; beam {beam}"));
        }
    }
    wrong
}

/// The tolerances are those of the issue of the references: 1 % in the plane, 3 % in space and of capacities, or what the case states.
#[test]
fn the_program_reproduces_cases_of_opensees() {
    let mut wrong = Vec::new();
    let in_plane = [
        ("max_displacement_m", "max_displacement_m", 0.01),
        ("residual_displacement_m", "residual_m", 0.015),
        ("max_displacement_time_s", "time_of_max_s", 0.03),
    ];
    wrong.extend(compared("plane10 b0.0001", &[], "reference", &in_plane));
    // The column swings to two peaks that are equal within 0.2 %, of which the reference has the later one: no time is compared.
    wrong.extend(compared("plane06 b0.01", &[], "reference", &in_plane[..2]));
    let in_space = [
        ("max_displacement_m", "max_displacement_along_hit_m", 0.03),
        ("max_sideways_m", "max_displacement_across_hit_m", 0.03),
        ("residual_displacement_m", "residual_along_hit_m", 0.03),
        ("residual_sideways_m", "residual_across_hit_m", 0.03),
    ];
    let oblique = "space HEB220 phi10 v10 b1e-4";
    let held = ["beam.torsion:=none"];
    wrong.extend(compared(
        oblique,
        &held,
        "reference_twist_suppressed",
        &in_space,
    ));
    let free = ["beam.torsion:=saint_venant"];
    wrong.extend(compared(oblique, &free, "reference", &in_space[..1]));
    let bowed = |axes: &str| {
        [
            format!("beam.bow_axes:={axes}"),
            "beam.bow:=-1.0".to_owned(),
        ]
    };
    let capacity = [("undamaged_capacity_n", "N_u_N", 0.03)];
    for (name, axes) in [
        ("capacity HEB220 4 m * bow y rs 0", "strong"),
        ("capacity HEB220 4 m * bow yz rs 0", "both"),
    ] {
        let bowed = bowed(axes);
        let further = bowed.each_ref().map(String::as_str);
        wrong.extend(compared(name, &further, "reference", &capacity));
    }
    let damaged = [
        ("residual_capacity_n", "N_u_N", 0.03),
        ("max_displacement_m", "max_displacement_along_hit_m", 0.01),
    ];
    wrong.extend(compared(
        "capacity HEB220 damaged phi0 v10 La1 Lb3 built in",
        &["beam.bow_axes:=strong"],
        "reference",
        &damaged,
    ));
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The names are an interface: exactly these.
#[test]
fn the_beam_has_exactly_the_fields_of_the_interface() {
    let found = simulated(&arguments("--mass 1500 --velocity 2 --direction 20"));
    let fields = found["beam"].as_object().expect("an object");
    let mut names: Vec<_> = fields.keys().map(String::as_str).collect();
    names.sort_unstable();
    let mut expected = [
        "max_displacement_m",
        "max_sideways_m",
        "residual_displacement_m",
        "residual_sideways_m",
        "residual_bow_m",
        "residual_bow_height_m",
        "max_displacement_time_s",
        "outcome",
        "undamaged_capacity_n",
        "residual_capacity_n",
        "base_shear_n",
        "base_moment_n_m",
        "error_estimate",
        "elements",
        "solve_time_s",
        "ratio_to_two_bars",
    ];
    expected.sort_unstable();
    assert_eq!(names, expected);
}

/// A hit at the weak axis: the plane model does not move and has nothing against the column, which lies 0.2 m beside its place.
#[test]
fn a_hit_that_the_two_bars_do_not_see_is_judged_by_the_beam() {
    let hit = |further: &str| {
        let base = "--mass 1500 --velocity 10 -p vehicle.name:=rigid -p geometry.length_below:=1.0 -p geometry.length_above:=3.0";
        simulated(&arguments(&format!("{base} {further}")))
    };
    let alone = hit("--direction 90 -p beam.mode:=off");
    // What nobody has seen is not called undamaged.
    let reason = alone["reason"].as_str().expect("a reason");
    assert!(reason.starts_with("At least NONE: "), "{reason}");
    assert_eq!(alone["not_evaluated"][0]["criterion"], "out_of_plane");
    let range = &alone["range"];
    assert_eq!(
        (&range["least"], &range["most"]),
        (&"none".into(), &"evacuate".into())
    );
    assert_eq!(range["not_evaluated"], serde_json::json!(["out_of_plane"]));
    assert_eq!(
        alone["beam"],
        "no second opinion: it is switched off (beam.mode: off)"
    );
    let both = hit("--direction 90");
    let reason = both["reason"].as_str().expect("a reason");
    assert!(reason.contains(" Cause, by the fibre beam: "), "{reason}");
    assert!(
        reason.contains("the vehicle travels at 90 degrees"),
        "{reason}"
    );
    assert!(["shore", "evacuate"].contains(&both["action"].as_str().expect("a word")));
    assert!(number(&both["beam"]["max_displacement_m"]) > 0.1);
    assert!(both["beam"]["ratio_to_two_bars"].is_null());
    // The criterion that decides is in the list, with its action and the model's name.
    let criteria = both["criteria"].as_array().expect("a list");
    let deciding = criteria
        .iter()
        .find(|it| it["name"] == both["deciding_criterion"])
        .expect("it is listed");
    assert_eq!(
        (&deciding["action"], &deciding["exceeded"]),
        (&both["action"], &true.into())
    );
    assert!(
        deciding["statement"]
            .as_str()
            .expect("words")
            .starts_with("By the fibre beam: ")
    );
    // Both models judge each variation: a slower hit is no worse, a faster one no milder, and neither is what the two bars see.
    let range = &both["range"];
    let variations = range["variations"].as_array().expect("a list");
    let [slower, faster] = ["9.00 m/s", "11.00 m/s"].map(|speed| {
        let mut all = variations.iter();
        all.find(|it| it["instead"] == speed).expect("a variation")
    });
    let peaks = [slower, &both["beam"], faster].map(|it| {
        let peak = it.get("max_v1_m").or_else(|| it.get("max_displacement_m"));
        number(peak.expect("a peak"))
    });
    assert!(peaks.is_sorted() && peaks[0] > 0.1, "{peaks:?}");
    assert_ne!(range["decided_by"], serde_json::json!(["direction"]));
    assert_eq!(range["not_evaluated"], serde_json::json!([]));
    assert_eq!(alone["range"]["variations"], serde_json::json!([]));
    assert_eq!(alone["range"]["decided_by"], serde_json::json!([]));
    // The speed of the vehicle, and what the two bars take of it.
    for of_one in [&alone, &both] {
        assert_eq!(of_one["velocity_m_s"], 10.0);
        assert_eq!(of_one["direction_rad"], std::f64::consts::FRAC_PI_2);
        // No impact has no speed at all.
        assert!(number(&of_one["velocity_in_plane_m_s"]).abs() < 1e-5);
    }
    assert_eq!(both["not_evaluated"], serde_json::json!([]));
    // What the two bars have computed is the same.
    for name in [
        "max_v1_m",
        "residual_v1_m",
        "steps",
        "impulse_n_s",
        "residual_capacity_n",
    ] {
        assert_eq!(both[name], alone[name], "{name}");
    }
}

/// A long column that is hit near its base: its inertia makes the long upper bar yield in its middle, which two rigid bars cannot
/// show. Where the beam keeps a larger bow and less capacity, its verdict counts.
#[test]
fn a_bow_that_two_straight_bars_cannot_have_is_judged_by_the_beam() {
    const HIT: &str = "--mass 1500 --velocity 2.5 -p vehicle.name:=rigid -p section.name:=IPE300 -p steel.grade:=S235 \
                       -p geometry.length_below:=0.75 -p geometry.length_above:=7.25 -p support.base:=pinned -p support.top:=pinned \
                       -p top.load:=5e4";
    let found = simulated(&arguments(HIT));
    let beam = &found["beam"];
    assert!((3.0..6.0).contains(&number(&beam["residual_bow_height_m"])));
    assert!(number(&beam["residual_bow_m"]) > 1.25 * number(&found["residual_v1_m"]));
    let text = summary(&arguments(HIT));
    assert!(
        text.contains("the beam keeps a bow of 21.4 mm at a height of 3.72 m"),
        "{text}"
    );
}

/// The two bars take the component in their plane, and say so.
#[test]
fn the_two_bars_take_the_component_and_say_so() {
    let oblique = simulated(&arguments(
        "--mass 1500 --velocity 10 --direction 60 -p beam.mode:=off",
    ));
    let straight = simulated(&arguments("--mass 1500 --velocity 5 -p beam.mode:=off"));
    let [found, expected] = [&oblique, &straight].map(|it| number(&it["max_v1_m"]));
    assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    let reason = oblique["reason"].as_str().expect("a reason");
    assert!(
        reason.contains("60 degrees to the plane of the two bars, which see the component in it, 0.5 of the whole"),
        "{reason}"
    );
    assert!(
        !straight["reason"]
            .as_str()
            .expect("a reason")
            .contains("degrees")
    );
}

/// Whatever the reason: the answer is in words, and everything else is that of the two bars alone.
#[test]
fn without_a_second_opinion_nothing_else_changes() {
    let plain = |line: &str| {
        let mut found = simulated(&arguments(line));
        let fields = found.as_object_mut().expect("an object");
        fields.remove("solve_time_s");
        // As it was given.
        fields.remove("direction_rad");
        let beam = fields.remove("beam").expect("an answer");
        (found, beam)
    };
    let car = "--mass 1500 --velocity 5";
    let numbers = "--config config/heb220_paper.yaml --mass 1500 --velocity 10";
    for (line, further, reason) in [
        (car, "--direction 200", "expected a number in (-pi, pi]"),
        (car, "--direction -180", "expected a number in (-pi, pi]"),
        (car, "-p beam.bow:=5.0", "at most a twentieth of the length"),
        (numbers, "", "the plates of the section are not known"),
    ] {
        let (found, beam) = plain(&format!("{line} {further}"));
        let words = beam.as_str().unwrap_or_else(|| panic!("{further}: {beam}"));
        assert!(words.starts_with("no second opinion: "), "{words}");
        assert!(words.contains(reason), "{words}");
        let (alone, _) = plain(&format!("{line} -p beam.mode:=off"));
        assert_eq!(found, alone, "{line} {further}");
    }
}

/// The beam consists of the plates of the section: it once answered as if the two bars had no other resistance than they.
#[test]
fn a_resistance_that_the_plates_do_not_have_leaves_no_second_opinion() {
    let beam = |further: &str| {
        let line = format!("--vehicle rigid --mass 1500 --velocity 6 --height 1 {further}");
        simulated(&arguments(&line))["beam"].clone()
    };
    for (name, number) in [
        ("resistance.moment", "1e5"),
        ("resistance.axial", "2e6"),
        ("resistance.shear", "2e5"),
        ("section.height", "0.3"),
        ("section.web_thickness", "0.02"),
    ] {
        let found = beam(&format!("-p {name}:={number}"));
        let words = found.as_str().unwrap_or_else(|| panic!("{name}: {found}"));
        let expected = format!("no second opinion: {name} is ");
        assert!(words.starts_with(&expected), "{words}");
    }
    // What the plates give, rounded.
    let peak = |further: &str| number(&beam(further)["max_displacement_m"]);
    let rounded = "-p resistance.moment:=2.94e5 -p resistance.axial:=3.23e6 -p resistance.shear:=4e5 -p section.height:=0.22";
    assert_eq!(peak(rounded), peak(""));
    // By numbers, without the fillets.
    let by_numbers = "-p section.name:=\"\" -p section.area:=91.04e-4 -p section.second_moment:=8091e-8 -p section.mass_per_length:=71.5 \
                      -p section.height:=0.22 -p section.width:=0.22 -p section.web_thickness:=0.0095 -p section.flange_thickness:=0.016";
    let found = beam(&format!("{by_numbers} -p resistance.moment:=2.936e5"));
    assert!(found.is_object(), "{found}");
    let found = beam(&format!("{by_numbers} -p resistance.moment:=2e5"));
    let words = found.as_str().unwrap_or_else(|| panic!("{found}"));
    assert!(words.contains("at most 10 %"), "{words}");
}

/// A hollow section by numbers, with walls that do not fit, and a steel with a plateau.
#[test]
fn hollow_sections_and_a_steel_with_a_plateau_have_a_second_opinion() {
    let beam = |further: &str| {
        let line = format!("--vehicle rigid --mass 1500 --velocity 6 --height 1 {further}");
        simulated(&arguments(&line))["beam"].clone()
    };
    // 200 x 200 x 10 and 219.1 x 10 of EN 10210-2.
    let square = "-p section.name:=\"\" -p section.shape:=rectangular_hollow -p section.area:=74.9e-4 -p section.second_moment:=4471e-8 \
                  -p section.mass_per_length:=58.8 -p section.height:=0.2 -p section.width:=0.2 -p section.web_thickness:=0.01 \
                  -p resistance.moment:=1.885e5";
    let tube = "-p section.name:=\"\" -p section.shape:=circular_hollow -p section.area:=65.7e-4 -p section.second_moment:=3598e-8 \
                -p section.mass_per_length:=51.6 -p section.height:=0.2191 -p section.web_thickness:=0.01 -p resistance.moment:=1.555e5";
    for section in [square, tube] {
        let found = beam(section);
        assert!(found.is_object(), "{found}");
        assert!(number(&found["max_displacement_m"]) > 0.01, "{found}");
        let found = beam(&format!("{section} -p section.flange_thickness:=0.02"));
        let words = found.as_str().unwrap_or_else(|| panic!("{found}"));
        assert!(words.contains("walls of one thickness"), "{words}");
    }
    // On its plateau the column moves further than with the default hardening of a named section.
    let peak = |further: &str| number(&beam(further)["max_displacement_m"]);
    assert!(peak("-p beam.steel:=plateau") > peak(""));
    let found = beam(
        "-p beam.steel:=plateau -p steel.grade:=\"\" -p steel.young_modulus:=210e9 -p steel.yield_strength:=355e6",
    );
    let words = found.as_str().unwrap_or_else(|| panic!("{found}"));
    assert!(words.contains("tensile strength"), "{words}");
}

/// `shear.model` is the paper's assumption about the two bars; the beam has `beam.shear`, and shows what the assumption leaves out.
#[test]
fn two_bars_that_do_not_shear_are_compared_with_a_beam_that_does() {
    let hit = |further: &str| {
        let line = format!("--vehicle rigid --mass 1500 --velocity 6 --height 1 {further}");
        simulated(&arguments(&line))
    };
    let (with, without) = (hit(""), hit("-p shear.model:=none"));
    for name in ["max_displacement_m", "residual_displacement_m"] {
        assert_eq!(with["beam"][name], without["beam"][name], "{name}");
    }
    assert!(number(&without["max_v1_m"]) < 0.8 * number(&with["max_v1_m"]));
    assert!(number(&without["beam"]["ratio_to_two_bars"]) > 1.25);
}

/// One or two sentences in the summary for people.
#[test]
fn the_summary_says_what_the_beam_says() {
    let text = |further: &str| summary(&arguments(&format!("--mass 1500 --velocity 10 {further}")));
    let oblique = text("--direction 10");
    assert!(
        oblique.contains("Beam the fibre beam has a peak of "),
        "{oblique}"
    );
    assert!(oblique.contains(" across it"), "{oblique}");
    assert!(oblique.contains(" times that of the two bars"), "{oblique}");
    assert!(
        oblique.contains("see the component in it, 0.9848 of the whole"),
        "{oblique}"
    );
    let none = text("--direction 181");
    assert!(none.contains("Beam no second opinion: "), "{none}");
}

/// A cell of a map by both models, or by the beam, is the simulation of its hit, bit for bit, whatever the number of threads and parts;
/// and the two bars of a map with directions are those of a map without.
#[test]
fn a_cell_of_a_map_is_the_simulation_of_its_hit() {
    let folder = tempfile::tempdir().expect("a folder");
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/config/heb220_s355.yaml");
    let map = |further: &[&str]| -> Json {
        let mut all = vec!["map", "--config", config, "--vehicle", "mid_car"];
        all.extend(["--direction", "0:20:2", "--velocity", "4:9:2", "--json"]);
        all.extend(further);
        let ended = run(folder.path(), &all);
        let errors = String::from_utf8_lossy(&ended.stderr);
        assert!(ended.status.success(), "{all:?}: {errors}");
        serde_json::from_slice(&ended.stdout).expect("JSON")
    };
    let (both, beam) = (
        map(&["--model", "both"]),
        map(&["--model", "beam", "--threads", "1"]),
    );
    assert_eq!(
        [&both["model"], &beam["model"], &map(&[])["model"]],
        ["both", "beam", "bars"]
    );
    let cells = |map: &Json| map["cells"].as_array().expect("cells").clone();
    let parts = ["1/2", "2/2"].map(|part| cells(&map(&["--model", "both", "--shard", part])));
    assert_eq!(parts.concat(), cells(&both));
    let mut deciding = 0;
    for (of_both, of_beam) in cells(&both).iter().zip(cells(&beam)) {
        let [degrees, speed] = ["direction_degrees", "velocity_m_s"].map(|it| number(&of_both[it]));
        let hit = format!(
            "--config {config} --vehicle mid_car --direction {degrees:?} --velocity {speed:?}"
        );
        let found = simulated(&arguments(&hit));
        for name in ["action", "deciding_criterion", "outcome", "max_v1_m"] {
            assert_eq!(of_both[name], found[name], "{hit}: {name}");
        }
        assert_eq!(
            of_both["residual_capacity_n"], found["residual_capacity_n"],
            "{hit}"
        );
        for (column, field) in [
            ("beam_outcome", "outcome"),
            ("beam_max_displacement_m", "max_displacement_m"),
            ("beam_max_sideways_m", "max_sideways_m"),
            ("beam_residual_displacement_m", "residual_displacement_m"),
            ("beam_residual_sideways_m", "residual_sideways_m"),
            ("beam_undamaged_capacity_n", "undamaged_capacity_n"),
            ("beam_residual_capacity_n", "residual_capacity_n"),
            ("beam_base_shear_n", "base_shear_n"),
            ("ratio_to_two_bars", "ratio_to_two_bars"),
        ] {
            for cell in [of_both, &of_beam] {
                assert_eq!(cell[column], found["beam"][field], "{hit}: {column}");
            }
        }
        assert_eq!(of_beam["action"], of_both["beam_action"], "{hit}");
        assert_eq!(of_beam["outcome"], found["beam"]["outcome"], "{hit}");
        let [along, across] =
            ["max_displacement_m", "max_sideways_m"].map(|it| number(&found["beam"][it]));
        let peak = number(&of_beam["max_v1_m"]);
        assert!((peak - along.hypot(across)).abs() < 1e-12, "{hit}: {peak}");
        deciding += of_both["beam_decides"].as_u64().expect("0 or 1");
    }
    let summary = &both["summary"]["second_opinions"];
    assert_eq!(summary["known"], 4);
    assert_eq!(summary["decides"], deciding);
    assert!(deciding > 0, "an oblique hit at 9 m/s: {both}");
}

/// What a map cannot be judged by says why, and a beam that says nothing leaves the verdict to the two bars.
#[test]
fn a_map_without_a_second_opinion_says_why() {
    let folder = tempfile::tempdir().expect("a folder");
    let numbers = concat!(env!("CARGO_MANIFEST_DIR"), "/config/heb220_paper.yaml");
    let map = |further: &[&str]| {
        let mut all = vec!["map", "--direction", "0:90:2", "--velocity", "2:3:2"];
        all.extend(["--mass", "1000"]);
        all.extend(further);
        run(folder.path(), &all)
    };
    for (further, code, expected) in [
        (
            &["--model", "both", "-p", "beam.mode:=off"][..],
            2,
            "the model both needs the fibre beam, which beam.mode: off switches off",
        ),
        (
            &["--model", "beam", "--bands"],
            2,
            "--bands belongs to the two bars",
        ),
        (
            &["--model", "beam", "--config", numbers],
            3,
            "no second opinion",
        ),
    ] {
        let ended = map(further);
        let errors = String::from_utf8_lossy(&ended.stderr);
        let errors = errors.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(ended.status.code(), Some(code), "{further:?}: {errors}");
        assert!(errors.contains(expected), "{further:?}: {errors}");
    }
    let ended = map(&["--model", "both", "--config", numbers]);
    let text = String::from_utf8_lossy(&ended.stdout);
    assert!(ended.status.success(), "{text}");
    let alone = "4 impacts have the verdict of the two bars alone; the first one, ";
    assert!(
        text.contains(alone) && text.contains("no second opinion"),
        "{text}"
    );
    // A direction ends at 180 degrees.
    let ended = run(
        folder.path(),
        &["map", "--direction", "0:181:2", "--velocity", "2:3:2"],
    );
    assert_eq!(ended.status.code(), Some(2));
    let errors = String::from_utf8_lossy(&ended.stderr);
    let errors = errors.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        errors.contains("181 degrees is not a direction"),
        "{errors}"
    );
}

/// The beam sees all of an oblique hit: where it finds nothing more severe than the two bars, their verdict is no lower bound.
#[test]
fn an_oblique_hit_that_the_beam_finds_no_worse_is_no_lower_bound() {
    const HIT: &str = "--mass 1500 --velocity 0.4 --direction 10 -p vehicle.name:=rigid -p section.name:=HEB300 -p steel.grade:=S355 \
                       -p top.load:=5e5 -p support.base:=built_in -p support.top:=built_in";
    let by_bars = simulated(&arguments(&format!("{HIT} -p beam.mode:=off")));
    let by_both = simulated(&arguments(HIT));
    let reasons =
        [&by_bars, &by_both].map(|it| it["reason"].as_str().expect("a reason").to_owned());
    assert!(reasons[0].starts_with("At least "), "{}", reasons[0]);
    assert_eq!(by_bars["action"], by_both["action"], "{reasons:?}");
    assert_eq!(by_both["at_least"], false);
    assert!(!reasons[1].contains("degrees"), "{}", reasons[1]);
}

/// Nothing was varied of a hit out of the plane on a column with damage.
#[test]
fn an_oblique_hit_on_a_damaged_column_has_a_range_by_both_models() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/heb220_s355.yaml");
    let overrides = [
        "vehicle.name:=rigid",
        "impact.mass:=1500.0",
        "impact.velocity:=6.0",
        "geometry.length_below:=1.0",
        "geometry.length_above:=3.0",
        "beam.elements:=12",
    ];
    let first = Parameters::load(&[file], &overrides.map(parse_override)).expect("parameters");
    let second = first
        .with_changes([
            ("impact.velocity", 4.0.into()),
            ("impact.direction", 0.5.into()),
        ])
        .expect("parameters");
    let undamaged = StudyColumn::undamaged(&second).expect("a column");
    let damaged = undamaged.after(&first.impact()).expect("a response");
    let impact = second.impact();
    let followed = damaged.expect("it stands").follow(&impact, |_, _| ());
    let earlier = followed.expect("a response").0.earlier.expect("a damage");
    assert!(earlier.have_damaged());
    let struck = second.column_properties();
    let hit = EarlierHit {
        lengths: [struck.length_below, struck.length_above],
        impact: first.whole_impact(),
        direction: 0.0,
    };
    let damage = beam_damage_after(&second, &[hit]).expect("a damage");
    let before = BeamDamageBefore::from(damage.expect("it has yielded"));
    let (whole, direction) = (second.whole_impact(), second.direction());
    let joint = JointVerdict::after(
        &second,
        &impact,
        whole,
        direction,
        (Some(&earlier), Some(before.clone())),
    )
    .expect("a verdict");
    let oblique = ObliqueHit {
        parameters: &second,
        struck: &struck,
        in_plane: impact,
        whole,
        direction,
        earlier: Some(&earlier),
        beam_before: Some(&before),
    };
    let verdict = OpenVerdict::from(&joint.assessment);
    let range = oblique.range(&verdict, &mut || true).expect("a range");
    // The speed, since the mass is rigid; another height would have led to another damage.
    let [slower, faster] = range.variations.as_slice() else {
        panic!("{range:?}");
    };
    assert_eq!(
        [slower, faster].map(|it| it.assumption),
        [Assumption::Speed; 2]
    );
    let opinion = joint.second_opinion.as_ref().expect("an opinion");
    let [[peak, _], _] = opinion.from_undamaged();
    let is_of_the_beam = |it: &Variation| it.report.max_v1 > 0.5 * peak;
    assert!(is_of_the_beam(slower) && is_of_the_beam(faster));
    assert!(slower.action <= faster.action);
    assert!(range.ends.least <= verdict.action && verdict.action <= range.ends.most);
    for of_damage in [Assumption::Height, Assumption::Hardening] {
        assert!(range.not_varied.iter().any(|(it, _)| *it == of_damage));
    }
    // Without the damage the same hit leaves less.
    let new = JointVerdict::on(&second, &impact, whole, direction).expect("a verdict");
    let bow = |it: &JointVerdict| it.input.largest_bow().unwrap_or(f64::INFINITY);
    assert!(bow(&new) < bow(&joint));
    assert!(new.assessment.action <= joint.assessment.action);
}

/// The two bars see less of a hit the more oblique it is, and the map of them alone becomes milder.
#[test]
fn a_map_of_directions_by_the_two_bars_says_that_it_has_lower_bounds() {
    let map = |further: &[&str]| {
        let mut all = vec![
            "map",
            "--vehicle",
            "lorry_8t",
            "--direction",
            "0:90:2",
            "--velocity",
            "2:4:2",
        ];
        all.extend(further);
        let ended = run(Path::new(env!("CARGO_MANIFEST_DIR")), &all);
        assert!(ended.status.success());
        String::from_utf8(ended.stdout).expect("text")
    };
    const SAID: &str = "; lower bounds by the two bars alone (see --model)";
    assert!(map(&["--config", "config/heb220_s355.yaml"]).contains(SAID));
    assert!(!map(&["--config", "config/heb220_s355.yaml", "--model", "both"]).contains(SAID));
}
