//! The same bits on every processor: with and without FMA and AVX, with any order of the lanes that a compiler may choose.
//!
//! `RUSTFLAGS="-C target-cpu=native" cargo test --release -p column_beam bits` must pass as well.

use crate::reference::column_hit_three_times;
use column_beam::BeamModel;

/// Bits of peak, residual and remaining capacity about the strong axis; they change with any change of the model.
const GOLDEN: [[u64; 3]; 3] = [
    [
        0x3fab_b4c6_cf5e_51f4,
        0x3faa_c3fe_5c37_8ad0,
        0x4143_7ccf_4cac_e0d1,
    ],
    [
        0x3fa8_9188_1b62_8eee,
        0x3fa7_42de_43e3_264d,
        0x413b_2223_f6d4_bcf0,
    ],
    [
        0x3f6e_3622_2bb4_85a5,
        0x3f55_a8a5_a90f_1122,
        0x413b_39b3_5d35_621e,
    ],
];

#[test]
fn responses_have_the_same_bits_on_every_processor() {
    let (it, hits) = column_hit_three_times();
    let model = BeamModel::new(&it).unwrap();
    let mut damage = None;
    let mut found = Vec::new();
    for hit in hits {
        let (outcome, after) = model.simulate(&hit, damage.as_ref()).unwrap();
        damage = after;
        found.push(
            [
                outcome.max_displacement_m,
                outcome.residual_displacement_m,
                outcome.residual_capacity_n[0],
            ]
            .map(f64::to_bits),
        );
    }
    assert_eq!(found, GOLDEN, "{found:#x?}");
}
