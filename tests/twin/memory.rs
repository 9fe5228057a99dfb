//! Memory: a response allocates none, and no memory accumulates.

use column_twin::column::ImpactSpecification;
use std::hint::black_box;

use column_twin::twin::{Command, ImpactCommand, MAX_SEEN_IDS, Output, Outputs, Twin};

use crate::{MS, START, event, light, parameters};

/// Counts outputs and drops them.
#[derive(Default)]
struct Counted {
    states: u64,
    forecasts: u64,
    reports: u64,
    rejected: u64,
    statuses: u64,
    saved: u64,
}

impl Outputs for Counted {
    fn put(&mut self, output: Output) {
        match black_box(output) {
            Output::State(_) => self.states += 1,
            Output::Forecast(_) => self.forecasts += 1,
            Output::Report(_) => self.reports += 1,
            Output::Rejected(_) => self.rejected += 1,
            Output::Status(_) => self.statuses += 1,
            Output::Save(_) => self.saved += 1,
            Output::Supplemented(_)
            | Output::Withdrawn(_)
            | Output::Estimate(_)
            | Output::Replaced(_)
            | Output::Merged(_)
            | Output::DamageCorrected(_)
            | Output::ParametersChanged(_)
            | Output::Notice(_)
            | Output::Journal(_) => {}
        }
    }
}

fn twin(dt: f64) -> Twin {
    let parameters = parameters(&[("solver.dt", dt.into())]);
    Twin::new(parameters, None, Box::new(|| 0), START).expect("the column stands")
}

#[test]
fn a_response_allocates_no_memory() {
    let mut twin = twin(1e-4);
    let mut out = Counted::default();
    // With a gap, so that the response has an approach, contact, release and free vibration.
    let event = ImpactCommand {
        impact: ImpactSpecification {
            gap: Some(0.5),
            ..event("a", START).impact
        },
        ..event("a", START)
    };
    let _ = twin.handle(Command::Impact(event), START, &mut out);
    let mut now = START;
    let memory = allocation_counter::measure(|| {
        for _ in 0..80 {
            twin.run_ahead(2, now, &mut out); // not to its end: that one keeps the damage
            now += MS;
            twin.advance_to(now, &mut out);
        }
    });
    assert!(twin.is_responding() && twin.is_looking_ahead());
    assert!(
        out.states > 75 && out.statuses > 1,
        "{} {}",
        out.states,
        out.statuses
    );
    assert_eq!((memory.count_total, memory.bytes_total), (0, 0));
}

/// 10 000 events at intervals of 360 ms, with rejected events, damage and resets.
#[test]
fn an_hour_of_traffic_accumulates_no_memory() {
    let mut twin = twin(1e-3);
    let mut out = Counted::default();
    let mut now = START;
    let mut hour = |events: std::ops::Range<i64>, out: &mut Counted| {
        for k in events {
            let id = format!("impact-{k:06}");
            let input = match k % 10 {
                0 => Command::Impact(ImpactCommand {
                    impact: ImpactSpecification {
                        mass: f64::NAN,
                        ..event(&id, now).impact
                    },
                    ..event(&id, now)
                }),
                1 => Command::Impact(light("impact-000002", now)),
                2 => Command::Impact(event(&id, now)),
                3 if k % 100 == 3 => Command::Reset {
                    source: "test".into(),
                },
                4 => Command::Impact(ImpactCommand {
                    impact: ImpactSpecification {
                        gap: Some(0.02),
                        ..light(&id, now - 30 * MS).impact
                    },
                    ..light(&id, now - 30 * MS)
                }),
                _ => Command::Impact(light(&id, now)),
            };
            let _ = twin.handle(input, now, out);
            for _ in 0..24 {
                twin.run_ahead(u64::MAX, now, out);
                now += 15 * MS;
                twin.advance_to(now, out);
            }
        }
    };
    // All tables have their final size when the first identifiers have been forgotten.
    hour(0..2_000, &mut out);
    let memory = allocation_counter::measure(|| hour(2_000..10_000, &mut out));
    // The lengths of the current identifiers and reasons differ by a few bytes.
    assert!(
        memory.bytes_current.abs() < 4_096,
        "{} bytes accumulated",
        memory.bytes_current
    );
    assert_eq!(now - START, 3_600_000 * MS);
    let status = twin.status(now);
    assert!(
        out.rejected >= 1_900 && out.reports > 5_000,
        "{} {}",
        out.rejected,
        out.reports
    );
    assert_eq!(
        status.counts.events_accepted + status.counts.events_rejected,
        9_900
    );
    assert!(out.statuses < 100_000 && out.saved < 30_000 && out.forecasts >= out.reports);
    assert!(twin.saved_state(now).seen_ids.len() <= MAX_SEEN_IDS);
}
