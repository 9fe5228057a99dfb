//! What a drawing shows of a hit is what the opinion says of it.

use crate::reference::{column, column_hit_three_times, hit};
use column_beam::{BeamModel, InTurn, Outcome};

#[test]
fn a_drawn_movement_has_the_peak_and_the_remains_of_the_opinion() {
    let (it, hits) = column_hit_three_times();
    let model = BeamModel::new(&it).unwrap();
    let mut damage = None;
    for hit in hits {
        let movement = model.movement(&hit, damage.as_ref()).unwrap();
        let opinion = model.opinion(&hit, damage.as_ref(), &InTurn).unwrap();
        let watched = model.opinion_and_movement(&hit, damage.as_ref(), &InTurn);
        let (watched, same) = watched.unwrap();
        // Who watches changes nothing.
        assert!(watched == opinion && same == movement);
        let (found, after) = (opinion.outcome, opinion.damage);
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
        let [there, sideways, _] = remains[node];
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

#[test]
fn the_fibres_that_have_yielded_lie_in_the_section_and_move_with_the_axis() {
    let mut it = column("HEB220", 355e6, 1e-2);
    (it.top_load, it.top_spring_stiffness, it.shear) = (0.5e6, 1e7, true);
    let model = BeamModel::new(&it).unwrap();
    for degrees in [0.0, 30.0] {
        let gentle = model.movement(&hit(1500.0, 0.5, None, degrees), None);
        assert!(gentle.unwrap().yielded.is_empty());
        let movement = model.movement(&hit(1500.0, 6.0, None, degrees), None);
        let movement = movement.unwrap();
        let remains = movement.remains.as_ref().unwrap();
        let (sin, cos) = libm::sincos(f64::to_radians(degrees));
        let mut sides = [0, 0];
        for fibre in &movement.yielded {
            let [along, across, height] = fibre.place;
            // The section of an HEB220 is 220 mm deep and wide, and 16 mm of it are flanges.
            let (y, z) = (cos * along - sin * across, sin * along + cos * across);
            assert!(y.abs() < 0.11 && z.abs() < 0.11, "{fibre:?}");
            assert!(y.abs() > 0.094 || z.abs() < 0.01, "{fibre:?}");
            assert!((1e-7..0.2).contains(&fibre.plastic_strain), "{fibre:?}");
            sides[usize::from(y > 0.0)] += 1;
            let above = movement.heights.partition_point(|it| *it <= height);
            let (low, high) = (movement.heights[above - 1], movement.heights[above]);
            let share = (height - low) / (high - low);
            let axis = [0, 1, 2]
                .map(|k| (1.0 - share) * remains[above - 1][k] + share * remains[above][k]);
            // A plane section turns without changing its size.
            let arm = |place: [f64; 3]| place.map(|x| x * x).iter().sum::<f64>().sqrt();
            let turned = arm([0, 1, 2].map(|k| fibre.moved[k] - axis[k] + [along, across, 0.0][k]));
            let before = arm([along, across, 0.0]);
            assert!(
                (turned - before).abs() < 0.01 * before + 1e-4,
                "{fibre:?}: {turned} m"
            );
        }
        println!("{degrees} degrees: {sides:?} fibres on each side have yielded");
        assert!(sides[0] > 4 && sides[1] > 4);
        // The largest plastic strain is at the base or at the impact point.
        let most = movement.yielded.iter();
        let most = most.max_by(|one, other| one.plastic_strain.total_cmp(&other.plastic_strain));
        let height = most.unwrap().place[2];
        let depth = 0.22;
        assert!(
            height < depth || (height - it.length_below).abs() < depth,
            "{height}"
        );
    }
}
