//! Parameters as a user sees them: the shipped files, wrong files, overrides, round trips.

use std::path::{Path, PathBuf};

use column_twin::column::{ElasticLaw, RateLaw, Scheme, Support, YieldExponents};
use column_twin::parameters::{
    Admissible, Applies, NodeName, Origin, PARAMETERS, Parameter, ParameterFaults, Parameters,
    Problem, SENSOR_PARAMETERS, STEEL_GRADES, SensorAxis, SensorMessage, SensorSource, Settings,
    Source, Value, catalogue, markdown, parse_override, python_keywords, vehicle_names,
};
use column_twin::sensors::{Quantity, Sensor};
use printable::is_printable;
use proptest::prelude::*;

fn in_repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn written(folder: &tempfile::TempDir, name: &str, text: &str) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("a temporary file can be written");
    path
}

#[test]
fn the_paper_as_printed() {
    let parameters = Parameters::load(&[in_repository("config/heb220_paper.yaml")], &[])
        .expect("the shipped file");
    let column = parameters.column_properties();
    assert_eq!((column.length_below, column.length_above), (1.0, 3.0));
    assert!((column.axial_rigidity - 210e9 * 91e-4).abs() < 1.0);
    assert!((column.bending_stiffness - 210e9 * 8091e-8).abs() < 1e-3);
    assert_eq!(column.mass_per_length, 70.1);
    assert_eq!(
        (column.resistance_moment, column.resistance_axial),
        (0.307e6, 3.23e6)
    );
    assert_eq!(
        column.yield_surface,
        YieldExponents {
            alpha: 2.0,
            beta: 2.0,
            gamma: 2.0
        }
    );
    assert_eq!(column.elastic_law, ElasticLaw::Uncoupled);
    assert_eq!(
        (column.base, column.top),
        (Support::BuiltIn, Support::BuiltIn)
    );
    assert_eq!(column.hinge_stiffness, [None; 4]);
    assert_eq!(
        (
            column.top_spring_stiffness,
            column.top_mass,
            column.top_load
        ),
        (1e7, 0.0, 0.5e6)
    );
    assert_eq!(
        (column.damping_ratio, column.scheme, column.step_nanos),
        (0.0, Scheme::ConservingMidpoint, 20_000)
    );
    let impact = parameters.impact();
    assert_eq!(
        (impact.mass, impact.velocity, impact.gap, impact.restitution),
        (1500.0, 10.0, 0.0, 0.0)
    );
    assert_eq!(
        (
            parameters.section().name,
            parameters.section().plastic_modulus
        ),
        (None, None)
    );
}

#[test]
fn the_same_column_computed_is_the_default() {
    let parameters = Parameters::load(&[in_repository("config/heb220_s355.yaml")], &[])
        .expect("the shipped file");
    // With the rigid mass it is the default.
    let idealised = [
        ("vehicle.name", Value::from("rigid")),
        ("impact.mass", 1500.0.into()),
    ];
    let idealised = parameters.with_changes(idealised).expect("right");
    assert_eq!(
        idealised.column_properties(),
        Parameters::default().column_properties()
    );
    assert_eq!(idealised.impact(), Parameters::default().impact());
    let with_rate = parameters.with_changes([("rate.law", "logarithmic".into())]);
    let rate = with_rate.expect("right").column_properties().rate;
    let rate = rate.expect("on");
    let RateLaw::Logarithmic { c, reference } = rate.law else {
        panic!("{rate:?}")
    };
    assert!((c * 355e6 - 6e6).abs() < 1e-3);
    assert_eq!((reference, rate.time_constant), (5e-5, 1e-3));
    assert_eq!(
        (rate.max_factor, rate.section_height, rate.hinge_length),
        (1.25, 0.22, 0.22)
    );
    let car = parameters.impact();
    assert_eq!((car.mass, car.velocity), (1719.0, 10.0));
    assert_eq!(
        car.vehicle,
        parameters.vehicle_named("mid_car").expect("known")
    );
    assert!(parameters.settings().vehicle.narrow_object);
    let (section, steel) = (parameters.section(), parameters.steel());
    assert_eq!((section.name, steel.grade), (Some("HEB220"), Some("S355")));
    assert_eq!(format!("{:.2}", section.area * 1e4), "91.04");
    assert_eq!(format!("{:.0}", section.second_moment * 1e8), "8091");
    assert_eq!(
        format!("{:.1}", section.plastic_modulus.expect("named") * 1e6),
        "827.0"
    );
    assert_eq!(format!("{:.1}", section.mass_per_length), "71.5");
    let column = parameters.column_properties();
    assert_eq!(format!("{:.4}", column.resistance_moment / 1e6), "0.2936");
    assert_eq!(format!("{:.3}", column.resistance_axial / 1e6), "3.232");
    assert_eq!(
        column.yield_surface,
        YieldExponents {
            alpha: 1.0,
            beta: 1.3,
            gamma: 1.0
        }
    );
    assert_eq!(column.elastic_law, ElasticLaw::Coupled);
}

/// What is generated from the table is up to date; `UPDATE_DOCS=1 cargo test --test parameters` updates it.
#[test]
fn the_reference_and_the_keywords_of_python_are_up_to_date() {
    for (path, generated) in [
        ("docs/parameters.md", markdown()),
        (
            "crates/python/python/column_twin/_keywords.py",
            python_keywords(),
        ),
    ] {
        let place = in_repository(path);
        if std::env::var_os("UPDATE_DOCS").is_some() {
            std::fs::write(&place, &generated).expect("the file can be written");
        }
        let kept = std::fs::read_to_string(&place).unwrap_or_default();
        assert!(
            kept == generated,
            "{path} differs from the table of parameters; update it with\n    UPDATE_DOCS=1 cargo test --test parameters"
        );
    }
}

/// A lorry of 8 kg was simulated without a word.
#[test]
fn a_mass_in_tonnes_is_a_warning() {
    let warnings = |mass: &str| {
        let given = ["vehicle.name:=lorry_8t", &format!("impact.mass:={mass}")];
        let sources = given.map(|text| Source::Override(parse_override(text)));
        let (_, warnings) =
            Parameters::load_in_order(&NodeName::default(), sources).expect("accepted");
        warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let found = warnings("8.0");
    assert_eq!(found.len(), 1);
    let expected = "-p impact.mass:=8.0: impact.mass is the mass of a lorry_8t of 8 kg: its own mass is 8000 kg, and the mass is expected in kg";
    assert!(found[0].starts_with(expected), "{}", found[0]);
    for mass in ["4000.0", "0.0", "20000.0"] {
        assert_eq!(warnings(mass), [""; 0], "{mass}");
    }
}

const WRONG: &str = r#"# Stütze A3
column_twin:
  ros__parameters:
    geometry:
      length_below: -1.0
      length_above: 3,5
    section.name: HEB 225
    steel.grade: 355
    hinge:
      elastic_law: coupled
      stiffness_1a: 1.0e+6
    support: {base: semi-rigid, top: semi_rigid}
    top:
      load: .nan
      load: 1.0e+6
    impact:
      velocty: 10.0
      mass: 1500 kg
      gap:
    solver.dt: 1.00005e-5
    colour: red
    record: off
    yield_surface.alpha: [1, 2]
    viewer.port: 98765
"#;

/// The message as users read it, kept whole so that changes to it are reviewed.
#[test]
fn all_faults_of_a_wrong_file_are_listed() {
    let faults = Parameters::from_yaml(Path::new("wrong.yaml"), WRONG).expect_err("a wrong file");
    let overrides = [
        parse_override("impact.velocity:=61"),
        parse_override("support.tpo:=pinned"),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = written(&folder, "wrong.yaml", WRONG);
    let with_overrides = Parameters::load(&[path], &overrides);
    let with_overrides = with_overrides.expect_err("a wrong file").to_string();

    assert_eq!(faults.to_string(), WRONG_LISTED);
    assert_eq!(
        with_overrides.lines().count(),
        WRONG_LISTED.lines().count() + 2
    );
    assert!(with_overrides.contains(
        "-p impact.velocity:=61: impact.velocity: `61` is out of range; allowed: 1e-6 to 60 m/s"
    ));
    assert!(with_overrides.contains(
        "-p support.tpo:=pinned: support.tpo is not a parameter (did you mean support.top?)"
    ));
}

const WRONG_LISTED: &str = r#"17 faults in the parameters
  wrong.yaml:5:21: geometry.length_below: `-1.0` is out of range; allowed: 0.02 to 100 m (L_a: height of the impact point above the base)
  wrong.yaml:6:21: geometry.length_above: `3,5` is a string, not a number; use a decimal point instead of the comma; allowed: 0.02 to 100 m
  wrong.yaml:7:19: section.name: `HEB 225` is not known (did you mean HEB220?); allowed: HEA, HEB or HEM 100 to 1000, IPE 80 to 600, or "" and numbers
  wrong.yaml:8:18: steel.grade: `355` is not known (did you mean S355?); allowed: S235, S275, S355, S420 or S460, or "" and numbers
  wrong.yaml:11:21: hinge.stiffness_1a is not compatible with the coupled law; write hinge.elastic_law: uncoupled, or omit the stiffness
  wrong.yaml:12:21: support.base: `semi-rigid` is not known (did you mean semi_rigid?); allowed: built_in, pinned or semi_rigid
  wrong.yaml:12:38: support.top_stiffness is required, because support.top is semi_rigid; give it in N m/rad
  wrong.yaml:14:13: top.load: `.nan` is not a finite number; allowed: 0 to 1e9 N
  wrong.yaml:15:7: top.load is given a second time; the first is in line 14; remove one of the two
  wrong.yaml:17:7: impact.velocty is not a parameter (did you mean impact.velocity?)
  wrong.yaml:18:13: impact.mass: `1500 kg` is a string, not a number; omit the unit; allowed: 0.001 to 1e6 kg, or 0 or NaN (the vehicle's own mass; not for a rigid one)
  wrong.yaml:19:7: impact.gap has no value; allowed: 0 to 100 m
  wrong.yaml:20:16: solver.dt: `1.00005e-5` is not a whole number of nanoseconds; the nearest is 1.0001e-5
  wrong.yaml:21:5: colour is not a parameter; docs/parameters.md lists all parameters
  wrong.yaml:22:5: record is a group of parameters, not a parameter; it contains record.mode, record.directory, record.max_file_size, record.max_duration, record.max_files, record.max_total_size, record.max_age, record.compression, record.sync, record.seal, record.seal_key
  wrong.yaml:23:5: yield_surface.alpha is a list; allowed: 1 to 50
  wrong.yaml:24:18: viewer.port: `98765` is out of range; allowed: a whole number from 1 to 65535 (TCP port to serve on or to connect to)"#;

/// A long list of wrong names costs no more than its length: only the first ones are compared with all known names.
#[test]
fn many_wrong_names_are_all_listed_and_the_first_ones_get_suggestions() {
    let wrong = (0..100).map(|k| (format!("impact.velocty{k}"), Value::from(1.0)));
    let faults = Parameters::from_values(wrong).expect_err("wrong");
    let explained: Vec<_> = faults
        .faults()
        .iter()
        .map(|fault| match &fault.problem {
            Problem::UnknownName { nearest } => !nearest.is_empty(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(explained, [[true; 16].as_slice(), &[false; 84]].concat());
}

/// The same faults in the text of the file.
#[test]
fn a_report_shows_the_lines() {
    let faults = Parameters::from_yaml(Path::new("wrong.yaml"), WRONG).expect_err("a wrong file");
    let mut shown = String::new();
    miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::unicode_nocolor())
        .with_width(120)
        .render_report(&mut shown, faults.report().as_ref())
        .expect("a report can be written");
    println!("{shown}");
    for fault in faults.faults() {
        assert!(
            shown.contains(&fault.problem.to_string()),
            "{fault}\n{shown}"
        );
    }
    assert!(shown.contains("wrong.yaml:5:21"));
}

#[test]
fn faults_can_be_used_by_a_program() {
    let faults = Parameters::from_yaml(Path::new("wrong.yaml"), WRONG).expect_err("a wrong file");
    let fault = faults
        .faults()
        .iter()
        .find(|fault| fault.name.as_deref() == Some("impact.velocty"))
        .expect("the misspelt name is listed");
    assert_eq!(
        fault.problem,
        Problem::UnknownName {
            nearest: vec!["impact.velocity".to_owned()]
        }
    );
    let Origin::File { path, position, .. } = &fault.place else {
        panic!("{fault:?}")
    };
    assert_eq!(
        (path.as_path(), *position),
        (Path::new("wrong.yaml"), Some((17, 7)))
    );
}

#[test]
fn later_files_and_overrides_win() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let head = "/**:\n  ros__parameters:\n";
    let first = written(
        &folder,
        "first.yaml",
        &format!("{head}    top: {{load: 1.0e+5, mass: 7}}\n"),
    );
    let second = written(
        &folder,
        "second.yaml",
        &format!("{head}    top.load: 2.0e+5\n"),
    );
    let overrides = ["top.load:=3.0e5", "top.load:=4e5"].map(parse_override);
    let load = |files: &[PathBuf], overrides| {
        let parameters = Parameters::load(files, overrides).expect("right");
        (
            parameters.settings().top.load,
            parameters.settings().top.mass,
        )
    };
    assert_eq!(load(&[first.clone(), second.clone()], &[]), (2e5, 7.0));
    assert_eq!(load(&[second.clone(), first.clone()], &[]), (1e5, 7.0));
    assert_eq!(load(&[first, second], &overrides), (4e5, 7.0));
}

#[test]
fn a_node_in_a_namespace_reads_its_own_section() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = "/garage/a3/column_twin:\n  ros__parameters: {top.load: 1.0e+5}\n\
                /garage/a4/column_twin:\n  ros__parameters: {top.load: 2.0e+5}\n";
    let files = [written(&folder, "garage.yaml", text)];
    for (namespace, load) in [("/garage/a3", 1e5), ("garage/a4", 2e5)] {
        let node = NodeName::new(namespace, "column_twin");
        assert_eq!(
            Parameters::load_in_order(&node, files.clone().map(Source::File))
                .expect("right")
                .0
                .settings()
                .top
                .load,
            load
        );
    }
    let elsewhere = Parameters::load(&files, &[])
        .expect_err("nothing for this node")
        .to_string();
    assert!(
        elsewhere.contains(
            "has parameters for /garage/a3/column_twin, /garage/a4/column_twin, but none for"
        ),
        "{elsewhere}"
    );
}

#[test]
fn changes_are_made_all_or_none() {
    let before = Parameters::default();
    let pinned = before
        .with_changes([
            ("support.base", "pinned".into()),
            ("impact.gap", 1_i64.into()),
        ])
        .expect("right");
    let changed: Vec<_> = pinned
        .changed_from(&before)
        .iter()
        .map(|parameter| parameter.name)
        .collect();
    assert_eq!(changed, ["support.base", "impact.gap"]);
    assert_eq!(pinned.get("impact.gap"), Some(Value::Double(1.0)));
    assert_eq!(pinned.get("impact.gaps"), None);
    assert_eq!(pinned.column_properties().base, Support::Pinned);

    let semi_rigid = ("support.base", Value::from("semi_rigid"));
    let stiffness = ("support.base_stiffness", Value::from(5e6));
    assert!(pinned.with_changes([semi_rigid.clone()]).is_err());
    let both = pinned
        .with_changes([semi_rigid, stiffness])
        .expect("right together");
    assert_eq!(
        both.column_properties().base,
        Support::SemiRigid { stiffness: 5e6 }
    );

    // A number overrides one property of the section that is already named.
    let heavier = before
        .with_changes([("section.mass_per_length", 100.0.into())])
        .expect("right");
    assert_eq!(heavier.section().name, Some("HEB220"));
    assert_eq!(heavier.column_properties().mass_per_length, 100.0);
    assert_eq!(
        heavier.column_properties().resistance_moment,
        before.column_properties().resistance_moment
    );
}

#[test]
fn what_would_need_a_restart_is_read_only() {
    let read_only: Vec<_> = PARAMETERS
        .iter()
        .filter(|parameter| parameter.read_only())
        .collect();
    assert!(
        read_only
            .iter()
            .all(|parameter| parameter.applies == Applies::Restart)
    );
    assert!(Parameter::named("column_id").is_some_and(Parameter::read_only));
    assert!(!Parameter::named("top.load").is_some_and(Parameter::read_only));
}

#[test]
fn json_is_checked_too() {
    let parameters = Parameters::load(&[in_repository("config/heb220_paper.yaml")], &[])
        .expect("the shipped file");
    let json = serde_json::to_string(&parameters).expect("serializes");
    assert_eq!(
        serde_json::from_str::<Parameters>(&json).expect("round trip"),
        parameters
    );
    let wrong = json.replace("\"alpha\":2.0", "\"alpha\":0.5");
    let error = serde_json::from_str::<Parameters>(&wrong)
        .expect_err("out of range")
        .to_string();
    assert!(
        error.contains("yield_surface.alpha: `0.5` is out of range; allowed: 1 to 50"),
        "{error}"
    );
    let mut settings: Settings = parameters.into();
    settings.impact.velocity = f64::NAN;
    assert!(Parameters::try_from(settings).is_err());
}

/// Any admissible value.
fn admissible(values: &'static Admissible) -> BoxedStrategy<Value> {
    let real = |min: f64, max: f64| (min..=max).prop_map(Value::Double);
    match *values {
        Admissible::Switch => any::<bool>().prop_map(Value::Bool).boxed(),
        Admissible::Integer { min, max } => (min..=max).prop_map(Value::Integer).boxed(),
        Admissible::Real { min, max } => prop_oneof![
            real(min, max),
            Just(Value::Double(min)),
            Just(Value::Double(max))
        ]
        .boxed(),
        Admissible::RealOrZero { min, max, .. } | Admissible::RealOrOpen { min, max, .. } => {
            prop_oneof![real(min, max), Just(Value::Double(0.0))].boxed()
        }
        Admissible::WholeNanoseconds { min, max, .. } => ((min * 1e9) as u64..=(max * 1e9) as u64)
            .prop_map(|nanos| Value::Double(nanos as f64 / 1e9))
            .boxed(),
        Admissible::Choice(words) => prop::sample::select(words).prop_map(Value::from).boxed(),
        Admissible::Text { min_chars, .. } => {
            prop::collection::vec(any::<char>(), min_chars.max(1)..20)
                .prop_map(|chars| {
                    chars
                        .into_iter()
                        .filter(|c| is_printable(*c))
                        .collect::<String>()
                })
                .prop_filter("not empty", |text| !text.is_empty())
                .prop_map(Value::from)
                .boxed()
        }
        Admissible::Sender => prop_oneof![
            prop::collection::vec(any::<u8>(), 4..=12)
                .prop_map(|bytes| bytes.iter().map(|byte| format!("{byte:02x}")).collect()),
            prop::sample::select(vec!["/operator", "/garage/operator_2"]).prop_map(str::to_owned),
        ]
        .prop_map(|text: String| Value::from(text))
        .boxed(),
        Admissible::Sign => prop::sample::select(vec![1_i64, -1])
            .prop_map(Value::Integer)
            .boxed(),
        Admissible::SensorName => {
            let characters = ('a'..='z').chain('A'..='Z').chain('0'..='9').chain(['_']);
            let character = prop::sample::select(characters.collect::<Vec<_>>());
            prop::collection::vec(character, 1..=40)
                .prop_map(|characters| characters.into_iter().collect())
                .prop_filter("reserved", |name: &String| {
                    name != "names" && name != "time"
                })
                .prop_map(Value::from)
                .boxed()
        }
        Admissible::SectionName => {
            let names: Vec<_> = catalogue()
                .iter()
                .map(|section| section.name.clone())
                .chain([String::new()])
                .collect();
            prop::sample::select(names).prop_map(Value::from).boxed()
        }
        Admissible::VehicleName => prop::sample::select(vehicle_names().collect::<Vec<_>>())
            .prop_map(Value::from)
            .boxed(),
        Admissible::SteelGrade => prop::sample::select(STEEL_GRADES)
            .prop_map(|grade| Value::from(grade.name))
            .boxed(),
        Admissible::Processors => prop::sample::select(vec!["", "0", "1,3-5"])
            .prop_map(Value::from)
            .boxed(),
        Admissible::List {
            of,
            min_len,
            max_len,
        } => prop::collection::vec(admissible(of), min_len..=max_len)
            .prop_map(move |elements| match of {
                Admissible::Real { .. } => {
                    Value::DoubleArray(elements.iter().filter_map(number).collect())
                }
                _ => Value::StringArray(elements.iter().map(Value::plain).collect()),
            })
            .boxed(),
    }
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Double(number) => Some(*number),
        _ => None,
    }
}

/// Parameters with admissible values, which need not be consistent.
fn changes() -> impl Strategy<Value = Vec<(&'static str, Value)>> {
    let one = (0..PARAMETERS.len()).prop_flat_map(|index| {
        let parameter = &PARAMETERS[index];
        admissible(&parameter.admissible).prop_map(move |value| (parameter.name, value))
    });
    prop::collection::vec(one, 0..60)
}

/// Admissible values are rejected only if they are not consistent with the others.
fn only_inconsistent(faults: &ParameterFaults) -> bool {
    let mut faults = faults.faults().iter();
    faults.all(|fault| matches!(fault.problem, Problem::Inconsistent(_)))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn admissible_values_survive_a_file(changes in changes()) {
        let mut parameters = Parameters::default();
        for change in changes {
            match parameters.with_changes([change.clone()]) {
                Ok(changed) => {
                    prop_assert_eq!(changed.get(change.0), Some(change.1));
                    parameters = changed;
                }
                Err(faults) => prop_assert!(only_inconsistent(&faults), "{}", faults),
            }
        }
        let read = Parameters::from_yaml(Path::new("written.yaml"), &parameters.to_yaml());
        prop_assert_eq!(read.map_err(|faults| faults.to_string()), Ok(parameters.clone()));
        let column = parameters.column_properties();
        for number in [column.axial_rigidity, column.bending_stiffness, column.mass_per_length,
            column.resistance_moment, column.resistance_axial] {
            prop_assert!(number.is_finite() && number > 0.0, "{:?}", column);
        }
        prop_assert!(column.step_nanos == 0 || (100..=1_000_000).contains(&column.step_nanos));
    }

    #[test]
    fn no_file_panics(bytes in prop::collection::vec(any::<u8>(), 0..300), cut in 0..WRONG.len(), at in 0..WRONG.len()) {
        let garbage = String::from_utf8_lossy(&bytes);
        let cut_off = String::from_utf8_lossy(&WRONG.as_bytes()[..cut]);
        let mut spliced = WRONG.as_bytes().to_vec();
        spliced.splice(at..at, bytes.iter().take(5).copied());
        let spliced = String::from_utf8_lossy(&spliced);
        for text in [garbage, cut_off, spliced] {
            if let Err(faults) = Parameters::from_yaml(Path::new("garbage.yaml"), &text) {
                prop_assert!(!faults.faults().is_empty());
                prop_assert_eq!(faults.to_string().lines().count(), faults.faults().len() + 1);
                let _ = format!("{:?}", faults.report());
            }
            let _ = parse_override(&text);
        }
    }

    #[test]
    fn no_value_panics(number in any::<f64>(), whole in any::<i64>(), characters in prop::collection::vec(any::<char>(), 0..60)) {
        let text: String = characters.into_iter().collect();
        for parameter in PARAMETERS {
            for value in [Value::Double(number), Value::Integer(whole), Value::from(text.as_str())] {
                let _ = Parameters::from_values([(parameter.name, value)]).map(|it| it.column_properties());
            }
        }
    }
}

/// The report of a wrong file as a user sees it, with its wrapped lines joined.
fn report_of(text: &str) -> String {
    let faults = Parameters::from_yaml(Path::new("f.yaml"), text).expect_err("a wrong file");
    format!("{:?}", faults.report()).replace("\n  │ ", " ")
}

#[test]
fn an_empty_file_is_rejected_with_the_reason() {
    for text in ["", "\n\n", "# only a comment\n"] {
        let report = report_of(text);
        let reason = "the file is empty; begin it with `column_twin:` and, indented below it, `ros__parameters:`";
        assert!(report.contains(reason), "{text:?}: {report}");
    }
}

#[test]
fn an_unclosed_bracket_is_rejected_with_the_reason() {
    for text in [
        "column_twin: [1, 2\n",
        "column_twin: {ros__parameters: {a: 1\n\n",
    ] {
        let report = report_of(text);
        assert!(report.contains("not valid YAML"), "{report}");
        assert!(report.contains("of line 1, column "), "{report}");
    }
}

#[test]
fn a_line_of_100_kb_is_not_quoted_whole() {
    let long = "x".repeat(100_000);
    for line in [
        format!("steel.grade: {long}"),
        format!("{long}: 1.0"),
        format!("top.load: [{long}"),
        format!("steel.grade: S350\n    # {long}"),
    ] {
        let report = report_of(&format!("column_twin:\n  ros__parameters:\n    {line}\n"));
        assert!(report.len() < 1000, "{} characters", report.len());
        assert!(report.contains("f.yaml:"), "{report}");
    }
}

/// A file could otherwise change the terminal of whoever looks at its faults.
#[test]
fn control_and_bidirectional_characters_of_a_file_are_not_shown() {
    for text in [
        "column_twin:\n  ros__parameters:\n    top.load: \"\u{202e}1e5\"\n",
        "column_twin:\n  ros__parameters:\n    top.lo\u{200b}ad: 1.0\n",
        "column_twin:\n  ros__parameters:\n    top.load: -1.0 # \u{202e}\n",
        "column_twin:\n  ros__parameters:\n    steel.grade: \"a\\e[2J\"\n",
    ] {
        let report = report_of(text);
        let shown = |c: char| c == '\n' || is_printable(c);
        assert!(report.chars().all(shown), "{report:?}");
    }
}

/// What a file declares of sensors of the default column, which is 4 m high.
fn with_sensors(sensors: &str) -> Result<Parameters, ParameterFaults> {
    let text = format!("column_twin:\n  ros__parameters:\n    sensors:\n{sensors}");
    Parameters::from_yaml(Path::new("s.yaml"), &text)
}

const TWO_SENSORS: &str = "      names: [top_laser, base_strain]
      top_laser: {quantity: displacement, height: 2.5, noise: 1.0e-4, bandwidth: 1000, sign: -1}
      base_strain: {quantity: bending_strain, height: 0.25, rate: 2000.0}
";

#[test]
fn sensors_are_declared_by_their_names() {
    let parameters = with_sensors(TWO_SENSORS).expect("right");
    let laser = Sensor {
        name: "top_laser".to_owned(),
        quantity: Quantity::Displacement,
        height: 2.5,
        range: 0.0,
        noise: 1e-4,
        bias: 0.0,
        gain_error: 0.0,
        rate: 10_000.0,
        bandwidth: 1000.0,
        reversed: true,
        fibre: 0.11,
    };
    let strain = Sensor {
        name: "base_strain".to_owned(),
        quantity: Quantity::BendingStrain,
        height: 0.25,
        noise: 0.0,
        rate: 2000.0,
        bandwidth: 1000.0,
        reversed: false,
        ..laser.clone()
    };
    assert_eq!(parameters.sensors(), [laser, strain]);
    assert_eq!(
        parameters.get("sensors.top_laser.sign"),
        Some(Value::Integer(-1))
    );
    assert_eq!(parameters.get("sensors.side_laser.sign"), None);
    assert_eq!(parameters.get("sensors.<name>.sign"), None);

    let names: Vec<_> = parameters
        .iter()
        .map(|(it, _)| it.name.to_owned())
        .collect();
    let count = PARAMETERS.len();
    assert_eq!(names.len(), count + 2 * SENSOR_PARAMETERS.len());
    assert_eq!(names[count - 1], "sensors.names");
    assert_eq!(names[count], "sensors.top_laser.quantity");
    assert_eq!(names[names.len() - 1], "sensors.base_strain.axis");
    for (declared, value) in parameters.iter() {
        assert_eq!(parameters.get(declared.name), Some(value));
        assert_eq!(parameters.declared(declared.name), Some(declared));
    }
    let changed = parameters.changed_from(&Parameters::default());
    assert_eq!(changed.len(), 1 + 2 * SENSOR_PARAMETERS.len());
    assert!(changed.iter().all(|it| it.row.read_only()));
    assert_eq!(Parameters::default().sensors(), []);
}

/// The names may stand behind what they declare, in the file, in a later file and on the command line.
#[test]
fn the_order_of_declaration_does_not_matter() {
    let expected = with_sensors(TWO_SENSORS).expect("right");
    let mut lines: Vec<_> = TWO_SENSORS.lines().collect();
    lines.reverse();
    assert_eq!(
        with_sensors(&(lines.join("\n") + "\n")),
        Ok(expected.clone())
    );
    let assignments = [
        "sensors.base_strain.height:=0.25",
        "sensors.top_laser.sign:=-1",
        "sensors.top_laser.quantity:=displacement",
        "sensors.top_laser.noise:=1e-4",
        "sensors.base_strain.rate:=2000",
        "sensors.names:=[top_laser, base_strain]",
        "sensors.base_strain.quantity:=bending_strain",
        "sensors.top_laser.height:=2.5",
        "sensors.top_laser.bandwidth:=1000.0",
    ];
    for turns in 0..assignments.len() {
        let mut turned = assignments;
        turned.rotate_left(turns);
        let loaded = Parameters::load(&[], &turned.map(parse_override));
        assert_eq!(loaded, Ok(expected.clone()));
    }
}

#[test]
fn the_shipped_sensors_suit_the_shipped_column() {
    let files = ["config/heb220_s355.yaml", "config/sensors_industrial.yaml"].map(in_repository);
    let parameters = Parameters::load(&files, &[]).expect("the shipped files");
    let column = Parameters::load(&files[..1], &[]).expect("the shipped file");
    assert_eq!(parameters.column_properties(), column.column_properties());
    let sensors = parameters.sensors();
    let facts: Vec<_> = sensors
        .iter()
        .map(|it| (it.quantity, it.height, it.bandwidth))
        .collect();
    assert_eq!(
        facts,
        [
            (Quantity::Acceleration, 1.0, 5000.0),
            (Quantity::Displacement, 1.0, 5000.0),
            (Quantity::BendingStrain, 0.11, 5000.0),
        ]
    );
    const G: f64 = 9.806_65;
    let accelerometer = &sensors[0];
    for (given, in_g) in [
        (accelerometer.range, 50.0),
        (accelerometer.noise, 2.2e-3),
        (accelerometer.bias, 50e-3),
    ] {
        assert!((given / (in_g * G) - 1.0).abs() < 1e-6);
    }
    assert_eq!(sensors[2].fibre, 0.11);
}

#[test]
fn drivers_of_accelerometers_are_named_by_topic_message_and_axis() {
    let one = |rest: &str| {
        with_sensors(&format!(
            "      names: [a, b]\n      a: {{quantity: acceleration, height: 1.0, topic: /imu, message: imu, axis: z}}\n      b: \
             {{height: 2.0, {rest}}}\n"
        ))
    };
    let right = one("quantity: acceleration, topic: /imu, message: imu").expect("right");
    let of = |topic: &str, axis| SensorSource {
        topic: topic.to_owned(),
        message: SensorMessage::Imu,
        axis,
    };
    let expected = [of("/imu", SensorAxis::Z), of("/imu", SensorAxis::X)];
    assert_eq!(right.sensor_sources(), expected);
    for (rest, expected) in [
        (
            "quantity: acceleration, message: accel_stamped",
            "sensors.b.topic is required, because the message is accel_stamped",
        ),
        (
            "quantity: rotation, topic: /tilt, message: imu",
            "sensors.b.message is imu, of which only the linear acceleration is read, but the quantity is rotation",
        ),
        (
            "quantity: acceleration, topic: /imu, message: accel_stamped",
            "sensors.b.message is accel_stamped, but sensors.a expects imu on the same topic",
        ),
        (
            "quantity: acceleration, message: laser_scan",
            "accel_stamped",
        ),
        ("quantity: acceleration, axis: w", "allowed: x, y or z"),
    ] {
        let faults = one(rest).expect_err(rest).to_string();
        assert!(faults.contains(expected), "{faults}");
    }
}

#[test]
fn sensors_survive_a_file_json_and_settings() {
    let parameters = with_sensors(TWO_SENSORS).expect("right");
    let read = Parameters::from_yaml(Path::new("written.yaml"), &parameters.to_yaml());
    assert_eq!(read, Ok(parameters.clone()));
    let json = serde_json::to_string(&parameters).expect("serializes");
    let read = serde_json::from_str::<Parameters>(&json).expect("reads");
    assert_eq!(read, parameters);
    let wrong = json.replace("\"height\":2.5", "\"height\":25.0");
    let error = serde_json::from_str::<Parameters>(&wrong)
        .expect_err("above the column")
        .to_string();
    assert!(
        error.contains("sensors.top_laser.height is 25 m"),
        "{error}"
    );
    let mut settings: Settings = parameters.clone().into();
    settings.sensors.names.pop();
    let faults = Parameters::try_from(settings).expect_err("not declared");
    assert!(faults.to_string().contains("does not contain base_strain"));
    let mut settings: Settings = parameters.into();
    settings.sensors.each.remove("base_strain");
    let faults = Parameters::try_from(settings).expect_err("not described");
    assert!(
        faults
            .to_string()
            .contains("sensors.base_strain.quantity is required")
    );
}

#[test]
fn sensors_change_with_the_other_parameters() {
    let before = with_sensors(TWO_SENSORS).expect("right");
    let moved = before
        .with_changes([("sensors.top_laser.height", 3.0.into())])
        .expect("right");
    let names: Vec<_> = moved
        .changed_from(&before)
        .iter()
        .map(|it| it.name)
        .collect();
    assert_eq!(names, ["sensors.top_laser.height"]);
    // A sensor that is taken out of the list takes its values with it.
    let one = vec!["base_strain".to_owned()];
    let fewer = before
        .with_changes([("sensors.names", Value::from(one))])
        .expect("right");
    assert_eq!(fewer.sensors(), before.sensors()[1..]);
    assert_eq!(fewer.get("sensors.top_laser.height"), None);
    let names: Vec<_> = fewer
        .changed_from(&before)
        .iter()
        .map(|it| it.name)
        .collect();
    assert_eq!(names, ["sensors.names"]);
    // The column becomes shorter than the place of a sensor.
    let shorter = before.with_changes([("geometry.length_above", 1.0.into())]);
    let faults = shorter
        .expect_err("the laser is above the column")
        .to_string();
    assert!(
        faults.contains("sensors.top_laser.height is 2.5 m, but the column is 2 m high"),
        "{faults}"
    );
}

const WRONG_SENSORS: &str = r#"column_twin:
  ros__parameters:
    sensors:
      top_lazer: {quantity: displacement}
      names: [top_laser, gauge, base, force, tilt]
      top_laser:
        height: 4.5
        heigth: 2.0
        quantity: displacment
        sign: 0
        rate: .nan
        noise: -1.0e-3
      gauge: {quantity: bending_strain, height: 1.0, fibre: 0.2, bandwidth: 1e9, range: [1.0]}
      base: {height: 0.0}
      force: {quantity: contact_force, sign: "1"}
      tilt: {quantity: rotation, gain_error: 1 %}
      "b\e[2J": {height: 1.0}
      other: 3.0
"#;

/// The message as users read it, kept whole so that changes to it are reviewed.
#[test]
fn all_faults_of_wrong_sensors_are_listed() {
    let faults = Parameters::from_yaml(Path::new("s.yaml"), WRONG_SENSORS).expect_err("wrong");
    assert_eq!(faults.to_string(), WRONG_SENSORS_LISTED);
}

const WRONG_SENSORS_LISTED: &str = r#"16 faults in the parameters
  s.yaml:4:19: sensors.top_lazer.quantity is given, but sensors.names does not contain top_lazer (did you mean top_laser?); known: top_laser, gauge, base, force, tilt
  s.yaml:5:7: sensors.base.quantity is required, because sensors.names contains base; allowed: acceleration, displacement, rotation, bending_strain, axial_strain or contact_force
  s.yaml:5:7: sensors.tilt.height is required, because sensors.names contains tilt; allowed: 0 to 200 m
  s.yaml:7:17: sensors.top_laser.height is 4.5 m, but the column is 4 m high; give at most that
  s.yaml:8:9: sensors.top_laser.heigth is not a parameter (did you mean sensors.top_laser.height?)
  s.yaml:9:19: sensors.top_laser.quantity: `displacment` is not known (did you mean displacement?); allowed: acceleration, displacement, rotation, bending_strain, axial_strain or contact_force
  s.yaml:10:15: sensors.top_laser.sign: `0` is out of range; allowed: 1 or -1 (-1 if the sensor is mounted in the opposite direction, so that its readings have the opposite sign)
  s.yaml:11:15: sensors.top_laser.rate: `.nan` is not a finite number; allowed: 1 to 1e6 Hz
  s.yaml:12:16: sensors.top_laser.noise: `-1.0e-3` is out of range; allowed: 0 to 1e12 (root mean square of the noise, in the unit of the quantity)
  s.yaml:13:61: sensors.gauge.fibre is 0.2 m, outside the section, which is 0.22 m high; give at most 0.11 m, or 0 for half the section height
  s.yaml:13:77: sensors.gauge.bandwidth: `1e9` is out of range; allowed: 0.1 to 1e6 Hz, or 0 (half the rate) (cut-off frequency of the anti-alias filter; more than half the rate has the effect of half the rate)
  s.yaml:13:82: sensors.gauge.range is a list; allowed: 1e-12 to 1e12, or 0 (no clipping)
  s.yaml:15:46: sensors.force.sign: `1` is a string, not a number; omit the quotes, and write an exponent with a decimal point (1.0e7); allowed: 1 or -1
  s.yaml:16:46: sensors.tilt.gain_error: `1 %` is a string, not a number; omit the unit; allowed: 0 to 1
  s.yaml:17:18: sensors.b\u{1b}[2J.height is given, but sensors.names does not contain b\u{1b}[2J; known: top_laser, gauge, base, force, tilt
  s.yaml:18:7: sensors.other is a group of parameters, not a parameter; it contains sensors.other.quantity, sensors.other.height, sensors.other.range, sensors.other.noise, sensors.other.bias, sensors.other.gain_error, sensors.other.rate, sensors.other.bandwidth, sensors.other.sign, sensors.other.fibre, sensors.other.topic, sensors.other.message, sensors.other.axis"#;

#[test]
fn wrong_names_of_sensors_are_rejected() {
    let many: Vec<_> = (0..65).map(|number| format!("s{number}")).collect();
    let too_many = format!("[{}]", many.join(", "));
    let too_long = format!("[{}]", "s".repeat(41));
    for (names, words) in [
        (
            "[a, b, a, b, c]",
            "sensors.names contains a, b more than once; give each sensor its own name",
        ),
        (
            "[\"\"]",
            "sensors.names: `` (element 1) is not a valid string",
        ),
        (
            "[a, top.laser]",
            "`top.laser` (element 2) is not a valid string; allowed: a name of 1 to 40 letters, digits and underscores other than names or time",
        ),
        ("[\"a b\"]", "(element 1) is not a valid string"),
        ("[kr\u{e4}fte]", "(element 1) is not a valid string"),
        ("[names]", "(element 1) is not a valid string"),
        ("[time]", "(element 1) is not a valid string"),
        (too_long.as_str(), "(element 1) is not a valid string"),
        ("[1]", "is a number; put a string in quotes"),
        ("top_laser", "is not a list; write [\"top_laser\"]"),
        (
            too_many.as_str(),
            "has 65 elements; allowed: a list of 0 to 64 elements",
        ),
    ] {
        // The parameters of a sensor are not reported, too, where the list of names is wrong.
        let overrides = [
            format!("sensors.names:={names}"),
            "sensors.a.height:=1.0".to_owned(),
        ];
        let faults = Parameters::load(&[], &overrides.map(|it| parse_override(&it)));
        let faults = faults.expect_err(names).to_string();
        assert!(faults.contains(words), "{faults}");
        assert!(!faults.contains("is given, but"), "{faults}");
    }
    let all = (0..64).flat_map(|number| {
        let names = ["quantity", "height"].map(|it| format!("sensors.s{number}.{it}"));
        names
            .into_iter()
            .zip([Value::from("axial_strain"), 1.0.into()])
    });
    let names = ("sensors.names".to_owned(), Value::from(many[..64].to_vec()));
    let parameters = Parameters::from_values(all.chain([names])).expect("64 sensors");
    assert_eq!(parameters.sensors().len(), 64);
}

#[test]
fn a_bending_strain_needs_the_distance_of_its_fibre() {
    let section = [
        ("section.area", 91e-4),
        ("section.second_moment", 8091e-8),
        ("section.mass_per_length", 70.1),
        ("resistance.moment", 0.3e6),
    ];
    let section = section.map(|(name, number)| (name, Value::from(number)));
    let with = |more: &[(&'static str, Value)]| {
        let gauge = [
            ("sensors.names", Value::from(vec!["gauge".to_owned()])),
            ("sensors.gauge.quantity", "bending_strain".into()),
            ("sensors.gauge.height", 0.5.into()),
        ];
        let all = section.iter().chain(&gauge).chain(more);
        let loaded = Parameters::from_values(all.cloned());
        loaded
            .map(|it| it.sensors()[0].fibre)
            .map_err(|it| it.to_string())
    };
    let missing = with(&[]).expect_err("no height of the section");
    assert!(
        missing.contains("sensors.gauge.fibre is required for a bending strain"),
        "{missing}"
    );
    assert_eq!(with(&[("section.height", 0.3.into())]), Ok(0.15));
    assert_eq!(with(&[("sensors.gauge.fibre", 0.1.into())]), Ok(0.1));
    let both = [
        ("section.height", Value::from(0.3)),
        ("sensors.gauge.fibre", 0.15.into()),
    ];
    assert_eq!(with(&both), Ok(0.15));
    assert_eq!(
        with(&[("sensors.gauge.quantity", "axial_strain".into())]),
        Ok(0.0)
    );
}

/// A section for any node may declare the sensors of another one.
#[test]
fn sensors_of_other_nodes_are_only_warned_of() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = "/**:\n  ros__parameters:\n    sensors.names: [top_laser]\n    sensors.top_laser: {quantity: displacement, height: 1.0}\n    \
                sensors.top_lazer.noise: 1.0e-4\n    sensors.lidar.angle: 3.0\n    sensors.top_laser.heigth: 2.0\n";
    let file = Source::File(written(&folder, "any.yaml", text));
    let (parameters, warnings) =
        Parameters::load_in_order(&NodeName::default(), [file]).expect("warnings only");
    assert_eq!(parameters.sensors().len(), 1);
    let ends: Vec<_> = warnings
        .iter()
        .filter_map(|it| {
            it.to_string()
                .split_once("any.yaml")
                .map(|it| it.1.to_owned())
        })
        .collect();
    const NONE: &str = "is not a parameter of this node and has no effect on it";
    assert_eq!(
        ends,
        [
            format!(":6:5: sensors.lidar.angle {NONE} (did you mean sensors.lidar.range?)"),
            format!(
                ":7:5: sensors.top_laser.heigth {NONE} (did you mean sensors.top_laser.height?)"
            ),
            format!(":5:5: sensors.top_lazer.noise {NONE} (did you mean sensors.top_laser.noise?)"),
        ]
    );
}

#[test]
fn without_names_no_sensor_is_declared() {
    let faults = Parameters::from_values([("sensors.top.height", Value::from(1.0))]);
    let reason = faults.expect_err("not declared").in_one_line();
    assert_eq!(
        reason,
        "sensors.top.height is given, but sensors.names does not contain top; known: none"
    );
}

/// Many parameters of sensors that are not declared cost no more than their number.
#[test]
fn many_undeclared_sensors_are_all_listed_and_the_first_ones_get_suggestions() {
    let wrong = (0..100).map(|k| (format!("sensors.laser_{k}.height"), Value::from(1.0)));
    let names = (
        "sensors.names".to_owned(),
        Value::from(vec!["laser_x".to_owned()]),
    );
    let faults = Parameters::from_values(wrong.chain([names])).expect_err("wrong");
    let suggested = faults
        .faults()
        .iter()
        .filter_map(|fault| match &fault.problem {
            Problem::UnknownSensor { nearest, .. } => Some(!nearest.is_empty()),
            _ => None,
        });
    let suggested: Vec<_> = suggested.collect();
    let listed = faults.to_string().matches("known: laser_x").count();
    assert_eq!(listed, 16);
    assert_eq!(suggested, [[true; 16].as_slice(), &[false; 84]].concat());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn admissible_sensors_survive_a_file(values in SENSOR_PARAMETERS.iter().map(|row| admissible(&row.admissible)).collect::<Vec<_>>(), name in admissible(&Admissible::SensorName)) {
        let sensor = name.plain();
        let rows = SENSOR_PARAMETERS.iter().map(|row| row.name.replace("<name>", &sensor));
        let names = ("sensors.names".to_owned(), Value::from(vec![sensor.clone()]));
        let given: Vec<_> = rows.zip(values).chain([names]).collect();
        match Parameters::from_values(given.clone()) {
            Ok(parameters) => {
                for (name, value) in given {
                    prop_assert_eq!(parameters.get(&name), Some(value));
                }
                let read = Parameters::from_yaml(Path::new("written.yaml"), &parameters.to_yaml());
                prop_assert_eq!(read, Ok(parameters.clone()));
                let sensor = &parameters.sensors()[0];
                prop_assert!(sensor.bandwidth > 0.0 && sensor.bandwidth <= sensor.rate / 2.0);
                prop_assert!(sensor.fibre > 0.0);
            }
            Err(faults) => prop_assert!(only_inconsistent(&faults), "{}", faults),
        }
    }

    #[test]
    fn no_sensor_panics(number in any::<f64>(), whole in any::<i64>(), characters in prop::collection::vec(any::<char>(), 0..30)) {
        let text: String = characters.into_iter().collect();
        for row in SENSOR_PARAMETERS {
            for value in [Value::Double(number), Value::Integer(whole), Value::from(text.as_str())] {
                for sensor in ["a", &text] {
                    let name = row.name.replace("<name>", sensor);
                    let names = ("sensors.names".to_owned(), Value::from(vec![sensor.to_owned()]));
                    if let Err(faults) = Parameters::from_values([(name, value.clone()), names]) {
                        prop_assert_eq!(faults.to_string().lines().count(), faults.faults().len() + 1);
                    }
                }
            }
        }
    }
}

/// A column that is given by its height is hit where its vehicle strikes; lengths that are given stay.
#[test]
fn a_height_lets_the_vehicle_say_where_it_strikes() {
    let loaded = |overrides: &[&str]| {
        let overrides: Vec<_> = overrides.iter().map(|it| parse_override(it)).collect();
        Parameters::load(&[], &overrides)
    };
    let lengths = |overrides: &[&str]| {
        let parameters = loaded(overrides).expect("right");
        let geometry = &parameters.settings().geometry;
        (geometry.length_below, geometry.length_above)
    };
    let height = "geometry.height:=4.0";
    for (vehicle, below) in [
        ("mid_car", 0.5),
        ("lorry_16t", 1.25),
        ("forklift", 0.75),
        ("rigid", 1.0),
    ] {
        let vehicle = format!("vehicle.name:={vehicle}");
        assert_eq!(lengths(&[height, &vehicle]), (below, 4.0 - below));
        // Without a height nothing follows the vehicle.
        assert_eq!(lengths(&[&vehicle]), (1.0, 3.0));
        let given = "geometry.length_below:=0.8";
        assert_eq!(lengths(&[height, &vehicle, given]), (0.8, 3.2));
        let above = "geometry.length_above:=2.5";
        assert_eq!(lengths(&[height, &vehicle, above]), (1.5, 2.5));
        let both = lengths(&[height, &vehicle, given, "geometry.length_above:=3.2"]);
        assert_eq!(both, (0.8, 3.2));
    }
    for (overrides, text) in [
        (
            &[
                height,
                "geometry.length_below:=1.0",
                "geometry.length_above:=2.0",
            ][..],
            "geometry.height is 4 m, but geometry.length_below of 1 m and geometry.length_above of 2 m are 3 m together; omit \
             one of the three",
        ),
        (
            &["geometry.height:=1.0", "vehicle.name:=lorry_8t"],
            "geometry.height of 1 m leaves bars of 1.25 m below and -0.25 m above the impact point",
        ),
    ] {
        let faults = loaded(overrides).expect_err("contradictory").to_string();
        assert!(faults.contains(text), "{faults}");
    }

    // Both lengths replace a height that was given before them, in a file, in an earlier section or in parameters that change.
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("f.yaml");
    std::fs::write(
        &file,
        "/**:\n  ros__parameters: {geometry: {height: 4.0}, vehicle: {name: mid_car}}\n",
    )
    .expect("written");
    let over_file = |overrides: &[&str]| {
        let overrides: Vec<_> = overrides.iter().map(|it| parse_override(it)).collect();
        let parameters = Parameters::load(std::slice::from_ref(&file), &overrides).expect("right");
        let geometry = &parameters.settings().geometry;
        let lorry = parameters.impact_height_of("lorry_8t");
        let lengths = [geometry.length_below, geometry.length_above];
        (geometry.height, lengths, lorry)
    };
    let (below, above) = ("geometry.length_below:=0.5", "geometry.length_above:=2.9");
    assert_eq!(over_file(&[]), (4.0, [0.5, 3.5], Some(1.25)));
    assert_eq!(over_file(&[below, above]), (0.0, [0.5, 2.9], None));
    assert_eq!(over_file(&[above]), (4.0, [1.1, 2.9], None));
    // Also if they are as long together as the height: their impact point stays.
    let same = over_file(&[below, "geometry.length_above:=3.5"]);
    assert_eq!(same, (0.0, [0.5, 3.5], None));
    let sections = "/**:\n  ros__parameters: {geometry: {height: 4.0}}\n\
                    column_twin:\n  ros__parameters: {geometry: {length_below: 0.6, length_above: 2.0}}\n";
    let read = Parameters::from_yaml(Path::new("f.yaml"), sections).expect("right");
    let geometry = &read.settings().geometry;
    assert_eq!(
        [
            geometry.height,
            geometry.length_below,
            geometry.length_above
        ],
        [0.0, 0.6, 2.0]
    );
    let both = loaded(&[height]).expect("right").with_changes([
        ("geometry.length_below", Value::from(1.0)),
        ("geometry.length_above", Value::from(2.0)),
    ]);
    assert_eq!(both.expect("right").settings().geometry.height, 0.0);

    // A vehicle without a height of its own strikes at 1 m, and others where they do.
    let rigid = loaded(&[height]).expect("right");
    assert_eq!(rigid.impact_height_of("lorry_8t"), Some(1.25));
    assert_eq!(rigid.impact_height_of("Rigid"), Some(1.0));
    assert_eq!(rigid.impact_height_of(""), None);
    assert_eq!(rigid.impact_height_of("mid_car@0.3"), Some(0.5));

    // What followed the vehicle follows a change of it, and a file says the same again.
    let car = loaded(&[height, "vehicle.name:=mid_car"]).expect("right");
    let changed = |name: &str, value: Value| {
        let changed = car.with_changes([(name, value)]).expect("right");
        let geometry = &changed.settings().geometry;
        (geometry.length_below, geometry.length_above)
    };
    assert_eq!(changed("vehicle.name", "lorry_8t".into()), (1.25, 2.75));
    let rigid = car.with_changes([
        ("vehicle.name", Value::from("rigid")),
        ("impact.mass", 1500.0.into()),
    ]);
    let rigid = rigid.expect("right");
    let geometry = &rigid.settings().geometry;
    assert_eq!((geometry.length_below, geometry.length_above), (1.0, 3.0));
    assert_eq!(changed("geometry.height", 5.0.into()), (0.5, 4.5));
    assert_eq!(changed("geometry.length_below", 1.5.into()), (1.5, 2.5));
    let read = Parameters::from_yaml(Path::new("f.yaml"), &car.to_yaml());
    assert_eq!(read, Ok(car.clone()));
    let json = serde_json::to_string(&car).expect("serializes");
    assert_eq!(
        serde_json::from_str::<Parameters>(&json).expect("reads"),
        car
    );
}
