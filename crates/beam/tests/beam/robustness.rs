//! Random columns in three dimensions: energy, convergence, and what a second hit makes of the first.

use crate::reference;
use crate::reference::{column, hit, vehicle};
use column_beam::{
    BeamColumn, BeamError, BeamModel, BowAxes, Damage, Hit, Outcome, Shape, Torsion,
};
use column_mechanics::Support;

/// Random numbers after Steele et al. (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn one_of<T: Copy>(&mut self, list: &[T]) -> T {
        list[((self.next() * list.len() as f64) as usize).min(list.len() - 1)]
    }
}

#[test]
fn random_columns_conserve_energy_and_end_in_rest_or_collapse() {
    let more = std::env::var("COLUMN_TWIN_EXPLORE").map(|n| n.parse().unwrap());
    let [count, tested] = more.map_or([40, 6], |count| [count; 2]);
    explore(count, tested, 0);
}

/// A response that is not solved is a collapse only where the impact point has moved by more than 8 % of the length; otherwise it fails
/// here. Every collapse is tested by displacement: with its top held and lowered, the column must nowhere bear its load, or, let go from
/// where its response has ended, it must have lost its shape for good.
#[test]
#[ignore = "takes minutes; .ci/long runs it"]
fn a_thousand_random_columns_conserve_energy_and_end_in_rest_or_collapse() {
    explore(1000, 1000, NOT_CONFIRMED);
}

/// So many of the 255 collapses of a thousand random columns are not confirmed. The vehicle pushes the top of this one, which bears 5 % of
/// its squash load, below half its height, where its response ends; without the vehicle its spring would lift it back within the
/// limits of the shape.
const NOT_CONFIRMED: usize = 1;

/// A random column and a hit on it, with the name of its section and the force that squashes it \[N\].
fn random_column(random: &mut Random) -> (&'static str, f64, BeamColumn, Hit) {
    let name = random.one_of(&[
        "HEB140", "HEB220", "HEB300", "HEA220", "HEA300", "IPE300", "IPE450",
    ]);
    let mut it = column(
        name,
        random.one_of(&[235e6, 355e6]),
        random.one_of(&[1e-4, 1e-3, 1e-2]),
    );
    let length = random.between(3.0, 6.0);
    it.length_below = length * random.between(0.12, 0.5);
    it.length_above = length - it.length_below;
    it.base = random.one_of(&[
        Support::BuiltIn,
        Support::Pinned,
        Support::SemiRigid { stiffness: 5e6 },
    ]);
    let squash = reference::section(name).properties().area * it.steel.yield_strength;
    it.top_load = squash * random.between(0.0, 0.35);
    it.top_spring_stiffness = random.one_of(&[0.0, 1e5, 1e7, 5e7]);
    it.shear = random.next() < 0.5;
    it.torsion = random.one_of(&[Torsion::Warping, Torsion::SaintVenant, Torsion::None]);
    it.residual_stress = random.next() < 0.5;
    it.bow = random.one_of(&[0.0, -1.0]);
    it.bumper_height = random.one_of(&[0.0, 0.2]);
    let mass = random.between(300.0, 20e3);
    let spring = match random.one_of(&[0, 1, 2]) {
        0 => None,
        1 => Some(vehicle(mass, random.between(2e5, 3e6), None)),
        _ => Some(vehicle(
            mass,
            random.between(5e5, 3e6),
            Some(random.between(2e5, 1.5e6)),
        )),
    };
    let oblique = random.between(-179.0, 180.0);
    let degrees = random.one_of(&[0.0, oblique]);
    let hit = reference::hit(mass, random.between(1.0, 20.0), spring, degrees);
    (name, squash, it, hit)
}

/// Computes a hit on each of the first `count` random columns, and tests collapses among the first `tested` by displacement, of which at
/// most so many may not be confirmed.
fn explore(count: i32, tested: i32, most_doubtful: usize) {
    let (mut give_way, mut lose_shape, mut doubtful) = (0, 0, Vec::new());
    let mut random = Random(2026);
    let (mut collapses, mut unstable, mut worst, mut failed) = (0, 0, 0.0_f64, Vec::new());
    let mut slowest = 0.0_f64;
    let mut whole = 0.0;
    let (mut largest, mut most) = (0, 0);
    for number in 0..count {
        let (name, squash, it, hit) = random_column(&mut random);
        let began = reference::cpu();
        let result = BeamModel::new(&it).and_then(|model| model.simulate(&hit, None));
        let took = reference::cpu() - began;
        slowest = slowest.max(took);
        whole += took;
        match result {
            Ok((found, damage)) => {
                if let Some(damage) = &damage {
                    let stored = serde_json::to_string(damage).unwrap();
                    assert!(stored.len() <= damage.most_bytes() + 2, "{number}");
                    largest = largest.max(stored.len());
                    most = most.max(damage.most_bytes());
                }
                if std::env::var("COLUMN_TWIN_EXPLORE").is_ok() {
                    println!(
                        "{number} {name} deg {:.0} {} P {:.2} ks {:.0e} b {:.0e} shear {} {:?} base {:?} bow {} bump {} v {:.1} m {:.0} | {took:.0} ms steps {} evals {} n {} ledger {:.1e} v1 {:.3}+{:.3} t {:.4} {:?}",
                        hit.direction.to_degrees(),
                        hit.impact.vehicle.is_some(),
                        it.top_load / squash,
                        it.top_spring_stiffness,
                        it.steel.hardening_ratio,
                        it.shear,
                        it.torsion,
                        it.base,
                        it.bow,
                        it.bumper_height,
                        hit.impact.velocity,
                        hit.impact.mass,
                        found.steps,
                        found.evaluations,
                        found.elements,
                        found.energy_error,
                        found.max_displacement_m,
                        found.max_sideways_m,
                        found.max_displacement_time_s,
                        found.outcome
                    );
                }
                worst = worst.max(found.energy_error.abs());
                if found.energy_error.abs() > 1e-8 {
                    println!(
                        "{number} {name} ledger {:e} {:?}",
                        found.energy_error, found.outcome
                    );
                }
                match found.outcome {
                    Outcome::Collapse => {
                        collapses += 1;
                        if number < tested {
                            let model = BeamModel::new(&it).unwrap();
                            match model.test_collapse(&hit, None).unwrap() {
                                Some(test) if test.gives_way() => give_way += 1,
                                Some(test) if test.lost_shape => lose_shape += 1,
                                test => doubtful.push(format!(
                                    "{number} {name} {test:?} {found:?} {it:?} {hit:?}"
                                )),
                            }
                        }
                    }
                    _ => assert!(damage.is_some(), "{number}"),
                }
            }
            Err(BeamError::Unstable { .. } | BeamError::WeakAxis { .. }) => unstable += 1,
            Err(error) => failed.push(format!("{number} {name} {error} {hit:?}")),
        }
    }
    println!(
        "{count}: {collapses} collapses, {unstable} without equilibrium, {} not solved, ledger {worst:e}, mean {:.0} ms, slowest {slowest:.0} ms",
        failed.len(),
        whole / f64::from(count)
    );
    println!("damage as stored: {largest} bytes of text, {most} if every fibre had yielded");
    println!(
        "by displacement: {give_way} give way under their load, {lose_shape} lose their shape, {} doubtful",
        doubtful.len()
    );
    doubtful.iter().for_each(|it| println!("{it}"));
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(doubtful.len() <= most_doubtful, "{doubtful:#?}");
    assert!(worst <= 1e-8, "{worst:e}");
    assert!(most <= 20_000, "{most}");
}

/// Such columns were given as collapsed, because Newton's method did not find the equilibrium without the vehicle: three that had hardly
/// yielded, one that hangs from its spring, and one that is at rest but has to bow to the other side.
#[test]
fn columns_far_from_their_equilibrium_come_to_rest() {
    let mut random = Random(2026);
    let columns: Vec<_> = (0..=400).map(|_| random_column(&mut random)).collect();
    for number in [331, 346, 400, 7, 76] {
        let (name, _, it, hit) = &columns[number];
        let model = BeamModel::new(it).unwrap();
        let (found, damage) = model.simulate(hit, None).unwrap();
        println!("{number} {name} {found:?}");
        assert!(
            damage.is_some() && found.outcome == Outcome::Plastic,
            "{number}"
        );
        let remains = libm::hypot(found.residual_displacement_m, found.residual_sideways_m);
        let most = libm::hypot(found.max_displacement_m, found.max_sideways_m);
        assert!(remains < 1.02 * most, "{number}: {remains} m of {most} m");
        if most < 0.01 * it.length() {
            // Bent by less than a 300th of its height at rest, it bears most of what it bore.
            let [strong, weak] = [0, 1]
                .map(|axis| found.residual_capacity_n[axis] / found.undamaged_capacity_n[axis]);
            assert!(strong > 0.75 && weak > 0.75, "{number}: {strong} {weak}");
        }
        assert_eq!(model.test_collapse(hit, None).unwrap(), None);
    }
}

#[test]
fn a_damaged_column_is_hit_again_and_its_damage_is_read_back_to_the_last_bit() {
    let mut it = column("HEB220", 355e6, 1e-3);
    it.top_load = 0.5e6;
    it.top_spring_stiffness = 1e7;
    let model = BeamModel::new(&it).unwrap();
    for degrees in [0.0, 20.0] {
        let first = hit(1500.0, 6.0, None, degrees);
        let (one, damage) = model.simulate(&first, None).unwrap();
        let damage = damage.unwrap();
        let text = serde_json::to_string(&damage).unwrap();
        let read: Damage = serde_json::from_str(&text).unwrap();
        assert_eq!(read, damage);
        let (again, _) = model.simulate(&first, Some(&damage)).unwrap();
        let (same, _) = model.simulate(&first, Some(&read)).unwrap();
        assert_eq!(
            again.max_displacement_m.to_bits(),
            same.max_displacement_m.to_bits()
        );
        println!("{degrees} {one:?}\n{again:?} {} bytes", text.len());
        // The second hit bends the column further, and less capacity remains.
        assert!(again.residual_displacement_m > 0.3 * one.residual_displacement_m);
        assert!(again.residual_capacity_n[0] < one.residual_capacity_n[0]);
        // What remains of each hit is what it has added; the bow is that of both.
        let [along, across] = again.displaced_before_m;
        assert_eq!(one.displaced_before_m, [0.0; 2]);
        assert!((along / one.residual_displacement_m - 1.0).abs() < 0.01);
        assert!((across.abs() - one.residual_sideways_m).abs() < 1e-4);
        let bow = libm::hypot(
            along + again.residual_displacement_m,
            across.abs() + again.residual_sideways_m,
        );
        assert!(again.residual_bow_m > 0.999 * bow, "{bow}");
    }
    // Damage in the plane of the web comes into space.
    let (_, damage) = model.simulate(&hit(1500.0, 6.0, None, 0.0), None).unwrap();
    let (oblique, _) = model
        .simulate(&hit(1500.0, 6.0, None, 45.0), damage.as_ref())
        .unwrap();
    assert!(oblique.max_sideways_m > 0.0);
}

#[test]
fn damage_comes_into_another_mesh_and_to_another_height_of_the_impact() {
    let mut it = column("HEB220", 355e6, 1e-3);
    it.top_load = 0.5e6;
    it.top_spring_stiffness = 1e7;
    it.shear = true;
    it.residual_stress = true;
    it.bow = -1.0;
    let model = BeamModel::new(&it).unwrap();
    let first = hit(1500.0, 8.0, None, 0.0);
    let (one, damage) = model.simulate(&first, None).unwrap();
    let damage = damage.unwrap();
    // A touch that bends nothing finds the column as it was left, whatever the mesh: in space, with another vehicle, or hit
    // at another height.
    let touch = hit(1500.0, 0.05, None, 0.0);
    let lorry = Some(vehicle(1500.0, 1e5, None));
    let soft = hit(1500.0, 0.05, lorry, 0.0);
    let oblique = hit(1500.0, 0.05, None, 30.0);
    let mut higher = it;
    (higher.length_below, higher.length_above) = (1.3, 2.7);
    let higher = BeamModel::new(&higher).unwrap();
    // The web was sheared below 1 m; above 1.3 m it may not be, and between the angle is spread.
    for (model, hit, [allowed, of_bow]) in [
        (&model, &touch, [0.001, 0.03]),
        (&model, &soft, [0.001, 0.03]),
        (&model, &oblique, [0.001, 0.03]),
        (&higher, &touch, [0.07, 0.15]),
    ] {
        let (found, after) = model.simulate(hit, Some(&damage)).unwrap();
        println!("{found:?}");
        let kept = found.residual_capacity_n[0] / one.residual_capacity_n[0];
        assert!((kept - 1.0).abs() < allowed, "{kept}");
        assert!(found.residual_displacement_m.abs() < 2e-4, "{found:?}");
        // A touch does not forget the bow of the first hit.
        let bow = found.residual_bow_m / one.residual_bow_m;
        assert!((bow - 1.0).abs() < of_bow, "{bow}");
        assert!(after.is_some());
    }
    let mut other = it;
    other.length_above = 3.5;
    let error = BeamModel::new(&other)
        .unwrap()
        .simulate(&touch, Some(&damage))
        .unwrap_err();
    assert!(
        error.to_string().contains("column of 4 m; expected 4.5 m"),
        "{error}"
    );
    let mut other = it;
    other.residual_stress = false;
    let error = BeamModel::new(&other)
        .unwrap()
        .simulate(&touch, Some(&damage))
        .unwrap_err();
    assert!(error.to_string().contains("fibres"), "{error}");
}

#[test]
fn stored_damage_that_was_changed_is_rejected_and_never_panics() {
    let it = column("HEB220", 355e6, 1e-3);
    let model = BeamModel::new(&it).unwrap();
    let first = hit(1500.0, 6.0, None, 20.0);
    let damage = model.simulate(&first, None).unwrap().1.unwrap();
    let bytes = damage.to_bytes();
    assert_eq!(Damage::from_bytes(&bytes).unwrap(), damage);
    for end in 0..bytes.len() {
        assert!(Damage::from_bytes(&bytes[..end]).is_err(), "{end}");
    }
    for place in 0..bytes.len() {
        for bit in 0..8 {
            let mut changed = bytes.clone();
            changed[place] ^= 1 << bit;
            // Some changes are other numbers; those that are not must be found.
            if let Ok(read) = Damage::from_bytes(&changed) {
                assert_eq!(read.to_bytes().len(), bytes.len());
            }
        }
    }
    let error = serde_json::from_str::<Damage>("\"01!x\"").unwrap_err();
    assert!(error.to_string().contains("base64"), "{error}");
}

#[test]
fn a_hit_from_the_other_side_is_its_mirror_image() {
    let mut it = column("HEB220", 355e6, 1e-3);
    it.top_load = 0.5e6;
    it.top_spring_stiffness = 1e7;
    let model = BeamModel::new(&it).unwrap();
    let mut found = [30.0, -30.0, 150.0].map(|degrees| {
        let (outcome, _) = model
            .simulate(&hit(1500.0, 6.0, None, degrees), None)
            .unwrap();
        outcome.max_displacement_m
    });
    found.sort_by(f64::total_cmp);
    assert!(found[2] - found[0] < 1e-6 * found[0], "{found:?}");
}

/// The two bars add the bows of both hits.
#[test]
fn a_hit_from_behind_bends_a_damaged_column_back() {
    let mut it = column("HEB220", 355e6, 1e-3);
    it.top_load = 0.5e6;
    it.top_spring_stiffness = 1e7;
    let model = BeamModel::new(&it).unwrap();
    let (one, damage) = model.simulate(&hit(1500.0, 6.0, None, 0.0), None).unwrap();
    let (two, _) = model
        .simulate(&hit(1500.0, 6.0, None, 180.0), damage.as_ref())
        .unwrap();
    let [before, _] = two.displaced_before_m;
    let bow = one.residual_displacement_m;
    println!("{bow} m, then {} m", before + two.residual_displacement_m);
    assert!((before + bow).abs() < 0.01 * bow, "{before} {bow}");
    assert!((before + two.residual_displacement_m).abs() < 0.5 * bow);
}

#[test]
fn bad_input_is_rejected_with_the_reason() {
    let mut it = column("HEB220", 355e6, 1e-3);
    let model = BeamModel::new(&it).unwrap();
    let error = model
        .simulate(&hit(1500.0, 6.0, None, 200.0), None)
        .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("direction of the impact is 3.49"),
        "{error}"
    );
    it.steel.hardening_ratio = 0.0;
    let error = BeamModel::new(&it).unwrap_err();
    assert!(error.to_string().contains("hardening ratio"), "{error}");
    it.steel.hardening_ratio = 1e-3;
    it.top_load = 5e6;
    let error = BeamModel::new(&it);
    assert!(
        matches!(error, Err(BeamError::Unstable { .. })),
        "{error:?}"
    );
}

/// A pinned column that is slender about its weak axis, with residual stresses and bow, without a spring at the top.
fn slender(load: f64) -> BeamColumn {
    let mut it = column("IPE300", 355e6, 1e-3);
    (it.base, it.top) = (Support::Pinned, Support::Pinned);
    it.length_above = 4.0;
    it.residual_stress = true;
    it.bow = -1.0;
    it.top_load = load;
    it
}

/// Such a column had the capacity 0, undamaged and after the hit, of which the verdict made something.
#[test]
fn a_column_whose_weak_axis_does_not_bear_its_load_has_no_second_opinion() {
    let [strong, weak] = BeamModel::new(&slender(0.0)).unwrap().undamaged_capacity();
    assert!(weak < 0.8 * strong, "{strong} {weak}");
    for share in [0.98, 1.02] {
        let found = BeamModel::new(&slender(share * weak));
        assert_eq!(found.is_ok(), share < 1.0, "{share}: {found:?}");
    }
    let between = 0.5 * (strong + weak);
    let reason = BeamModel::new(&slender(between)).unwrap_err();
    assert!(
        matches!(reason, BeamError::WeakAxis { load } if load == between),
        "{reason}"
    );
    assert!(reason.to_string().contains("beam.bow_axes: strong"));
    // Held about its weak axis, as the message says, it has one.
    let held = BeamColumn {
        bow_axes: BowAxes::Strong,
        ..slender(between)
    };
    let model = BeamModel::new(&held).unwrap();
    let (found, damage) = model
        .simulate(&hit(300.0, 3.0, None, 0.0), None)
        .expect("a second opinion");
    assert!(damage.is_some() && found.residual_capacity_n[0] > between);
}

/// Such a column stood, with the capacity 0.
#[test]
fn a_damaged_column_whose_weak_axis_does_not_bear_its_load_does_not_stand() {
    let undamaged = BeamModel::new(&slender(0.0)).unwrap();
    let load = 0.97 * undamaged.capacity_bowed(slender(0.0).bows());
    let model = BeamModel::new(&slender(load)).unwrap();
    // Held about its weak axis, the same column stands after the same hit.
    let held = BeamModel::new(&BeamColumn {
        bow_axes: BowAxes::Strong,
        ..slender(load)
    })
    .unwrap();
    let mut gives_way_sideways = 0;
    for speed in [3.0, 6.0, 7.0, 8.0, 9.0] {
        let hit = hit(1500.0, speed, None, 0.0);
        let (outcome, damage) = model.simulate(&hit, None).unwrap();
        let (in_plane, _) = held.simulate(&hit, None).unwrap();
        println!(
            "{speed}: {:?} {:?}",
            outcome.outcome, outcome.residual_capacity_n
        );
        println!(
            "held: {:?} {:?}",
            in_plane.outcome, in_plane.residual_capacity_n
        );
        match damage {
            Some(damage) => {
                let left = model.capacity_left(slender(load).bows(), &damage);
                assert!(left >= load, "{speed}: {left} {load}");
                let [strong, weak] = outcome.residual_capacity_n;
                assert!(
                    strong >= load && weak >= load,
                    "{speed}: {strong} {weak} {load}"
                );
            }
            None => {
                assert_eq!(outcome.outcome, Outcome::Collapse);
                assert_eq!(outcome.residual_capacity_n, [0.0; 2]);
                assert!(outcome.residual_displacement_m.is_nan());
                gives_way_sideways += usize::from(in_plane.outcome == Outcome::Plastic);
            }
        }
    }
    assert!(gives_way_sideways > 0);
}

#[test]
fn sections_without_room_between_their_walls_and_numbers_that_are_none_are_rejected() {
    let good = column("HEB220", 355e6, 1e-3);
    let mut plates = good;
    plates.shape = Shape::plates(0.22, 0.22, 0.0095, 0.016);
    plates.shear = true;
    // Without fillets, HEB220 has 2 % less area and bears less.
    let ratio = BeamModel::new(&plates).unwrap().undamaged_capacity()[0]
        / BeamModel::new(&good).unwrap().undamaged_capacity()[0];
    assert!((0.96..0.99).contains(&ratio), "{ratio}");
    let mut bad = Vec::new();
    for shape in [
        Shape::plates(0.22, 0.22, 0.0095, 0.11),
        Shape::plates(0.22, 0.22, 0.22, 0.016),
        Shape::plates(0.22, f64::NAN, 0.0095, 0.016),
        Shape::plates(0.22, 0.22, 0.0095, 0.0),
        Shape::Rectangular {
            depth: 0.2,
            width: 0.1,
            thickness: 0.05,
        },
        Shape::Circular {
            diameter: 0.2,
            thickness: -0.01,
        },
    ] {
        bad.push(BeamColumn { shape, ..good });
    }
    for elements in [401, usize::MAX] {
        bad.push(BeamColumn { elements, ..good });
    }
    let fibres = 101;
    bad.push(BeamColumn { fibres, ..good });
    for stiffness in [0.0, f64::INFINITY] {
        let base = Support::SemiRigid { stiffness };
        bad.push(BeamColumn { base, ..good });
    }
    for column in bad {
        let found = BeamModel::new(&column);
        assert!(matches!(found, Err(BeamError::Column { .. })), "{found:?}");
    }
}

#[test]
fn a_bollard_bends_in_space_and_in_the_plane() {
    let mut it = column("HEB140", 235e6, 1e-3);
    (it.length_below, it.length_above) = (0.6, 0.4);
    it.top = Support::Free;
    it.bumper_height = 0.2;
    it.shear = true;
    let model = BeamModel::new(&it).unwrap();
    let mut peaks = Vec::new();
    for degrees in [0.0, 0.001, 45.0, 90.0] {
        let (found, _) = model
            .simulate(&hit(1500.0, 3.0, None, degrees), None)
            .unwrap();
        println!("{degrees} {found:?}");
        assert_eq!(found.outcome, Outcome::Plastic);
        assert!(found.energy_error.abs() < 1e-8);
        peaks.push(found.max_displacement_m);
    }
    // In space as in the plane but for mesh and step, and weakest about the weak axis.
    assert!((peaks[1] / peaks[0] - 1.0).abs() < 0.02, "{peaks:?}");
    assert!(peaks[0] < peaks[2] && peaks[2] < peaks[3], "{peaks:?}");
}

/// A lorry that crushes meets the finest mesh of the parameters.
fn finest() -> (BeamColumn, Hit) {
    let mut it = column("HEB220", 355e6, 1e-3);
    (it.elements, it.fibres) = (200, 64);
    (it.top_load, it.top_spring_stiffness) = (0.5e6, 1e7);
    let lorry = vehicle(8000.0, 3e6, Some(6e5));
    (it, reference::hit(8000.0, 8.0, Some(lorry), 45.0))
}

#[test]
fn a_response_that_no_budget_can_finish_is_rejected_with_the_reason() {
    let (mut it, hit) = finest();
    it.step_nanos = 1000;
    let model = BeamModel::new(&it).unwrap();
    let began = reference::cpu();
    let rejected = model.respond(&hit).unwrap_err();
    println!(
        "{rejected}; rejected after {:.0} ms",
        reference::cpu() - began
    );
    assert!(matches!(rejected, BeamError::Budget { .. }), "{rejected:?}");
    assert!(rejected.to_string().contains("beam.dt"), "{rejected}");
}

/// The budget is none for the finest mesh with the step that is chosen by itself.
#[test]
fn the_finest_mesh_ends_within_its_budget() {
    let (it, hit) = finest();
    let began = reference::cpu();
    let (found, _) = BeamModel::new(&it).unwrap().simulate(&hit, None).unwrap();
    println!(
        "{:.0} ms, {} evaluations",
        reference::cpu() - began,
        found.evaluations
    );
    assert!(found.elements >= 200);
}

#[test]
fn a_step_does_not_allocate() {
    for (degrees, front) in [(0.0, None), (30.0, None), (30.0, Some(3e5))] {
        let vehicle = front.map(|force| vehicle(1500.0, 1e6, Some(force)));
        let hit = hit(1500.0, 5.0, vehicle, degrees);
        let allocations = [40_000, 20_000].map(|nanos| {
            let mut it = column("HEB220", 355e6, 1e-3);
            (it.shear, it.step_nanos) = (true, nanos);
            let model = BeamModel::new(&it).unwrap();
            let counted = allocation_counter::measure(|| {
                model.respond(&hit).unwrap();
            });
            counted.count_total
        });
        // Twice as many steps, of which there are hundreds, and perhaps a few sections more or less that have yielded, each of which is
        // stored with two or three allocations.
        let more = allocations[0].abs_diff(allocations[1]);
        assert!(more < 30, "{degrees} {front:?}: {allocations:?}");
    }
}
