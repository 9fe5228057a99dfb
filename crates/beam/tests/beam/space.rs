//! Plane and oblique hits and push-downs against OpenSees (`data/beam_reference.json`).

use crate::cases::{Case, cases, described, impact_case, number};
use crate::found;
use column_beam::{BeamModel, BowAxes, Torsion};

#[test]
fn plane_hits_at_the_edge_of_yielding_agree_with_opensees() {
    let (mut wrong, mut rows) = (Vec::new(), Vec::new());
    for case in cases("plane impact") {
        let Case {
            name,
            column,
            hit,
            peak,
            time,
            residual,
            ..
        } = impact_case(&case);
        let model = BeamModel::new(&column).unwrap();
        let found = model.respond(&hit).unwrap();
        let (ratio, remains) = (found[0] / peak, found[1] / residual);
        println!(
            "{name:18} v1 {ratio:.4} res {remains:.4} t {:.4}",
            found[2] / time
        );
        rows.push(format!(
            "{name},{peak:.5},{ratio:.4},{residual:.5},{remains:.4}"
        ));
        // The target is 1 %. The residual of one case is 1.2 % too large, because its reference is not converged, as its stated tolerance
        // of 8 % says: OpenSees finds 1.3 % more with the mesh of the beam, which has two elements more, and 5.6 % more with 134 elements.
        let at_rest = if name == "plane06 b0.0001" {
            0.015
        } else {
            0.01
        };
        if (ratio - 1.0).abs() > 0.01 || (remains - 1.0).abs() > at_rest {
            wrong.push(format!("{name} {ratio} {remains}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    let header = "case,peak_m,ratio,residual_m,residual_ratio";
    found::keep("edge", header, &rows);
}

#[test]
fn oblique_hits_agree_with_opensees() {
    let (mut wrong, mut rows) = (Vec::new(), Vec::new());
    for case in cases("3D impact") {
        let (mut it, hit) = described(&case);
        let hit = hit.unwrap();
        for (torsion, key) in [
            (Torsion::SaintVenant, "reference"),
            (Torsion::None, "reference_twist_suppressed"),
        ] {
            let r = &case[key];
            if r.is_null() {
                continue;
            }
            it.torsion = torsion;
            let model = BeamModel::new(&it).unwrap();
            let alone = model.respond(&hit).unwrap();
            let (found, _) = model.simulate(&hit, None).unwrap();
            let along = alone[0] / number(&r["max_displacement_along_hit_m"]);
            let across = found.max_sideways_m / number(&r["max_displacement_across_hit_m"]).abs();
            let remains = found.residual_displacement_m / number(&r["residual_along_hit_m"]);
            let remains_across =
                found.residual_sideways_m / number(&r["residual_across_hit_m"]).abs();
            println!(
                "{:36} {torsion:?} along {along:.4} across {across:.4} res {remains:.4} sideways {:.4} t {:.4} cap {:?} ({:?}) | steps {} ledger {:.1e}",
                case["name"].as_str().unwrap(),
                remains_across,
                found.max_displacement_time_s / number(&r["time_of_max_s"]),
                found.residual_capacity_n,
                r["residual_capacity_N_u_after_impact_N"],
                found.steps,
                found.energy_error
            );
            // Across a hit along an axis there is round-off alone.
            let moves_across = number(&r["max_displacement_across_hit_m"]).abs() > 1e-3;
            let across = if moves_across { across } else { f64::NAN };
            rows.push(format!(
                "{},{torsion:?},{:.5},{along:.4},{:.5},{across:.4},{:.5},{remains:.4}",
                case["name"].as_str().unwrap(),
                number(&r["max_displacement_along_hit_m"]),
                number(&r["max_displacement_across_hit_m"]).abs(),
                number(&r["residual_along_hit_m"]),
            ));
            let quantities = [
                ("peak along", along),
                ("residual along", remains),
                ("peak across", across),
                ("residual across", remains_across),
            ];
            let count = if moves_across { 4 } else { 2 };
            for (quantity, ratio) in &quantities[..count] {
                let deviation = (ratio - 1.0).abs();
                if deviation.is_nan() || deviation > 0.03 {
                    wrong.push(format!("{} {torsion:?} {quantity} {ratio}", case["name"]));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    let header = "case,torsion,along_m,along_ratio,across_m,across_ratio,residual_m,residual_ratio";
    found::keep("oblique", header, &rows);
}

#[test]
fn push_downs_agree_with_opensees() {
    let (mut wrong, mut rows) = (Vec::new(), Vec::new());
    for case in cases("push-down (GMNIA)") {
        let (mut it, hit) = described(&case);
        let p = &case["parameters"];
        let bows = [number(&p["bow_about_y_m"]), number(&p["bow_about_z_m"])];
        it.residual_stress = p["residual_stresses"] != "none";
        let expected = number(&case["reference"]["N_u_N"]);
        it.bow = bows[0].max(bows[1]);
        it.bow_axes = match bows {
            [y, 0.0] if y > 0.0 => BowAxes::Strong,
            [0.0, z] if z > 0.0 => BowAxes::Weak,
            _ => BowAxes::Both,
        };
        let model = BeamModel::new(&it).unwrap();
        let found = match hit {
            Some(hit) => model.simulate(&hit, None).unwrap().0.residual_capacity_n[0],
            None if bows[0] > 0.0 && bows[1] > 0.0 => model.capacity_bowed(bows),
            None if bows[1] > 0.0 => model.undamaged_capacity()[1],
            None => model.undamaged_capacity()[0],
        };
        let ratio = found / expected;
        println!("{} {ratio:.4}", case["name"]);
        let tolerance = number(&case["tolerance_relative"]["N_u_N"]);
        rows.push(format!(
            "{} of {} m {},{},{},{expected:.0},{ratio:.4},{tolerance}",
            p["section"].as_str().unwrap(),
            it.length(),
            match hit {
                Some(hit) => format!("hit with {} m/s", hit.impact.velocity),
                None => "undamaged".to_owned(),
            },
            match bows {
                [0.0, 0.0] => "none",
                [_, 0.0] => "strong",
                [0.0, _] => "weak",
                _ => "both",
            },
            it.residual_stress,
        ));
        if (ratio - 1.0).abs() > tolerance {
            wrong.push(format!("{} {ratio}", case["name"]));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    let header = "case,bow,residual_stress,capacity_n,ratio,tolerance";
    found::keep("push_down", header, &rows);
}
