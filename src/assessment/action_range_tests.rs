//! Tests of the range of a verdict.

use super::{
    Action, ActionRange, Assumption, ImpactEvaluation, MissingData, OpenVerdict, respond_and_rest,
};
use crate::parameters::{Parameters, parse_override};

fn evaluated(overrides: &[&str]) -> ImpactEvaluation {
    let overrides: Vec<_> = overrides.iter().map(|it| parse_override(it)).collect();
    let parameters = Parameters::load(&[], &overrides).expect("parameters");
    let (properties, impact) = (parameters.column_properties(), parameters.impact());
    let ended =
        respond_and_rest(&properties, &impact, parameters.response_duration()).expect("a response");
    ImpactEvaluation::complete(&parameters, &properties, &impact, ended).expect("an evaluation")
}

/// Each end of the range is an action to which the verdict or a variation leads, and what decides it leads there alone.
#[test]
fn the_range_of_a_verdict_holds_it_and_names_what_decides() {
    let real = [
        "section.name:=HEB220",
        "steel.grade:=S355",
        "top.load:=5.0e5",
        "support.base:=built_in",
        "support.top:=built_in",
        "vehicle.name:=mid_car",
    ];
    let hits: [&[&str]; 4] = [
        &[],
        &["impact.velocity:=5.0"],
        &["geometry.length_below:=0.5", "geometry.length_above:=3.5"],
        &["support.base:=pinned", "top.load:=1.0e6"],
    ];
    let mut wide = 0;
    for hit in hits {
        let evaluation = evaluated(&[&real[..], hit].concat());
        let assessment = evaluation.assessment.expect("an assessment");
        let (verdict, missing) = (assessment.action, assessment.not_evaluated);
        let range = evaluation.range.expect("a range");
        let ends = &range.ends;
        assert!(ends.least <= verdict && verdict <= ends.most, "{range}");
        let found: Vec<_> = range.variations.iter().map(|it| it.action).collect();
        assert!(
            ends.least == verdict || found.contains(&ends.least),
            "{range}"
        );
        // The most severe one is that of the verdict, of a variation, or of what is not evaluated.
        let by_missing = |it: &MissingData| it.action == ends.most;
        let is_open = !ends.not_evaluated.is_empty();
        assert!(!is_open || missing.iter().any(by_missing), "{range}");
        assert!(
            is_open || ends.most == verdict || found.contains(&ends.most),
            "{range}"
        );
        assert!(missing.iter().all(|it| it.action <= ends.most), "{range}");
        assert!(!ends.at_least, "{range}");
        let end = if ends.most > verdict {
            ends.most
        } else {
            ends.least
        };
        let is_explained = !ends.decided_by.is_empty() || is_open;
        assert_eq!(!is_explained, end == verdict, "{range}");
        for assumption in &ends.decided_by {
            assert!(range.of_assumption(*assumption).any(|it| it.action == end));
        }
        wide += usize::from(range.ends.least < range.ends.most);
        assert_eq!(range.not_varied, []);
    }
    assert!(wide > 0);
}

/// A section by numbers: the range ended at the worst action found, and its text at "at least".
#[test]
fn the_range_reaches_what_is_not_evaluated() {
    let evaluation = evaluated(&[
        "section.name:=''",
        "section.area:=91.04e-4",
        "section.second_moment:=8091.0e-8",
        "section.mass_per_length:=71.5",
        "resistance.moment:=0.294e6",
        "impact.velocity:=2.0",
    ]);
    let assessment = evaluation.assessment.expect("an assessment");
    assert!(assessment.at_least && assessment.action < Action::Evacuate);
    let range = evaluation.range.expect("a range");
    assert_eq!(range.ends.most, Action::Evacuate);
    let words = range.to_string();
    assert!(words.contains(" to EVACUATE, decided by "), "{words}");
    assert!(words.contains("missing data: "), "{words}");
    assert!(!words.contains("at least"), "{words}");
    for missing in &assessment.not_evaluated {
        let is_named = range
            .ends
            .not_evaluated
            .iter()
            .any(|it| it == missing.criterion);
        assert_eq!(is_named, missing.action == Action::Evacuate, "{words}");
    }
}

/// Where the beam had seen a hit out of the plane and nothing was varied, the range ended at the verdict, and began at that of the
/// two bars on a component of the hit.
#[test]
fn a_hit_out_of_the_plane_of_which_nothing_is_varied_is_open_upwards() {
    let hit = [
        "section.name:=HEB220",
        "steel.grade:=S355",
        "top.load:=5.0e5",
        "support.base:=built_in",
        "support.top:=built_in",
        "vehicle.name:=rigid",
        "impact.mass:=1500.0",
        "impact.velocity:=0.3",
        "impact.direction:=0.5",
    ];
    let evaluation = evaluated(&hit);
    let mut assessment = evaluation.assessment.expect("an assessment");
    let mut range = evaluation.range.expect("a range");
    assert!(range.variations.is_empty() && assessment.action < Action::Restrict);
    assert_eq!(range.ends.least, assessment.action);
    assert_eq!(range.ends.most, Action::Evacuate);
    // By the beam it is worse, and nothing of it is unknown.
    assessment.seen_in_space();
    assessment.action = Action::Restrict;
    assert_eq!(assessment.not_evaluated, []);
    let words =
        "RESTRICT to EVACUATE, decided by missing data: movement out of the plane of the two bars";
    range.with_another_model(&assessment);
    assert_eq!(range.to_string(), words);
    let not_varied = range.not_varied.clone();
    let verdict = OpenVerdict::from(&assessment);
    let of_both = ActionRange::of_variations(&verdict, Vec::new(), not_varied);
    assert_eq!(of_both.to_string(), words);
    // More than that is not possible.
    assessment.action = Action::Evacuate;
    range.with_another_model(&assessment);
    assert_eq!(range.ends.most, Action::Evacuate);
    assert_eq!(range.ends.least, Action::Evacuate);
}

#[test]
fn what_cannot_be_varied_is_named_with_its_reason() {
    let range = evaluated(&[
        "geometry.length_below:=0.3",
        "assessment.range_height:=0.4",
        "resistance.moment:=3.0e5",
    ])
    .range
    .expect("a range");
    let reason = |assumption| {
        let mut all = range.not_varied.iter().filter(|(it, _)| *it == assumption);
        all.next().map(|(_, reason)| reason.as_str())
    };
    let height = reason(Assumption::Height);
    assert_eq!(height, Some("-0.10 m above the base is not on the column"));
    assert_eq!(range.of_assumption(Assumption::Height).count(), 1);
    let strength = reason(Assumption::YieldStrength);
    assert_eq!(strength, Some("resistance.moment is given as a number"));
}

/// Without a width of a range nothing of it is varied.
#[test]
fn a_range_without_width_is_not_varied() {
    let range = evaluated(&[
        "assessment.range_velocity:=0.0",
        "assessment.range_height:=0.0",
        "assessment.range_front:=0.0",
    ])
    .range
    .expect("a range");
    let varied: Vec<_> = range.variations.iter().map(|it| it.assumption).collect();
    for assumption in [
        Assumption::Speed,
        Assumption::Height,
        Assumption::FrontForce,
    ] {
        assert!(!varied.contains(&assumption));
    }
}

/// A variation that follows later, such as that of the fibre beam, changes the range as if it had been there from the beginning.
#[test]
fn a_variation_that_follows_gives_the_range_of_all() {
    let evaluation = evaluated(&[
        "section.name:=HEB220",
        "steel.grade:=S355",
        "top.load:=5.0e5",
        "vehicle.name:=mid_car",
    ]);
    let verdict = OpenVerdict::from(&evaluation.assessment.expect("an assessment"));
    let all = evaluation.range.expect("a range").variations;
    for action in [
        Action::None,
        Action::Inspect,
        Action::Restrict,
        Action::Evacuate,
    ] {
        let verdict = OpenVerdict {
            action,
            ..verdict.clone()
        };
        let whole = ActionRange::of_variations(&verdict, all.clone(), Vec::new());
        for known in 0..=all.len() {
            let (before, after) = all.split_at(known);
            let mut range = ActionRange::of_variations(&verdict, before.to_vec(), Vec::new());
            for variation in after {
                range.include(&verdict, variation.clone());
            }
            assert_eq!(range, whole, "{known}");
        }
    }
}
