//! Damage that a measurement on the column at rest corrects.

use crate::reference::{column, hit, hit_by_a_car};
use column_beam::{BeamError, BeamModel, Measurement};

fn measurement(height: f64, value: f64) -> Measurement {
    Measurement {
        is_rotation: false,
        height,
        value,
        deviation: 1e-4,
        factors: [0.5, 2.0],
    }
}

/// The next hit finds the column where it was measured, in equilibrium: a touch leaves it there.
#[test]
fn the_corrected_beam_has_what_was_measured() {
    let mut it = column("HEB220", 355e6, 1e-3);
    it.top_load = 0.5e6;
    hit_by_a_car(&mut it);
    let model = BeamModel::new(&it).unwrap();
    let touch = hit(1500.0, 0.02, None, 0.0);
    for degrees in [0.0, 20.0] {
        let hit = hit(1500.0, 6.0, None, degrees);
        let (found, damage) = model.simulate(&hit, None).unwrap();
        let damage = damage.unwrap();
        let angle = degrees.to_radians();
        let along_web =
            |along: f64, across: f64| along * libm::cos(angle) - across * libm::sin(angle);
        let (before, _) = model.simulate(&touch, Some(&damage)).unwrap();
        let y = before.displaced_before_m[0];
        let signed = [1.0, -1.0].map(|sign| {
            along_web(
                found.residual_displacement_m,
                sign * found.residual_sideways_m,
            )
        });
        assert!(
            signed.iter().any(|it| (it / y - 1.0).abs() < 1e-3),
            "{signed:?} {y}"
        );
        let mut capacities = Vec::new();
        for factor in [0.8, 1.3] {
            let value = factor * y;
            let measured = measurement(it.length_below, value);
            let corrected = model.corrected(&damage, &measured).unwrap();
            let (again, _) = model.simulate(&touch, Some(&corrected)).unwrap();
            let now = again.displaced_before_m;
            assert!((now[0] - value).abs() < 2e-6, "{now:?} {value}");
            // The shape remains, so that across it is corrected with it.
            let across = before.displaced_before_m[1];
            if degrees > 0.0 {
                assert!(
                    (now[1] / (factor * across) - 1.0).abs() < 0.1,
                    "{now:?} {across}"
                );
            }
            assert!(again.residual_displacement_m.abs() < 2e-5);
            let bow = again.residual_bow_m / before.residual_bow_m;
            assert!((bow / factor - 1.0).abs() < 0.1, "{bow}");
            capacities.push(model.capacity_left([4e-3; 2], &corrected));
            // What is measured once more is there.
            assert_eq!(model.corrected(&corrected, &measured).unwrap(), corrected);
        }
        let uncorrected = model.capacity_left([4e-3; 2], &damage);
        assert!(capacities[0] > uncorrected && uncorrected > capacities[1]);
        let near = measurement(it.length_below, y + 0.9e-4);
        assert_eq!(model.corrected(&damage, &near).unwrap(), damage);
        let far = measurement(it.length_below, 3.0 * y);
        let error = model.corrected(&damage, &far).unwrap_err();
        assert!(matches!(error, BeamError::Correction { .. }), "{error}");
    }
}

#[test]
fn a_rotation_corrects_the_beam_too() {
    let mut it = column("HEB220", 355e6, 1e-3);
    it.top_load = 0.5e6;
    let model = BeamModel::new(&it).unwrap();
    let (_, damage) = model.simulate(&hit(1500.0, 8.0, None, 0.0), None).unwrap();
    let damage = damage.unwrap();
    let touch = hit(1500.0, 0.02, None, 0.0);
    let at_impact = |damage| {
        let (found, _) = model.simulate(&touch, Some(damage)).unwrap();
        found.displaced_before_m[0]
    };
    // Half-way to the impact point, the bar between base and impact leans by about the displacement over its length.
    let before = at_impact(&damage);
    let measured = Measurement {
        is_rotation: true,
        value: 1.2 * before / it.length_below,
        ..measurement(0.5, 0.0)
    };
    let after = at_impact(&model.corrected(&damage, &measured).unwrap());
    assert!((1.1..1.3).contains(&(after / before)), "{before} {after}");
}
