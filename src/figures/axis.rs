//! Axes of plots: a range and round numbers marked on it.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use crate::shape::round_number;

/// The range of an axis and its marks, in the unit of the axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlotAxis {
    pub from: f64,
    pub to: f64,
    pub marks: Vec<f64>,
    step: f64,
    /// A second unit that each mark shows in parentheses: how many of it there are in one of the first.
    second_unit: Option<f64>,
    /// Names of the marks 0, 1, ..., where the axis shows names.
    names: Vec<String>,
}

impl PlotAxis {
    /// An axis from `low` to `high`, with about `count` round numbers marked.
    pub fn between(low: f64, high: f64, count: usize) -> Self {
        let (low, high) = widened(low, high);
        Self::marked(low, high, round_number((high - low) / count as f64))
    }

    /// An axis from one number to another, which are its ends.
    pub fn exactly(from: f64, to: f64, count: usize) -> Self {
        Self::marked(from, to, round_number((to - from) / count as f64))
    }

    /// An axis of names, which are at 0, 1, ...
    pub fn named(names: Vec<String>) -> Self {
        let count = names.len() as f64;
        Self {
            from: -0.5,
            to: count - 0.5,
            marks: (0..names.len()).map(|mark| mark as f64).collect(),
            step: 1.0,
            second_unit: None,
            names,
        }
    }

    fn marked(from: f64, to: f64, step: f64) -> Self {
        let first = (from / step - 1e-6).ceil();
        let last = (to / step + 1e-6).floor();
        // Marks are counted, so that a step too small for the magnitude of the numbers cannot cause an endless loop.
        let marks = (0..=((last - first) as usize).min(100))
            .map(|number| (first + number as f64) * step + 0.0)
            .collect();
        Self {
            from,
            to,
            marks,
            step,
            second_unit: None,
            names: Vec::new(),
        }
    }

    /// The same axis, whose marks also show their value in a second unit, of which `per_unit` make one of the first.
    pub fn with_second_unit(mut self, per_unit: f64) -> Self {
        self.second_unit = Some(per_unit);
        self
    }
}

impl Ranged for PlotAxis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        let part = (value - self.from) / (self.to - self.from);
        start + (f64::from(end - start) * part).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            Vec::new()
        } else {
            self.marks.clone()
        }
    }

    fn range(&self) -> Range<f64> {
        self.from..self.to
    }
}

impl ValueFormatter<f64> for PlotAxis {
    fn format_ext(&self, mark: &f64) -> String {
        if let Some(name) = self.names.get(mark.round().max(0.0) as usize) {
            return name.clone();
        }
        if *mark == 0.0 {
            return "0".into();
        }
        let largest = self.from.abs().max(self.to.abs());
        if self.step < 1e-5 || largest >= 1e6 {
            let digits = (largest / self.step).log10().ceil().clamp(0.0, 9.0) as usize;
            return format!("{mark:.digits$e}");
        }
        let decimals = (-self.step.log10().floor()).max(0.0) as usize;
        match self.second_unit {
            Some(per_unit) => format!("{mark:.decimals$} ({:.0})", mark * per_unit),
            None => format!("{mark:.decimals$}"),
        }
    }
}

/// The range with its ends in order, and never so narrow that they coincide.
fn widened(low: f64, high: f64) -> (f64, f64) {
    let (low, high) = if low.is_finite() && high.is_finite() {
        (low.min(high), low.max(high))
    } else {
        (0.0, 1.0)
    };
    let magnitude = low.abs().max(high.abs());
    if magnitude == 0.0 {
        (0.0, 1.0)
    } else if high - low < 1e-9 * magnitude {
        (low - 0.1 * magnitude, high + 0.1 * magnitude)
    } else {
        (low, high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_round() {
        let axis = PlotAxis::between(-3.0, 94.6, 6);
        assert_eq!((axis.from, axis.to), (-3.0, 94.6));
        assert_eq!(axis.marks, [0.0, 20.0, 40.0, 60.0, 80.0]);
        assert_eq!(axis.format_ext(&20.0), "20");
        let time = PlotAxis::between(0.0, 43.7, 8);
        assert_eq!(time.to, 43.7);
        assert_eq!(*time.marks.last().unwrap(), 40.0);
        assert_eq!(PlotAxis::between(0.0, 0.3, 5).format_ext(&0.1), "0.1");
        assert_eq!(
            PlotAxis::between(0.0, 3e-10, 3).format_ext(&1e-10),
            "1.0e-10"
        );
    }

    #[test]
    fn degenerate_ranges_have_an_axis() {
        for (low, high) in [
            (0.0, 0.0),
            (5.0, 5.0),
            (-7.0, -7.0),
            (1e6, 1e6 + 1e-9),
            (f64::NAN, 1.0),
            (f64::NEG_INFINITY, f64::INFINITY),
            (1e-300, 2e-300),
            (1e300, 1.5e300),
            (3.0, 1.0),
        ] {
            {
                let axis = PlotAxis::between(low, high, 6);
                assert!(axis.from < axis.to, "{low} {high}: {axis:?}");
                assert!(!axis.marks.is_empty() && axis.marks.len() < 100);
                assert!(axis.marks.iter().all(|mark| mark.is_finite()));
            }
        }
    }
}
