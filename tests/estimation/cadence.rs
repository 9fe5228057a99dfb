//! An estimate rests on its data, and not on how many estimates there were before.

use column_twin::estimation::{CredibleInterval, Estimator, ImpactEstimate, hypotheses};
use column_twin::standing::StandingColumn;

use super::beam_signals::{BEFORE, BeamSignal, parameters, sensors};

/// The data end so long after contact \[s\].
const LAST: f64 = 0.2;

/// Estimates, one every 10 ms.
const ESTIMATES: u32 = 20;

const ROUNDS: usize = 20;

/// How far the ends of two intervals may be apart, relative to the wider one of them: the 5 % quantile of 60 responses, as many as an estimate
/// aims at, has a standard deviation of 0.27 of theirs, the difference of two has 0.39, and three times this is a third of the interval of
/// 3.3 standard deviations.
const TOLERANCE: f64 = 0.35;

/// The estimate at [`LAST`] after as many others in equal steps as make this number with it.
fn last_of(estimates: u32, prepared: &Estimator, signal: &BeamSignal) -> ImpactEstimate {
    let readings = signal.readings(&sensors(), BEFORE, 5);
    let mut estimator = prepared.clone();
    estimator.begin(BEFORE, 0.3e-3, &[(0.0, 0.0); 4]);
    for (time, values) in readings.rows() {
        for (sensor, &value) in values.iter().enumerate() {
            estimator.push(sensor, time, value);
        }
    }
    for number in 1..=estimates {
        estimator.observe(BEFORE + LAST * f64::from(number) / f64::from(estimates));
        estimator.settle(ROUNDS);
    }
    estimator.estimate(BEFORE + LAST)
}

/// Distance of the ends of two intervals of a positive quantity, as logarithms and relative to the width of the wider one.
fn apart(a: &CredibleInterval, b: &CredibleInterval) -> f64 {
    let width = |it: &CredibleInterval| (it.high / it.low).ln();
    let ends = (a.low / b.low).ln().abs().max((a.high / b.high).ln().abs());
    ends / width(a).max(width(b))
}

/// Estimates every 10 ms were believed to narrow down what the last one can weigh.
#[test]
fn twenty_estimates_before_the_last_one_do_not_change_it() {
    let parameters = parameters();
    let column = StandingColumn::undamaged(&parameters);
    let hypotheses = hypotheses(&parameters);
    let mut prepared =
        Estimator::new(&parameters, &column, sensors(), hypotheses, 1).expect("sensors");
    while !prepared.prepare() {}
    for name in ["held_light_rigid_9", "held_crush_car_10"] {
        let signal = BeamSignal::make(name, &sensors(), LAST + 0.01);
        let [often, once] = [ESTIMATES, 1].map(|it| last_of(it, &prepared, &signal));
        for (quantity, a, b) in [
            ("momentum", often.momentum, once.momentum),
            ("peak", often.peak_v1, once.peak_v1),
        ] {
            let apart = apart(&a, &b);
            println!("{name}: {quantity} {a:?}, {b:?}, ends {apart:.2} of the width apart");
            assert!(apart < TOLERANCE, "{name}: {quantity} {a:?} {b:?}");
        }
    }
}
