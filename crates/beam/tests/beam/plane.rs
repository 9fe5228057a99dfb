//! Plane hits against OpenSees (`data/fibre_cases.csv`).

use crate::cases::plane_cases;
use crate::found;
use column_beam::BeamModel;

#[test]
fn plane_hits_agree_with_opensees() {
    let (mut wrong, mut rows) = (Vec::new(), Vec::new());
    for case in plane_cases() {
        let (it, hit) = (case.column, case.hit);
        let model = BeamModel::new(&it).unwrap();
        let alone = model.respond(&hit).unwrap();
        let (outcome, _) = model.simulate(&hit, None).unwrap();
        let ratio = alone[0] / case.peak;
        let (remains, expected) = (alone[1], case.residual);
        println!(
            "{:16} {:7} v1 {ratio:.4} t {:.4} res {:.4} | n {} steps {} err {:.1e} ledger {:.1e} cap {:.3e} -> {:.3e}",
            case.name,
            case.hardening,
            alone[2] / case.time,
            remains / expected,
            outcome.elements,
            outcome.steps,
            outcome.error_estimate,
            outcome.energy_error,
            outcome.undamaged_capacity_n[0],
            outcome.residual_capacity_n[0]
        );
        rows.push(format!(
            "{},{},{},{:.5},{ratio:.4},{expected:.5},{:.4}",
            case.name,
            if hit.impact.vehicle.is_some() {
                "soft"
            } else {
                "rigid"
            },
            case.hardening,
            case.peak,
            remains / expected,
        ));
        if (ratio - 1.0).abs() > 0.01 || (remains - expected).abs() > 0.01 * expected + 1e-5 {
            wrong.push(format!(
                "{} {}: {ratio} {}",
                case.name,
                case.hardening,
                remains / expected
            ));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    let header = "case,vehicle,hardening,peak_m,ratio,residual_m,residual_ratio";
    found::keep("plane", header, &rows);
}
