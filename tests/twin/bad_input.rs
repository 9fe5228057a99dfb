//! Rejected commands change nothing, and their senders can read the reason.

use column_twin::column::ImpactSpecification;
use column_twin::twin::{ImpactCommand, MAX_EVENT_ID_CHARS, MAX_REASON_CHARS, RejectedInput};

use crate::{Bench, MS, START, event};

fn rejection_of(event: ImpactCommand) -> String {
    let mut bench = Bench::new(&[]);
    let before = bench.twin.saved_state(START);
    bench.hit(event);
    let rejections = bench.rejections();
    assert_eq!(rejections.len(), 1, "{rejections:?}");
    assert_eq!(rejections[0].what, RejectedInput::Impact);
    let reason = rejections[0].rejection.reason.to_string();
    let status = bench.status();
    assert_eq!(*status.last_rejection_reason, *reason);
    assert_eq!(
        (status.counts.events_rejected, status.counts.events_accepted),
        (1, 0)
    );
    let mut after = bench.twin.saved_state(START);
    assert_eq!(after.rejected_since_reset, 1);
    after.rejected_since_reset = 0;
    assert_eq!(after, before);
    assert!(!bench.twin.is_responding() && !bench.twin.is_looking_ahead());
    reason
}

#[test]
fn invalid_numbers_are_rejected() {
    let good = event("a", START);
    for (bad, expected) in [
        (
            ImpactCommand {
                impact: ImpactSpecification {
                    mass: f64::NAN,
                    ..good.clone().impact
                },
                ..good.clone()
            },
            "mass = NaN: is required, because a rigid vehicle has no mass of its own",
        ),
        (
            ImpactCommand {
                impact: ImpactSpecification {
                    mass: -1500.0,
                    ..good.clone().impact
                },
                ..good.clone()
            },
            "mass = -1500: is out of range",
        ),
        (
            ImpactCommand {
                impact: ImpactSpecification {
                    mass: f64::INFINITY,
                    ..good.clone().impact
                },
                ..good.clone()
            },
            "mass = inf",
        ),
        (
            ImpactCommand {
                impact: ImpactSpecification {
                    velocity: 0.0,
                    ..good.clone().impact
                },
                ..good.clone()
            },
            "velocity = 0: is out of range; allowed: 1e-6 to 60 m/s",
        ),
        (
            ImpactCommand {
                impact: ImpactSpecification {
                    velocity: -10.0,
                    ..good.clone().impact
                },
                ..good.clone()
            },
            "velocity = -10",
        ),
        (
            ImpactCommand {
                impact: ImpactSpecification {
                    velocity: 1e300,
                    ..good.clone().impact
                },
                ..good.clone()
            },
            "velocity = 1",
        ),
        (
            ImpactCommand {
                impact: ImpactSpecification {
                    gap: Some(f64::NAN),
                    ..good.clone().impact
                },
                ..good.clone()
            },
            "gap = NaN",
        ),
        (
            ImpactCommand {
                impact: ImpactSpecification {
                    gap: Some(-0.1),
                    ..good.clone().impact
                },
                ..good.clone()
            },
            "gap = -0.1",
        ),
        (
            ImpactCommand {
                impact: ImpactSpecification {
                    restitution: Some(1.1),
                    ..good.clone().impact
                },
                ..good.clone()
            },
            "restitution = 1.1",
        ),
        (
            ImpactCommand {
                impact: ImpactSpecification {
                    height: Some(f64::NAN),
                    ..good.clone().impact
                },
                ..good.clone()
            },
            "height = NaN",
        ),
        (
            ImpactCommand {
                impact: ImpactSpecification {
                    height: Some(-1.0),
                    ..good.clone().impact
                },
                ..good.clone()
            },
            "height = -1",
        ),
        (
            ImpactCommand {
                impact: ImpactSpecification {
                    height: Some(4.0),
                    ..good.clone().impact
                },
                ..good.clone()
            },
            "the column is 4 m high",
        ),
    ] {
        let reason = rejection_of(bad);
        assert!(reason.contains(expected), "{reason}");
    }
}

#[test]
fn all_invalid_numbers_are_listed() {
    let bad = ImpactCommand {
        impact: ImpactSpecification {
            mass: f64::NAN,
            velocity: 0.0,
            gap: Some(-1.0),
            ..event("a", START).impact
        },
        ..event("a", START)
    };
    let reason = rejection_of(bad);
    assert!(
        ["mass", "velocity", "gap"]
            .iter()
            .all(|name| reason.contains(name)),
        "{reason}"
    );
}

/// A field that a sender leaves out of a message is 0: the rejection tells how to leave it open.
#[test]
fn a_height_of_0_is_rejected_with_a_hint_at_nan() {
    let good = event("a", START);
    let hint = "NaN (in YAML: .nan) takes the value of the parameter";
    let mut of_height = good.clone();
    of_height.impact.height = Some(0.0);
    let reason = rejection_of(of_height);
    assert!(
        reason.starts_with("height = 0: is out of range") && reason.ends_with(hint),
        "{reason}"
    );
    let mut of_gap = good.clone();
    of_gap.impact.gap = Some(-1.0);
    let reason = rejection_of(of_gap);
    assert!(reason.ends_with(hint), "{reason}");
}

/// f64::MAX has 309 digits.
#[test]
fn a_number_of_300_digits_is_shortened() {
    let impact = event("a", START).impact;
    for (impact, expected) in [
        (
            ImpactSpecification {
                mass: 1e300,
                ..impact
            },
            "mass = 1e300: is out of range",
        ),
        (
            ImpactSpecification {
                velocity: f64::MAX,
                ..impact
            },
            "velocity = 1.7976931348623157e308: is",
        ),
        (
            ImpactSpecification {
                height: Some(-1e299),
                ..impact
            },
            "height = -1e299: is out of range",
        ),
        (
            ImpactSpecification {
                gap: Some(1e200),
                ..impact
            },
            "gap = 1e200: is out of range",
        ),
    ] {
        let reason = rejection_of(ImpactCommand {
            impact,
            ..event("a", START)
        });
        assert!(reason.starts_with(expected), "{reason}");
        assert!(!reason.contains("0000000000"), "{reason}");
    }
    let light = ImpactCommand {
        vehicle: "mid_car".to_owned(),
        impact: ImpactSpecification {
            mass: -1e300,
            ..impact
        },
        ..event("a", START)
    };
    let reason = rejection_of(light);
    assert!(reason.contains("-1e300 kg"), "{reason}");
}

#[test]
fn invalid_identifiers_are_rejected() {
    let good = event("a", START);
    let other = rejection_of(ImpactCommand {
        column_id: "other\u{1b}[31m".into(),
        ..good.clone()
    });
    assert_eq!(
        other,
        "column_id is \"other\\u{1b}[31m\", but this is the twin of column \"column\""
    );
    let empty = rejection_of(ImpactCommand {
        event_id: String::new(),
        ..good.clone()
    });
    assert!(empty.contains("event_id is empty"));
    let long = "x".repeat(MAX_EVENT_ID_CHARS + 1);
    assert!(
        rejection_of(ImpactCommand {
            event_id: long,
            ..good.clone()
        })
        .contains("too long")
    );
    let control = rejection_of(ImpactCommand {
        event_id: "a\nb".into(),
        ..good.clone()
    });
    assert!(control.contains("control characters"));
}

#[test]
fn huge_identifiers_are_not_stored() {
    let mut bench = Bench::new(&[]);
    let huge = "x".repeat(10_000_000);
    bench.hit(ImpactCommand {
        event_id: huge.clone(),
        column_id: huge,
        ..event("", START)
    });
    let rejected = bench.rejections()[0].clone();
    assert!(rejected.rejection.reason.len() < MAX_REASON_CHARS && rejected.event_id.len() < 300);
}

#[test]
fn stamps_outside_the_tolerance_are_rejected() {
    for (stamp, expected) in [
        (
            START - 5_001 * MS,
            "the stamp is 5.001 s old; event.max_age is 5 s",
        ),
        (
            START + 1_001 * MS,
            "the stamp is 1.001 s ahead; event.max_ahead is 1 s",
        ),
        (0, "the stamp is zero"),
        (1, "s old"),
        (i64::MIN, "a second or more of nanoseconds"),
        (i64::MIN + 1, "s old"),
        (i64::MAX, "s ahead"),
    ] {
        let reason = rejection_of(event("a", stamp));
        assert!(reason.contains(expected), "{reason}");
    }
    for stamp in [START - 5_000 * MS, START + 1_000 * MS] {
        let mut bench = Bench::new(&[]);
        bench.hit(event("a", stamp));
        assert!(bench.rejections().is_empty());
    }
}

#[test]
fn a_repeated_identifier_is_rejected() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.hit(event("a", START + MS));
    bench.rest();
    bench.hit(event("a", bench.now));
    let reasons: Vec<_> = bench
        .rejections()
        .iter()
        .map(|it| it.rejection.reason.to_string())
        .collect();
    assert_eq!(reasons.len(), 2);
    assert!(
        reasons.iter().all(|it| it.contains("was accepted before")),
        "{reasons:?}"
    );
    assert_eq!(bench.reports().len(), 1);
}

/// A sender may correct a rejected event.
#[test]
fn the_identifier_of_a_rejected_event_can_be_used_again() {
    let mut bench = Bench::new(&[]);
    bench.hit(ImpactCommand {
        impact: ImpactSpecification {
            velocity: 0.0,
            ..event("a", START).impact
        },
        ..event("a", START)
    });
    bench.hit(event("a", START));
    assert_eq!(
        (bench.rejections().len(), bench.twin.is_responding()),
        (1, true)
    );
}

#[test]
fn a_rejection_during_a_response_does_not_disturb_it() {
    let mut quiet = Bench::new(&[]);
    quiet.hit(event("a", START));
    quiet.rest();
    let mut loud = Bench::new(&[]);
    loud.hit(event("a", START));
    for k in 0..20 {
        loud.go_on(MS);
        loud.hit(ImpactCommand {
            impact: ImpactSpecification {
                mass: f64::NAN,
                ..event(&k.to_string(), loud.now).impact
            },
            ..event(&k.to_string(), loud.now)
        });
    }
    loud.rest();
    assert_eq!(loud.rejections().len(), 20);
    let samples = |bench: &Bench| -> Vec<_> { bench.states().iter().map(|it| it.sample).collect() };
    assert_eq!(samples(&quiet), samples(&loud));
    assert_eq!(quiet.reports()[0].report, loud.reports()[0].report);
}

/// All events are rejected or computed, and counted, and the twin continues.
#[test]
fn ten_thousand_events_in_a_second() {
    let mut bench = Bench::new(&[("solver.dt", 1e-3.into())]);
    for k in 0..10_000 {
        bench.hit(event(&format!("{}", k % 3_000), bench.now));
        bench.now += 100_000;
        bench.twin.advance_to(bench.now, &mut bench.out);
    }
    bench.rest();
    let counts = bench.status().counts;
    assert_eq!(counts.events_accepted + counts.events_rejected, 10_000);
    assert_eq!(counts.events_rejected, bench.rejections().len() as u64);
    assert!(counts.events_accepted >= 1);
}

/// It was once called 1795303513 s old.
#[test]
fn a_stamp_of_zero_is_one_that_was_not_set() {
    let reason = rejection_of(event("a", 0));
    assert!(
        reason.contains("the stamp is zero") && reason.contains("header.stamp"),
        "{reason}"
    );
}
