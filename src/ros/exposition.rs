//! Metrics in the text format that Prometheus reads (version 0.0.4).
//!
//! The node has its numbers already, as snapshots for `/diagnostics`. A library of metrics would keep each of them a second time, in
//! counters of its own; the format itself is one function.

use std::fmt::{Display, Write as _};

/// Kinds of metrics.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    /// Only grows.
    Counter,
    /// Goes up and down.
    Gauge,
}

/// A page of metrics.
#[derive(Debug, Default)]
pub(super) struct Page {
    text: String,
}

impl Page {
    /// A metric with its values, each with its labels. `name` has its unit, and of a counter it ends with `_total`.
    pub fn metric<'a, V: Display>(
        &mut self,
        kind: Kind,
        name: &str,
        help: &str,
        values: impl IntoIterator<Item = (&'a [(&'a str, &'a str)], V)>,
    ) {
        let kind = match kind {
            Kind::Counter => "counter",
            Kind::Gauge => "gauge",
        };
        self.head(kind, name, help);
        for (labels, value) in values {
            self.sample(name, labels, value);
        }
    }

    /// A metric with one value.
    pub fn single(&mut self, kind: Kind, name: &str, help: &str, value: impl Display) {
        self.metric(kind, name, help, [(&[] as &[_], value)]);
    }

    /// A histogram.
    pub fn histogram(&mut self, name: &str, help: &str, histogram: &Histogram) {
        self.head("histogram", name, help);
        let bucket = format!("{name}_bucket");
        let mut below = 0;
        for (bound, count) in BOUNDS.iter().zip(histogram.counts) {
            below += count;
            self.sample(&bucket, &[("le", &bound.to_string())], below);
        }
        self.sample(&bucket, &[("le", "+Inf")], histogram.count);
        self.sample(&format!("{name}_sum"), &[], histogram.sum);
        self.sample(&format!("{name}_count"), &[], histogram.count);
    }

    fn head(&mut self, kind: &str, name: &str, help: &str) {
        let _ = writeln!(self.text, "# HELP {name} {help}\n# TYPE {name} {kind}");
    }

    fn sample(&mut self, name: &str, labels: &[(&str, &str)], value: impl Display) {
        self.text.push_str(name);
        for (index, (label, value)) in labels.iter().enumerate() {
            let before = if index == 0 { '{' } else { ',' };
            let _ = write!(self.text, "{before}{label}=\"{}\"", escaped(value));
        }
        if !labels.is_empty() {
            self.text.push('}');
        }
        let _ = writeln!(self.text, " {value}");
    }

    /// The page.
    pub fn into_text(self) -> String {
        self.text
    }
}

/// A value of a label: backslash, quote and line end are escaped, and nothing else is.
fn escaped(value: &str) -> String {
    value
        .replace('\\', "\\\\")
        .replace('"', "\\\"")
        .replace('\n', "\\n")
}

/// Upper bounds of the buckets \[s\]: a forecast is known after milliseconds.
const BOUNDS: [f64; 13] = [
    0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0,
];

/// How often a duration was how long.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Histogram {
    counts: [u64; BOUNDS.len()],
    count: u64,
    sum: f64,
}

impl Histogram {
    /// Counts a duration \[s\].
    pub fn observe(&mut self, seconds: f64) {
        if let Some(bucket) = BOUNDS.iter().position(|bound| seconds <= *bound) {
            self.counts[bucket] += 1;
        }
        self.count += 1;
        self.sum += seconds;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_what_the_format_asks_for() {
        let mut page = Page::default();
        let labels: &[(&str, &str)] = &[("column", "a\"3\\\n"), ("what", "x")];
        page.metric(Kind::Counter, "lost_total", "What was lost.", [(labels, 3)]);
        page.single(Kind::Gauge, "lateness_seconds", "How late.", 0.25);
        let expected = "# HELP lost_total What was lost.\n# TYPE lost_total counter\n\
                        lost_total{column=\"a\\\"3\\\\\\n\",what=\"x\"} 3\n\
                        # HELP lateness_seconds How late.\n# TYPE lateness_seconds gauge\n\
                        lateness_seconds 0.25\n";
        assert_eq!(page.into_text(), expected);
    }

    #[test]
    fn buckets_of_a_histogram_count_all_that_is_below() {
        let mut histogram = Histogram::default();
        for seconds in [0.0005, 0.003, 0.003, 100.0] {
            histogram.observe(seconds);
        }
        let mut page = Page::default();
        page.histogram("t_seconds", "T.", &histogram);
        let text = page.into_text();
        for line in [
            "t_seconds_bucket{le=\"0.001\"} 1",
            "t_seconds_bucket{le=\"0.005\"} 3",
            "t_seconds_bucket{le=\"10\"} 3",
            "t_seconds_bucket{le=\"+Inf\"} 4",
            "t_seconds_count 4",
        ] {
            assert!(text.lines().any(|it| it == line), "{line} in {text}");
        }
    }
}
