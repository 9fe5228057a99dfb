mod reference;
use column_beam::BeamModel;
use reference::{column, hit};
#[test]
fn probe() {
    for (deg, elements) in [(0.0, 22), (0.0, 35), (45.0, 22), (45.0, 16)] {
        let mut it = column("HEB220", 355e6, 1e-4);
        it.top_spring_stiffness = 10e6;
        it.top_load = 0.5e6;
        it.elements = elements;
        let m = BeamModel::new(&it).unwrap();
        let t = reference::cpu();
        for _ in 0..5 { m.respond(&hit(1500.0, 10.0, None, deg)).unwrap(); }
        let r = m.respond(&hit(1500.0, 10.0, None, deg)).unwrap();
        println!("PROBE {deg} {elements} {:.2} ms {r:?}", (reference::cpu() - t) / 6.0);
    }
}
