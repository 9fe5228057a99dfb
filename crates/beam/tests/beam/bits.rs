//! The same bits on every processor: with and without FMA and AVX, with any order of the lanes that a compiler may choose.
//!
//! `RUSTFLAGS="-C target-cpu=native" cargo test --release -p column_beam bits` must pass as well.

use crate::reference::column_hit_three_times;
use column_beam::BeamModel;

/// Bits of peak, residual and remaining capacity about the strong axis; they change with any change of the model.
const GOLDEN: [[u64; 3]; 3] = [
    [
        0x3fab_b4c6_c957_8d2a,
        0x3faa_c3fe_5fb7_6703,
        0x4143_7ccf_465a_24ca,
    ],
    [
        0x3fa8_9188_2378_230e,
        0x3fa7_42de_79a5_eb3f,
        0x413b_2223_d1af_688a,
    ],
    [
        0x3f6e_3625_6a52_fc50,
        0x3f55_a8ad_f6e5_6a72,
        0x413b_39b3_2738_536f,
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
