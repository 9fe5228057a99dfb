//! Frequencies and shapes of free vibrations against the closed forms of beams.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

use std::f64::consts::PI;

use column_beam::{BeamColumn, BeamError, modes};
use column_mechanics::Support;

use super::reference::{column, section};

/// A column of this length \[m\] with its bending stiffness \[N m²\], mass \[kg/m\] and rotary inertia \[kg m\] in closed form.
fn of_length(length: f64, base: Support, top: Support) -> (BeamColumn, [f64; 3]) {
    let mut it = column("HEB220", 355e6, 1e-3);
    (it.length_below, it.length_above) = (0.25 * length, 0.75 * length);
    (it.base, it.top) = (base, top);
    let properties = section("HEB220").properties();
    let (e, rho) = (it.steel.young_modulus, it.steel.density);
    let second_moment = it.bending_stiffness() / e;
    let numbers = [
        e * second_moment,
        rho * properties.area,
        rho * second_moment,
    ];
    (it, numbers)
}

fn off(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

#[test]
fn slender_columns_have_the_frequencies_of_euler_and_bernoulli() {
    let length = 40.0;
    for (base, top, roots) in [
        (Support::Pinned, Support::Pinned, [PI, 2.0 * PI]),
        (Support::BuiltIn, Support::Pinned, [3.926_602, 7.068_583]),
        (Support::Pinned, Support::BuiltIn, [3.926_602, 7.068_583]),
        (Support::BuiltIn, Support::BuiltIn, [4.730_041, 7.853_205]),
        (Support::BuiltIn, Support::Free, [1.875_104, 4.694_091]),
    ] {
        let (it, [bending, mass, _]) = of_length(length, base, top);
        let found = modes(&it, 2).expect("modes");
        assert_eq!(found.len(), 2);
        for (mode, root) in found.iter().zip(roots) {
            let expected = (root / length).powi(2) * (bending / mass).sqrt() / (2.0 * PI);
            let off = off(mode.frequency, expected);
            assert!(
                off < 5e-3,
                "{base:?} {top:?}: {} instead of {expected}",
                mode.frequency
            );
        }
    }
}

#[test]
fn a_load_lowers_the_frequency_as_it_does_in_closed_form() {
    let (mut it, [bending, mass, rotary]) = of_length(4.0, Support::Pinned, Support::Pinned);
    for share in [0.0, 0.3, 0.9] {
        it.top_load = share * bending * (PI / 4.0).powi(2);
        for (mode, order) in modes(&it, 3).expect("modes").iter().zip([1.0, 2.0, 3.0]) {
            let k: f64 = order * PI / 4.0;
            let stiffness = bending * k.powi(4) - it.top_load * k * k;
            let expected = (stiffness / (mass + rotary * k * k)).sqrt() / (2.0 * PI);
            let off = off(mode.frequency, expected);
            assert!(
                off < 5e-3,
                "{share} {order}: {} instead of {expected}",
                mode.frequency
            );
            let sign = mode.displacement(0.3).signum();
            for x in [0.3, 1.1, 2.0, 3.7] {
                let sine = (k * x).sin();
                assert!(
                    (sign * mode.displacement(x) - sine).abs() < 2e-3,
                    "{order} {x}"
                );
                assert!(
                    (sign * mode.curvature(x) + k * k * sine).abs() < 0.01 * k * k,
                    "{order} {x}"
                );
                let turn = k * (k * x).cos();
                assert!(
                    (sign * mode.rotation(x) - turn).abs() < 5e-3 * k,
                    "{order} {x}"
                );
            }
        }
    }
}

#[test]
fn a_column_that_buckles_has_no_modes() {
    let (mut it, [bending, ..]) = of_length(6.0, Support::BuiltIn, Support::BuiltIn);
    let critical = 4.0 * PI * PI * bending / 36.0;
    it.top_load = 0.99 * critical;
    assert!(modes(&it, 1).is_ok());
    it.top_load = 1.01 * critical;
    assert_eq!(
        modes(&it, 1),
        Err(BeamError::Unstable { load: it.top_load })
    );
}

#[test]
fn a_web_that_shears_gives_the_frequencies_of_timoshenko() {
    let (mut it, [bending, mass, rotary]) = of_length(4.0, Support::Pinned, Support::Pinned);
    it.shear = true;
    let plain = modes(&it, 2).expect("modes");
    // The shear rigidity that gives the first frequency must give the second one, too, and be about that of the web.
    let rigidity_of = |order: f64, frequency: f64| {
        let k = order * PI / 4.0;
        let square = (2.0 * PI * frequency).powi(2);
        let bent = bending * k * k - rotary * square;
        mass * square * bent / (k * k * bent - mass * square)
    };
    let [first, second] =
        [(1.0, 0), (2.0, 1)].map(|(order, index)| rigidity_of(order, plain[index].frequency));
    let dimensions = section("HEB220");
    let web = (dimensions.depth - dimensions.flange_thickness) * dimensions.web_thickness;
    let expected = it.steel.shear_modulus() * web;
    assert!(off(second, first) < 0.1, "{first:e} {second:e}");
    assert!(off(first, expected) < 0.3, "{first:e} {expected:e}");
}

#[test]
fn a_rotational_spring_lies_between_a_hinge_and_a_fixed_end() {
    let frequency = |base| {
        let (it, _) = of_length(4.0, base, Support::BuiltIn);
        modes(&it, 1).expect("modes")[0].frequency
    };
    let pinned = frequency(Support::Pinned);
    let built_in = frequency(Support::BuiltIn);
    let springs =
        [1e2, 1e6, 1e7, 1e8, 1e13].map(|stiffness| frequency(Support::SemiRigid { stiffness }));
    assert!(off(springs[0], pinned) < 1e-3);
    assert!(off(springs[4], built_in) < 1e-3);
    assert!(springs.is_sorted());
}

#[test]
fn a_mass_at_the_free_top_of_a_cantilever_lowers_its_frequency() {
    let (mut it, [bending, mass, _]) = of_length(4.0, Support::BuiltIn, Support::Free);
    it.top_mass = 100.0 * mass * 4.0;
    let expected = (3.0 * bending / 64.0 / (it.top_mass + 0.243 * mass * 4.0)).sqrt() / (2.0 * PI);
    let found = modes(&it, 1).expect("modes")[0].frequency;
    assert!(off(found, expected) < 5e-3, "{found} instead of {expected}");
}
