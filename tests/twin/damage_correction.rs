//! Corrections of the damage by what was measured on the column at rest.

use column_twin::column::{Model, residual_state};
use column_twin::estimation::Probe;
use column_twin::parameters::Value;
use column_twin::sensors::Quantity;
use column_twin::twin::{
    Accepted, CORRECTION_FACTORS, Command, DamageCorrection, Output, Rejection, RejectionCode,
    ResidualMeasurement,
};

use crate::{Bench, MS, START, event, fatal, parameters};

impl Bench {
    fn measure(
        &mut self,
        quantity: Quantity,
        height: f64,
        value: f64,
        deviation: f64,
    ) -> Result<DamageCorrection, Rejection> {
        let outcome = self.handle(Command::CorrectDamage(ResidualMeasurement {
            quantity,
            height,
            value,
            deviation,
            source: "test".into(),
        }));
        match outcome? {
            Accepted::DamageCorrected(correction) => Ok(correction),
            other => panic!("{other:?}"),
        }
    }
}

/// A column with the damage of an impact.
fn damaged() -> Bench {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.rest();
    bench
}

fn height() -> f64 {
    parameters(&[]).column_properties().length_below
}

/// The corrected column reads what was measured, is in equilibrium by an independent solution, and has the mechanism of the
/// impact: the ratios of its plastic rotations.
#[test]
fn the_corrected_column_has_what_was_measured() {
    for (quantity, at, share) in [
        (Quantity::Displacement, 1.0, 1.1),
        (Quantity::Displacement, 0.5, 0.8),
        (Quantity::Displacement, 1.3, 1.4),
        (Quantity::Rotation, 0.2, 0.9),
        (Quantity::Rotation, 1.5, 1.2),
    ] {
        let mut bench = damaged();
        let before = bench.twin.checkpoint(bench.now).expect("at rest");
        let model = Model::new(&parameters(&[]).column_properties()).expect("stands");
        let at = at * height();
        let probe = Probe::ideal(&model, quantity, at);
        let value = share * probe.read(&before.state);
        let deviation = 1e-3 * value.abs();
        let found = bench
            .measure(quantity, at, value, deviation)
            .expect("plausible");
        assert_eq!(found.before, probe.read(&before.state));
        let after = bench.twin.checkpoint(bench.now).expect("at rest").state;
        assert_eq!(found.after, probe.read(&after));
        assert!(
            (found.after - value).abs() <= 0.011 * deviation,
            "{found:?}"
        );
        assert!((found.factor - share).abs() < 0.15, "{found:?}");
        let again = residual_state(&model, &after).expect("an equilibrium");
        assert!((again.displacement.v1 - after.displacement.v1).abs() < 1e-9);
        let pairs = [
            (before.state.plastic.below, after.plastic.below),
            (before.state.plastic.above, after.plastic.above),
        ];
        for (before, after) in pairs {
            for hinge in 0..2 {
                let (before, after) = (before.rotation[hinge], after.rotation[hinge]);
                assert!((after - found.factor * before).abs() <= 1e-15 + 1e-12 * before.abs());
            }
        }
        let status = bench.status();
        assert_eq!(status.last_correction, Some(found));
        assert_eq!(status.corrections_since_reset, 1);
        assert_eq!(status.residual_v1, after.displacement.v1);
        assert!(
            bench
                .out
                .iter()
                .any(|it| matches!(it, Output::DamageCorrected(it) if *it == found))
        );
    }
}

/// The correction is part of the damage: it is saved, and the next impact meets the corrected column.
#[test]
fn a_correction_survives_a_restart_and_counts_for_the_next_impact() {
    let mut bench = damaged();
    let value = 1.2 * bench.status().residual_v1;
    let found = bench
        .measure(Quantity::Displacement, height(), value, 1e-4)
        .expect("plausible");
    let capacity = |it: &Bench| it.status().assessed.expect("assessed").remaining.now;
    let saved = bench
        .saved()
        .last()
        .map(|it| (***it).clone())
        .expect("saved");
    let restored = Bench::with(parameters(&[]), Some(&saved));
    assert_eq!(restored.status().last_correction, Some(found));
    assert!((restored.status().residual_v1 - value).abs() < 1e-5);
    assert_eq!(capacity(&restored), capacity(&bench));
    let uncorrected = damaged();
    assert!(capacity(&bench) != capacity(&uncorrected));
    let mut both = [bench, uncorrected];
    let reports = both.each_mut().map(|it| {
        it.hit(event("b", it.now));
        it.rest();
        it.reports().last().expect("a report").report
    });
    assert!(reports[0].residual_v1 > reports[1].residual_v1);
}

/// A measurement that agrees is noted, and changes no bit.
#[test]
fn a_measurement_that_agrees_changes_nothing() {
    let mut bench = damaged();
    let before = bench.twin.checkpoint(bench.now).expect("at rest").state;
    let value = bench.status().residual_v1;
    let found = bench
        .measure(Quantity::Displacement, height(), value + 0.9e-3, 1e-3)
        .expect("plausible");
    assert_eq!((found.factor, found.after), (1.0, found.before));
    assert_eq!(
        bench.twin.checkpoint(bench.now).expect("at rest").state,
        before
    );
    assert_eq!(bench.status().corrections_since_reset, 1);
    // An undamaged column that stands straight agrees too.
    let mut bench = Bench::new(&[]);
    assert!(bench.measure(Quantity::Rotation, 1.0, 1e-4, 1e-3).is_ok());
    bench.reset();
    assert_eq!(bench.status().corrections_since_reset, 0);
    assert_eq!(bench.status().last_correction, None);
}

#[test]
fn measurements_that_cannot_be_met_are_rejected_with_the_reason() {
    let implausible = RejectionCode::MeasurementImplausible;
    let mut bench = damaged();
    let v1 = bench.status().residual_v1;
    let before = bench.twin.checkpoint(bench.now).expect("at rest");
    let whole = {
        let p = parameters(&[]).column_properties();
        p.length_below + p.length_above
    };
    let [least, most] = CORRECTION_FACTORS;
    for (quantity, at, value, deviation, words) in [
        (
            Quantity::Displacement,
            height(),
            1.2 * most * v1,
            1e-4,
            "no factor",
        ),
        (
            Quantity::Displacement,
            height(),
            0.8 * least * v1,
            1e-4,
            "no factor",
        ),
        (Quantity::Displacement, height(), -v1, 1e-4, "no factor"),
        (Quantity::Displacement, 0.0, v1, 1e-4, "no factor"),
        (Quantity::Displacement, -0.1, v1, 1e-4, "not on the column"),
        (
            Quantity::Displacement,
            whole + 0.1,
            v1,
            1e-4,
            "not on the column",
        ),
        (
            Quantity::Displacement,
            f64::NAN,
            v1,
            1e-4,
            "not on the column",
        ),
        (Quantity::Displacement, height(), f64::NAN, 1e-4, "finite"),
        (
            Quantity::Displacement,
            height(),
            f64::INFINITY,
            1e-4,
            "finite",
        ),
        (
            Quantity::Displacement,
            height(),
            v1,
            0.0,
            "standard deviation",
        ),
        (
            Quantity::Displacement,
            height(),
            v1,
            -1.0,
            "standard deviation",
        ),
        (
            Quantity::Displacement,
            height(),
            v1,
            f64::NAN,
            "standard deviation",
        ),
        // It agreed with every column.
        (
            Quantity::Displacement,
            height(),
            v1,
            1e300,
            "standard deviation",
        ),
        (Quantity::Rotation, 0.5, 0.0, 2.0, "standard deviation"),
        (
            Quantity::BendingStrain,
            height(),
            v1,
            1e-4,
            "displacement or its rotation",
        ),
    ] {
        let rejection = bench
            .measure(quantity, at, value, deviation)
            .expect_err(words);
        assert_eq!(rejection.code, implausible, "{rejection}");
        assert!(rejection.reason.contains(words), "{rejection}");
    }
    let after = bench.twin.checkpoint(bench.now).expect("at rest");
    assert_eq!(after.state, before.state);
    assert_eq!(after.life.corrections_since_reset, 0);
    assert_eq!(after.counts, before.counts);
}

#[test]
fn only_a_column_at_rest_that_stands_is_corrected() {
    let mut bench = Bench::new(&[]);
    let undamaged = bench
        .measure(Quantity::Displacement, height(), 0.05, 1e-3)
        .expect_err("undamaged");
    assert!(
        undamaged.reason.contains("no plastic deformation"),
        "{undamaged}"
    );
    bench.hit(event("a", START));
    bench.go_on(10 * MS);
    let moving = bench
        .measure(Quantity::Displacement, height(), 0.05, 1e-3)
        .expect_err("in motion");
    assert_eq!(moving.code, RejectionCode::NotAtRest);
    let mut bench = Bench::new(&[("top.load", Value::from(2e6))]);
    bench.hit(fatal("a", START));
    bench.rest();
    let collapsed = bench
        .measure(Quantity::Displacement, height(), 0.05, 1e-3)
        .expect_err("collapsed");
    assert_eq!(collapsed.code, RejectionCode::ColumnCollapsed);
}
