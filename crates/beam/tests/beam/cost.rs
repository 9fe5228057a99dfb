//! What an opinion costs: `cargo test --release -p column_beam cost -- --ignored --nocapture` on a quiet machine.

use crate::reference::{column, cpu, hit, hit_by_a_car, vehicle};
use column_beam::BeamModel;

#[test]
#[ignore = "a table for a quiet machine, without assertions on time"]
fn cost_of_opinions() {
    println!("case | to the end of the response | whole opinion | steps | evaluations | elements");
    for live in [false, true] {
        for (name, soft) in [("rigid", None), ("600 kN front", Some(6e5))] {
            for degrees in [0.0, 10.0, 45.0, 90.0] {
                let mut it = column("HEB220", 355e6, 1e-3);
                it.top_load = 0.5e6;
                it.top_spring_stiffness = 1e7;
                if live {
                    hit_by_a_car(&mut it);
                }
                let front = soft.map(|force| vehicle(1500.0, 1.5e6, Some(force)));
                let hit = hit(1500.0, 10.0, front, degrees);
                let model = BeamModel::new(&it).unwrap();
                let began = cpu();
                model.respond(&hit).unwrap();
                let response = cpu() - began;
                let began = cpu();
                let model = BeamModel::new(&it).unwrap();
                let (found, _) = model.simulate(&hit, None).unwrap();
                let whole = cpu() - began;
                println!(
                    "{name} {degrees} deg {} | {response:.0} ms | {whole:.0} ms | {} | {} | {} | v1 {:.1} mm err {:.1e} t {:.4}",
                    if live { "live" } else { "bare" },
                    found.steps,
                    found.evaluations,
                    found.elements,
                    1e3 * found.max_displacement_m,
                    found.error_estimate,
                    found.max_displacement_time_s,
                );
                assert!(found.steps > 0);
            }
        }
    }
}
