//! The events of an impact with their times: from a report if there is one, otherwise from the states.

use crate::column::{HINGES, HingeState, Phase, Sample, WEBS};
use crate::messages::column_twin_msgs::ImpactReport;

use super::scene::force;
use crate::observables::{HINGE_PLACES, WEB_PLACES};

/// An event of an impact.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Time since the stamp of the impact event \[s\].
    pub time: f64,
    /// Description for the log.
    pub text: String,
}

/// Detects the events of one impact in the sequence of its states.
#[derive(Debug, Clone, Default)]
pub struct EventDetector {
    /// Events of the report that have not been returned yet, the latest first.
    pending: Vec<Event>,
    /// Whether a report gives the times.
    has_report: bool,
    touched: bool,
    released: bool,
    peaked: bool,
    yielded: [bool; HINGES],
    sheared: [bool; WEBS],
    last: Option<Sample>,
}

impl EventDetector {
    /// Uses a report of the impact: its events are not looked for in the states any more.
    pub fn use_report(&mut self, report: &ImpactReport) {
        if self.has_report {
            return;
        }
        self.has_report = true;
        self.pending = of_report(report);
        let last = self.last.map_or(f64::NEG_INFINITY, |last| last.time);
        self.pending.retain(|it| it.time > last);
        self.pending
            .sort_by(|one, other| other.time.total_cmp(&one.time));
    }

    /// The events up to this state that have not been returned yet.
    pub fn until(&mut self, sample: &Sample) -> Vec<Event> {
        let mut found = Vec::new();
        let mut add = |time, text: String| found.push(Event { time, text });
        if !self.touched && (sample.phase == Phase::Contact || sample.impulse > 0.0) {
            self.touched = true;
            add(sample.time, contact(sample));
        }
        if sample.impact_impulse > 0.0 {
            let text = format!("impact impulse of {:.0} N s", sample.impact_impulse);
            add(sample.time, text);
        }
        if !self.has_report {
            self.detect(sample, &mut add);
        }
        self.last = Some(*sample);
        while let Some(next) = self.pending.pop_if(|next| next.time <= sample.time) {
            found.push(next);
        }
        found.sort_by(|one, other| one.time.total_cmp(&other.time));
        found
    }

    /// The events that follow from the states alone, as precisely as their spacing allows.
    fn detect(&mut self, sample: &Sample, add: &mut impl FnMut(f64, String)) {
        for (index, hinge) in sample.hinges.iter().enumerate() {
            if hinge.state == HingeState::Plastic && !self.yielded[index] {
                self.yielded[index] = true;
                add(sample.time, first_yield(index));
            }
        }
        for (index, web) in sample.webs.iter().enumerate() {
            if web.state == HingeState::Plastic && !self.sheared[index] {
                self.sheared[index] = true;
                add(sample.time, first_shear(index));
            }
        }
        if let Some(last) = &self.last {
            if !self.peaked && self.touched && last.v1_rate > 0.0 && sample.v1_rate <= 0.0 {
                self.peaked = true;
                add(last.time, peak(last.v1));
            }
            if !self.released && last.phase == Phase::Contact && sample.phase == Phase::Free {
                self.released = true;
                add(sample.time, separation(sample.impactor_velocity));
            }
        }
    }
}

/// The events of a report, unordered.
fn of_report(report: &ImpactReport) -> Vec<Event> {
    let mut events: Vec<_> = (0..HINGES)
        .map(|index| {
            (
                report.first_yield_time.get_or(index, f64::NAN),
                first_yield(index),
            )
        })
        .collect();
    events.extend((0..WEBS).map(|index| {
        (
            report.web_first_yield_time.get_or(index, f64::NAN),
            first_shear(index),
        )
    }));
    events.push((report.max_v1_time, peak(report.max_v1)));
    events.push((report.release_time, separation(report.impactor_rebound)));
    events.push((report.end_time, end(report)));
    events
        .into_iter()
        .filter(|(time, _)| time.is_finite())
        .map(|(time, text)| Event { time, text })
        .collect()
}

fn contact(sample: &Sample) -> String {
    format!(
        "contact: velocity of the impactor {:.2} m/s",
        sample.impactor_velocity
    )
}

fn first_yield(hinge: usize) -> String {
    format!("first yield of hinge {}", HINGE_PLACES[hinge])
}

fn first_shear(web: usize) -> String {
    format!("the web {} begins to shear", WEB_PLACES[web])
}

fn peak(v1: f64) -> String {
    format!("peak: v1 = {:.1} mm", 1e3 * v1)
}

fn separation(velocity: f64) -> String {
    format!("separation: velocity of the impactor {velocity:.2} m/s")
}

fn end(report: &ImpactReport) -> String {
    let residual = 1e3 * report.residual_v1;
    match (report.outcome, report.end) {
        (ImpactReport::COLLAPSED, _) => "collapse".to_owned(),
        (ImpactReport::FRACTURED, _) => {
            "fractured: a hinge, a web or the base is fractured".to_owned()
        }
        (_, ImpactReport::END_DURATION_REACHED) => {
            format!("stopped at response.duration; residual v1 = {residual:.1} mm")
        }
        _ => format!("rest: residual v1 = {residual:.1} mm"),
    }
}

/// One line that summarises a report.
#[must_use]
pub fn summary(report: &ImpactReport) -> String {
    let outcome = match report.outcome {
        ImpactReport::ELASTIC => "elastic",
        ImpactReport::PLASTIC => "plastic",
        ImpactReport::FRACTURED => "FRACTURED",
        _ => "COLLAPSED",
    };
    // A column that collapses or fractures has none.
    let residual = match report.residual_v1.is_finite() {
        true => format!(", residual v1 {:.1} mm", 1e3 * report.residual_v1),
        false => String::new(),
    };
    format!(
        "{outcome}: peak v1 {:.1} mm at {:.2} ms{residual}, max u2 {:.1} mm, peak contact force {}, plastic work {:.1} kJ",
        1e3 * report.max_v1,
        1e3 * report.max_v1_time,
        1e3 * report.max_u2,
        force(report.peak_contact_force),
        1e-3 * report.plastic_work,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::{Impact, simulate};
    use crate::parameters::Parameters;

    fn impact() -> (Vec<Sample>, ImpactReport) {
        let car = Impact {
            mass: 1500.0,
            velocity: 10.0,
            gap: 0.005,
            restitution: 0.0,
            vehicle: None,
            bumper_height: 0.0,
            transverse_force: 0.0,
        };
        let mut samples = Vec::new();
        let only_bends = [("shear.model", "none".into())];
        let parameters = Parameters::from_values(only_bends).expect("admissible");
        let column = parameters.column_properties();
        let report = simulate(&column, &car, 2.0, &mut |sample| samples.push(*sample));
        (samples, ImpactReport::from(&report.expect("simulated")))
    }

    fn all(events: &mut EventDetector, samples: &[Sample]) -> Vec<Event> {
        samples
            .iter()
            .flat_map(|sample| events.until(sample))
            .collect()
    }

    const EVERYTHING: [&str; 9] = [
        "contact",
        "impact impulse",
        "first yield of hinge 3",
        "first yield of hinge 1b",
        "first yield of hinge 1a",
        "first yield of hinge 2",
        "peak",
        "separation",
        "rest",
    ];

    #[test]
    fn a_report_gives_the_times_of_the_events() {
        let (samples, report) = impact();
        let mut events = EventDetector::default();
        events.use_report(&report);
        let found = all(&mut events, &samples);
        for (event, expected) in found.iter().zip(EVERYTHING) {
            assert!(event.text.starts_with(expected), "{event:?} {expected}");
        }
        assert_eq!(found.len(), EVERYTHING.len());
        assert!(found.is_sorted_by_key(|it| it.time));
        assert_eq!(found[2].time, report.first_yield_time[3]);
        assert_eq!(found[6].time, report.max_v1_time);
    }

    /// A running twin publishes its first states before its forecast: no event is returned twice or lost.
    #[test]
    fn a_report_may_come_late() {
        let (samples, report) = impact();
        for late in [1, 30, 600] {
            let mut events = EventDetector::default();
            let mut found = all(&mut events, &samples[..late]);
            events.use_report(&report);
            found.extend(all(&mut events, &samples[late..]));
            for (event, expected) in found.iter().zip(EVERYTHING) {
                assert!(event.text.starts_with(expected), "{event:?} {expected}");
            }
            assert_eq!(found.len(), EVERYTHING.len());
        }
    }

    /// A recording without the report gives the same events, to within one step.
    #[test]
    fn states_alone_give_the_same_events() {
        let (samples, report) = impact();
        let mut with = EventDetector::default();
        with.use_report(&report);
        let mut with = all(&mut with, &samples);
        with.retain(|it| !it.text.starts_with("rest"));
        let alone = all(&mut EventDetector::default(), &samples);
        assert_eq!(alone.len(), with.len(), "{alone:#?}");
        for (alone, with) in alone.iter().zip(&with) {
            assert_eq!(alone.text.split(':').next(), with.text.split(':').next());
            assert!(
                (alone.time - with.time).abs() < 4.1e-5,
                "{alone:?} {with:?}"
            );
        }
    }
}
