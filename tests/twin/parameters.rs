//! Changes of parameters: between two steps, as a whole, or refused.

use column_twin::parameters::Value;
use column_twin::twin::{
    Accepted, Command, Output, ParametersChanged, Refusal, RefusalCode, RefusedInput,
};

use crate::{Bench, MS, START, event};

fn changed(bench: &Bench) -> Vec<&ParametersChanged> {
    bench.all(|it| {
        if let Output::ParametersChanged(it) = it {
            Some(it)
        } else {
            None
        }
    })
}

fn value(bench: &Bench, name: &str) -> Value {
    bench.twin.parameters().get(name).expect(name)
}

#[test]
fn at_rest_they_apply_at_once() {
    let mut bench = Bench::new(&[]);
    bench.change(&[
        ("section.name", "HEB300".into()),
        ("impact.gap", 0.1.into()),
    ]);
    assert_eq!(changed(&bench)[0].change, Accepted::Applied);
    assert_eq!(changed(&bench)[0].names, ["section.name", "impact.gap"]);
    let mut other = Bench::new(&[
        ("section.name", "HEB300".into()),
        ("impact.gap", 0.1.into()),
    ]);
    for bench in [&mut bench, &mut other] {
        bench.hit(event("a", START));
        bench.rest();
    }
    assert_eq!(bench.reports()[0].report, other.reports()[0].report);
}

#[test]
fn one_wrong_value_refuses_all_of_them() {
    let mut bench = Bench::new(&[]);
    let before = bench.twin.parameters().clone();
    let outcome = bench.handle(Command::SetParameters {
        changes: vec![
            ("top.load".into(), 4e5.into()),
            ("impact.velocity".into(), 1e9.into()),
            ("impact.mas".into(), 1.0.into()),
        ],
        source: "test".into(),
    });
    let Refusal { code, reason } = outcome.expect_err("refused");
    assert_eq!(code, RefusalCode::ParametersInvalid);
    assert!(
        reason.contains("impact.velocity") && reason.contains("impact.mass"),
        "{reason}"
    );
    assert_eq!(*bench.twin.parameters(), before);
    assert_eq!(bench.refusals()[0].what, RefusedInput::Parameters);
    let status = bench.status();
    assert_eq!(
        (
            status.counts.parameters_refused,
            status.counts.parameters_accepted
        ),
        (1, 0)
    );
    assert_eq!(status.last_refusal_reason, reason);
}

#[test]
fn a_column_that_would_not_stand_is_refused() {
    let mut bench = Bench::new(&[]);
    bench.change(&[("top.load", 1e9.into())]);
    assert!(
        bench.refusals()[0].refusal.reason.contains("squash"),
        "{:?}",
        bench.refusals()
    );
    assert_eq!(value(&bench, "top.load"), Value::Double(5e5));
}

#[test]
fn what_needs_a_restart_is_read_only() {
    let mut bench = Bench::new(&[]);
    bench.change(&[("column_id", "other".into()), ("top.load", 4e5.into())]);
    assert!(
        bench.refusals()[0]
            .refusal
            .reason
            .contains("column_id cannot be changed while the node runs")
    );
    assert_eq!(value(&bench, "top.load"), Value::Double(5e5));
}

#[test]
fn during_a_response_they_wait_for_its_end() {
    let mut bench = Bench::new(&[]);
    let mut undisturbed = Bench::new(&[]);
    bench.hit(event("a", START));
    undisturbed.hit(event("a", START));
    bench.go_on(5 * MS);
    bench.change(&[("top.load", 4e5.into()), ("impact.gap", 0.05.into())]);
    bench.change(&[("damping.ratio", 0.02.into())]);
    let waiting: Vec<_> = changed(&bench).iter().map(|it| it.change).collect();
    assert_eq!(waiting, [Accepted::Waiting, Accepted::Waiting]);
    assert_eq!(value(&bench, "top.load"), Value::Double(5e5));
    assert_eq!(
        value(&bench, "impact.gap"),
        Value::Double(0.0),
        "nothing is half applied"
    );
    bench.rest();
    undisturbed.rest();
    assert_eq!(bench.reports()[0].report, undisturbed.reports()[0].report);
    let last = changed(&bench)[2];
    assert_eq!(last.change, Accepted::Applied);
    assert_eq!(last.names, ["top.load", "impact.gap", "damping.ratio"]);
    assert_eq!(value(&bench, "top.load"), Value::Double(4e5));
    assert_ne!(bench.status().residual_v1, undisturbed.status().residual_v1);
}

#[test]
fn those_that_apply_at_once_do_so_during_a_response() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.go_on(5 * MS);
    bench.change(&[("top.load", 4e5.into())]);
    bench.change(&[("impact.gap", 0.05.into())]);
    assert_eq!(value(&bench, "impact.gap"), Value::Double(0.05));
    assert_eq!(value(&bench, "top.load"), Value::Double(5e5));
    bench.rest();
    assert_eq!(value(&bench, "impact.gap"), Value::Double(0.05));
    assert_eq!(value(&bench, "top.load"), Value::Double(4e5));
}

#[test]
fn a_damaged_column_stays_the_column_that_it_is() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.rest();
    for change in [
        ("section.name", Value::from("HEB300")),
        ("geometry.length_below", 1.1.into()),
        ("steel.grade", "S235".into()),
        ("support.top", "pinned".into()),
    ] {
        let before = bench.refusals().len();
        bench.change(&[change]);
        assert_eq!(bench.refusals().len(), before + 1);
        assert!(
            bench.refusals()[before]
                .refusal
                .reason
                .contains("reset the twin first")
        );
    }
    bench.change(&[("top.load", 4e5.into()), ("solver.dt", 2e-5.into())]);
    assert_eq!(bench.refusals().len(), 4);
    bench.change(&[("top.load", 2.9e6.into())]);
    assert!(
        bench.refusals()[4]
            .refusal
            .reason
            .contains("does not stand"),
        "{:?}",
        bench.refusals()[4]
    );
    bench.reset();
    bench.change(&[("section.name", "HEB300".into())]);
    assert_eq!(bench.refusals().len(), 5);
}

/// A change that waited, and that the damage of the response forbids, is refused at its end.
#[test]
fn a_change_that_waited_can_still_be_refused() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.go_on(MS);
    bench.change(&[("section.name", "HEB300".into())]);
    assert!(bench.refusals().is_empty());
    bench.rest();
    assert!(
        bench.refusals()[0]
            .refusal
            .reason
            .contains("waited for the end of the response")
    );
    assert_eq!(value(&bench, "section.name"), Value::from("HEB220"));
    // Whoever was told that it waits is told that it goes back.
    let told: Vec<_> = changed(&bench)
        .iter()
        .map(|it| it.parameters.get("section.name"))
        .collect();
    assert_eq!(
        told,
        [Some(Value::from("HEB300")), Some(Value::from("HEB220"))]
    );
}

/// What cannot be read, or is for another column, is counted and said like what the twin finds wrong itself.
#[test]
fn a_change_that_was_refused_before_is_said_too() {
    let mut bench = Bench::new(&[]);
    let refusal = Refusal::new(RefusalCode::OtherColumn, "they are for another column");
    let outcome = bench.handle(Command::RejectedChange {
        refusal: refusal.clone(),
        source: "test".into(),
    });
    assert_eq!(outcome, Err(refusal));
    assert_eq!(bench.refusals()[0].what, RefusedInput::Parameters);
    let status = bench.status();
    assert_eq!(status.counts.parameters_refused, 1);
    assert_eq!(&*status.last_refusal_reason, "they are for another column");
    assert_eq!(status.last_refusal_code, Some(RefusalCode::OtherColumn));
}

#[test]
fn the_same_values_again_change_nothing() {
    let mut bench = Bench::new(&[]);
    bench.change(&[("top.load", 5e5.into())]);
    assert!(changed(&bench).is_empty() && bench.refusals().is_empty());
    assert_eq!(bench.status().counts.parameters_accepted, 1);
}

#[test]
fn a_new_rate_applies_from_the_next_response_on() {
    let mut bench = Bench::new(&[]);
    bench.change(&[("publish_rate", 100.0.into())]);
    bench.hit(event("a", START));
    bench.rest();
    let states = bench.states();
    assert_eq!(states[1].stamp - states[0].stamp, 10 * MS);
}
