//! The reactions of the base against what the section and the support can bear.

use crate::reference::{column, hit};
use column_beam::BeamModel;
use column_mechanics::Support;

/// Plastic moments of an HEB220 of S355 about both axes \[N m\], by its table.
const PLASTIC: [f64; 2] = [827e-6 * 355e6, 393.9e-6 * 355e6];

fn base_moment(base: Support, degrees: f64) -> f64 {
    let mut it = column("HEB220", 355e6, 1e-3);
    it.base = base;
    let model = BeamModel::new(&it).unwrap();
    let (found, _) = model
        .simulate(&hit(1500.0, 10.0, None, degrees), None)
        .unwrap();
    found.base_moment_n_m
}

#[test]
fn the_moment_of_a_base_that_yields_is_the_plastic_moment_about_the_axis_of_the_hit() {
    for (degrees, plastic) in [(0.0, PLASTIC[0]), (90.0, PLASTIC[1]), (-90.0, PLASTIC[1])] {
        let ratio = base_moment(Support::BuiltIn, degrees) / plastic;
        assert!((0.9..1.25).contains(&ratio), "{degrees}: {ratio}");
    }
}

#[test]
fn the_moment_of_the_base_is_what_its_spring_bears() {
    let built_in = base_moment(Support::BuiltIn, 0.0);
    let stiff = base_moment(Support::SemiRigid { stiffness: 1e10 }, 0.0);
    assert!((stiff / built_in - 1.0).abs() < 0.03, "{stiff} {built_in}");
    let soft = base_moment(Support::SemiRigid { stiffness: 1e5 }, 0.0);
    // It turns by less than 0.5 rad.
    assert!(soft > 1e3 && soft < 0.5 * 1e5, "{soft}");
    for degrees in [0.0, 30.0] {
        let pinned = base_moment(Support::Pinned, degrees);
        assert!(pinned < 1e-3 * PLASTIC[1], "{degrees}: {pinned}");
    }
}
