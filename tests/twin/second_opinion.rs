//! The second opinion of the fibre beam: computed behind the forecast, part of forecast, report, status and saved state from then on,
//! and the verdict where it is more severe.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use column_twin::column::Impact;
use column_twin::parameters::{Parameters, Value};
use column_twin::second_opinion::{BeamAnswer, BeamTask};
use column_twin::sensors::Quantity;
use column_twin::twin::{
    Accepted, BackgroundTask, BeamResult, Checkpoint, Command, OpinionState, Output, ReportOutput,
    ResidualMeasurement, SavedState, SupplementedReport, Twin,
};

use super::{Bench, MS, event};

fn parameters() -> Parameters {
    parameters_of("config/heb220_s355.yaml")
}

fn parameters_of(file: &str) -> Parameters {
    let given = Parameters::load(&[file.into()], &[]).expect("admissible");
    let changes = [
        ("column_id", Value::from("column")),
        // A large step keeps the tests short.
        ("solver.dt", Value::from(1e-4)),
    ];
    given.with_changes(changes).expect("admissible")
}

fn bench() -> Bench {
    Bench::with(parameters(), None)
}

/// A rigid mass of 1.5 t.
fn hit(bench: &mut Bench, id: &str, velocity: f64, direction: f64) {
    let mut event = event(id, bench.now);
    event.vehicle = "rigid".to_owned();
    event.impact.velocity = velocity;
    event.impact.height = Some(1.0);
    event.impact.direction = Some(direction);
    bench.hit(event);
}

fn computed(bench: &Bench) -> Arc<BeamResult> {
    bench.twin.opinion_task().expect("awaited").compute()
}

/// Gives the twin the second opinion that it awaits.
fn told(bench: &mut Bench) -> BeamAnswer {
    let result = computed(bench);
    let given = bench.handle(Command::SecondOpinion(Arc::clone(&result)));
    assert_eq!(given, Ok(Accepted::Applied));
    match &*result {
        BeamResult::Answer(answer) => (**answer).clone(),
        BeamResult::None(reason) => panic!("{reason}"),
    }
}

fn supplemented(bench: &Bench) -> Vec<&SupplementedReport> {
    let all = bench.out.iter().filter_map(|it| match it {
        Output::Supplemented(again) => Some(again),
        _ => None,
    });
    all.collect()
}

fn reason(report: &ReportOutput) -> &str {
    match &report.opinion {
        OpinionState::None(reason) => reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn it_follows_the_complete_forecast_and_comes_before_the_range() {
    let mut bench = bench();
    hit(&mut bench, "a", 5.0, 0.0);
    assert!(!bench.twin.awaits_opinion(), "there is no forecast yet");
    bench.twin.run_ahead(u64::MAX, bench.now, &mut bench.out);
    assert!(bench.twin.awaits_opinion() && !bench.twin.awaits_range());
    let first = bench.twin.background_tasks().next().expect("a task");
    assert!(matches!(first, BackgroundTask::SecondOpinion(_)));
    assert_eq!(bench.forecasts()[1].opinion, OpinionState::Awaited);

    let answer = told(&mut bench);
    assert!(!bench.twin.awaits(&first) && bench.twin.awaits_range());
    let forecast = bench.forecasts()[1].clone();
    let [again] = supplemented(&bench)[..] else {
        panic!("{:?}", supplemented(&bench));
    };
    assert!(!again.is_result);
    assert_eq!(again.report.report, forecast.report);
    assert_eq!(again.report.opinion, OpinionState::Known);
    let assessed = again.report.assessed.clone().expect("assessed");
    let opinion = assessed.second_opinion.clone().expect("a second opinion");
    // The same hit without a twin.
    let impact = Impact::rigid(1500.0, 5.0);
    let alone = BeamTask::new(&parameters(), [1.0, 3.0], impact, 0.0, None).expect("a task");
    let alone = alone.compute();
    let alone = alone.expect("an answer");
    assert_eq!(answer, alone);
    assert_eq!(opinion.beam, alone.beam);

    bench.rest();
    let report = bench.reports()[0];
    assert_eq!(report.opinion, OpinionState::Known);
    assert_eq!(report.assessed.as_ref(), Some(&assessed));
    let status = bench.twin.status(bench.now);
    assert_eq!(status.assessed.as_ref(), Some(&assessed));
    assert!(!bench.twin.awaits_opinion());
}

/// The two bars see 0.17 of the speed of a vehicle that comes at 80 degrees.
#[test]
fn out_of_the_plane_the_verdict_is_that_of_the_beam_wherever_it_is_more_severe() {
    let mut bench = bench();
    hit(&mut bench, "a", 8.0, 80.0_f64.to_radians());
    bench.rest();
    let by_bars = bench.reports()[0].assessed.clone().expect("assessed");
    told(&mut bench);
    let status = bench.twin.status(bench.now);
    let by_both = status.assessed.expect("assessed");
    assert!(by_both.assessment.action > by_bars.assessment.action);
    assert!(by_both.second_opinion.as_ref().is_some_and(|it| it.decides));
    let reason = &by_both.assessment.reason;
    assert!(reason.contains("fibre beam"), "{reason}");
    let [again] = supplemented(&bench)[..] else {
        panic!("{:?}", supplemented(&bench));
    };
    assert!(again.is_result);
    assert_eq!(again.report.assessed.as_ref(), Some(&by_both));
    assert_eq!(again.report.striking.velocity(), 8.0);
}

/// Two hits on one twin are two hits on one beam, with a restart between them or without one.
#[test]
fn the_damage_of_the_beam_accumulates_and_survives_a_restart() {
    let mut bench = bench();
    hit(&mut bench, "a", 6.0, 0.3);
    bench.rest();
    let first = told(&mut bench);
    let checkpoint = bench.twin.checkpoint(bench.now).expect("at rest");
    let text = serde_json::to_string(&checkpoint).expect("JSON");
    let read: Checkpoint = serde_json::from_str(&text).expect("a checkpoint");
    let saved = bench.twin.saved_state(bench.now).to_json().expect("JSON");
    let saved = SavedState::from_json(&saved, &parameters()).expect("a state");
    let assessed = bench.twin.status(bench.now).assessed;

    let mut continued = Bench::with(parameters(), None);
    continued.twin = Twin::from_checkpoint(&read, Box::new(|| 0)).expect("a column");
    let mut restarted = Bench::with(parameters(), Some(&saved));
    let mut answers = Vec::new();
    for (name, twin) in [
        ("the same", &mut bench),
        ("from a checkpoint", &mut continued),
        ("restarted", &mut restarted),
    ] {
        assert_eq!(twin.twin.status(twin.now).assessed, assessed, "{name}");
        hit(twin, "b", 5.0, -0.2);
        twin.rest();
        answers.push(told(twin));
    }
    assert_eq!(answers[0], answers[1]);
    assert_eq!(answers[0], answers[2]);
    let undamaged = {
        let mut bench = Bench::with(parameters(), None);
        hit(&mut bench, "b", 5.0, -0.2);
        bench.rest();
        told(&mut bench)
    };
    assert_ne!(answers[0].damage, first.damage);
    assert_ne!(
        answers[0].beam.residual_capacity_n,
        undamaged.beam.residual_capacity_n
    );
}

#[test]
fn a_section_without_plates_has_none_and_says_why() {
    let mut bench = Bench::with(parameters_of("config/heb220_paper.yaml"), None);
    hit(&mut bench, "a", 5.0, 0.0);
    bench.rest();
    assert!(!bench.twin.awaits_opinion());
    let text = reason(bench.reports()[0]);
    assert!(text.contains("section.name"), "{text}");
}

#[test]
fn a_direction_that_is_none_has_none_and_nothing_else_changes() {
    let mut bench = bench();
    hit(&mut bench, "a", 5.0, 4.0);
    bench.rest();
    let result = computed(&bench);
    let given = bench.handle(Command::SecondOpinion(result));
    assert_eq!(given, Ok(Accepted::Applied));
    let [again] = supplemented(&bench)[..] else {
        panic!("{:?}", supplemented(&bench));
    };
    let text = reason(&again.report);
    assert!(text.contains("no second opinion"), "{text}");
    let report = bench.reports()[0];
    assert_eq!(again.report.report, report.report);
    assert_eq!(again.report.assessed, report.assessed);
}

/// What the beam has not seen through to its end it does not know, until a reset.
#[test]
fn after_an_impact_that_the_beam_has_not_computed_there_is_none_until_a_reset() {
    let awaited = |bench: &mut Bench| {
        hit(bench, "a", 8.0, 0.0);
        bench.rest();
    };
    let moving = |bench: &mut Bench| {
        hit(bench, "a", 8.0, 0.0);
        bench.go_on(20 * MS);
        hit(bench, "moving", 8.0, 0.0);
        bench.rest();
        assert!(reason(bench.reports()[0]).contains("moving"));
    };
    let ways: [&dyn Fn(&mut Bench); 2] = [&awaited, &moving];
    for way in ways {
        let mut bench = bench();
        way(&mut bench);
        let before = bench.reports().len();
        hit(&mut bench, "b", 5.0, 0.0);
        bench.rest();
        let text = reason(bench.reports()[before]);
        assert!(text.starts_with("no second opinion"), "{text}");
        assert!(!bench.twin.awaits_opinion());
        bench.reset();
        hit(&mut bench, "c", 5.0, 0.0);
        bench.rest();
        told(&mut bench);
    }
}

/// The beam forgot its damage when a measurement corrected that of the two bars, and said nothing more until a reset.
#[test]
fn after_a_measurement_has_corrected_the_damage_the_beam_has_what_was_measured() {
    let mut bench = bench();
    hit(&mut bench, "a", 8.0, 0.0);
    bench.rest();
    told(&mut bench);
    let value = 1.2 * bench.twin.status(bench.now).residual_v1;
    let measured = ResidualMeasurement {
        quantity: Quantity::Displacement,
        height: 1.0,
        value,
        deviation: 1e-4,
        source: "test".into(),
    };
    let done = bench.handle(Command::CorrectDamage(measured));
    assert!(matches!(done, Ok(Accepted::DamageCorrected(_))), "{done:?}");
    let status = bench.twin.status(bench.now);
    let assessed = status.assessed.as_ref().expect("assessed");
    assert_eq!(assessed.second_opinion, None);
    hit(&mut bench, "b", 3.0, 0.0);
    bench.rest();
    let answer = told(&mut bench);
    let [along, _] = answer.beam.displaced_before_m;
    assert!((along - value).abs() < 1e-5, "{along} {value}");
    // A third hit finds what the second one has left.
    hit(&mut bench, "c", 3.0, 0.0);
    bench.rest();
    let [before, _] = told(&mut bench).beam.displaced_before_m;
    let left = along + answer.beam.residual_displacement_m;
    assert!((before - left).abs() < 1e-6, "{before} {left}");
}

/// A vehicle at right angles to the plane of the two bars does nothing to them.
#[test]
fn the_two_bars_do_not_see_a_hit_at_right_angles() {
    let mut bench = bench();
    hit(&mut bench, "a", 8.0, FRAC_PI_2);
    bench.rest();
    let report = &bench.reports()[0].report;
    assert!(report.max_v1.abs() < 1e-6, "{}", report.max_v1);
    let answer = told(&mut bench);
    assert!(answer.beam.max_displacement_m > 0.05);
    let assessed = bench.twin.status(bench.now).assessed.expect("assessed");
    let opinion = assessed.second_opinion.clone().expect("a second opinion");
    assert_eq!(opinion.ratio_to_two_bars, None);
    assert!(opinion.decides);
}

/// A prediction out of the plane awaits the second opinion, and with it is what the twin tells of the same impact afterwards, also on a
/// column that the beam has seen damaged; in the plane it has none, except where the beam governs.
#[test]
fn a_prediction_out_of_the_plane_is_that_of_both_models() {
    let mut bench = bench();
    for (id, velocity, direction) in [("a", 6.0, 0.2), ("b", 4.0, FRAC_PI_2)] {
        let mut asked = event(id, bench.now).impact;
        (asked.velocity, asked.height, asked.direction) = (velocity, Some(1.0), Some(direction));
        let snapshot = bench.twin.snapshot();
        let predict = || snapshot.predict("", "rigid", &asked, &|| 0);
        let prediction = predict().expect("a prediction");
        assert_eq!(prediction.opinion, OpinionState::Awaited);
        let found = prediction.opinion_task().expect("awaited").compute();
        let prediction = prediction.with_opinion(&found);
        assert_eq!(prediction.opinion, OpinionState::Known);
        assert!(prediction.opinion_task().is_none());
        hit(&mut bench, id, velocity, direction);
        bench.rest();
        assert_eq!(*computed(&bench), *found);
        told(&mut bench);
        let assessed = bench.twin.status(bench.now).assessed.expect("assessed");
        let predicted = prediction.assessed.expect("assessed");
        assert_eq!(predicted.second_opinion, assessed.second_opinion);
        assert_eq!(predicted.assessment, assessed.assessment);
        // Without an answer it is that of the two bars, and says why.
        let alone = predict().expect("a prediction").without_opinion("too busy");
        assert_eq!(alone.opinion, OpinionState::None("too busy".into()));
        assert!(alone.assessed.expect("assessed").second_opinion.is_none());
    }
    let in_plane = |bench: &Bench| {
        let snapshot = bench.twin.snapshot();
        let impact = event("c", bench.now).impact;
        snapshot
            .predict("", "rigid", &impact, &|| 0)
            .expect("a prediction")
    };
    match in_plane(&bench).opinion {
        OpinionState::None(reason) => assert!(reason.contains("out of the plane"), "{reason}"),
        other => panic!("{other:?}"),
    }
    let governing = parameters().with_changes([("beam.mode", Value::from("governing"))]);
    let governing = Bench::with(governing.expect("admissible"), None);
    assert!(in_plane(&governing).opinion_task().is_some());
}
