//! A column whose undamaged capacities are known.

use crate::reference::column_hit_three_times;
use column_beam::{BeamModel, InTurn};

#[test]
fn a_column_that_is_known_has_the_same_opinion_to_the_last_bit() {
    let (it, [hit, ..]) = column_hit_three_times();
    let first = BeamModel::new(&it)
        .unwrap()
        .opinion(&hit, None, &InTurn)
        .unwrap();
    let known = BeamModel::known(&it, first.undamaged);
    let again = known.opinion(&hit, None, &InTurn).unwrap();
    assert_eq!(again, first);
    assert!(first.capacity[0] > first.capacity[1]);
}
