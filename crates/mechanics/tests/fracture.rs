//! Where a section fractures.

mod example;

use column_mechanics::{ColumnProperties, Impact, Outcome, Report, Sample, simulate};

fn respond(properties: &ColumnProperties, impact: &Impact, duration: f64) -> (Report, Vec<Sample>) {
    let mut samples = Vec::new();
    let report = simulate(properties, impact, duration, &mut |sample| {
        samples.push(*sample);
    })
    .expect("a response");
    (report, samples)
}

/// Version 0.3 compared each of the hinges 1a and 1b with the limit, so that the fracture hung on the split of the kink between
/// them, which is undetermined.
#[test]
fn the_kink_at_the_impact_point_tears_however_it_is_split() {
    let (mut properties, impact) = example::paper();
    // The split depends on the place of the impact.
    let mut shares = Vec::new();
    for below in [1.0, 1.25, 1.5, 1.75, 2.0] {
        (properties.length_below, properties.length_above) = (below, 4.0 - below);
        properties.ultimate_rotation = 0.0;
        let (whole, _) = respond(&properties, &impact, 0.1);
        let [a, b, _, _] = whole.hinges.map(|hinge| hinge.plastic_rotation);
        assert!(a >= 0.0 && b >= 0.0);
        shares.push(a.max(b) / (a + b));
        let limit = 0.99 * (a + b);
        properties.ultimate_rotation = limit;
        let (fractured, samples) = respond(&properties, &impact, 0.1);
        assert_eq!(fractured.outcome, Outcome::Fractured, "{below} m");
        let last = samples.last().expect("samples").hinges;
        let kink = last[0].plastic_rotation + last[1].plastic_rotation;
        assert!(kink > limit && kink < 1.01 * limit, "{kink} {limit}");
        properties.ultimate_rotation = 1.01 * whole.hinges[3].plastic_rotation.max(a + b);
        let (stands, _) = respond(&properties, &impact, 0.1);
        assert_eq!(stands.outcome, Outcome::Plastic, "{below} m");
    }
    println!("share of the larger of both: {shares:.3?}");
    assert!(shares.iter().any(|share| *share < 0.95));
}
