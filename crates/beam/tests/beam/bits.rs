//! The same bits on every processor: with and without FMA and AVX, with any order of the lanes that a compiler may choose.
//!
//! `RUSTFLAGS="-C target-cpu=native" cargo test --release -p column_beam bits` must pass as well.

use crate::reference::column_hit_three_times;
use column_beam::BeamModel;

/// Bits of peak, residual and remaining capacity about the strong axis; they change with any change of the model.
const GOLDEN: [[u64; 3]; 3] = [
    [
        0x3fab_cb27_0dfa_60e1,
        0x3faa_da18_57f0_b41f,
        0x4143_6b37_e7d4_5ced,
    ],
    [
        0x3fa9_0eb2_4240_dcee,
        0x3fa7_c2d4_1b77_66cb,
        0x413a_053a_bceb_8007,
    ],
    [
        0x3f6f_5674_944f_0aad,
        0x3f56_32b2_5eb0_827d,
        0x413a_2495_6365_9746,
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
