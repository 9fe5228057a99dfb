mod reference;
use column_beam::BeamModel;
use reference::{column, hit, vehicle};
#[test]
fn probe() {
    for b in [1e-4, 1e-2] {
    for (elements, nanos) in [(16, 0), (0, 0), (35, 20000), (70, 20000), (140, 20000), (0, 20000), (0, 10000)] {
        let mut it = column("HEB220", 355e6, b);
        it.top_spring_stiffness = 10e6;
        it.top_load = 0.5e6;
        it.elements = elements;
        it.step_nanos = nanos;
        let m = BeamModel::new(&it).unwrap();
        let r = m.respond(&hit(1500.0, 10.0, None, 0.0)).unwrap();
        let s = m.respond(&hit(1500.0, 40.0, Some(vehicle(1500.0, 3e5, None)), 0.0)).unwrap();
        println!("{b} {elements} {nanos} {r:?} {s:?}");
    }
    }
}

#[test]
fn limit() {
    let mut it = column("HEB220", 355e6, 1e-5);
    it.steel.young_modulus *= 100.0;
    it.shear = true;
    it.length_below = 1.0;
    it.bumper_height = 0.2;
    let m = BeamModel::new(&it).unwrap();
    eprintln!("XX");
    for way in [1e-4, 2e-4, 5e-4, 1e-3] { eprintln!("XX {way} {:?}", m.lateral_resistance(way)); }
}
