//! The same bits on every processor: with and without FMA and AVX, with any order of the lanes that a compiler may choose.
//!
//! `RUSTFLAGS="-C target-cpu=native" cargo test --release -p column_beam bits` must pass as well.

use crate::reference::column_hit_three_times;
use column_beam::BeamModel;

/// Bits of peak, residual and remaining capacity about the strong axis; they change with any change of the model.
const GOLDEN: [[u64; 3]; 3] = [
    [
        0x3fab_cb27_107b_d177,
        0x3faa_da18_5ca6_c833,
        0x4143_6b37_f16f_ec8d,
    ],
    [
        0x3fa9_0dad_8977_6825,
        0x3fa7_c1d0_7ea3_c01c,
        0x413a_0589_84fc_1734,
    ],
    [
        0x3f6f_4f04_bd64_3690,
        0x3f56_24c2_8e2b_bbed,
        0x413a_24be_9f0c_18c3,
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
