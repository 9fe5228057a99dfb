//! What a drawing shows of a hit is what the opinion says of it.

use crate::reference::{column, column_hit_three_times, hit};
use column_beam::{BeamModel, Outcome};

#[test]
fn a_drawn_movement_has_the_peak_and_the_remains_of_the_opinion() {
    let (it, hits) = column_hit_three_times();
    let model = BeamModel::new(&it).unwrap();
    let mut damage = None;
    for hit in hits {
        let movement = model.movement(&hit, damage.as_ref()).unwrap();
        let (found, after) = model.simulate(&hit, damage.as_ref()).unwrap();
        let [along, across] = found.displaced_before_m;
        let close = |one: f64, other: f64| (one - other).abs() < 1e-12;
        let [time, ..] = movement.points[0];
        assert!(time == 0.0 && close(movement.points[0][1], along));
        let furthest = movement.points.iter().map(|it| it[1]);
        let peak = furthest.fold(f64::NEG_INFINITY, f64::max);
        assert!(close(peak, along + found.max_displacement_m), "{peak}");
        let at = movement.points.iter().find(|it| it[1] == peak).unwrap();
        assert!(close(at[0], found.max_displacement_time_s), "{at:?}");
        let node = (0..movement.heights.len())
            .find(|node| close(movement.heights[*node], it.length_below))
            .unwrap();
        assert!(close(movement.peak[node][0], peak));
        let remains = movement.remains.unwrap();
        let [there, sideways] = remains[node];
        assert!(close(there, along + found.residual_displacement_m));
        let sideways = (sideways - across).abs();
        assert!(close(sideways, found.residual_sideways_m), "{sideways}");
        let bow = remains.iter().map(|it| libm::hypot(it[0], it[1]));
        assert!(close(bow.fold(0.0, f64::max), found.residual_bow_m));
        assert_eq!(found.outcome, Outcome::Plastic);
        damage = after;
    }
}

#[test]
fn a_long_movement_is_thinned_and_reaches_the_end() {
    let mut it = column("HEB220", 355e6, 1e-3);
    it.step_nanos = 5_000;
    let model = BeamModel::new(&it).unwrap();
    let hit = hit(1500.0, 10.0, None, 0.0);
    let (found, _) = model.simulate(&hit, None).unwrap();
    assert!(found.steps > 4096, "{} steps", found.steps);
    let points = model.movement(&hit, None).unwrap().points;
    assert!((1024..=2048).contains(&points.len()), "{}", points.len());
    let gaps: Vec<f64> = points.windows(2).map(|it| it[1][0] - it[0][0]).collect();
    let [least, most] = [
        gaps.iter().copied().fold(f64::INFINITY, f64::min),
        gaps.iter().copied().fold(0.0, f64::max),
    ];
    assert!(least > 0.5 * most, "{least} {most}");
    let end = 5e-6 * found.steps as f64;
    let last = points[points.len() - 1][0];
    assert!(
        (end - 2.0 * most..=end + 1e-9).contains(&last),
        "{last} {end}"
    );
    let peak = points.iter().map(|it| it[1]).fold(0.0, f64::max);
    assert!((peak / found.max_displacement_m - 1.0).abs() < 1e-5);
}
