//! Steel with a yield plateau.

use crate::reference::{column, column_hit_three_times, hit};
use column_beam::{BeamColumn, BeamError, BeamModel, Outcome};

fn with_plateau(mut column: BeamColumn) -> BeamColumn {
    column.steel.hardening_ratio = 1e-4;
    column.steel.tensile_strength = Some(490e6);
    column
}

/// As long as hardly any fibre passes its plateau, the steel is the bilinear one with the slope of the plateau.
#[test]
fn a_column_that_stays_on_the_plateau_answers_as_with_a_bilinear_steel() {
    for residual_stress in [false, true] {
        let mut it = column("HEB220", 355e6, 1e-4);
        it.top_load = 0.5e6;
        it.top_spring_stiffness = 1e7;
        it.residual_stress = residual_stress;
        for shear in [false, true] {
            it.shear = shear;
            for degrees in [0.0, 20.0] {
                let hit = hit(1500.0, 1.7, None, degrees);
                let plain = BeamModel::new(&it).unwrap().simulate(&hit, None).unwrap().0;
                let other = BeamModel::new(&with_plateau(it)).unwrap();
                let found = other.simulate(&hit, None).unwrap().0;
                assert_eq!(plain.outcome, Outcome::Plastic);
                let ratio = found.max_displacement_m / plain.max_displacement_m;
                // About the weak axis the tips of the flanges pass their plateau.
                let [of_peak, of_residual] = match degrees {
                    0.0 => [1e-4, 1e-3],
                    _ => [1e-3, 1e-2],
                };
                assert!((ratio - 1.0).abs() < of_peak, "{shear} {degrees}: {ratio}");
                let difference = found.residual_displacement_m - plain.residual_displacement_m;
                let ratio = difference / plain.max_displacement_m;
                assert!(ratio.abs() < of_residual, "{shear} {degrees}: {ratio}");
                assert!(found.energy_error.abs() < 1e-8, "{}", found.energy_error);
            }
        }
    }
}

/// Pushed from the side, the column resists as with a bilinear steel until its hinges pass the plateau, and then by up to the
/// tensile strength over the yield strength more.
#[test]
fn a_column_pushed_sideways_hardens_beyond_its_plateau_up_to_its_tensile_strength() {
    for shear in [false, true] {
        let mut it = column("HEB220", 355e6, 1e-4);
        it.shear = shear;
        let pushed = |it: &BeamColumn, way: f64| {
            let model = BeamModel::new(it).unwrap();
            model.lateral_resistance(way).unwrap()
        };
        let ratio = |way: f64| pushed(&with_plateau(it), way) / pushed(&it, way);
        let [short, long] = [0.006, 0.15].map(ratio);
        println!("{short} {long}");
        assert!((short - 1.0).abs() < 1e-4, "{shear}: {short}");
        assert!((1.05..490.0 / 355.0).contains(&long), "{shear}: {long}");
    }
}

/// Hits that yield far beyond the plateau, one after the other: no energy is lost, and the steel that hardens lies between the one
/// that stays on its plateau and one that hardens from the first yield with the slope that begins behind the plateau.
#[test]
fn a_column_beyond_the_plateau_keeps_its_energy_and_lies_between_two_bilinear_ones() {
    let (mut it, hits) = column_hit_three_times();
    it.steel.hardening_ratio = 1e-4;
    let mut steeper = it;
    steeper.steel.hardening_ratio = 0.0135;
    let [soft, curve, hard] = [it, with_plateau(it), steeper].map(|it| {
        let model = BeamModel::new(&it).unwrap();
        let mut damage = None;
        let mut peaks = Vec::new();
        for hit in &hits {
            let (found, after) = model.simulate(hit, damage.as_ref()).unwrap();
            println!("{found:?}");
            assert!(found.energy_error.abs() < 1e-8, "{}", found.energy_error);
            assert_ne!(found.outcome, Outcome::Collapse);
            peaks.push(found.max_displacement_m);
            damage = after;
        }
        peaks
    });
    println!("{soft:?} {curve:?} {hard:?}");
    assert!(hard[2] < curve[2] && curve[2] < soft[2]);
}

#[test]
fn a_tensile_strength_below_the_yield_strength_is_rejected() {
    for (tensile, yield_strength) in [(355e6, 355e6), (f64::NAN, 355e6), (4e9, 355e6), (6e9, 3e9)] {
        let mut it = column("HEB220", yield_strength, 1e-4);
        it.steel.tensile_strength = Some(tensile);
        let found = BeamModel::new(&it);
        assert!(matches!(found, Err(BeamError::Column { .. })), "{found:?}");
    }
    let it = with_plateau(column("HEB220", 355e6, 1e-4));
    assert!(BeamModel::new(&it).is_ok());
}
