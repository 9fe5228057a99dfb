mod reference;
use column_beam::BeamModel;
use reference::{column, hit, vehicle};
#[test]
fn probe() {
    for (deg, elements) in [(0.0, 0), (0.0, 22)] {
        let mut it = column("HEB220", 355e6, 1e-4);
        it.top_spring_stiffness = 10e6;
        it.top_load = 0.5e6;
        it.elements = elements;
        let m = BeamModel::new(&it).unwrap();
        for v in [None, Some(vehicle(1500.0, 3e5, None))] {
        let h = hit(1500.0, if v.is_some() { 40.0 } else { 10.0 }, v, deg);
        let t = reference::cpu();
        for _ in 0..20 { m.respond(&h).unwrap(); }
        println!("PROBE {deg} {elements} {:.2} ms", (reference::cpu() - t) / 20.0);
        }
    }
}
