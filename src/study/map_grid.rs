//! The cells of a map as pictures need them, in a bounded memory.

use super::map::{DamageMap, MapCell};
use crate::assessment::Action;

/// Most points along an axis of a picture; of a finer map, a picture shows every second, third, ... one.
const MAX_POINTS: u64 = 400;

/// The cells of a map that a picture shows.
#[derive(Debug, Clone, PartialEq)]
pub struct MapGrid {
    /// Places on the axis of the rows.
    rows: Vec<u64>,
    /// Places on the axis of the columns.
    columns: Vec<u64>,
    row_stride: u64,
    column_stride: u64,
    /// Variant by variant, row by row.
    cells: Vec<Option<GridCell>>,
}

/// A cell as a picture shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridCell {
    /// What has to be done.
    pub action: Action,
    /// Residual displacement of the impact point \[m\]; `None` where the column does not stand.
    pub residual_v1: Option<f64>,
}

impl MapGrid {
    /// A grid without values for the pictures of this map.
    #[must_use]
    pub fn of(map: &DamageMap) -> Self {
        let [row_stride, column_stride] =
            [map.rows(), map.columns()].map(|axis| axis.len().div_ceil(MAX_POINTS));
        let places =
            |count: u64, stride: u64| (0..count).step_by(stride as usize).collect::<Vec<_>>();
        let rows = places(map.rows().len(), row_stride);
        let columns = places(map.columns().len(), column_stride);
        Self {
            cells: vec![None; map.variants().len() * rows.len() * columns.len()],
            rows,
            columns,
            row_stride,
            column_stride,
        }
    }

    /// Takes a cell, if the picture shows it.
    pub fn push(&mut self, cell: &MapCell) {
        let (place, strides) = (cell.place, (self.row_stride, self.column_stride));
        let is_shown =
            place.row.is_multiple_of(strides.0) && place.column.is_multiple_of(strides.1);
        let Some(evaluation) = cell.result.as_ref().ok().filter(|_| is_shown) else {
            return;
        };
        let (row, column) = (
            (place.row / strides.0) as usize,
            (place.column / strides.1) as usize,
        );
        let index = (place.variant * self.rows.len() + row) * self.columns.len() + column;
        self.cells[index] = Some(GridCell {
            action: evaluation.action,
            residual_v1: evaluation.residual_v1,
        });
    }

    /// Places on the axis of the rows that are shown.
    #[must_use]
    pub fn rows(&self) -> &[u64] {
        &self.rows
    }

    /// Places on the axis of the columns that are shown.
    #[must_use]
    pub fn columns(&self) -> &[u64] {
        &self.columns
    }

    /// The cell at these numbers of a shown row and a shown column; `None` if it was not computed.
    #[must_use]
    pub fn cell(&self, variant: usize, row: usize, column: usize) -> Option<GridCell> {
        let index = (variant * self.rows.len() + row) * self.columns.len() + column;
        self.cells.get(index).copied().flatten()
    }
}
