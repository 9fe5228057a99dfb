//! Every fault that a sensor, its clock or its connection can have.

use super::*;
use crate::estimation::TOLERATED_OFFSET;
use crate::sensors::Quantity;

const MILLISECOND: Nanos = 1_000_000;
const EPOCH: Nanos = 1_700_000_000_000_000_000;

/// 10 kHz, in batches of 10 ms.
const PERIOD: Nanos = 100_000;
const BATCH: Nanos = 10 * MILLISECOND;

/// A batch arrives so long after its last sample.
const TRANSPORT: Nanos = 2 * MILLISECOND;

fn sensor(name: &str) -> Sensor {
    Sensor {
        name: name.to_owned(),
        quantity: Quantity::Acceleration,
        height: 1.0,
        range: 490.3325,
        noise: 0.02,
        bias: 0.0,
        gain_error: 0.0,
        rate: 10_000.0,
        bandwidth: 5_000.0,
        reversed: false,
        fibre: 0.0,
    }
}

fn intake() -> Intake {
    let reversed = Sensor {
        reversed: true,
        ..sensor("b")
    };
    Intake::new(&[sensor("a"), reversed], "column")
}

/// Values that name their samples: whole numbers modulo 256, so that none is equal to the one before.
fn values(from: Nanos, count: usize) -> Vec<f32> {
    let first = (from - EPOCH).div_euclid(PERIOD);
    (0..count as i64)
        .map(|k| (first + k).rem_euclid(256) as f32)
        .collect()
}

fn raw(values: &[f32], stamp: Nanos) -> RawBatch<'_> {
    RawBatch {
        column_id: "column",
        sensor_id: "a",
        stamp,
        sample_period: 1e-4,
        values,
    }
}

/// Offers a batch of 10 ms that arrives in time.
fn offer(intake: &mut Intake, stamp: Nanos) -> Result<Batch, BatchRejection> {
    offer_at(intake, stamp, stamp + BATCH + TRANSPORT)
}

fn offer_at(intake: &mut Intake, stamp: Nanos, received: Nanos) -> Result<Batch, BatchRejection> {
    intake.take(&raw(&values(stamp, 100), stamp), received)
}

fn counts(intake: &Intake) -> SensorCounts {
    intake.health(EPOCH)[0].counts
}

#[test]
fn batches_in_order_pass_as_they_are() {
    let mut intake = intake();
    for k in 0..100 {
        let stamp = EPOCH + k * BATCH;
        let batch = offer(&mut intake, stamp).expect("in order");
        assert_eq!(
            (batch.sensor, batch.first, batch.period),
            (0, stamp, 100_000)
        );
        assert_eq!(*batch.values, *values(stamp, 100));
    }
    let expected = SensorCounts {
        batches: 100,
        samples: 10_000,
        ..SensorCounts::default()
    };
    assert_eq!(counts(&intake), expected);
    assert_eq!(intake.health(EPOCH)[0].clock_offset, TRANSPORT);
}

#[test]
fn signs_are_those_of_the_model_and_what_is_no_number_is_missing() {
    let mut intake = intake();
    let given = [1.0, f32::NAN, f32::NEG_INFINITY, -2.0];
    let batch = RawBatch {
        sensor_id: "b",
        ..raw(&given, EPOCH)
    };
    let taken = intake.take(&batch, EPOCH).expect("taken");
    assert_eq!(taken.sensor, 1);
    assert_eq!([taken.values[0], taken.values[3]], [-1.0, 2.0]);
    assert!(taken.values[1].is_nan() && taken.values[2].is_nan());
    let health = &intake.health(EPOCH)[1];
    assert_eq!((health.counts.missing, health.counts.samples), (2, 4));
}

/// A range that single precision rounds down, and one that it rounds up.
#[test]
fn clipped_samples_are_counted_in_single_precision() {
    for range in [490.3325, 490.33252] {
        let clipping = Sensor {
            range,
            ..sensor("a")
        };
        let mut intake = Intake::new(&[clipping], "column");
        let given = [range as f32, -(range as f32), 1e30, 490.0, 0.0];
        intake.take(&raw(&given, EPOCH), EPOCH).expect("taken");
        assert_eq!(counts(&intake).saturated, 3, "{range}");
    }
}

#[test]
fn bad_batches_are_rejected_with_a_reason_and_counted() {
    let mut intake = intake();
    let good = values(EPOCH, 100);
    let long = vec![0.0; MAX_BATCH_SAMPLES + 1];
    let batch = raw(&good, EPOCH);
    let with_period = |sample_period| RawBatch {
        sample_period,
        ..batch
    };
    let cases = [
        (
            RawBatch {
                column_id: "other",
                ..batch
            },
            "for column \"other\", but this is the twin of column \"column\"",
        ),
        (
            RawBatch {
                sensor_id: "c\u{7}",
                ..batch
            },
            "no sensor is called \"c\\u{7}\"; sensors.names contains a, b",
        ),
        (raw(&[], EPOCH), "no samples"),
        (raw(&long, EPOCH), "65537 samples; expected at most 65536"),
        (with_period(1e-3), "sensors.a.rate is 10000 Hz"),
        (with_period(0.0), "its sample_period is 0 s"),
        (with_period(-1e-4), "its sample_period is -0.0001 s"),
        (with_period(f64::NAN), "its sample_period is NaN s"),
        (with_period(f64::INFINITY), "its sample_period is inf s"),
        (with_period(1.02e-4), "0.000102 s"),
        (raw(&good, 0), "its stamp is 0"),
    ];
    for (batch, expected) in cases {
        let rejection = intake.take(&batch, EPOCH).expect_err(expected);
        assert!(rejection.to_string().contains(expected), "{rejection}");
    }
    assert_eq!(counts(&intake).rejected, 9);
    let Strays {
        other_column,
        unknown_sensor,
        last,
    } = intake.strays();
    assert_eq!((*other_column, *unknown_sensor), (1, 1));
    assert!(matches!(last, Some(BatchRejection::UnknownSensor { .. })));
    assert_eq!(intake.health(EPOCH)[0].condition, SensorCondition::Waiting);
    // The period may be off by as much as a real clock is.
    let slightly = with_period(1.005e-4);
    intake.take(&slightly, EPOCH).expect("within the tolerance");
}

#[test]
fn gaps_duplicates_late_batches_and_overlaps_are_counted() {
    let mut intake = intake();
    let at = |k: i64| EPOCH + k * BATCH;
    offer(&mut intake, at(0)).expect("first");
    offer(&mut intake, at(1)).expect("second");
    assert_eq!(offer(&mut intake, at(0)), Err(BatchRejection::Duplicate));
    assert_eq!(offer(&mut intake, at(1)), Err(BatchRejection::Duplicate));
    // The third one is overtaken by the fourth.
    offer(&mut intake, at(3)).expect("after a gap");
    assert_eq!(counts(&intake).lost, 100);
    let late = offer_at(&mut intake, at(2), at(4) + TRANSPORT);
    let behind = BATCH.unsigned_abs();
    assert_eq!(late, Err(BatchRejection::Late { behind }));
    // The next one repeats the last 30 samples of the fourth.
    let stamp = at(4) - 30 * PERIOD;
    let rest = offer(&mut intake, stamp).expect("its end is new");
    assert_eq!((rest.first, rest.values.len()), (at(4), 70));
    assert_eq!(*rest.values, *values(at(4), 70));
    let expected = SensorCounts {
        batches: 4,
        samples: 370,
        lost: 100,
        duplicates: 230,
        late: 100,
        ..SensorCounts::default()
    };
    assert_eq!(counts(&intake), expected);
}

#[test]
fn jitter_of_the_stamps_is_smoothed() {
    let mut intake = intake();
    for k in 0..1_000_i64 {
        let truth = EPOCH + k * BATCH;
        // Off by up to 0.5 ms, by turns.
        let jitter = 5 * PERIOD * (k % 3 - 1);
        let stamp = truth + jitter;
        let given = values(truth, 100);
        let batch = intake.take(&raw(&given, stamp), truth + BATCH + TRANSPORT);
        let batch = batch.expect("continues");
        assert_eq!(batch.values.len(), 100);
        // The first one is all that is known at first.
        let error = (batch.first - truth).abs();
        assert!(error <= 6 * PERIOD, "{k}: {error}");
        if k > 100 {
            assert!(error <= 2 * PERIOD, "{k}: {error}");
        }
    }
    let counts = counts(&intake);
    assert_eq!((counts.lost, counts.duplicates, counts.late), (0, 0, 0));
}

#[test]
fn a_clock_that_is_set_is_believed_after_three_batches() {
    let hour = 3_600_000 * MILLISECOND;
    for shift in [hour, -hour, 2_000 * MILLISECOND, -2_000 * MILLISECOND] {
        let mut intake = intake();
        let truth = |k: i64| EPOCH + k * BATCH;
        let arrival = |k: i64| truth(k + 1) + TRANSPORT;
        for k in 0..100 {
            offer(&mut intake, truth(k)).expect("in order");
        }
        for k in 100..102 {
            let doubted = offer_at(&mut intake, truth(k) + shift, arrival(k));
            assert!(
                matches!(doubted, Err(BatchRejection::Doubted { .. })),
                "{doubted:?}"
            );
        }
        for k in 102..200 {
            let batch = offer_at(&mut intake, truth(k) + shift, arrival(k)).expect("believed");
            // The new clock is corrected.
            assert_eq!(batch.first, truth(k) + TRANSPORT, "{shift}");
        }
        let counts = counts(&intake);
        assert_eq!((counts.clock_jumps, counts.doubted), (1, 200));
        assert_eq!((counts.lost, counts.late), (0, 0));
    }
}

/// Somebody replays old measurements beside the sensor, or sends nonsense.
#[test]
fn single_doubtful_batches_do_not_disturb_the_sensor() {
    let mut intake = intake();
    let day = 86_400_000 * MILLISECOND;
    for k in 0..300 {
        let truth = EPOCH + k * BATCH;
        assert_eq!(offer(&mut intake, truth).expect("in order").first, truth);
        let strange = [truth - day, truth + day, i64::MIN, i64::MAX][(k % 4) as usize];
        let given = values(EPOCH, 100);
        let received = truth + BATCH + TRANSPORT;
        let doubted = intake.take(&raw(&given, strange), received);
        assert!(doubted.is_err(), "{strange}");
    }
    assert_eq!(counts(&intake).batches, 300);
    assert_eq!(counts(&intake).clock_jumps, 0);
}

/// As a looped recording does with simulated time.
#[test]
fn the_twin_s_own_clock_may_be_set_back() {
    let mut intake = intake();
    for round in 0..3 {
        for k in 0..200 {
            let stamp = EPOCH + k * BATCH;
            let batch = offer(&mut intake, stamp).expect("in order");
            assert_eq!(batch.first, stamp, "{round}");
        }
    }
    assert_eq!(counts(&intake).clock_jumps, 2);
}

#[test]
fn a_clock_that_is_off_is_corrected_and_reported() {
    for offset in [-5_000 * MILLISECOND, 0, 5_000 * MILLISECOND, EPOCH - 1] {
        let mut intake = intake();
        for k in 0..100 {
            let truth = EPOCH + k * BATCH;
            let received = truth + BATCH + TRANSPORT;
            let batch = offer_at(&mut intake, truth - offset, received).expect("in order");
            let error = if offset == 0 { 0 } else { TRANSPORT };
            assert_eq!(batch.first, truth + error);
        }
        let health = &intake.health(EPOCH)[0];
        assert_eq!(health.clock_offset, offset + TRANSPORT);
        let corrected = health.clock_correction != 0;
        assert_eq!(corrected, offset.abs() > TOLERATED_OFFSET);
    }
}

#[test]
fn a_sensor_that_dies_or_sticks_is_found() {
    let mut intake = intake();
    let condition = |intake: &Intake, now| intake.health(now)[0].condition;
    assert_eq!(condition(&intake, EPOCH), SensorCondition::Waiting);
    let mut now = EPOCH;
    for k in 0..100 {
        let stamp = EPOCH + k * BATCH;
        now = stamp + BATCH + TRANSPORT;
        offer(&mut intake, stamp).expect("in order");
        assert_eq!(condition(&intake, now), SensorCondition::Alive);
    }
    // It sends, but no numbers.
    for k in 100..250 {
        let stamp = EPOCH + k * BATCH;
        let nothing = [f32::NAN; 100];
        now = stamp + BATCH + TRANSPORT;
        intake.take(&raw(&nothing, stamp), now).expect("in order");
    }
    assert_eq!(
        condition(&intake, now),
        SensorCondition::Dead(1_500 * MILLISECOND.unsigned_abs())
    );
    for k in 250..260 {
        let stamp = EPOCH + k * BATCH;
        let stuck = [1.5; 100];
        now = stamp + BATCH + TRANSPORT;
        intake.take(&raw(&stuck, stamp), now).expect("in order");
    }
    assert_eq!(condition(&intake, now), SensorCondition::Stuck);
    // A sensor that is clipped is not stuck.
    let clipped = [600.0; 100];
    for k in 260..270 {
        let stamp = EPOCH + k * BATCH;
        now = stamp + BATCH + TRANSPORT;
        intake.take(&raw(&clipped, stamp), now).expect("in order");
    }
    assert_eq!(condition(&intake, now), SensorCondition::Alive);
    now += 1_001 * MILLISECOND;
    assert!(matches!(
        condition(&intake, now),
        SensorCondition::Dead(1_001_000_000)
    ));
    // It returns: what it did not send in the meantime is one interruption.
    offer(&mut intake, now).expect("after a pause");
    let counts = counts(&intake);
    assert_eq!((counts.interruptions, counts.lost), (1, 0));
}

/// A pseudo-random sequence of faults: the same result twice, every sample counted once, and times in order.
#[test]
fn any_sequence_is_deterministic_and_loses_no_count() {
    for seed in 0..50_u64 {
        let run = || {
            let mut intake = intake();
            let (mut random, mut sent) = (seed, 0);
            let mut below = |limit: i64| {
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (random >> 33) as i64 % limit
            };
            let mut stamp = EPOCH;
            let mut results = Vec::new();
            let mut resumed = None;
            for step in 0..400 {
                match below(12) {
                    0 => stamp -= below(4) * BATCH,
                    1 => stamp += below(4) * BATCH,
                    2 => stamp += below(40_000_000) - 20_000_000,
                    3 => stamp -= below(30_000) * BATCH,
                    4 => stamp += below(3_000) * BATCH,
                    _ => {}
                }
                let count = 1 + below(150);
                let given = values(stamp, count as usize);
                let received = stamp + count * PERIOD + below(30) * MILLISECOND;
                sent += given.len() as u64;
                let result = intake.take(&raw(&given, stamp), received);
                if let Some(other) = &mut resumed {
                    // One that goes on from the state of this one takes the same.
                    assert_eq!(Intake::take(other, &raw(&given, stamp), received), result);
                    assert_eq!(other.state(), intake.state(), "{seed}");
                }
                results.push(result);
                if step % 80 == 79 {
                    let text = serde_json::to_string(&intake.state()).expect("JSON");
                    let state: IntakeState = serde_json::from_str(&text).expect("the same");
                    let mut other = self::intake();
                    assert!(other.resume(&state));
                    resumed = Some(other);
                }
                stamp += count * PERIOD;
            }
            let counts = counts(&intake);
            let SensorCounts {
                samples,
                duplicates,
                late,
                doubted,
                rejected,
                ..
            } = counts;
            assert_eq!(samples + duplicates + late + doubted, sent, "{seed}");
            assert_eq!(rejected, 0);
            (results, counts)
        };
        let (results, counts) = run();
        assert_eq!((&results, counts), (&run().0, counts));
        assert!(counts.batches > 100, "{counts:?}");
        let batches: Vec<_> = results.iter().flatten().collect();
        // A correction of the clock may move a batch by part of a sample; only a clock that was set moves it further.
        let back = batches
            .windows(2)
            .filter(|pair| pair[1].first < pair[0].end() - PERIOD)
            .count() as u64;
        assert!(back <= 2 * counts.clock_jumps, "{back} {counts:?}");
    }
}
