//! What the fibre beam says of the cells of a map, as columns for Python.

use column_twin::study::{ColumnKind, DamageMap, MapCell, TableValue};
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::values::doubles;

/// Names of the columns before those of the beam and after them, in the table of a map.
const AROUND: [&str; 2] = ["model", "fault"];

/// The columns of the beam in the table of a map; none where it is not asked.
pub struct BeamColumns {
    /// Place of the first one in the table.
    first: usize,
    columns: Vec<BeamColumn>,
}

struct BeamColumn {
    name: String,
    unit: &'static str,
    meaning: &'static str,
    values: Values,
}

/// NaN and `None` where there is nothing.
enum Values {
    Numbers(Vec<f64>),
    Texts(Vec<Option<String>>),
}

/// A column for Python: name, unit, meaning, and doubles or texts.
type PyColumn<'py> = (String, &'static str, &'static str, Bound<'py, PyAny>);

impl BeamColumns {
    /// The columns of this map, without values.
    pub fn of(map: &DamageMap) -> Self {
        let table = map.table_columns();
        let place = |name: &str| table.iter().position(|it| it.name == name);
        let [before, after] = AROUND.map(place);
        let between = match (before, after) {
            (Some(before), Some(after)) => before + 1..after,
            _ => 0..0,
        };
        Self {
            first: between.start,
            columns: table[between]
                .iter()
                .map(|it| BeamColumn {
                    name: it.name.clone(),
                    unit: it.unit,
                    meaning: it.meaning,
                    values: match it.kind {
                        ColumnKind::Whole | ColumnKind::Number => Values::Numbers(Vec::new()),
                        ColumnKind::Text => Values::Texts(Vec::new()),
                    },
                })
                .collect(),
        }
    }

    /// Appends the values of a cell of this map.
    pub fn push(&mut self, map: &DamageMap, cell: &MapCell) {
        let columns = &mut self.columns;
        if columns.is_empty() {
            return;
        }
        for (column, value) in columns
            .iter_mut()
            .zip(map.table_values(cell).skip(self.first))
        {
            match (&mut column.values, value) {
                (Values::Numbers(all), TableValue::Number(it)) => all.push(it.unwrap_or(f64::NAN)),
                (Values::Numbers(all), TableValue::Whole(it)) => {
                    all.push(it.map_or(f64::NAN, |it| it as f64));
                }
                (Values::Numbers(all), TableValue::Text(_)) => all.push(f64::NAN),
                (Values::Texts(all), TableValue::Text(it)) => all.push(it.map(str::to_owned)),
                (Values::Texts(all), _) => all.push(None),
            }
        }
    }

    /// The columns for Python.
    pub fn into_py(self, py: Python<'_>) -> PyResult<Vec<PyColumn<'_>>> {
        let columns = self.columns.into_iter().map(|it| {
            let values = match it.values {
                Values::Numbers(numbers) => doubles(py, &numbers)?.into_any(),
                Values::Texts(texts) => PyList::new(py, texts)?.into_any(),
            };
            Ok((it.name, it.unit, it.meaning, values))
        });
        columns.collect()
    }
}
