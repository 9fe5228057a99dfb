//! The capacity and the load of a verdict: against a fibre beam, and what must hold of every column.

use column_twin::assessment::{
    Action, AssessmentInput, ResidualCapacity, assess, imperfection, respond_and_rest,
};
use column_twin::column::{
    Impact, Model, Outcome, PerBar, PlasticFlow, State, capacity, carried_load, residual_state,
};
use column_twin::parameters::{DEFAULT_CRITERIA, Parameters, Value, catalogue};
use column_twin::second_opinion::evaluate;
use column_twin::study::StudyColumn;
use serde::Deserialize;

/// A column on which the push-down was compared with fibre beams in the plane and in space (OpenSees): signed errors in per
/// cent, positive where the program is on the unsafe side, rounded to whole ones.
#[derive(Deserialize)]
struct FibreColumn {
    section: String,
    grade: String,
    height_m: f64,
    base: String,
    top: String,
    length_below_m: f64,
    slenderness: f64,
    /// Push-down of the undamaged column over the buckling resistance of EN 1993-1-1 about the strong axis.
    push_down_over_code_percent: f64,
    /// The same over the fibre beam with a bow of L/1000 and residual stresses.
    push_down_over_gmnia_percent: f64,
    /// What a hit of a rigid vehicle leaves, by the push-down and by the fibre beam.
    ratio_of_push_down: f64,
    ratio_of_fibre: f64,
    /// min(ratio times strong-axis resistance, undamaged weak-axis resistance), the rule of version 0.2, over a fibre beam in space;
    /// empty where there is none.
    smaller_of_both_axes_percent: Option<f64>,
}

impl FibreColumn {
    fn all() -> Vec<Self> {
        let text = include_str!("data/capacity_fibre.csv");
        let columns = csv::Reader::from_reader(text.as_bytes())
            .deserialize()
            .collect::<Result<Vec<Self>, _>>();
        columns.expect("tests/data/capacity_fibre.csv")
    }

    /// Without rate, hardening, softening and shear, as the fibre beam.
    fn parameters(&self) -> Parameters {
        Parameters::from_values([
            ("section.name", Value::from(self.section.as_str())),
            ("steel.grade", self.grade.as_str().into()),
            ("geometry.length_below", self.length_below_m.into()),
            (
                "geometry.length_above",
                (self.height_m - self.length_below_m).into(),
            ),
            ("support.base", self.base.as_str().into()),
            ("support.top", self.top.as_str().into()),
            ("top.load", 2e5.into()),
            ("rate.law", "none".into()),
            ("hardening.ratio", 0.0.into()),
            ("softening.model", "none".into()),
            ("shear.model", "none".into()),
        ])
        .expect("a column")
    }

    /// What a rigid vehicle of 1.5 t leaves that is as fast as it takes to leave this ratio.
    fn damaged(&self, parameters: &Parameters, ratio: f64) -> ResidualCapacity {
        self.speed_and_damage(parameters, ratio).1
    }

    /// The same with its speed.
    fn speed_and_damage(&self, parameters: &Parameters, ratio: f64) -> (f64, ResidualCapacity) {
        let properties = parameters.column_properties();
        let model = Model::new(&properties).expect("a column");
        let after = |velocity: f64| {
            let impact = Impact::rigid(1500.0, velocity);
            let (_, rest) = respond_and_rest(&properties, &impact, 2.0).expect("a response");
            ResidualCapacity::compute(parameters, &model, rest.as_ref()).expect("capacities")
        };
        let (mut slow, mut fast) = (0.5, 25.0);
        for _ in 0..14 {
            let middle = 0.5 * (slow + fast);
            if after(middle).ratio > ratio {
                slow = middle;
            } else {
                fast = middle;
            }
        }
        (slow, after(slow))
    }

    /// Buckling resistance of the undamaged column by a fibre beam with a bow of L/1000 and residual stresses \[N\].
    fn gmnia(&self, undamaged_push_down: f64) -> f64 {
        undamaged_push_down / (1.0 + 0.01 * self.push_down_over_gmnia_percent)
    }
}

/// The capacity that decides lies within -20 and +5 % of a fibre beam with a bow of L/1000 and residual stresses, up to a
/// slenderness of 1.6, where the push-down alone is up to 69 % too high.
#[test]
fn the_capacity_that_decides_is_that_of_a_fibre_beam() {
    let mut misses = Vec::new();
    println!(
        "column          slenderness  push-down  N_u undamaged  N_u after a hit, over the fibre beam"
    );
    for column in FibreColumn::all() {
        let parameters = column.parameters();
        let model = Model::new(&parameters.column_properties()).expect("a column");
        let new = ResidualCapacity::compute(&parameters, &model, Some(&State::at_rest(&model)))
            .expect("capacities");
        // The reference belongs to this column.
        let name = format!("{} {} m", column.section, column.height_m);
        assert!(
            (new.strong.slenderness - column.slenderness).abs() < 0.006,
            "{name}"
        );
        let over_code = 100.0 * (new.undamaged.force / new.strong.force - 1.0);
        assert!(
            (over_code - column.push_down_over_code_percent).abs() < 1.0,
            "{name}: {over_code}"
        );
        let gmnia = column.gmnia(new.undamaged.force);
        let error = |force: f64, reference: f64| 100.0 * (force / reference - 1.0);
        assert_eq!((new.ratio, new.axial_capacity), (1.0, new.strong.force));
        let undamaged = error(new.axial_capacity, gmnia);
        let after = column.damaged(&parameters, column.ratio_of_push_down);
        assert!(
            (after.ratio - column.ratio_of_push_down).abs() < 0.01,
            "{name}: {}",
            after.ratio
        );
        let damaged = error(after.axial_capacity, column.ratio_of_fibre * gmnia);
        println!(
            "{name:<15} {:>11.2}  {:>+8.0} %  {undamaged:>+9.1} %  {damaged:>+9.1} %",
            new.strong.slenderness, column.push_down_over_gmnia_percent
        );
        let within = |error: f64| (-20.0..=5.0).contains(&error);
        assert!(within(undamaged), "{name}: {undamaged} %");
        if !within(damaged) {
            misses.push((name, damaged));
        }
    }
    // A long column hit near its base: the hit leaves the upper bar of 7.25 m straight, where the fibre beam has a second hinge in
    // its middle and keeps twice the bow. A push-down that may bow between the hinges does not mend that; the second opinion does.
    let [(name, error)] = &misses[..] else {
        panic!("{misses:?}")
    };
    assert_eq!(name, "IPE300 8 m");
    assert!((10.0..16.0).contains(error), "{error} %");
}

/// Where the two bars overestimate the capacity that a hit leaves, the second opinion does not: the smaller capacity of both models
/// lies within -20 and +5 % of OpenSees, but for the most slender column, which is 24 % on the safe side.
#[test]
fn the_smaller_capacity_of_both_models_is_never_on_the_unsafe_side() {
    println!(
        "column           speed   two bars       beam    smaller, over the fibre beam of OpenSees"
    );
    for column in FibreColumn::all() {
        let name = format!("{} {} m", column.section, column.height_m);
        let parameters = column.parameters();
        let (speed, after) = column.speed_and_damage(&parameters, column.ratio_of_push_down);
        let hit = parameters
            .with_changes([
                ("vehicle.name", Value::from("rigid")),
                ("impact.mass", 1500.0.into()),
                ("impact.velocity", speed.into()),
                ("beam.shear", false.into()),
                ("beam.bow_axes", "strong".into()),
            ])
            .expect("a hit");
        let opinion = evaluate(&hit).expect("a response").second_opinion;
        let [undamaged, left] = opinion.expect("a second opinion").capacity;
        let reference = column.ratio_of_fibre * column.gmnia(after.undamaged.force);
        let strong = after.strong.force;
        let errors = [
            after.ratio,
            left / undamaged,
            after.ratio.min(left / undamaged),
        ]
        .map(|ratio| 100.0 * (ratio * strong / reference - 1.0));
        println!(
            "{name:<15} {speed:>4.1} m/s {:>+8.1} % {:>+8.1} % {:>+8.1} %",
            errors[0], errors[1], errors[2]
        );
        let lowest = if column.slenderness > 1.5 {
            -25.0
        } else {
            -20.0
        };
        assert!((lowest..=5.0).contains(&errors[2]), "{name}: {errors:?}");
    }
}

/// As much of the weak-axis resistance is taken to be left as of the strong one: with the whole of it the rule was up to 40 %
/// on the unsafe side of a fibre beam in space.
#[test]
fn the_weak_axis_after_a_hit_is_on_the_safe_side_of_a_fibre_beam_in_space() {
    println!("column          undamaged weak axis  as much as of the strong one");
    for column in FibreColumn::all() {
        let Some(before) = column.smaller_of_both_axes_percent else {
            continue;
        };
        let parameters = column.parameters();
        let after = column.damaged(&parameters, column.ratio_of_push_down);
        let weak = after.weak.expect("a named section").force;
        let old_rule = weak.min(after.ratio * after.strong.force);
        let reference = old_rule / (1.0 + 0.01 * before);
        let now = 100.0 * (after.resistance.expect("a resistance") / reference - 1.0);
        let name = format!("{} {} m", column.section, column.height_m);
        println!("{name:<15} {before:>+14.0} %  {now:>+10.1} %");
        assert!((-30.0..=0.0).contains(&now), "{name}: {now} %");
    }
}

#[test]
fn buckling_lengths_are_those_that_are_given() {
    let remaining = |values: &[(&str, Value)]| {
        let parameters = Parameters::from_values(values.iter().cloned()).expect("a column");
        let model = Model::new(&parameters.column_properties()).expect("a column");
        ResidualCapacity::compute(&parameters, &model, Some(&State::at_rest(&model)))
            .expect("capacities")
    };
    let default = remaining(&[]);
    let weak = |it: &ResidualCapacity| it.weak.expect("a named section");
    assert!((weak(&default).buckling_length - 2.0).abs() < 1e-9);
    // HEB 220, S355, 4 m, computed independently: 2781 kN built in, 1866 kN pinned about the weak axis.
    let pinned = remaining(&[("capacity.buckling_factor_weak", 1.0.into())]);
    assert!((weak(&pinned).force - 1866e3).abs() < 1e3);
    assert_eq!(pinned.strong, default.strong);
    assert_eq!(pinned.resistance, Some(weak(&pinned).force));
    assert!((pinned.resistance_over_load().expect("a load") - 1866.0 / 500.0).abs() < 3e-3);
    let swaying = remaining(&[("capacity.buckling_factor_strong", 2.0.into())]);
    assert_eq!(swaying.strong.buckling_length, 8.0);
    assert_eq!(weak(&swaying), weak(&default));
    assert_eq!(swaying.weak_axis_governs(), Some(false));
    assert!(swaying.reserve < default.reserve);
    // The push-down knows the supports alone.
    assert_eq!(swaying.undamaged, default.undamaged);
}

/// A column whose structure above is proven to take so much of the load \[N\]; with 0, nothing is.
fn with_proof(mut values: Vec<(&'static str, Value)>, limit: f64) -> Parameters {
    if limit > 0.0 {
        values.push(("top.redistribution_limit", limit.into()));
        values.push(("top.redistribution_proof", "calculation 17".into()));
    }
    Parameters::from_values(values).expect("a column")
}

/// The load is that before any help, but for what is proven.
#[test]
fn what_the_structure_above_takes_counts_up_to_its_proven_limit() {
    let remaining = |spring: f64, limit: f64| {
        let parameters = with_proof(vec![("top.spring_stiffness", Value::from(spring))], limit);
        let properties = parameters.column_properties();
        let model = Model::new(&properties).expect("a column");
        let impact = Impact::rigid(1500.0, 10.0);
        let (_, rest) = respond_and_rest(&properties, &impact, 2.0).expect("a response");
        let rest = rest.expect("a column that stands");
        let shed = properties.top_load - carried_load(&model, &rest);
        let remaining =
            ResidualCapacity::compute(&parameters, &model, Some(&rest)).expect("capacities");
        (remaining, shed)
    };
    let (alone, shed) = remaining(0.0, 0.0);
    assert!(shed.abs() < 1.0);
    assert_eq!(alone.carried_load, 500e3);
    let (held, shed) = remaining(1e7, 0.0);
    assert!(shed > 50e3, "{shed}");
    assert_eq!(held.carried_load, 500e3);
    let (proven, _) = remaining(1e7, 20e3);
    assert_eq!(proven.carried_load, 480e3);
    assert!(proven.reserve > held.reserve);
    let (wholly, shed) = remaining(1e7, 1e6);
    assert!((wholly.carried_load - (500e3 - shed)).abs() < 1e-6);
}

/// A column that stands by the spring at its top alone: whatever the structure above is proven to take, it is not judged milder than
/// one that cannot bear its load with its partial factors, and the first lines say from what the load hangs.
#[test]
fn a_column_that_hangs_from_its_spring_is_shored_at_least() {
    let judged = |load: f64, velocity: f64, limit: f64| {
        let values = vec![
            ("top.spring_stiffness", Value::from(1e8)),
            ("top.load", load.into()),
        ];
        let parameters = with_proof(values, limit);
        let properties = parameters.column_properties();
        let model = Model::new(&properties).expect("a column");
        let impact = Impact::rigid(1500.0, velocity);
        let (report, rest) = respond_and_rest(&properties, &impact, 2.0).expect("a response");
        let rest = rest?;
        let taken = load - carried_load(&model, &rest);
        let remaining = ResidualCapacity::compute(&parameters, &model, Some(&rest));
        let remaining = remaining.expect("capacities");
        let own = remaining
            .resistance
            .expect("known")
            .min(remaining.axial_capacity);
        let input = AssessmentInput::of_response(&parameters, &model, &impact, &report, remaining);
        Some((assess(&input), own, taken, report.outcome))
    };
    let mut hanging = 0;
    for load in [1.2e6, 1.8e6, 2.1e6] {
        for velocity in [4.0, 8.0, 10.0, 12.0] {
            for limit in [0.0, 1e5, 1e9] {
                let Some((assessment, own, taken, outcome)) = judged(load, velocity, limit) else {
                    continue;
                };
                let lines = assessment.first_lines();
                println!("{load} {velocity} {limit}: {outcome:?} {own:.0} {taken:.0} {lines:?}");
                if outcome != Outcome::Plastic || own >= load {
                    assert!(!lines[1].contains("does not bear its load"), "{lines:?}");
                    continue;
                }
                hanging += 1;
                let least = if limit == 0.0 {
                    Action::Evacuate
                } else {
                    Action::Shore
                };
                assert!(assessment.action >= least, "{lines:?}");
                let says = "The column alone does not bear its load of ";
                assert!(lines[1].contains(says), "{lines:?}");
                let hangs = lines[1].contains("it hangs from the spring at the top, which bears ");
                assert_eq!(hangs, load - taken <= own, "{lines:?}");
            }
        }
    }
    assert!(hanging > 5, "{hanging}");
}

/// Which load it is stands beside every verdict, also beside that of a column that carries nothing.
#[test]
fn every_verdict_says_which_load_it_is_about() {
    const SENTENCE: &str = "The applied load N of 495 kN is top.load of 500 kN, the accidental combination of EN 1990 with its psi factors, less \
                            5.00 kN that the structure above takes (proof: calculation 17); gamma_M = 1.0.";
    let parameters = Parameters::from_values([
        ("top.spring_stiffness", Value::from(1e7)),
        ("top.redistribution_limit", 5e3.into()),
        ("top.redistribution_proof", "calculation 17".into()),
        ("top.load_basis", "accidental".into()),
    ])
    .expect("a column");
    let model = Model::new(&parameters.column_properties()).expect("a column");
    let new = State::at_rest(&model);
    let remaining = ResidualCapacity::compute(&parameters, &model, Some(&new)).expect("capacities");
    let mut input = AssessmentInput::of_state(&parameters, &model, &new, remaining);
    for collapsed in [false, true] {
        input.collapsed = collapsed;
        let assessment = assess(&input);
        assert_eq!(assessment.load, SENTENCE);
        assert!(
            assessment.reservations().contains(SENTENCE),
            "{}",
            assessment.reason
        );
    }
}

/// Numbers that are spread without a pattern, the same in every run (splitmix64).
struct Spread(u64);

impl Spread {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[(self.unit() * all.len() as f64) as usize]
    }

    /// A column of the catalogue with a load of 5 to 70 % of its resistance, in a third of all cases each without a spring, with
    /// one, and with one that is proven. `None` where these make no column.
    fn column(&mut self) -> Option<(Parameters, Model)> {
        let sections: Vec<_> = catalogue()
            .iter()
            .filter(|it| (0.1..0.6).contains(&it.dimensions.depth))
            .map(|it| it.name.as_str())
            .collect();
        let height = self.between(2.5, 9.0);
        let below = height * self.between(0.08, 0.92);
        let mut values = vec![
            ("section.name", Value::from(self.one_of(&sections))),
            ("steel.grade", self.one_of(&["S235", "S355", "S460"]).into()),
            ("geometry.length_below", below.into()),
            ("geometry.length_above", (height - below).into()),
            ("support.base", self.one_of(&["built_in", "pinned"]).into()),
            ("support.top", self.one_of(&["built_in", "pinned"]).into()),
            ("top.load", 1e3.into()),
        ];
        let light = Parameters::from_values(values.clone()).ok()?;
        let [strong, weak] = column_twin::assessment::buckling_resistances(&light);
        let resistance = strong?.force.min(weak?.force);
        values[6].1 = (self.between(0.05, 0.7) * resistance).into();
        match self.one_of(&[0, 1, 2]) {
            0 => (),
            kind => {
                let stiffness = 10.0_f64.powf(self.between(5.0, 8.0));
                values.push(("top.spring_stiffness", stiffness.into()));
                if kind == 2 {
                    let limit = self.between(0.01, 0.5) * resistance;
                    values.push(("top.redistribution_limit", limit.into()));
                    values.push(("top.redistribution_proof", "calculation 17".into()));
                }
            }
        }
        let parameters = Parameters::from_values(values).ok()?;
        let model = Model::new(&parameters.column_properties()).ok()?;
        Some((parameters, model))
    }

    fn flow(&mut self, length: f64) -> PlasticFlow {
        let mut rotation = || self.between(-1.0, 1.0).powi(3) * 0.1;
        let rotation = [rotation(), rotation()];
        PlasticFlow {
            rotation,
            elongation: [0.0, 1.0].map(|_| length * self.between(-1.0, 0.4) * 2e-3),
            ..PlasticFlow::default()
        }
    }
}

/// Whether a column as it is reports no more than the new one.
fn is_no_better(now: &ResidualCapacity, new: &ResidualCapacity) -> bool {
    now.now.force <= new.now.force
        && now.ratio <= 1.0
        && now.axial_capacity <= new.axial_capacity
        && now.resistance <= new.resistance
        && now.reserve <= new.reserve
        && now.resistance_over_load() <= new.resistance_over_load()
}

/// Any plastic deformation whatever, also such as steel that has hardened or a bow that opposes the imperfection.
#[test]
fn no_deformation_gives_a_column_more_reserve_than_new() {
    const DAMAGED: usize = 2_000;
    const OF_ONE_COLUMN: usize = 25;
    let mut spread = Spread(1);
    let (mut damaged, mut above, mut shed, mut columns) = (0, 0, 0, 0);
    while damaged < DAMAGED {
        let Some((parameters, model)) = spread.column() else {
            continue;
        };
        let at_rest = State::at_rest(&model);
        let bow = imperfection(&parameters);
        let undamaged = capacity(&model, &at_rest, bow).expect("a capacity");
        let new = ResidualCapacity::new(&parameters, &model, Some(&at_rest), undamaged, undamaged);
        columns += 1;
        for _ in 0..OF_ONE_COLUMN {
            let properties = &model.properties;
            let plastic = PerBar {
                below: spread.flow(properties.length_below),
                above: spread.flow(properties.length_above),
            };
            let state = State::settled(&model, at_rest.displacement, plastic);
            let Some(rest) = residual_state(&model, &state) else {
                continue;
            };
            let found = capacity(&model, &rest, bow).expect("a capacity");
            let now = ResidualCapacity::new(&parameters, &model, Some(&rest), undamaged, found);
            assert!(
                is_no_better(&now, &new),
                "{:?}\n{now:?}\n{new:?}",
                parameters.section().name
            );
            damaged += 1;
            above += usize::from(found.force > undamaged.force);
            shed += usize::from(carried_load(&model, &rest) < carried_load(&model, &at_rest));
        }
    }
    println!(
        "{damaged} damaged states of {columns} columns: {above} push-downs above that of the new column, {shed} carry less than new"
    );
    assert!(above > 0 && shed > damaged / 10);
}

/// 168 of 184 damaged columns had more reserve than new ones, because a spring had taken the load off them.
#[test]
fn no_hit_leaves_a_column_with_more_reserve_than_new() {
    const DAMAGED: usize = 10_000;
    let mut spread = Spread(2);
    let (mut damaged, mut hits, mut at_the_bound) = (0, 0, 0);
    while damaged < DAMAGED {
        let Some((parameters, _)) = spread.column() else {
            continue;
        };
        let column = StudyColumn::undamaged(&parameters).expect("a column");
        let new = column
            .evaluate(&Impact::rigid(1.0, 1e-3))
            .expect("a response");
        assert_eq!(new.capacity_ratio, 1.0);
        for _ in 0..10 {
            let impact = Impact::rigid(spread.between(300.0, 3e3), spread.between(1.0, 10.0));
            let hit = column.evaluate(&impact).expect("a response");
            assert!(
                hit.residual_capacity <= new.residual_capacity
                    && hit.capacity_ratio <= 1.0
                    && hit.reserve <= new.reserve,
                "{hit:?}\n{new:?}"
            );
            hits += 1;
            if hit.residual_v1.is_some() && hit.outcome == Outcome::Plastic {
                damaged += 1;
                at_the_bound += usize::from(hit.reserve == new.reserve);
            }
        }
    }
    println!(
        "{damaged} damaged columns of {hits} hits, {at_the_bound} with the reserve of the new column"
    );
}

/// With the base not evaluated, whose friction grows with the load, the action never becomes milder when the load grows.
#[test]
fn the_action_never_becomes_milder_when_the_load_grows() {
    let criteria: Vec<String> = DEFAULT_CRITERIA
        .iter()
        .filter(|name| !name.starts_with("base_"))
        .map(|name| (*name).to_owned())
        .collect();
    let (mut verdicts, mut milder) = (0, Vec::new());
    for (section, grade, height) in [
        ("HEB220", "S355", 4.0),
        ("HEA200", "S235", 5.0),
        ("IPE300", "S355", 4.0),
        ("HEB160", "S355", 6.0),
    ] {
        for (base, top) in [("built_in", "built_in"), ("pinned", "pinned")] {
            for (vehicle, below, speeds) in [
                ("rigid", 1.0, &[2.0, 4.0, 7.0, 11.0][..]),
                ("mid_car", 0.5, &[6.0, 11.0, 16.0]),
                ("lorry_8t", 1.25, &[3.0, 6.0, 9.0]),
            ] {
                let with = |load: f64| {
                    Parameters::from_values([
                        ("section.name", Value::from(section)),
                        ("steel.grade", grade.into()),
                        ("geometry.length_below", below.into()),
                        ("geometry.length_above", (height - below).into()),
                        ("support.base", base.into()),
                        ("support.top", top.into()),
                        ("vehicle.name", vehicle.into()),
                        ("top.load", load.into()),
                        ("assessment.criteria", criteria.clone().into()),
                    ])
                    .expect("a column")
                };
                let [strong, weak] = column_twin::assessment::buckling_resistances(&with(1e3));
                let resistance = [strong, weak]
                    .into_iter()
                    .flatten()
                    .map(|it| it.force)
                    .fold(f64::INFINITY, f64::min);
                let mut before = vec![None; speeds.len()];
                for share in [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7] {
                    let parameters = with(share * resistance);
                    let column = StudyColumn::undamaged(&parameters).expect("a column");
                    for (speed, before) in speeds.iter().zip(&mut before) {
                        let impact = column
                            .impact(Some(vehicle), None, *speed)
                            .or_else(|_| column.impact(Some(vehicle), Some(1500.0), *speed))
                            .expect("an impact");
                        let here = column.evaluate(&impact).expect("a response");
                        verdicts += 1;
                        if *before > Some(here.action) {
                            milder.push(format!(
                                "{section} {grade} {height} m {base}, {vehicle} at {speed} m/s: {before:?}, then {} by {} at {share} of \
                                 the resistance",
                                here.action, here.deciding_criterion
                            ));
                        }
                        *before = Some(here.action);
                    }
                }
            }
        }
    }
    println!("{verdicts} verdicts");
    assert!(milder.is_empty(), "{}", milder.join("\n"));
}
