//! Estimates while measurements arrive, batch by batch, of the fibre-beam signals with the errors of industrial sensors.

use column_twin::assessment::Action;
use column_twin::column::{
    ColumnProperties, Impact, Model, Progress, Report, Response, State, residual_state,
};
use column_twin::estimation::{
    Batch, CredibleInterval, EstimateRecord, EventEvidence, Library, Probe, Readings,
    Recomputation, Sensing, Work,
};
use column_twin::parameters::Parameters;
use column_twin::sensors::Sensor;
use column_twin::standing::StandingColumn;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::beam_signals::{self, BeamSignal};
use super::signals::{NAMES, Normal, START, Signal, batch, batches, with_sensors};

/// Samples of a batch: 10 ms.
const SAMPLES: usize = 100;

/// Slices of refinement for which there is time while a batch of 10 ms arrives: a response takes 1 to 4 ms.
const SLICES: usize = 3;

/// All sensors; an accelerometer, a displacement sensor and a strain gauge.
const SETS: [&[usize]; 2] = [&[0, 1, 2, 3, 4, 5, 6, 7], &[1, 3, 4]];

/// Sensing of a column with these sensors, prepared; the parameters with the sensors.
fn prepared(of: &Parameters, sensors: &[Sensor]) -> (Parameters, Sensing) {
    let parameters = with_sensors(of, sensors);
    let column = StandingColumn::undamaged(&parameters);
    let mut sensing = Sensing::new(&parameters, column).expect("sensors");
    while sensing.step() != Work::Idle {}
    (parameters, sensing)
}

/// Lets the work be done for which there is time while a batch arrives.
fn work(sensing: &mut Sensing, mut slices: usize, records: &mut Vec<EstimateRecord>) {
    loop {
        match sensing.step() {
            Work::More { is_urgent: true } => {}
            Work::More { is_urgent: false } if slices > 0 => slices -= 1,
            Work::Estimate(record) => records.push(*record),
            Work::More { .. } | Work::Idle => return,
            Work::Missed(reason) => panic!("{reason}"),
        }
    }
}

/// All estimates of a signal, whose data arrive in time.
fn estimates(signal: &Signal, chosen: &[usize], seed: u64) -> (Parameters, Vec<EstimateRecord>) {
    let (sensors, readings) = signal.readings(chosen, seed);
    let (parameters, mut sensing) = prepared(&signal.parameters(), &sensors);
    let mut records = Vec::new();
    for (number, batch) in batches(&readings, SAMPLES) {
        let is_last = usize::from(batch.sensor) + 1 == sensors.len();
        sensing.push(number, batch);
        if is_last {
            work(&mut sensing, SLICES, &mut records);
        }
    }
    // The signals end before the last estimate is due.
    sensing.note_time(START + 2_000_000_000);
    work(&mut sensing, usize::MAX, &mut records);
    (parameters, records)
}

fn is_within(interval: &CredibleInterval, truth: f64) -> bool {
    (interval.low..=interval.high).contains(&truth)
}

#[test]
#[ignore = "slow: estimates of many impacts take minutes"]
fn live_estimates_reach_what_those_of_recordings_do() {
    let (mut held, mut total) = (0, 0);
    for name in NAMES {
        let signal = Signal::read(name);
        let number = |name| signal.number(name);
        let (mass, speed) = (number("mass"), number("speed"));
        let (peak, residual) = (number("peak_v1"), number("residual_v1"));
        for chosen in SETS {
            let (_, records) = estimates(&signal, chosen, 7);
            let [first, .., last] = records.as_slice() else {
                panic!("{name}: {} estimates", records.len());
            };
            assert!(last.is_final && records.iter().filter(|it| it.is_final).count() == 1);
            assert!((0..).zip(&records).all(|(k, it)| it.update == k));
            let contact = number("contact_instant");
            let found = 1e-9 * (first.origin - START) as f64;
            assert!((found - contact).abs() < 1e-3, "{name}: {found}");
            for record in &records {
                let it = &record.estimate;
                assert!(it.doubtful_sensors.is_empty(), "{name}: {it:#?}");
                let holds = [
                    is_within(&it.mass, mass),
                    is_within(&it.velocity, speed),
                    is_within(&it.momentum, mass * speed),
                    is_within(&it.peak_v1, peak),
                    is_within(&it.residual_v1, residual),
                ];
                println!(
                    "{name} {:>6.1} ms, {:>2} + {:>2} drawn, {:>5.1} effective, mass {:.3}, speed {:.3}, peak {:.3}, {}",
                    1e3 * it.data_until,
                    record.drawn_before,
                    record.drawn,
                    it.effective_sample_size,
                    it.mass.mean / mass,
                    it.velocity.mean / speed,
                    it.peak_v1.mean / peak,
                    it.vehicle_probabilities[0].0,
                );
                held += holds.iter().filter(|it| **it).count();
                total += holds.len();
            }
            let last = &last.estimate;
            let report = format!("{name} {chosen:?}: {last:#?}");
            let momentum = last.momentum.mean / (mass * speed) - 1.0;
            assert!(momentum.abs() < 0.15, "{report}");
            let error = (last.peak_v1.mean - peak).abs();
            assert!(error < (0.1 * peak).max(1e-3), "{report}");
            let error = (last.residual_v1.mean - residual).abs();
            assert!(error < (0.1 * residual).max(2e-3), "{report}");
            let elastic = signal.truth["outcome"] == "elastic";
            let none = last.action.iter().find(|it| it.0 == Action::None);
            assert!(none.is_some_and(|it| (it.1 > 0.9) == elastic), "{report}");
        }
    }
    println!("{held} of {total} intervals hold the truth");
    let share = f64::from(held as u32) / f64::from(total as u32);
    assert!(share >= 0.8, "{held} of {total}");
}

/// All estimates of a signal of which an event says this mass and speed after the second estimate.
fn estimates_with_event(
    signal: &Signal,
    mass: f64,
    velocity: f64,
) -> (Parameters, Vec<EstimateRecord>) {
    let (sensors, readings) = signal.readings(SETS[1], 7);
    let (parameters, mut sensing) = prepared(&signal.parameters(), &sensors);
    let (mut records, mut is_told) = (Vec::<EstimateRecord>::new(), false);
    for (number, batch) in batches(&readings, SAMPLES) {
        sensing.push(number, batch);
        work(&mut sensing, SLICES, &mut records);
        if let (false, [first, _, ..]) = (is_told, records.as_slice()) {
            is_told = true;
            let event = EventEvidence {
                event_id: "camera".into(),
                mass,
                mass_deviation: 0.1,
                velocity,
                velocity_deviation: 0.05,
            };
            assert!(!sensing.note_event("another impact", event.clone()));
            assert!(sensing.note_event(&first.event_id, event));
        }
    }
    sensing.note_time(START + 2_000_000_000);
    work(&mut sensing, usize::MAX, &mut records);
    (parameters, records)
}

/// A soft vehicle, whose mass its sensors show late and with a wide interval.
#[test]
fn an_event_is_evidence_beside_the_sensors_and_does_not_overrule_them() {
    let signal = Signal::read("s04_car_soft_14");
    let (mass, speed) = (signal.number("mass"), signal.number("speed"));
    let width = |it: &CredibleInterval| (it.high - it.low) / it.mean;
    let (parameters, records) = estimates_with_event(&signal, mass, speed);
    let (_, without) = estimates(&signal, SETS[1], 7);
    let counted = records.iter().filter(|it| !it.events.is_empty()).count();
    assert_eq!(counted, records.len() - 2);
    let (last, alone) = (
        records.last().expect("estimates"),
        without.last().expect("estimates"),
    );
    let [last, alone] = [last, alone].map(|it| &it.estimate);
    println!("{:?} with the event, {:?} without", last.mass, alone.mass);
    assert!(
        width(&last.mass) < 0.7 * width(&alone.mass),
        "{last:#?} {alone:#?}"
    );
    assert!(
        is_within(&last.mass, mass) && is_within(&last.velocity, speed),
        "{last:#?}"
    );

    // What counted is part of the record, so that the same bits follow from it.
    let (_, readings) = signal.readings(SETS[1], 7);
    let given = batches(&readings, SAMPLES);
    let known = |number: u64| given.get(number as usize).map(|(_, batch)| batch);
    let mut recomputation = Recomputation::new(&parameters);
    for record in &records {
        let again = recomputation.repeat(record, known).expect("computed again");
        assert_eq!(format!("{again:?}"), format!("{record:?}"));
    }
    let mut recomputation = Recomputation::new(&parameters);
    let mut forged = records.clone();
    forged[2].events[0].mass *= 1.1;
    let again = forged[..3]
        .iter()
        .map(|it| recomputation.repeat(it, known).expect("computed again"));
    assert_ne!(again.last().expect("three").estimate, records[2].estimate);

    // A sender who errs by a factor of 100 changes nothing.
    let (_, wrong) = estimates_with_event(&signal, 100.0 * mass, 0.1 * speed);
    let wrong = &wrong.last().expect("estimates").estimate;
    let momentum = wrong.momentum.mean / (mass * speed);
    assert!((momentum - 1.0).abs() < 0.15, "{wrong:#?}");
}

/// A number below `below`.
fn any(random: &mut ChaCha8Rng, below: u64) -> usize {
    (random.next_u64() % below) as usize
}

#[test]
fn whatever_the_order_of_data_and_work_the_records_give_the_same_bits_again() {
    let signal = Signal::read("s02_rigid_10");
    let (sensors, readings) = signal.readings(SETS[1], 5);
    let (parameters, sensing) = prepared(&signal.parameters(), &sensors);
    repeat_in_any_order(&parameters, sensing, &readings, 4);
}

/// The search for such a front is cut into slices by the estimates, and continues with older data than these.
#[test]
fn whatever_the_order_a_search_for_a_crushed_front_gives_the_same_bits_again() {
    repeat_beam_signal_in_any_order("crushed_lorry_14", 2);
}

/// Live it is cut into slices, and its responses are computed one after another; what is computed again takes all processors.
#[test]
fn a_search_by_the_beam_gives_the_same_bits_in_slices_and_on_all_processors() {
    let counted = repeat_beam_signal_in_any_order("light_rigid_2", 1);
    assert!(counted > 0, "no record counts what the beam answers");
}

fn repeat_beam_signal_in_any_order(name: &str, orders: u64) -> usize {
    let sensors = beam_signals::sensors();
    let signal = BeamSignal::make(name, &sensors, beam_signals::AFTER);
    let readings = signal.readings(&sensors, beam_signals::BEFORE, 5);
    let (parameters, sensing) = prepared(&beam_signals::parameters(), &sensors);
    repeat_in_any_order(&parameters, sensing, &readings, orders)
}

/// In so many orders; returns how many records count what the beam has answered.
fn repeat_in_any_order(
    parameters: &Parameters,
    mut sensing: Sensing,
    readings: &Readings,
    orders: u64,
) -> usize {
    let sensors = readings.sensors;
    let mut counted = 0;
    let rows: Vec<(f64, &[f64])> = readings.rows().collect();
    let mut recomputation = Recomputation::new(parameters);
    for seed in 0..orders {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        // Every sensor has its own batches; the next one comes from a sensor that is not far ahead of the others.
        let mut next = vec![0; sensors];
        let mut given = Vec::new();
        let (mut records, mut work_left) = (Vec::new(), true);
        // The sensing goes on from one impact to the next, after a second of rest.
        let later = START + 3_000_000_000 * seed as i64;
        let rest = (0..150).flat_map(|step: i64| (0..sensors).map(move |sensor| (sensor, step)));
        if seed > 0 {
            for (sensor, step) in rest {
                let mut batch = batch(sensor, &rows[..SAMPLES]);
                batch.first = later - 1_600_000_000 + 10_000_000 * step;
                given.push(batch);
            }
        }
        let numbered = |count: usize| 1000 * seed + count as u64;
        for (count, batch) in given.iter().enumerate() {
            sensing.push(numbered(count), batch.clone());
            while matches!(sensing.step(), Work::More { .. }) {}
        }
        while next.iter().any(|it| *it < rows.len()) {
            let least = next.iter().copied().min().unwrap_or_default();
            let sensor = any(&mut random, sensors as u64);
            let from = next[sensor];
            if from < rows.len() && from <= least + 2 * SAMPLES {
                let to = (from + 1 + any(&mut random, 2 * SAMPLES as u64)).min(rows.len());
                next[sensor] = to;
                let mut batch = batch(sensor, &rows[from..to]);
                batch.first += later - START;
                given.push(batch.clone());
                sensing.push(numbered(given.len() - 1), batch);
            }
            for _ in 0..any(&mut random, 60) {
                match sensing.step() {
                    Work::Estimate(record) => records.push(*record),
                    Work::Missed(reason) => panic!("{reason}"),
                    Work::More { .. } | Work::Idle => {}
                }
            }
        }
        sensing.note_time(later + 2_000_000_000);
        while std::mem::take(&mut work_left) {
            match sensing.step() {
                Work::Estimate(record) => {
                    work_left = !record.is_final;
                    records.push(*record);
                }
                _ => work_left = true,
            }
        }
        assert!(records.len() > 3, "{}", records.len());
        let known = |number: u64| given.get(number.checked_sub(numbered(0))? as usize);
        for record in &records {
            let again = recomputation.repeat(record, known).expect("computed again");
            assert_eq!(format!("{again:?}"), format!("{record:?}"), "seed {seed}");
            counted += usize::from(record.counts_beam);
        }
    }
    counted
}

#[test]
fn a_forged_measurement_or_record_does_not_give_the_same_estimate() {
    let signal = Signal::read("s01_rigid_3");
    let (parameters, records) = estimates(&signal, SETS[1], 2);
    let (_, readings) = signal.readings(SETS[1], 2);
    let genuine: Vec<Batch> = batches(&readings, SAMPLES)
        .into_iter()
        .map(|(_, batch)| batch)
        .collect();
    let record = &records[0];
    let mut recomputation = Recomputation::new(&parameters);
    let mut repeated = |record: &EstimateRecord, batches: &[Batch]| {
        recomputation.repeat(record, |number| batches.get(number as usize))
    };
    let again = repeated(record, &genuine).expect("computed again");
    assert_eq!(format!("{again:?}"), format!("{record:?}"));

    let mut forged = genuine.clone();
    let touched = &mut forged[record.batches as usize - 2];
    let mut values = touched.values.to_vec();
    values[0] += 0.01;
    touched.values = values.into();
    let other = repeated(record, &forged).expect("computed");
    assert_ne!(other.estimate, record.estimate);

    let mut forged = record.clone();
    forged.drawn += 1;
    let other = repeated(&forged, &genuine).expect("computed");
    assert_ne!(other.estimate, record.estimate);

    let missing = repeated(record, &genuine[..3]).expect_err("is missing");
    assert!(
        missing.to_string().ends_with("of which batch 3 is missing"),
        "{missing}"
    );
    let later = repeated(&records[1], &genuine).expect_err("builds upon the first one");
    assert!(
        later.to_string().contains("begin with the first one"),
        "{later}"
    );
}

/// A signal of all sensors but the second and third accelerometer, with one sensor that reads something else.
fn estimates_with(
    signal: &Signal,
    chosen: &[usize],
    change: impl Fn(usize, f64, f64) -> f64,
) -> Vec<EstimateRecord> {
    let (sensors, mut readings) = signal.readings(chosen, 3);
    let times = readings.times.clone();
    for (time, row) in times.iter().zip(readings.values.chunks_mut(sensors.len())) {
        for (sensor, value) in row.iter_mut().enumerate() {
            *value = change(sensor, *time, *value);
        }
    }
    let (_, mut sensing) = prepared(&signal.parameters(), &sensors);
    let mut records = Vec::new();
    for (number, batch) in batches(&readings, SAMPLES) {
        let is_last = usize::from(batch.sensor) + 1 == sensors.len();
        sensing.push(number, batch);
        if is_last {
            work(&mut sensing, SLICES, &mut records);
        }
    }
    sensing.note_time(START + 2_000_000_000);
    work(&mut sensing, usize::MAX, &mut records);
    records
}

#[test]
fn a_sensor_that_contradicts_the_others_is_named_and_does_not_count() {
    let signal = Signal::read("s04_car_soft_14");
    let chosen = [1, 3, 4, 5];
    let (mass, speed) = (signal.number("mass"), signal.number("speed"));
    // A laser whose scale is wrong by a factor of 5.
    let records = estimates_with(&signal, &chosen, |sensor, _, value| {
        if sensor == 1 { 5.0 * value } else { value }
    });
    let last = &records.last().expect("estimates").estimate;
    assert_eq!(last.doubtful_sensors, ["v1"], "{last:#?}");
    let momentum = last.momentum.mean / (mass * speed);
    assert!((momentum - 1.0).abs() < 0.3, "{last:#?}");

    // A laser that is mounted the other way round: no impact at all lets it read that.
    let records = estimates_with(&signal, &[3, 4], |sensor, _, value| match sensor {
        0 => -value,
        _ => value,
    });
    let last = &records.last().expect("estimates").estimate;
    assert_eq!(last.doubtful_sensors, ["v1"], "{last:#?}");
    let peak = last.peak_v1.mean / signal.number("peak_v1");
    assert!((peak - 1.0).abs() < 0.5, "{last:#?}");
}

#[test]
fn a_sensor_that_sticks_or_dies_in_the_middle_does_not_spoil_the_estimate() {
    let signal = Signal::read("s02_rigid_10");
    let contact = signal.number("contact_instant");
    let (peak, residual) = (signal.number("peak_v1"), signal.number("residual_v1"));
    for stuck_at in [f64::NAN, 0.004] {
        // The laser reads the same value from 6 ms after contact on, or nothing any more.
        let records = estimates_with(&signal, &[1, 3, 4, 5], |sensor, time, value| {
            if sensor == 1 && time > contact + 6e-3 {
                stuck_at
            } else {
                value
            }
        });
        let last = &records.last().expect("estimates").estimate;
        assert!((last.peak_v1.mean / peak - 1.0).abs() < 0.25, "{last:#?}");
        assert!(is_within(&last.peak_v1, peak), "{last:#?}");
        assert!(is_within(&last.residual_v1, residual), "{last:#?}");
    }
}

/// What a displacement sensor and a strain gauge read when a rigid mass strikes a column in this state; and the outcome.
fn struck(model: &Model, rest: &State, impact: Impact, sensors: &[Sensor]) -> (Readings, Report) {
    const LEAD: usize = 2000;
    const TAIL: usize = 5000;
    let mut normal = Normal::new(9);
    let mut state = *rest;
    let steps = 100_000 / model.properties.step_nanos;
    assert_eq!(steps * model.properties.step_nanos, 100_000);
    let probes: Vec<_> = sensors.iter().map(|it| Probe::new(model, it)).collect();
    let mut readings = Readings {
        sensors: sensors.len(),
        ..Readings::default()
    };
    let mut sample = |state: &State| {
        readings.times.push(readings.times.len() as f64 * 1e-4);
        for (probe, sensor) in probes.iter().zip(sensors) {
            let reading = probe.read(state) - probe.read(rest);
            readings.values.push(reading + sensor.noise * normal.next());
        }
    };
    for _ in 0..LEAD {
        sample(&state);
    }
    let mut response = Response::begin(model, &mut state, impact, 1.0).expect("an impact");
    let mut report = None;
    for _ in 0..TAIL {
        for _ in 0..steps {
            if report.is_none()
                && let Progress::Over(end) = response.advance(model, &mut state, 1).expect("a step")
            {
                report = Some(response.report(model, &state, end));
            }
        }
        sample(&state);
    }
    (readings, report.expect("the response is over"))
}

#[test]
fn an_impact_on_a_damaged_column_is_estimated_for_the_column_as_it_is() {
    let signal = Signal::read("s02_rigid_10");
    let sensors: Vec<Sensor> = signal.industrial().drain(3..5).collect();
    let parameters = with_sensors(&signal.parameters(), &sensors);
    let model = Model::new(&ColumnProperties {
        step_nanos: 20_000,
        ..parameters.column_properties()
    });
    let model = model.expect("a column");
    let undamaged = State::at_rest(&model);
    let first = Impact::rigid(1500.0, 8.0);
    let mut state = undamaged;
    let mut response = Response::begin(&model, &mut state, first, 1.0).expect("an impact");
    while response.advance(&model, &mut state, 1).expect("a step") == Progress::Running {}
    let damaged = residual_state(&model, &state).expect("it stands");
    assert!(damaged.displacement.v1 > 0.03);
    let second = Impact::rigid(1200.0, 7.0);
    let (readings, report) = struck(&model, &damaged, second, &sensors);

    let estimate = |column: StandingColumn| {
        let mut sensing = Sensing::new(&parameters, column).expect("sensors");
        while sensing.step() != Work::Idle {}
        let mut records = Vec::new();
        for (number, batch) in batches(&readings, SAMPLES) {
            sensing.push(number, batch);
            work(&mut sensing, SLICES, &mut records);
        }
        sensing.note_time(START + 2_000_000_000);
        work(&mut sensing, usize::MAX, &mut records);
        records.pop().expect("an estimate").estimate
    };
    let column = StandingColumn::new(&model, &damaged);
    assert!(column.damage.is_some());
    let last = estimate(column);
    let residual = report.residual_v1.expect("it stands");
    println!("{report:#?} {last:#?}");
    assert!(
        (last.peak_v1.mean / report.max_v1 - 1.0).abs() < 0.05,
        "{last:#?}"
    );
    assert!(is_within(&last.peak_v1, report.max_v1), "{last:#?}");
    assert!(is_within(&last.residual_v1, residual), "{last:#?}");
    assert!((last.velocity.mean / 7.0 - 1.0).abs() < 0.15, "{last:#?}");
    // What is left of the column is judged with its earlier damage: worse than after the second impact alone.
    let alone = estimate(StandingColumn::undamaged(&parameters));
    assert!(last.peak_v1.mean > alone.peak_v1.mean + 0.8 * damaged.displacement.v1);
    assert!(
        last.capacity_ratio.mean < alone.capacity_ratio.mean,
        "{last:#?} {alone:#?}"
    );
}

#[test]
fn an_undamaged_state_is_the_undamaged_column() {
    let parameters = Parameters::default();
    let model = Model::new(&parameters.column_properties()).expect("a column");
    let column = StandingColumn::new(&model, &State::at_rest(&model));
    assert_eq!(column, StandingColumn::undamaged(&parameters));
}

/// Columns of a fleet share what is prepared. An estimate does not depend on that, and what one impact adds does not reach the
/// next one.
#[test]
fn a_column_that_shares_its_responses_makes_the_same_estimates_as_one_of_its_own() {
    let signal = Signal::read("s02_rigid_10");
    let (sensors, readings) = signal.readings(SETS[1], 7);
    let parameters = with_sensors(&signal.parameters(), &sensors);
    let base = Library::new(&parameters, StandingColumn::undamaged(&parameters)).expect("sensors");
    let mut library = base.clone();
    while !library.prepare_one() {}
    assert_eq!(base.prepared(), 0, "a copy is carried on alone");
    let (_, expected) = estimates(&signal, SETS[1], 7);
    for _ in 0..2 {
        let mut sensing = Sensing::sharing(base.clone());
        assert_eq!(sensing.step(), Work::Idle, "others prepare for it");
        let mut records = Vec::new();
        for (number, batch) in batches(&readings, SAMPLES) {
            let is_last = usize::from(batch.sensor) + 1 == sensors.len();
            sensing.push(number, batch);
            if sensing.has_detected() {
                sensing.take_library(&library);
            }
            if is_last {
                work(&mut sensing, SLICES, &mut records);
            }
        }
        sensing.note_time(START + 2_000_000_000);
        work(&mut sensing, usize::MAX, &mut records);
        assert_eq!(format!("{records:?}"), format!("{expected:?}"));
        assert_eq!(sensing.prepared(), 0, "its own copy is gone");
    }
}

/// The data of an impact whose responses are prepared late wait, and all of them count.
#[test]
fn an_impact_whose_responses_are_prepared_late_is_estimated_later_from_the_same_data() {
    let signal = Signal::read("s02_rigid_10");
    let (sensors, readings) = signal.readings(SETS[1], 7);
    let parameters = with_sensors(&signal.parameters(), &sensors);
    let base = Library::new(&parameters, StandingColumn::undamaged(&parameters)).expect("sensors");
    let mut sensing = Sensing::sharing(base);
    let given = batches(&readings, SAMPLES);
    let last = given.last().expect("data").1.end();
    for (number, batch) in given.iter().cloned() {
        sensing.push(number, batch);
    }
    // Seconds pass in which the column is at rest.
    for (number, second) in (given.len() as u64..).zip(0..3) {
        let values = vec![0.0_f32; 10_000];
        let values = values.into();
        sensing.push(
            number,
            Batch {
                sensor: 0,
                first: last + 1_000_000_000 * second,
                period: 100_000,
                values,
            },
        );
    }
    assert!(sensing.has_detected());
    while !sensing.prepare_one() {}
    let mut records = Vec::new();
    sensing.note_time(last + 10_000_000_000);
    work(&mut sensing, usize::MAX, &mut records);
    let final_one = records.last().expect("an estimate");
    assert!(final_one.is_final);
    assert_eq!(final_one.lost_batches, 0, "what was not kept was not lost");
    let momentum = &final_one.estimate.momentum;
    let truth = signal.number("mass") * signal.number("speed");
    assert!((momentum.mean / truth - 1.0).abs() < 0.15, "{momentum:?}");
    // The same bits follow from all batches that came.
    let known = |number: u64| given.get(number as usize).map(|(_, batch)| batch);
    let quiet: Vec<Batch> = (0..3)
        .map(|second| Batch {
            sensor: 0,
            first: last + 1_000_000_000 * second,
            period: 100_000,
            values: vec![0.0; 10_000].into(),
        })
        .collect();
    let known = |number: u64| {
        known(number).or_else(|| quiet.get((number as usize).checked_sub(given.len())?))
    };
    let mut recomputation = Recomputation::new(&parameters);
    for record in &records {
        let again = recomputation.repeat(record, known).expect("computed again");
        assert_eq!(format!("{again:?}"), format!("{record:?}"));
    }
}
