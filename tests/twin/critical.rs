//! Critical velocities of the column at rest: how hard it may be hit next.

use std::sync::Arc;

use column_twin::assessment::Action;
use column_twin::column::{ImpactSpecification, Model};
use column_twin::parameters::{Value, vehicle_catalogue};
use column_twin::study::{LIMIT_VELOCITIES, StudyColumn, VehicleLimits, vehicle_limits};
use column_twin::twin::{Accepted, Checkpoint, Command, Output, Status, Twin};

use super::{Bench, MS, event, light};

fn hit(bench: &mut Bench, velocity: f64) {
    let mut event = event("a", bench.now);
    event.impact.velocity = velocity;
    bench.hit(event);
}

type Limits = Arc<[VehicleLimits]>;

fn compute(bench: &Bench) -> Limits {
    let task = bench.twin.critical_velocity_task().expect("awaited");
    task.compute(&mut || true).expect("not abandoned")
}

fn give(bench: &mut Bench, vehicles: &Limits) -> Result<Accepted, column_twin::twin::Rejection> {
    bench.handle(Command::CriticalVelocities {
        vehicles: Arc::clone(vehicles),
    })
}

fn status(bench: &Bench) -> Status {
    bench.twin.status(bench.now)
}

fn known(bench: &Bench) -> Option<Limits> {
    status(bench).critical_velocities
}

/// By the library alone, from what a recording has of the column at rest.
fn of_checkpoint(checkpoint: &Checkpoint, at_rest: Action) -> Vec<VehicleLimits> {
    let mut properties = checkpoint.parameters.column_properties();
    properties.length_below = checkpoint.length_below;
    properties.length_above = checkpoint.length_above;
    let model = Model::new(&properties).expect("a column");
    let column = StudyColumn::at_rest(&checkpoint.parameters, model, checkpoint.state);
    vehicle_limits(&column.expect("stands"), at_rest, &mut || true).expect("computed")
}

#[test]
fn the_status_contains_those_of_the_damaged_column_and_after_a_reset_those_of_the_undamaged_one() {
    let mut bench = Bench::new(&[]);
    assert_eq!(known(&bench), None);
    let undamaged = compute(&bench);
    assert_eq!(undamaged.len(), 1 + vehicle_catalogue().len());
    assert_eq!(give(&mut bench, &undamaged), Ok(Accepted::Applied));
    assert_eq!(known(&bench).as_ref(), Some(&undamaged));
    assert!(bench.twin.critical_velocity_task().is_none());

    hit(&mut bench, 5.0);
    assert_eq!(known(&bench), None, "the column moves");
    assert!(bench.twin.critical_velocity_task().is_none());
    bench.go_on(3_000 * MS);
    assert!(!bench.twin.is_responding());
    assert_eq!(
        known(&bench),
        None,
        "they were those of the undamaged column"
    );

    let damaged = compute(&bench);
    assert_eq!(give(&mut bench, &damaged), Ok(Accepted::Applied));
    bench.go_on(MS);
    let last = bench.out.iter().rev().find_map(|it| match it {
        Output::Status(status) => status.critical_velocities.clone(),
        _ => None,
    });
    assert_eq!(last.as_ref(), Some(&damaged));
    let action = status(&bench).assessed.expect("assessed").assessment.action;
    let checkpoint = bench.twin.checkpoint(bench.now).expect("at rest");
    assert_eq!(*damaged, *of_checkpoint(&checkpoint, action));
    assert_ne!(damaged, undamaged);

    // A twin that continues from the checkpoint knows the same.
    let continued = Twin::from_checkpoint(&checkpoint, Box::new(|| 0)).expect("a column");
    let its = continued.status(bench.now).critical_velocities;
    assert_eq!(its.as_ref(), Some(&damaged));

    let reset = Command::Reset {
        source: "test".into(),
    };
    bench.handle(reset).expect("accepted");
    assert_eq!(known(&bench), None);
    assert_eq!(compute(&bench), undamaged);
}

/// Every value against the prediction of the twin, which shares neither the search nor the evaluation: below the critical velocity the
/// action is lower, 1 % above it is reached.
#[test]
fn the_prediction_of_an_impact_confirms_them() {
    let mut bench = Bench::new(&[]);
    hit(&mut bench, 4.0);
    bench.go_on(3_000 * MS);
    confirm_by_predictions(&bench);
}

/// On a column that is given by its height, car, lorry and forklift truck strike at heights of their own, and so they do where
/// nothing but an event names a vehicle. They once had the height of the vehicle of the parameters.
#[test]
fn the_prediction_confirms_them_where_each_vehicle_strikes_at_its_own_height() {
    let height = ("geometry.height", Value::from(4.0));
    for vehicle in ["mid_car", "rigid"] {
        let bench = Bench::new(&[height.clone(), ("vehicle.name", Value::from(vehicle))]);
        confirm_by_predictions(&bench);
        let limits = compute(&bench);
        let one_height = Bench::new(&[("vehicle.name", Value::from(vehicle))]);
        let at_one_height = compute(&one_height);
        let of = |limits: &Limits, name: &str| {
            let found = limits.iter().skip(1).find(|it| &*it.vehicle == name);
            found.expect("in the catalogue").restrict
        };
        for name in ["suv", "lorry_8t", "forklift"] {
            assert_ne!(of(&limits, name), of(&at_one_height, name), "{name}");
        }
    }
}

fn confirm_by_predictions(bench: &Bench) {
    let at_rest = status(bench).assessed.expect("assessed").assessment.action;
    let predicted = |limits: &VehicleLimits, velocity: f64| {
        let impact = ImpactSpecification {
            mass: limits.mass,
            velocity,
            gap: Some(0.0),
            restitution: None,
            height: None,
            direction: None,
        };
        let snapshot = bench.twin.snapshot();
        let prediction = snapshot.predict("", &limits.vehicle, &impact, &|| 0);
        let assessed = prediction.expect("computed").assessed;
        assessed.map_or(Action::Evacuate, |it| it.assessment.action)
    };
    let mut checked = 0;
    for limits in compute(bench).iter().skip(1) {
        for (action, velocity) in [
            (Action::Restrict, limits.restrict),
            (Action::Evacuate, limits.evacuate),
        ] {
            match velocity {
                None => assert!(predicted(limits, LIMIT_VELOCITIES[1]) < action),
                Some(0.0) if action <= at_rest => {}
                Some(0.0) => assert!(predicted(limits, LIMIT_VELOCITIES[0]) >= action),
                Some(velocity) => {
                    assert!(predicted(limits, velocity) < action, "{limits:?}");
                    assert!(predicted(limits, 1.01 * velocity) >= action, "{limits:?}");
                    checked += 1;
                }
            }
        }
    }
    assert!(checked >= 5, "{checked}");
}

#[test]
fn values_that_come_during_a_response_change_nothing() {
    let run = |background: bool| {
        let mut bench = Bench::new(&[]);
        let late = compute(&bench);
        hit(&mut bench, 5.0);
        bench.go_on(10 * MS);
        if background {
            assert_eq!(give(&mut bench, &late), Ok(Accepted::Unchanged));
        }
        bench.go_on(3_000 * MS);
        assert_eq!(known(&bench), None);
        let outputs = bench.out.into_iter().filter_map(|it| match it {
            Output::State(it) => Some(format!("{it:?}")),
            Output::Forecast(it) | Output::Report(it) => Some(format!("{it:?}")),
            _ => None,
        });
        outputs.collect::<Vec<_>>()
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn an_impact_that_leaves_no_trace_keeps_them_and_a_parameter_does_not() {
    let mut bench = Bench::new(&[]);
    let undamaged = compute(&bench);
    give(&mut bench, &undamaged).expect("accepted");
    bench.hit(light("a", bench.now));
    bench.go_on(3_000 * MS);
    assert_eq!(known(&bench), Some(undamaged));
    let change = Command::SetParameters {
        changes: vec![("top.load".to_owned(), 1e5.into())],
        source: "test".into(),
    };
    bench.handle(change).expect("accepted");
    assert_eq!(known(&bench), None);
    assert!(bench.twin.critical_velocity_task().is_some());
}

#[test]
fn on_a_collapsed_column_no_velocity_is_admissible_and_nothing_is_computed() {
    let mut bench = Bench::new(&[]);
    hit(&mut bench, 30.0);
    bench.go_on(5_000 * MS);
    let task = bench.twin.critical_velocity_task().expect("assessed");
    let limits = task.compute(&mut || false).expect("without a response");
    assert!(!limits.is_empty());
    for it in limits.iter() {
        assert_eq!((it.restrict, it.evacuate), (Some(0.0), Some(0.0)));
    }
}

#[test]
fn a_computation_can_be_abandoned() {
    let bench = Bench::new(&[]);
    let task = bench.twin.critical_velocity_task().expect("awaited");
    let mut responses = 0;
    let go_on = &mut || {
        responses += 1;
        responses <= 3
    };
    assert_eq!(task.compute(go_on), None);
    assert_eq!(responses, 4);
}
