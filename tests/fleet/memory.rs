//! What a column costs that nobody hits.

use std::sync::Arc;

use column_twin::fleet::make_twins;
use column_twin::parameters::{FleetColumn, Parameters, Value};

/// The aim: beside what equal columns share.
const MAX_BYTES: i64 = 20_000;

/// Columns that differ by their names only.
pub fn columns(count: usize, changes: &[(&str, Value)]) -> Vec<FleetColumn> {
    let column = |number| {
        let name = format!("c{number}");
        let own = [("column_id", Value::from(name.as_str()))];
        let parameters = Parameters::from_values(own.iter().chain(changes).cloned());
        FleetColumn {
            name: format!("/hall/{name}"),
            parameters: Arc::new(parameters.expect("admissible")),
        }
    };
    (0..count).map(column).collect()
}

#[test]
fn an_idle_column_costs_little() {
    let bytes = |count: usize| {
        let mut kept = None;
        let memory = allocation_counter::measure(|| {
            let columns = columns(count, &[]);
            let twins = make_twins(&columns, &[], || 0, 0).expect("stand");
            kept = Some((columns, twins));
        });
        assert_eq!(kept.map(|(_, twins)| twins.len()), Some(count));
        memory.bytes_current
    };
    // The first measurement pays for what is made once.
    bytes(1);
    let each = (bytes(300) - bytes(100)) / 200;
    println!("{each} bytes of each idle column");
    assert!(each > 1_000, "measured nothing: {each}");
    assert!(each <= MAX_BYTES, "{each} bytes");
}
