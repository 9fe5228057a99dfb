//! The live twin behind the node: what a reader receives in real time is what the simulation computes.

use std::time::Instant;

use column_twin::column::{Impact, Sample, simulate};
use column_twin::live::LiveOptions;
use column_twin::messages::column_twin::ColumnState;
use column_twin::parameters::{Parameters, Value};
use column_twin::ros::{ImpactOutcome, Names, Node, StartedTwin, TwinNode, qos, start_live_twin};

use super::domain::Domain;
use super::loopback::{Incoming, PATIENCE, impact};

#[test]
fn the_stream_in_real_time_is_that_of_the_simulation() {
    let domain = Domain::fresh();
    // Without a state file.
    let parameters = Parameters::from_values([("state.directory", Value::from(""))]).unwrap();
    let mut steps = Vec::new();
    let of_event = Impact {
        mass: 1500.0,
        velocity: 1.0,
        gap: 0.0,
        restitution: 0.0,
    };
    let properties = parameters.column_properties();
    let mut observe = |sample: &Sample| steps.push(*sample);
    simulate(
        &properties,
        &of_event,
        parameters.response_duration(),
        &mut observe,
    )
    .unwrap();

    let started = start_live_twin(parameters, LiveOptions::default()).unwrap();
    let StartedTwin {
        twin,
        outputs,
        stop,
    } = started;
    let names = Names::new("/", "column_twin", &[]).unwrap();
    let node = TwinNode::start(&domain.environment, names, twin, outputs, None).unwrap();
    let names = Names::new("/", "reader", &[]).unwrap();
    let mut reader = Node::new(&domain.environment, names).unwrap();
    let states = Incoming::<ColumnState>::start(&mut reader, &qos::COLUMN_STATE);
    let forecast = match impact(&domain, 1500.0, PATIENCE) {
        Ok(ImpactOutcome::Forecast(forecast)) => forecast,
        other => panic!("{other:?}"),
    };
    println!("forecast computed in {} s", forecast.compute_time);
    // 50 steps of 20 microseconds for each sample, and the end.
    let last = steps.len() - 1;
    let expected = (0..last).step_by(50).chain([last]);
    let (mut first, mut count) = (None, 0);
    for step in expected {
        let state = states.next();
        let stamp = state.header.stamp.to_nanos().unwrap();
        let since = stamp - *first.get_or_insert(stamp);
        assert_eq!(
            since,
            20_000 * i64::try_from(step).unwrap(),
            "none is missing"
        );
        let mut of_step = ColumnState::from(&steps[step]);
        (of_step.header, of_step.phase) = (state.header.clone(), state.phase);
        (of_step.column_id, of_step.event_id) = ("column".to_owned(), forecast.event_id.clone());
        // The sum over the steps since the sample before.
        of_step.percussion = state.percussion;
        assert_eq!(state, of_step);
        assert_eq!(state.phase == ColumnState::REST, step == last);
        count += 1;
    }
    println!("{count} samples, {} steps", steps.len());
    let before = Instant::now();
    node.stop(stop);
    println!("stopped within {:?}", before.elapsed());
    drop(states);
}
