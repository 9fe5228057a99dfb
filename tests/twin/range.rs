//! The range of the verdict on an impact: computed behind the forecast, and part of forecast, report and status from then on.

use std::sync::Arc;

use column_twin::assessment::{ActionRange, VerdictRange};
use column_twin::parameters::Value;
use column_twin::second_opinion::evaluate;
use column_twin::twin::{
    Accepted, BackgroundTask, Checkpoint, Command, Output, SupplementedReport, Twin,
};

use super::{Bench, MS, event, parameters};

fn hit(bench: &mut Bench, id: &str, velocity: f64) {
    let mut event = event(id, bench.now);
    event.impact.velocity = velocity;
    bench.hit(event);
}

/// With the second opinion before it.
fn computed(bench: &mut Bench) -> Arc<VerdictRange> {
    if let Some(task) = bench.twin.opinion_task() {
        let given = bench.handle(Command::SecondOpinion(task.compute()));
        assert_eq!(given, Ok(Accepted::Applied));
    }
    let task = bench.twin.range_task().expect("awaited");
    task.compute(&mut || true).expect("not abandoned")
}

fn ranged(bench: &Bench) -> Vec<&SupplementedReport> {
    let all = bench.out.iter().filter_map(|it| match it {
        Output::Supplemented(again) if again.report.range.is_some() => Some(again),
        _ => None,
    });
    all.collect()
}

/// By the library alone, as `column-twin simulate` computes it, with the beam at a second hardening.
fn by_simulation(velocity: f64) -> ActionRange {
    let parameters = parameters(&[("impact.velocity", Value::from(velocity))]);
    let evaluated = evaluate(&parameters).expect("a column");
    evaluated.evaluation.range.expect("assessed")
}

#[test]
fn it_is_that_of_a_simulation_and_is_awaited_once_the_forecast_is_complete() {
    let mut bench = Bench::new(&[]);
    assert!(!bench.twin.awaits_range(), "nothing has happened");
    hit(&mut bench, "a", 5.0);
    assert!(!bench.twin.awaits_range(), "there is no forecast yet");
    bench.twin.run_ahead(u64::MAX, bench.now, &mut bench.out);
    assert!(!bench.twin.awaits_range(), "there is no second opinion yet");
    let range = computed(&mut bench);
    assert!(bench.twin.awaits_range());
    let first = bench.twin.background_tasks().next().expect("a task");
    assert!(matches!(first, BackgroundTask::Range(_)), "before all else");
    assert_eq!(*range, by_simulation(5.0).ends);

    let given = bench.handle(Command::VerdictRange(Arc::clone(&range)));
    assert_eq!(given, Ok(Accepted::Applied));
    assert!(!bench.twin.awaits(&first));
    let forecast = bench.forecasts()[1].clone();
    let [again] = ranged(&bench)[..] else {
        panic!("{:?}", ranged(&bench));
    };
    assert!(!again.is_result);
    assert_eq!(again.report.report, forecast.report);
    assert_eq!(again.report.error_estimate, forecast.error_estimate);
    assert_eq!(again.report.range.as_ref(), Some(&range));
    let status = bench.twin.status(bench.now);
    assert_eq!(status.range, None, "the column at rest was not hit");

    bench.rest();
    assert_eq!(bench.reports()[0].range.as_ref(), Some(&range));
    let status = bench.twin.status(bench.now);
    assert_eq!(status.range.as_ref(), Some(&range));
    assert!(!bench.twin.awaits_range());
}

/// A twin that continues from a checkpoint gives out the same report with the same range.
#[test]
fn after_the_response_the_report_is_given_out_once_more() {
    let mut bench = Bench::new(&[]);
    hit(&mut bench, "a", 5.0);
    bench.rest();
    assert_eq!(bench.reports()[0].range, None);
    let range = computed(&mut bench);
    let checkpoint = bench.twin.checkpoint(bench.now).expect("at rest");
    let text = serde_json::to_string(&checkpoint).expect("JSON");
    let read: Checkpoint = serde_json::from_str(&text).expect("a checkpoint");
    assert_eq!(read, checkpoint);
    let mut continued = Bench::new(&[]);
    continued.twin = Twin::from_checkpoint(&read, Box::new(|| 0)).expect("a column");
    continued.now = bench.now;
    assert_eq!(computed(&mut continued), range);
    let report = bench.reports()[0].clone();
    for bench in [&mut bench, &mut continued] {
        let given = bench.handle(Command::VerdictRange(Arc::clone(&range)));
        assert_eq!(given, Ok(Accepted::Applied));
        let [again] = ranged(bench)[..] else {
            panic!("{:?}", ranged(bench));
        };
        assert!(again.is_result);
        assert_eq!(again.report.report, report.report);
        assert_eq!(again.report.event_id, report.event_id);
        assert_eq!(again.report.error_estimate, report.error_estimate);
        assert_eq!(again.report.assessed, bench.twin.status(bench.now).assessed);
        assert_eq!(again.report.range.as_ref(), Some(&range));
        let status = bench.twin.status(bench.now);
        assert_eq!(status.range.as_ref(), Some(&range));
        // It is known now, and what comes twice is left aside.
        let given = bench.handle(Command::VerdictRange(Arc::clone(&range)));
        assert_eq!(given, Ok(Accepted::Unchanged));
        assert_eq!(ranged(bench).len(), 1);
    }
}

#[test]
fn another_impact_or_a_reset_withdraws_what_is_not_known_yet() {
    let reset = |bench: &mut Bench| bench.reset();
    let second = |bench: &mut Bench| hit(bench, "b", 1.0);
    let ways: [&dyn Fn(&mut Bench); 2] = [&reset, &second];
    for during in [true, false] {
        for way in ways {
            let mut bench = Bench::new(&[]);
            hit(&mut bench, "a", 5.0);
            match during {
                true => bench.go_on(20 * MS),
                false => bench.rest(),
            }
            let late = computed(&mut bench);
            let task = bench.twin.background_tasks().next().expect("a task");
            way(&mut bench);
            assert!(!bench.twin.awaits(&task));
            let given = bench.handle(Command::VerdictRange(late));
            assert_eq!(given, Ok(Accepted::Unchanged));
            bench.twin.run_ahead(u64::MAX, bench.now, &mut bench.out);
            if during {
                assert!(!bench.twin.awaits_range(), "it was moving, or is new");
            }
            bench.rest();
            assert!(ranged(&bench).is_empty());
            assert_eq!(bench.twin.status(bench.now).range, None);
        }
    }
}

/// The verdict on a damaged column had no range. What is varied are the assumptions about the second impact, and each variation is what
/// `~/predict` answers.
#[test]
fn it_is_that_of_the_predictions_of_a_damaged_column() {
    let mut bench = Bench::new(&[]);
    hit(&mut bench, "a", 5.0);
    bench.rest();
    let snapshot = bench.twin.snapshot();
    let before = snapshot.standing().expect("it stands").expect("at rest");
    assert!(before.damage.is_some());
    let (mut ends, mut wide) = (Vec::new(), 0);
    for velocity in [1.0, 2.0, 3.0, 4.0, 5.0, 6.0] {
        let mut bench = Bench::new(&[]);
        hit(&mut bench, "a", 5.0);
        bench.rest();
        hit(&mut bench, "b", velocity);
        bench.twin.run_ahead(u64::MAX, bench.now, &mut bench.out);
        let range = computed(&mut bench);
        let predicted = [0.9, 1.1].map(|factor| {
            let mut impact = event("x", 0).impact;
            impact.velocity = velocity * (1.0 + (factor - 1.0));
            let prediction = snapshot.predict("", "", &impact, &|| 0);
            let assessed = prediction.expect("a prediction").assessed;
            assessed.expect("it is assessed").assessment.action
        });
        for action in predicted {
            assert!((range.least..=range.most).contains(&action), "{range}");
        }
        wide += usize::from(range.least < range.most);
        ends.push((predicted, range.to_string()));
        bench.rest();
        let given = bench.handle(Command::VerdictRange(Arc::clone(&range)));
        assert_eq!(given, Ok(Accepted::Applied));
        let checkpoint = bench.twin.checkpoint(bench.now).expect("at rest");
        let text = serde_json::to_string(&checkpoint).expect("JSON");
        let read: Checkpoint = serde_json::from_str(&text).expect("a checkpoint");
        let continued = Twin::from_checkpoint(&read, Box::new(|| 0)).expect("a column");
        let task = continued.range_task_at_rest().expect("it has a range");
        assert_eq!(task.compute(&mut || true), Some(range));
    }
    assert!(wide > 0, "{ends:?}");
}

#[test]
fn it_ends_with_a_correction_or_a_change_of_parameters() {
    let mut bench = Bench::new(&[]);
    hit(&mut bench, "a", 5.0);
    bench.rest();
    let range = computed(&mut bench);
    let _ = bench.handle(Command::VerdictRange(range));
    assert!(bench.twin.status(bench.now).range.is_some());
    bench.change(&[("top.load", Value::from(1e5))]);
    assert_eq!(bench.twin.status(bench.now).range, None);
    assert!(!bench.twin.awaits_range());
}
