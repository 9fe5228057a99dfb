//! A vehicle that hits several columns: which impacts follow from its event, and what is left of the vehicle.

use std::sync::Arc;

use column_twin::fleet::{MAX_ROW_COLUMNS, MAX_ROWS, NotHit, RowImpact, Rows};
use column_twin::incoming::impact_command;
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::{ImpactEvent, RowImpactEvent};
use column_twin::messages::std_msgs::Header;
use column_twin::parameters::{Parameters, Value};
use column_twin::time::Nanos;
use column_twin::twin::{Command, NoticeLevel, Output, ReportOutput, Twin};

const START: Nanos = 1_800_000_000_000_000_000;
const SECOND: Nanos = 1_000_000_000;

fn row(columns: &[&str]) -> RowImpactEvent {
    RowImpactEvent {
        header: Header {
            stamp: Time::from_nanos(START).expect("a time"),
            frame_id: String::new(),
        },
        event_id: "lorry".to_owned(),
        vehicle: "lorry_16t".to_owned(),
        mass: f64::NAN,
        velocity: 20.0,
        gap: f64::NAN,
        restitution: f64::NAN,
        height: f64::NAN,
        direction: f64::NAN,
        column_ids: columns.iter().map(|it| (*it).to_owned()).collect(),
        offsets: Vec::new(),
        distances: vec![5.0; columns.len()],
    }
}

fn parameters(column: &str, section: &str) -> Arc<Parameters> {
    let values = [
        ("column_id", Value::from(column)),
        ("section.name", Value::from(section)),
        ("solver.dt", Value::from(1e-4)),
    ];
    Arc::new(Parameters::from_values(values).expect("admissible"))
}

/// The forecast of an impact on an undamaged column.
fn forecast(parameters: &Arc<Parameters>, event: &ImpactEvent) -> (Output, ReportOutput) {
    let stamp = event.header.stamp.to_nanos().expect("a time");
    let mut twin = Twin::new(Arc::clone(parameters), None, Box::new(|| 0), stamp).expect("stands");
    let Command::Impact(command) = impact_command(event.clone()) else {
        panic!("an impact");
    };
    let checked = twin.check_impact(&command, stamp).expect("admissible");
    let mut outputs: Vec<Output> = Vec::new();
    let accepted = twin.handle(Command::Impact(command), stamp, &mut outputs);
    accepted.expect("admissible");
    twin.run_ahead(u64::MAX, stamp, &mut outputs);
    let found = outputs.into_iter().find_map(|output| match &output {
        Output::Forecast(report) => Some((output.clone(), report.clone())),
        _ => None,
    });
    let found = found.expect("a forecast");
    assert_eq!(found.1.striking, checked);
    found
}

fn crush(
    parameters: &Parameters,
) -> impl Fn(&column_twin::twin::Striking, &column_twin::column::VehicleReport) -> Vec<f64> {
    let new = parameters
        .vehicle_named("lorry_16t")
        .expect("known")
        .expect("deformable");
    move |striking, report| {
        let before = column_twin::parameters::crush_of_name(&striking.vehicle).expect("valid");
        new.crush_after(&before, &report.max_crush)[..report.masses].to_vec()
    }
}

/// At any distance ahead of the clock.
fn due(rows: &mut Rows) -> Vec<ImpactEvent> {
    rows.due(START, |_| 100 * SECOND)
}

fn only(events: Vec<ImpactEvent>) -> ImpactEvent {
    let [event] = <[ImpactEvent; 1]>::try_from(events).expect("one impact");
    event
}

#[test]
fn a_vehicle_goes_on_with_what_a_column_leaves_of_it_until_one_stands() {
    // A slender column gives way to a lorry, a heavy one stops what is left.
    let slender = parameters("a1", "HEB 120");
    let second = parameters("a2", "HEB 120");
    let heavy = parameters("a3", "HEM 600");
    let mut rows = Rows::default();
    let event = RowImpact::new(row(&["a1", "a2", "a3", "a4"])).expect("right");
    rows.begin(event).expect("room");
    let first = only(due(&mut rows));
    assert_eq!(
        (first.event_id.as_str(), first.velocity),
        ("lorry/a1", 20.0)
    );
    let (output, found) = forecast(&slender, &first);
    let report = found.report;
    assert!(report.impactor_velocity > 1.0, "{report:?}");
    rows.take("a2", &output, crush(&slender));
    assert!(due(&mut rows).is_empty(), "it is of another column");
    rows.take("a1", &output, crush(&slender));
    let next = only(due(&mut rows));
    // The first impact takes exactly what the momentum of the vehicle has lost: nothing is created on the way.
    let lost = found.striking.impact.mass * (20.0 - report.impactor_velocity);
    assert!(
        (lost - report.impulse).abs() < 1e-6 * lost,
        "{lost} {}",
        report.impulse
    );
    assert_eq!(
        (next.column_id.as_str(), next.event_id.as_str()),
        ("a2", "lorry/a2")
    );
    assert_eq!(next.velocity, report.impactor_velocity);
    assert_eq!((next.mass, next.gap), (16_000.0, 0.0));
    assert_eq!(
        next.vehicle,
        format!("lorry_16t@{:.6}", report.vehicle.max_crush[0])
    );
    // The way from where the vehicle was at the end of the response, at its speed then.
    let contact = next.header.stamp.to_nanos().expect("a time");
    let seconds = (contact - START) as f64 / 1e9;
    let expected = report.end_time + (5.0 - report.max_v1) / report.impactor_velocity;
    assert!((seconds - expected).abs() < 2e-9, "{seconds} {expected}");
    // What is crushed already yields no further energy: the second column meets a stiffer front.
    let (output, found) = forecast(&second, &next);
    let used = found.report;
    assert!(used.impactor_velocity < next.velocity && used.peak_contact_force > 0.0);
    let fresh = ImpactEvent {
        vehicle: "lorry_16t".to_owned(),
        ..next.clone()
    };
    let (_, fresh) = forecast(&second, &fresh);
    assert!(used.vehicle.dissipated[0] < fresh.report.vehicle.dissipated[0]);
    rows.take("a2", &output, crush(&second));
    let third = only(due(&mut rows));
    let (_, largest) = third.vehicle.split_once('@').expect("a crush");
    let largest: f64 = largest.parse().expect("a number");
    assert!(
        largest >= report.vehicle.max_crush[0] - 1e-6,
        "crush never decreases"
    );
    let (output, found) = forecast(&heavy, &third);
    rows.take("a3", &output, crush(&heavy));
    assert!(due(&mut rows).is_empty(), "{:?}", found.report.outcome);
    let [
        NotHit {
            impacts,
            reason,
            level,
            is_rejected,
        },
    ] = &rows.take_ended()[..]
    else {
        panic!("the end of the row");
    };
    assert_eq!(impacts.len(), 1);
    assert_eq!(impacts[0].event_id, "lorry/a4");
    assert_eq!(
        reason,
        "the row ends at column \"a3\": the column stands and has stopped the vehicle"
    );
    assert!(*level == NoticeLevel::Info && !is_rejected);
    assert!(rows.is_empty());
}

#[test]
fn impacts_with_given_times_are_kept_until_their_columns_accept_them() {
    let mut rows = Rows::default();
    let event = RowImpactEvent {
        offsets: vec![0.0, 1.5, 3.0],
        distances: Vec::new(),
        ..row(&["a1", "a2", "a3"])
    };
    rows.begin(RowImpact::new(event).expect("right"))
        .expect("room");
    let mut at = |seconds: f64| {
        let now = START + (1e9 * seconds) as Nanos;
        let due = rows.due(now, |_| SECOND).into_iter();
        due.map(|it| it.event_id).collect::<Vec<_>>()
    };
    assert_eq!(at(0.0), ["lorry/a1"]);
    assert!(at(0.49).is_empty());
    assert_eq!(at(0.5), ["lorry/a2"]);
    assert_eq!(at(9.0), ["lorry/a3"]);
    // Their columns may still reject them, but nothing depends on their forecasts.
    rows.give_up(START + 1000 * SECOND);
    assert!(rows.take_ended().is_empty() && rows.is_empty());
}

#[test]
fn an_impact_without_a_forecast_ends_the_row_with_an_error() {
    let heavy = parameters("a1", "HEM 600");
    let begun = || {
        let mut rows = Rows::default();
        rows.begin(RowImpact::new(row(&["a1", "a2", "a3"])).expect("right"))
            .expect("room");
        let first = only(due(&mut rows));
        (rows, first)
    };
    let ended = |mut rows: Rows| {
        let ended = rows.take_ended();
        assert!(rows.is_empty());
        assert!(ended.iter().all(|it| it.level == NoticeLevel::Error));
        let impacts = ended.iter().flat_map(|it| &it.impacts);
        impacts.map(|it| it.event_id.clone()).collect::<Vec<_>>()
    };
    let (mut rows, first) = begun();
    rows.not_submitted(&first, "the queue is full");
    assert_eq!(ended(rows), ["lorry/a1", "lorry/a2", "lorry/a3"]);
    let (mut rows, _) = begun();
    rows.give_up(START + 1000 * SECOND);
    assert_eq!(ended(rows), ["lorry/a2", "lorry/a3"]);
    let (mut rows, _) = begun();
    rows.stop();
    assert_eq!(ended(rows), ["lorry/a2", "lorry/a3"]);
    // The column rejects it after all, because another impact was faster.
    let (mut rows, first) = begun();
    let mut twin = Twin::new(heavy, None, Box::new(|| 0), START).expect("stands");
    let mut outputs: Vec<Output> = Vec::new();
    let command = || impact_command(first.clone());
    twin.handle(command(), START, &mut outputs)
        .expect("accepted");
    outputs.clear();
    twin.handle(command(), START, &mut outputs)
        .expect_err("repeated");
    for output in &outputs {
        rows.take("a1", output, |_, _| panic!("no crush"));
    }
    assert_eq!(ended(rows), ["lorry/a1", "lorry/a2", "lorry/a3"]);
}

/// When the last column of a row rejected its impact, the sender of the event got no answer and waited until its timeout.
#[test]
fn the_rejection_by_the_last_column_of_a_row_is_told() {
    let mut rows = Rows::default();
    rows.begin(RowImpact::new(row(&["a1"])).expect("right"))
        .expect("room");
    let first = only(due(&mut rows));
    let mut twin =
        Twin::new(parameters("a1", "HEM 600"), None, Box::new(|| 0), START).expect("stands");
    let mut outputs: Vec<Output> = Vec::new();
    let command = || impact_command(first.clone());
    twin.handle(command(), START, &mut outputs)
        .expect("accepted");
    outputs.clear();
    let rejection = twin
        .handle(command(), START, &mut outputs)
        .expect_err("repeated");
    for output in &outputs {
        rows.take("a1", output, |_, _| panic!("no crush"));
    }
    let [ended] = &rows.take_ended()[..] else {
        panic!("one rejection");
    };
    assert!(ended.is_rejected);
    assert_eq!(ended.impacts[0].event_id, "lorry/a1");
    assert!(
        ended.reason.ends_with(&rejection.reason.to_string()),
        "{}",
        ended.reason
    );
}

#[test]
fn everything_that_is_wrong_with_an_event_is_told() {
    type Change = fn(&mut RowImpactEvent);
    let cases: [(Change, &str); 11] = [
        (|it| it.event_id.clear(), "event_id is empty"),
        (|it| it.column_ids.clear(), "column_ids has 0 columns"),
        (
            |it| it.column_ids = (0..=MAX_ROW_COLUMNS).map(|it| it.to_string()).collect(),
            "expected 1 to 100",
        ),
        (
            |it| it.column_ids[2] = "a1".to_owned(),
            "names column \"a1\" twice",
        ),
        (
            |it| it.offsets = vec![0.0],
            "offsets has 1 values for 3 columns",
        ),
        (
            |it| it.distances = vec![1.0; 4],
            "distances has 4 values for 3 columns",
        ),
        (
            |it| it.distances = vec![],
            "the distance of column \"a2\" from the one before is NaN m",
        ),
        (
            |it| it.distances[2] = -1.0,
            "the distance of column \"a3\" from the one before is -1 m",
        ),
        (
            |it| it.offsets = vec![f64::NAN, 1.0, 2.0],
            "the offset of the first column, \"a1\", is NaN",
        ),
        (
            |it| it.offsets = vec![0.0, 2.0, 1.0],
            "the offset of column \"a3\" is 1 s; expected 2 s",
        ),
        (
            |it| it.header.stamp.nanosec = u32::MAX,
            "a second or more of nanoseconds",
        ),
    ];
    for (change, expected) in cases {
        let mut event = row(&["a1", "a2", "a3"]);
        change(&mut event);
        let faults = RowImpact::new(event).expect_err(expected).join("; ");
        assert!(faults.contains(expected), "{faults}");
    }
    let mut event = row(&["a1", "a2", "a2"]);
    event.event_id.clear();
    event.offsets = vec![0.0];
    assert_eq!(RowImpact::new(event).expect_err("three faults").len(), 3);
    for offset in [-0.1, f64::INFINITY, 61.0] {
        let mut event = row(&["a1", "a2"]);
        event.offsets = vec![0.0, offset];
        RowImpact::new(event).expect_err("out of range");
    }
}

#[test]
fn only_so_many_vehicles_are_on_their_way() {
    let mut rows = Rows::default();
    for number in 0..MAX_ROWS {
        let event = RowImpactEvent {
            event_id: number.to_string(),
            ..row(&["a1", "a2"])
        };
        rows.begin(RowImpact::new(event).expect("right"))
            .expect("room");
    }
    let event = RowImpact::new(row(&["a1", "a2"])).expect("right");
    let reason = rows.begin(event).expect_err("too many");
    assert!(reason.contains("at most 64"), "{reason}");
    assert_eq!(due(&mut rows).len(), MAX_ROWS);
}

#[test]
fn a_vehicle_of_the_parameters_has_to_be_the_same_for_all_columns() {
    let of = |vehicle: &str| {
        let values = [
            ("vehicle.name", Value::from(vehicle)),
            ("impact.mass", Value::from(0.0)),
        ];
        let parameters = Arc::new(Parameters::from_values(values).expect("admissible"));
        let event = ImpactEvent {
            mass: f64::NAN,
            velocity: 2.0,
            ..row_impact()
        };
        forecast(&parameters, &event).1.striking
    };
    let (car, van) = (of("mid_car"), of("van"));
    let open = RowImpactEvent {
        vehicle: String::new(),
        ..row(&["a1", "a2"])
    };
    let open = RowImpact::new(open).expect("right");
    assert_eq!(open.differing_vehicles(&[car.clone(), car.clone()]), None);
    let fault = open
        .differing_vehicles(&[car.clone(), van.clone()])
        .expect("differ");
    assert!(
        fault.contains("\"a1\" and \"a2\" give different vehicles"),
        "{fault}"
    );
    let named = RowImpact::new(row(&["a1", "a2"])).expect("right");
    assert_eq!(named.differing_vehicles(&[car, van]), None);
}

fn row_impact() -> ImpactEvent {
    ImpactEvent {
        header: Header {
            stamp: Time::from_nanos(START).expect("a time"),
            frame_id: String::new(),
        },
        column_id: Parameters::default().settings().column_id.clone(),
        event_id: "e".to_owned(),
        ..ImpactEvent::default()
    }
}
