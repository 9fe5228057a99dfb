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
        0x3fa8_9497_ed9a_6012,
        0x3fa7_45fd_0967_702d,
        0x413b_2019_5544_3757,
    ],
    [
        0x3f6e_7ba8_89d7_a5f7,
        0x3f56_1e54_ccb1_a022,
        0x413b_3913_d480_765e,
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
