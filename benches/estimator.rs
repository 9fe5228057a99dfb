//! What live estimation costs one processor: preparation, and each estimate of the fibre-beam signals while their data
//! arrive in batches of 10 ms.
//!
//! The work runs in one thread. Its processor time is the clock by which the data arrive, so that other load on the machine
//! falsifies the figures little.

use column_twin::estimation::{Sensing, Work};
use column_twin::standing::StandingColumn;
use rustix::time::{ClockId, clock_gettime};
use signals::{NAMES, START, Signal, batches, with_sensors};

#[allow(dead_code)] // the tests use the rest of it
#[path = "../tests/estimation/signals.rs"]
mod signals;

/// Samples of a batch: 10 ms.
const SAMPLES: usize = 100;

const SETS: [(&str, &[usize]); 2] = [("8", &[0, 1, 2, 3, 4, 5, 6, 7]), ("3", &[1, 3, 4])];

/// Processor time of this thread \[ms\].
fn now() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

fn main() {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("load {}", load.trim());
    println!(
        "milliseconds of one processor; lag: from the arrival of the data to the estimate; slice: longest time without a look at \
         new data\n{:<18}{:>8}{:>10}{:>7}{:>10}{:>10}{:>10}{:>10}{:>8}{:>8}{:>8}",
        "signal",
        "sensors",
        "prepare",
        "slice",
        "estimates",
        "first lag",
        "lag p50",
        "lag max",
        "slice",
        "drawn",
        "eff.",
    );
    for name in NAMES {
        let signal = Signal::read(name);
        for (sensors, chosen) in SETS {
            row(&signal, sensors, chosen);
        }
    }
}

fn row(signal: &Signal, count: &str, chosen: &[usize]) {
    let (sensors, readings) = signal.readings(chosen, 7);
    let parameters = with_sensors(&signal.parameters(), &sensors);
    let column = StandingColumn::undamaged(&parameters);
    let mut sensing = Sensing::new(&parameters, column).expect("sensors");
    let began = now();
    let mut slices = Vec::new();
    loop {
        let before = now();
        let work = sensing.step();
        slices.push(now() - before);
        if work == Work::Idle {
            break;
        }
    }
    let (prepare, prepare_slice) = (now() - began, largest(&slices));
    slices.clear();

    let mut arriving = batches(&readings, SAMPLES).into_iter().peekable();
    let arrival = |end: i64| 1e-6 * (end - START) as f64;
    let mut time = 0.0;
    let (mut lags, mut drawn, mut effective) = (Vec::new(), 0, Vec::new());
    loop {
        while let Some((number, batch)) =
            arriving.next_if(|(_, batch)| arrival(batch.end()) <= time)
        {
            let before = now();
            sensing.push(number, batch);
            time += now() - before;
        }
        let before = now();
        let work = sensing.step();
        let spent = now() - before;
        time += spent;
        if sensing.is_estimating() {
            slices.push(spent);
        }
        match work {
            Work::Estimate(record) => {
                // The batch that completes its data.
                let until = arrival(record.origin) + 1e3 * record.estimate.data_until;
                lags.push(time - (until / 10.0 - 1e-6).ceil() * 10.0);
                drawn += record.drawn_before + record.drawn;
                effective.push(record.estimate.effective_sample_size);
            }
            Work::Idle => match arriving.peek() {
                Some((_, batch)) => time = arrival(batch.end()).max(time),
                None => break,
            },
            Work::More { .. } => {}
            Work::Missed(reason) => panic!("{reason}"),
        }
    }
    let first = lags.first().copied().unwrap_or(f64::NAN);
    println!(
        "{:<18}{count:>8}{prepare:>10.0}{prepare_slice:>7.1}{:>10}{first:>10.1}{:>10.1}{:>10.1}{:>8.1}{drawn:>8}{:>8.0}",
        signal.name,
        lags.len(),
        median(&mut lags.clone()),
        largest(&lags),
        largest(&slices),
        median(&mut effective),
    );
}
