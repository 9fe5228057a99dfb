//! Rank histograms: impacts that the estimator itself conceives, with the errors that it assumes of model and sensors, and where the truth
//! lies in what it says of them (simulation-based calibration, Talts et al. 2018, arXiv:1804.06788).

use column_twin::estimation::{Estimator, hypotheses};
use column_twin::standing::StandingColumn;

use super::beam_signals::{parameters, sensors};
use super::signals::Normal;

/// Impacts; the environment variable `COLUMN_TWIN_RANKS` gives another number.
const IMPACTS: u64 = 1000;

/// Added to the seed of an impact for the errors that are drawn here: both generators are the same, and would give equal numbers.
const OTHER_NUMBERS: u64 = 1 << 32;

const BINS: usize = 10;

/// Value that chi-square of 9 degrees of freedom exceeds with a probability of 1 % (NIST/SEMATECH e-Handbook, 1.3.6.7.4).
const CHI_SQUARE: f64 = 21.666;

/// The contact is detected with this standard deviation \[s\].
const CONTACT_DEVIATION: f64 = 0.3e-3;

/// Times after contact at which the estimator looks at the data \[s\].
const INSTANTS: [f64; 4] = [0.010, 0.030, 0.100, 0.350];

const ROUNDS: usize = 20;

const QUANTITIES: [&str; 3] = ["momentum", "peak", "residual"];

fn chi_square(histogram: &[u32; BINS]) -> f64 {
    let expected = f64::from(histogram.iter().sum::<u32>()) / BINS as f64;
    let each = histogram
        .iter()
        .map(|it| (f64::from(*it) - expected).powi(2) / expected);
    each.sum()
}

#[test]
#[ignore = "slow: estimates of many impacts take minutes"]
fn truths_are_uniformly_distributed_within_the_estimates_of_impacts_that_the_estimator_conceives() {
    let impacts =
        std::env::var("COLUMN_TWIN_RANKS").map_or(IMPACTS, |it| it.parse().expect("a number"));
    let parameters = parameters();
    let column = StandingColumn::undamaged(&parameters);
    let (hypotheses, sensors) = (hypotheses(&parameters), sensors());
    let zeros = vec![(0.0, 0.0); sensors.len()];
    let mut estimator =
        Estimator::new(&parameters, &column, sensors, hypotheses, 1).expect("sensors");
    while !estimator.prepare() {}
    let mut histograms = [[0_u32; BINS]; 3];
    for seed in 0..impacts {
        let Some(conceived) = estimator.conceive(seed) else {
            println!("{seed}: no response");
            continue;
        };
        let mut normal = Normal::new(seed + OTHER_NUMBERS);
        let contact = CONTACT_DEVIATION * normal.next();
        estimator.begin(contact, CONTACT_DEVIATION, &zeros);
        for (time, values) in conceived.readings.rows() {
            for (sensor, &value) in values.iter().enumerate() {
                estimator.push(sensor, time, value);
            }
        }
        for instant in INSTANTS {
            estimator.observe(contact + instant);
            estimator.settle(ROUNDS);
        }
        let stands = conceived.outcome.stands();
        // What the readings leave open of the scale of the sensor that tells the peak.
        let scale = (estimator.peak_scale_deviation() * normal.next()).exp();
        let peak = scale * conceived.peak_v1;
        let shares = estimator.shares_below(conceived.momentum, peak, conceived.residual_v1);
        println!(
            "{seed}: {:.0} kg at {:.1} m/s, {:.0} N s, {:.2} mm, {:.2} mm, {:?}: {shares:.3?}, {:.0} effective",
            conceived.impact.mass,
            conceived.impact.velocity,
            conceived.momentum,
            1e3 * conceived.peak_v1,
            1e3 * conceived.residual_v1,
            conceived.outcome,
            estimator.effective_sample_size(),
        );
        // A column that gives way has neither a peak nor a residual displacement.
        let compared = if stands { QUANTITIES.len() } else { 1 };
        for (histogram, share) in histograms.iter_mut().zip(shares).take(compared) {
            histogram[((share * BINS as f64) as usize).min(BINS - 1)] += 1;
        }
    }
    for (name, histogram) in QUANTITIES.iter().zip(&histograms) {
        println!(
            "{name}: {histogram:?}, chi-square {:.1}",
            chi_square(histogram)
        );
    }
    for (name, histogram) in QUANTITIES.iter().zip(&histograms) {
        let found = chi_square(histogram);
        assert!(
            found < CHI_SQUARE,
            "{name}: {histogram:?} is not uniform, {found:.1}"
        );
    }
}
