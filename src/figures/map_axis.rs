//! An axis of a damage map as its figures show it.

use super::axis::PlotAxis;
use super::map_marks::{METRES_PER_SECOND, Mark, marks};
use super::units::Unit;
use crate::study::{MapAxis, MapQuantity};

/// An axis of a map as a figure shows it.
pub(super) struct ShownAxis<'a> {
    pub axis: &'a MapAxis,
    pub symbol: String,
    pub per_si: f64,
}

impl<'a> ShownAxis<'a> {
    pub fn of(axis: &'a MapAxis) -> Self {
        let last = axis.ends().map_or(0.0, |ends| ends[1]);
        let fitting = |unit: Unit| (unit.symbol.to_owned(), unit.per_si);
        let (symbol, per_si) = match axis.quantity().unit() {
            "kg" if last >= 1e4 => ("t".to_owned(), 1e-3),
            "N" => fitting(Unit::force(last)),
            "N m" => fitting(Unit::moment(last)),
            "Pa" => ("MPa".to_owned(), 1e-6),
            unit => (unit.to_owned(), 1.0),
        };
        Self {
            axis,
            symbol,
            per_si,
        }
    }

    /// The place of a value of the axis, in the unit of the figure; of a name, its number.
    pub fn at(&self, index: u64) -> f64 {
        let number = self.axis.number(index);
        number.map_or(index as f64, |number| number * self.per_si)
    }

    pub fn of_si(&self, value: f64) -> f64 {
        value * self.per_si
    }

    pub fn plot_axis(&self, count: usize) -> PlotAxis {
        match self.axis.ends() {
            Some([from, to]) => {
                let axis = PlotAxis::exactly(self.of_si(from), self.of_si(to), count);
                match self.axis.quantity() {
                    MapQuantity::Velocity => axis.with_second_unit(1.0 / METRES_PER_SECOND),
                    _ => axis,
                }
            }
            None => {
                let names = (0..self.axis.len()).map(|index| self.axis.value(index).to_string());
                PlotAxis::named(names.collect())
            }
        }
    }

    /// As [`plot_axis`](Self::plot_axis), up to a value in its SI unit where one is given.
    pub fn plot_axis_to(&self, end: Option<f64>, count: usize) -> PlotAxis {
        let (Some(end), Some([from, _])) = (end, self.axis.ends()) else {
            return self.plot_axis(count);
        };
        let axis = PlotAxis::exactly(self.of_si(from), self.of_si(end), count);
        match self.axis.quantity() {
            MapQuantity::Velocity => axis.with_second_unit(1.0 / METRES_PER_SECOND),
            _ => axis,
        }
    }

    pub fn name(&self) -> String {
        self.titled(self.axis.quantity().title())
    }

    /// As [`name`](Self::name), for a low panel.
    pub fn short_name(&self) -> String {
        self.titled(self.axis.quantity().name())
    }

    pub fn titled(&self, title: &str) -> String {
        match &*self.symbol {
            "" => title.to_owned(),
            "m/s" => format!("{title} [m/s (km/h)]"),
            symbol => format!("{title} [{symbol}]"),
        }
    }

    /// What is marked along the axis, in the unit of the figure.
    pub fn marks(&self) -> Vec<Mark> {
        let shown = |mark: Mark| Mark {
            value: self.of_si(mark.value),
            ..mark
        };
        marks(self.axis).into_iter().map(shown).collect()
    }

    /// The edges of the cells at these places of the axis: midway between them; the first and the last one reach to the ends of the
    /// figure.
    pub fn edges(&self, places: &[u64], plot: &PlotAxis) -> Vec<f64> {
        let at: Vec<f64> = places.iter().map(|&index| self.at(index)).collect();
        let between = at.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        [plot.from]
            .into_iter()
            .chain(between)
            .chain([plot.to])
            .collect()
    }
}
