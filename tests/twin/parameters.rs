//! Parameter changes: applied between two steps and as a whole, or rejected.

use column_twin::parameters::Value;
use column_twin::twin::{
    Accepted, Command, Output, ParametersChanged, RejectedInput, Rejection, RejectionCode,
};

use crate::{Bench, MS, START, event, light};

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
fn changes_at_rest_apply_immediately() {
    let mut bench = Bench::new(&[]);
    bench.change(&[
        ("section.name", "HEB300".into()),
        ("impact.gap", 0.1.into()),
    ]);
    assert_eq!(changed(&bench)[0].change, Accepted::Applied);
    // Nobody has given the rest of this column.
    let expected = ["section.name", "impact.gap", "assessment.assumed"];
    assert_eq!(changed(&bench)[0].names, expected);
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
fn one_invalid_value_rejects_the_whole_change() {
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
    let Rejection { code, reason } = outcome.expect_err("rejected");
    assert_eq!(code, RejectionCode::ParametersInvalid);
    assert!(
        reason.contains("impact.velocity") && reason.contains("impact.mass"),
        "{reason}"
    );
    assert_eq!(*bench.twin.parameters(), before);
    assert_eq!(bench.rejections()[0].what, RejectedInput::Parameters);
    let status = bench.status();
    assert_eq!(
        (
            status.counts.parameters_rejected,
            status.counts.parameters_accepted
        ),
        (1, 0)
    );
    assert_eq!(status.last_rejection_reason, reason);
}

#[test]
fn a_column_without_equilibrium_is_rejected() {
    let mut bench = Bench::new(&[]);
    bench.change(&[("top.load", 1e9.into())]);
    assert!(
        bench.rejections()[0].rejection.reason.contains("squash"),
        "{:?}",
        bench.rejections()
    );
    assert_eq!(value(&bench, "top.load"), Value::Double(5e5));
}

#[test]
fn parameters_that_need_a_restart_are_read_only() {
    let mut bench = Bench::new(&[]);
    bench.change(&[("column_id", "other".into()), ("top.load", 4e5.into())]);
    assert!(
        bench.rejections()[0]
            .rejection
            .reason
            .contains("column_id cannot be changed while the node runs")
    );
    assert_eq!(value(&bench, "top.load"), Value::Double(5e5));
}

#[test]
fn changes_during_a_response_wait_for_its_end() {
    let mut bench = Bench::new(&[]);
    let mut undisturbed = Bench::new(&[]);
    bench.hit(event("a", START));
    undisturbed.hit(event("a", START));
    bench.go_on(5 * MS);
    bench.change(&[("top.load", 4e5.into()), ("impact.gap", 0.05.into())]);
    bench.change(&[("damping.ratio", 0.02.into())]);
    let told = changed(&bench);
    assert!(told.iter().all(|it| it.change == Accepted::Waiting));
    assert_eq!(told[0].waiting, ["top.load", "impact.gap"]);
    assert_eq!(told[1].waiting, ["top.load", "impact.gap", "damping.ratio"]);
    // What is announced is what holds.
    assert!(
        told.iter()
            .all(|it| it.parameters == *bench.twin.parameters())
    );
    assert_eq!(value(&bench, "top.load"), Value::Double(5e5));
    assert_eq!(
        value(&bench, "impact.gap"),
        Value::Double(0.0),
        "no change is applied in part"
    );
    bench.rest();
    undisturbed.rest();
    assert_eq!(bench.reports()[0].report, undisturbed.reports()[0].report);
    let last = changed(&bench)[2];
    assert_eq!(last.change, Accepted::Applied);
    assert_eq!(last.names, ["top.load", "impact.gap", "damping.ratio"]);
    assert!(last.waiting.is_empty());
    assert_eq!(value(&bench, "top.load"), Value::Double(4e5));
    assert_ne!(bench.status().residual_v1, undisturbed.status().residual_v1);
}

#[test]
fn some_changes_apply_during_a_response() {
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
fn the_properties_of_a_damaged_column_cannot_change() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.rest();
    for change in [
        ("section.name", Value::from("HEB300")),
        ("geometry.length_below", 1.1.into()),
        ("steel.grade", "S235".into()),
        ("support.top", "pinned".into()),
    ] {
        let before = bench.rejections().len();
        bench.change(&[change]);
        assert_eq!(bench.rejections().len(), before + 1);
        assert!(
            bench.rejections()[before]
                .rejection
                .reason
                .contains("reset the twin before changing them")
        );
    }
    bench.change(&[("top.load", 4e5.into()), ("solver.dt", 2e-5.into())]);
    assert_eq!(bench.rejections().len(), 4);
    bench.change(&[("top.load", 2.9e6.into())]);
    assert!(
        bench.rejections()[4]
            .rejection
            .reason
            .contains("the damaged column has no equilibrium"),
        "{:?}",
        bench.rejections()[4]
    );
    bench.reset();
    bench.change(&[("section.name", "HEB300".into())]);
    assert_eq!(bench.rejections().len(), 5);
}

/// A set was accepted during a response, and undone at its end because the column was damaged by then. What the response
/// will leave behind is known after milliseconds: it is rejected at once, with the reason.
#[test]
fn a_change_that_the_damage_of_the_response_forbids_is_rejected_at_once() {
    let properties = ("section.name", Value::from("HEB300"));
    let without_equilibrium = ("top.load", Value::from(2.9e6));
    for (change, code, words) in [
        (
            properties,
            RejectionCode::ColumnDamaged,
            "reset the twin before changing them",
        ),
        (
            without_equilibrium,
            RejectionCode::NoEquilibrium,
            "has no equilibrium",
        ),
    ] {
        let mut bench = Bench::new(&[]);
        let mut undisturbed = Bench::new(&[]);
        bench.hit(event("a", START));
        undisturbed.hit(event("a", START));
        // Before any step was made, and before the forecast is known.
        bench.change(&[change]);
        let rejected = bench.rejections();
        let [rejected] = &rejected[..] else {
            panic!("{rejected:?}");
        };
        assert_eq!(rejected.rejection.code, code);
        let reason = &rejected.rejection.reason;
        assert!(
            reason.contains("when the response to the impact ends"),
            "{reason}"
        );
        assert!(reason.contains(words), "{reason}");
        assert!(changed(&bench).is_empty());
        bench.rest();
        undisturbed.rest();
        assert_eq!(bench.rejections().len(), 1);
        // The forecast was only computed earlier.
        let forecasts =
            |bench: &Bench| -> Vec<_> { bench.forecasts().iter().map(|it| it.report).collect() };
        assert_eq!(forecasts(&bench), forecasts(&undisturbed));
        assert_eq!(bench.reports()[0].report, undisturbed.reports()[0].report);
    }
}

/// A change of the section waits for the end of an elastic response.
fn section_changed_after_a_light_impact() -> Bench {
    let mut bench = Bench::new(&[]);
    bench.hit(light("a", START));
    bench.go_on(MS);
    bench.change(&[("section.name", "HEB300".into())]);
    bench
}

/// A response that leaves no damage lets the properties change at its end.
#[test]
fn properties_change_after_an_elastic_response() {
    let mut bench = section_changed_after_a_light_impact();
    assert!(bench.rejections().is_empty(), "{:?}", bench.rejections());
    assert_eq!(value(&bench, "section.name"), Value::from("HEB220"));
    bench.rest();
    assert_eq!(value(&bench, "section.name"), Value::from("HEB300"));
}

/// A second impact, which was not predicted, may damage the column before the change takes effect.
#[test]
fn a_waiting_change_can_be_rejected_at_the_end_of_the_response() {
    let mut bench = section_changed_after_a_light_impact();
    assert!(bench.rejections().is_empty());
    let now = bench.now;
    bench.hit(event("b", now));
    bench.rest();
    assert!(
        bench.rejections()[0]
            .rejection
            .reason
            .contains("waited for the end of the response")
    );
    assert_eq!(value(&bench, "section.name"), Value::from("HEB220"));
    // It never held, and waits no longer.
    let told: Vec<_> = changed(&bench)
        .iter()
        .map(|it| {
            (
                it.change,
                it.waiting.len(),
                it.parameters.get("section.name"),
            )
        })
        .collect();
    let section = || Some(Value::from("HEB220"));
    assert_eq!(
        told,
        [
            // The section, and what nobody has given of it.
            (Accepted::Waiting, 2, section()),
            (Accepted::Unchanged, 0, section())
        ]
    );
}

/// Changes that cannot be read or are for another column are counted and reported like any other rejected change.
#[test]
fn a_change_rejected_before_the_twin_is_reported() {
    let mut bench = Bench::new(&[]);
    let rejection = Rejection::new(
        RejectionCode::OtherColumn,
        "the message is for another column",
    );
    let outcome = bench.handle(Command::RejectedChange {
        rejection: rejection.clone(),
        source: "test".into(),
    });
    assert_eq!(outcome, Err(rejection));
    assert_eq!(bench.rejections()[0].what, RejectedInput::Parameters);
    let status = bench.status();
    assert_eq!(status.counts.parameters_rejected, 1);
    assert_eq!(
        &*status.last_rejection_reason,
        "the message is for another column"
    );
    assert_eq!(status.last_rejection_code, Some(RejectionCode::OtherColumn));
}

#[test]
fn equal_values_change_nothing() {
    let mut bench = Bench::new(&[]);
    bench.change(&[("top.load", 5e5.into())]);
    assert!(changed(&bench).is_empty() && bench.rejections().is_empty());
    assert_eq!(bench.status().counts.parameters_accepted, 1);
}

#[test]
fn a_new_publish_rate_applies_to_the_next_response() {
    let mut bench = Bench::new(&[]);
    bench.change(&[("publish_rate", 100.0.into())]);
    bench.hit(event("a", START));
    bench.rest();
    let states = bench.states();
    assert_eq!(states[1].stamp - states[0].stamp, 10 * MS);
}

/// Of a sensor that is added, the rejection names what was given, and not all that the sensor would have.
#[test]
fn sensors_cannot_be_added_while_the_node_runs() {
    let mut bench = Bench::new(&[]);
    let before = bench.twin.parameters().clone();
    let outcome = bench.handle(Command::SetParameters {
        changes: vec![
            ("sensors.laser.quantity".into(), "displacement".into()),
            ("sensors.laser.height".into(), 1.0.into()),
            ("sensors.names".into(), vec!["laser".to_owned()].into()),
        ],
        source: "test".into(),
    });
    let Rejection { code, reason } = outcome.expect_err("rejected");
    assert_eq!(code, RejectionCode::ParametersReadOnly);
    assert_eq!(
        &*reason,
        "sensors.names, sensors.laser.quantity, sensors.laser.height cannot be changed while the node runs; restart it with the new value"
    );
    assert_eq!(*bench.twin.parameters(), before);
}
