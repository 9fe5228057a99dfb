//! Rectangular and circular hollow sections against closed forms and limit analysis.

use crate::reference::{column, hit};
use column_beam::{BeamColumn, BeamModel, Shape};

const SQUARE: Shape = Shape::Rectangular {
    depth: 0.2,
    width: 0.2,
    thickness: 0.01,
};

const FLAT: Shape = Shape::Rectangular {
    depth: 0.3,
    width: 0.1,
    thickness: 0.008,
};

const ROUND: Shape = Shape::Circular {
    diameter: 0.2191,
    thickness: 0.01,
};

fn hollow(shape: Shape) -> BeamColumn {
    BeamColumn {
        shape,
        ..column("HEB220", 355e6, 1e-4)
    }
}

fn power(x: f64, exponent: usize) -> f64 {
    std::iter::repeat_n(x, exponent).product()
}

/// By the closed forms of the walls.
#[test]
fn the_bending_stiffness_of_hollow_sections_is_that_of_their_walls() {
    let cube = |b: f64, h: f64| b * h * h * h / 12.0;
    let pi = std::f64::consts::PI;
    for (shape, expected) in [
        (SQUARE, cube(0.2, 0.2) - cube(0.18, 0.18)),
        (FLAT, cube(0.1, 0.3) - cube(0.084, 0.284)),
        (ROUND, pi / 64.0 * (power(0.2191, 4) - power(0.1991, 4))),
    ] {
        let found = hollow(shape).bending_stiffness() / (210e9 * expected);
        println!("{found}");
        // The layers of a wall and the mean radius of a ring leave a little out.
        assert!((found - 1.0).abs() < 0.01, "{shape:?}: {found}");
    }
}

/// `F0 = M_p (1 / a + 1 / b) 2` of three hinges or the shear resistance of both walls next to the impact, whichever is less.
#[test]
fn hollow_columns_resist_sideways_as_limit_analysis_says() {
    let plastic = 355e6 * (0.3 * 0.3 * 0.1 - 0.284 * 0.284 * 0.084) / 4.0;
    let ring = 355e6 * (power(0.2191, 3) - power(0.1991, 3)) / 6.0;
    for (shape, moment, sheared) in [
        (FLAT, plastic, 2.0 * 0.3 * 0.008),
        (ROUND, ring, 0.5 * (power(0.2191, 2) - power(0.1991, 2))),
    ] {
        for below in [0.25, 1.0, 2.0] {
            let mut it = hollow(shape);
            (it.length_below, it.length_above) = (below, 4.0 - below);
            let bending = 2.0 * moment * (1.0 / below + 1.0 / (4.0 - below));
            let above = 2.0 * moment / (4.0 - below);
            let shearing = 355e6 / 3.0_f64.sqrt() * sheared + above;
            let expected = bending.min(shearing);
            it.shear = true;
            let found = BeamModel::new(&it)
                .unwrap()
                .lateral_resistance(0.06)
                .unwrap();
            let ratio = found / expected;
            println!("{shape:?} {below} {ratio} bending {bending:.3e} shear {shearing:.3e}");
            // Both are bounds from above: bending and shear act together in the walls.
            assert!((0.8..1.06).contains(&ratio), "{shape:?} {below}: {ratio}");
        }
    }
}

/// A tube has no strong axis, and a square one has two.
#[test]
fn a_tube_moves_alike_whichever_way_it_is_hit() {
    for (shape, directions) in [(ROUND, [0.0, 45.0, 90.0]), (SQUARE, [0.0, 0.0, 90.0])] {
        let it = hollow(shape);
        let peaks = directions.map(|degrees| {
            let hit = hit(1500.0, 6.0, None, degrees);
            let found = BeamModel::new(&it).unwrap().simulate(&hit, None).unwrap().0;
            assert!(found.energy_error.abs() < 1e-8);
            assert!(found.max_sideways_m < 0.01 * found.max_displacement_m);
            found.max_displacement_m
        });
        println!("{peaks:?}");
        for peak in peaks {
            assert!((peak / peaks[0] - 1.0).abs() < 0.02, "{shape:?} {peaks:?}");
        }
    }
}

/// Walls that shear: energy is kept, the damage is read back, and the column moves further than one whose walls do not shear.
#[test]
fn hollow_columns_hit_near_the_base_shear_and_keep_their_energy() {
    for shape in [FLAT, ROUND] {
        let mut it = hollow(shape);
        (it.length_below, it.length_above) = (0.4, 3.6);
        let hit = hit(1500.0, 6.0, None, 0.0);
        let [with, without] = [true, false].map(|shear| {
            it.shear = shear;
            let model = BeamModel::new(&it).unwrap();
            let (found, damage) = model.simulate(&hit, None).unwrap();
            assert!(found.energy_error.abs() < 1e-8, "{found:?}");
            let again = model.simulate(&hit, damage.as_ref()).unwrap().0;
            assert!(again.energy_error.abs() < 1e-8, "{again:?}");
            found.max_displacement_m
        });
        println!("{with} {without}");
        assert!(with > without, "{shape:?}: {with} {without}");
    }
}
