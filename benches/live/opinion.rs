//! Time from a forecast to the same forecast with the second opinion of the fibre beam, to the one with the range of its verdict, which
//! contains the beam with a second hardening, and what the beam costs the forecast itself.

use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{
    ImpactEvent, ImpactReport, SecondOpinion, TwinStatus,
};
use column_twin::ros::qos;

use super::domain::{Domain, PATIENCE};
use super::peers::{Peer, event, now};
use super::program::Program;
use super::table::{Ranked, number, row};

/// Direction \[degrees\], velocity \[m/s\] and vehicle of the hits.
const HITS: [(f64, f64, &str); 8] = [
    (0.0, 3.0, "rigid"),
    (0.0, 6.0, "rigid"),
    (0.0, 10.0, "mid_car"),
    (0.0, 6.0, "lorry_8t"),
    (10.0, 10.0, "mid_car"),
    (45.0, 6.0, "lorry_8t"),
    (90.0, 3.0, "rigid"),
    (90.0, 10.0, "mid_car"),
];

/// How often each of them is repeated.
const ROUNDS: usize = 5;

/// Between two looks at what has arrived, each with its time.
const POLL: Duration = Duration::from_millis(1);

/// The times of all hits \[ms\]: from the event to the forecast, from the forecast to the one with the beam, and to the one with the
/// range of the verdict.
struct Times {
    forecast: Ranked,
    in_plane: Ranked,
    oblique: Ranked,
    range: Ranked,
}

fn measured(mode: &str) -> Times {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/config/heb220_s355.yaml");
    let mode = format!("beam.mode:={mode}");
    let overrides = [
        "--params-file",
        config,
        "-p",
        &mode,
        "-p",
        "column_id:=column",
    ];
    let _program = Program::ready(&domain, folder.path(), &overrides);
    let mut peer = Peer::new(&domain);
    let taken = |report: ImpactReport, _| (Instant::now(), report);
    let stamp = |it: &ImpactReport| it.header.stamp;
    let forecasts = peer.reader(&qos::IMPACT_FORECAST, taken, stamp);
    let reports = peer.reader(&qos::IMPACT_REPORT, taken, stamp);
    let reset = peer.reset();
    let events = peer.publisher::<ImpactEvent>(&qos::IMPACT_EVENT);
    let millis = |from: Instant, to: Instant| 1e3 * to.duration_since(from).as_secs_f64();
    let (mut forecast_times, mut in_plane, mut oblique) = (vec![], vec![], vec![]);
    let mut range_times = vec![];
    for number in 0..ROUNDS * HITS.len() {
        let (degrees, velocity, vehicle) = HITS[number % HITS.len()];
        let id = format!("impact-{number:06}");
        let mass = if vehicle == "rigid" { 1500.0 } else { 0.0 };
        let sent = Instant::now();
        events
            .publish(ImpactEvent {
                vehicle: vehicle.to_owned(),
                direction: f64::to_radians(degrees),
                ..event(&id, now(), mass, velocity)
            })
            .expect("room for one");
        let (mut forecast, mut known, mut range, mut is_over) = (None, None, None, false);
        let end = Instant::now() + PATIENCE;
        // The beam comes with the forecast, or with the result where the response is over by then.
        while forecast.is_none() || known.is_none() || range.is_none() || !is_over {
            assert!(
                Instant::now() < end,
                "no forecast, result, second opinion or range of the verdict on {id}"
            );
            for (reader, is_result) in [(&forecasts, false), (&reports, true)] {
                for (at, it) in reader.arrivals.try_iter() {
                    if it.event_id != id {
                        continue;
                    }
                    is_over |= is_result;
                    forecast.get_or_insert(at);
                    if it.range_most != TwinStatus::ACTION_UNKNOWN {
                        range.get_or_insert(at);
                    }
                    if it.beam.state != SecondOpinion::PENDING {
                        known.get_or_insert((at, it.beam));
                    }
                }
            }
            std::thread::sleep(POLL);
        }
        let received = forecast.expect("it was awaited");
        let (at, beam) = known.expect("it was awaited");
        forecast_times.push(millis(sent, received));
        if beam.state == SecondOpinion::KNOWN {
            let times = if degrees == 0.0 {
                &mut in_plane
            } else {
                &mut oblique
            };
            times.push(millis(received, at));
        }
        range_times.push(millis(received, range.expect("it was awaited")));
        reset();
    }
    Times {
        forecast: Ranked::new(forecast_times),
        in_plane: Ranked::new(in_plane),
        oblique: Ranked::new(oblique),
        range: Ranked::new(range_times),
    }
}

pub fn run(_: Duration) {
    let [without, with] = ["off", "second_opinion"].map(measured);
    println!(
        "HEB220 in S355, {} hits by cars, lorries and rigid masses at 0 to 90 degrees, each on an undamaged column",
        with.forecast.len()
    );
    row("[ms]", ["p50", "p95", "p99", "max"].map(str::to_owned));
    for (name, times) in [
        ("event to forecast, beam.mode: off", &without.forecast),
        ("event to forecast, with the beam", &with.forecast),
        ("forecast to second opinion, in the plane", &with.in_plane),
        ("forecast to second opinion, oblique", &with.oblique),
        ("forecast to the range of the verdict", &with.range),
    ] {
        let columns = [50.0, 95.0, 99.0, 100.0].map(|percent| times.percentile(percent));
        row(name, columns.map(number));
    }
    let ratio =
        |percent: f64| with.forecast.percentile(percent) / without.forecast.percentile(percent);
    row(
        "forecast with the beam / without",
        [50.0, 95.0, 99.0, 100.0].map(|percent| number(ratio(percent))),
    );
}
