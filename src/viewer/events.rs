//! What happens in the course of an impact, each with its time: from a report where there is one, else from the states.

use crate::column::{HINGE_NAMES, HINGES, HingeState, Phase, Sample};
use crate::messages::column_twin::ImpactReport;

use super::scene::{HINGE_PLACES, force};

/// Something that happens.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Since the event \[s\].
    pub time: f64,
    /// In words.
    pub text: String,
}

/// Finds what happens while the states of one impact pass.
#[derive(Debug, Clone, Default)]
pub struct Events {
    /// Of the report, what has not been told yet, the latest first.
    announced: Vec<Event>,
    /// Whether a report tells the times.
    has_report: bool,
    touched: bool,
    released: bool,
    peaked: bool,
    yielded: [bool; HINGES],
    last: Option<Sample>,
}

impl Events {
    /// A report of the impact whose states begin now, or have begun: what it tells is not looked for in the states.
    pub fn announce(&mut self, report: &ImpactReport) {
        if self.has_report {
            return;
        }
        self.has_report = true;
        self.announced = of_report(report);
        let last = self.last.map_or(f64::NEG_INFINITY, |last| last.time);
        self.announced.retain(|it| it.time > last);
        self.announced
            .sort_by(|one, other| other.time.total_cmp(&one.time));
    }

    /// What has happened until this state and has not been told.
    pub fn until(&mut self, sample: &Sample) -> Vec<Event> {
        let mut found = Vec::new();
        let mut tell = |time, text: String| found.push(Event { time, text });
        if !self.touched && (sample.phase == Phase::Contact || sample.impulse > 0.0) {
            self.touched = true;
            tell(sample.time, contact(sample));
        }
        if sample.percussion > 0.0 {
            let text = format!("percussion of {:.0} N s", sample.percussion);
            tell(sample.time, text);
        }
        if !self.has_report {
            self.look(sample, &mut tell);
        }
        self.last = Some(*sample);
        while let Some(next) = self.announced.pop_if(|next| next.time <= sample.time) {
            found.push(next);
        }
        found.sort_by(|one, other| one.time.total_cmp(&other.time));
        found
    }

    /// What the states alone tell, to the precision of their spacing.
    fn look(&mut self, sample: &Sample, tell: &mut impl FnMut(f64, String)) {
        for (index, hinge) in sample.hinges.iter().enumerate() {
            if hinge.state == HingeState::Plastic && !self.yielded[index] {
                self.yielded[index] = true;
                tell(sample.time, first_yield(index));
            }
        }
        if let Some(last) = &self.last {
            if !self.peaked && self.touched && last.v1_rate > 0.0 && sample.v1_rate <= 0.0 {
                self.peaked = true;
                tell(last.time, peak(last.v1));
            }
            if !self.released && last.phase == Phase::Contact && sample.phase == Phase::Free {
                self.released = true;
                tell(sample.time, release(sample.impactor_velocity));
            }
        }
    }
}

/// What a report tells, in no order.
fn of_report(report: &ImpactReport) -> Vec<Event> {
    let mut told: Vec<_> = (0..HINGES)
        .map(|index| (report.first_yield_time[index], first_yield(index)))
        .collect();
    told.push((report.max_v1_time, peak(report.max_v1)));
    told.push((report.release_time, release(report.impactor_rebound)));
    told.push((report.end_time, end(report)));
    told.into_iter()
        .filter(|(time, _)| time.is_finite())
        .map(|(time, text)| Event { time, text })
        .collect()
}

fn contact(sample: &Sample) -> String {
    format!(
        "contact: the impactor touches the column, {:.2} m/s after it",
        sample.impactor_velocity
    )
}

fn first_yield(hinge: usize) -> String {
    format!(
        "first yield of hinge {} ({})",
        HINGE_NAMES[hinge], HINGE_PLACES[hinge]
    )
}

fn peak(v1: f64) -> String {
    format!("peak: v1 = {:.1} mm", 1e3 * v1)
}

fn release(velocity: f64) -> String {
    format!("release: the impactor leaves with {velocity:.2} m/s")
}

fn end(report: &ImpactReport) -> String {
    let residual = 1e3 * report.residual_v1;
    match (report.outcome, report.end) {
        (ImpactReport::COLLAPSED, _) => "collapse".to_owned(),
        (_, ImpactReport::END_DURATION_REACHED) => {
            format!("end of response.duration; residual v1 = {residual:.1} mm")
        }
        _ => format!("rest: residual v1 = {residual:.1} mm"),
    }
}

/// A report in one line.
#[must_use]
pub fn summary(report: &ImpactReport) -> String {
    let outcome = match report.outcome {
        ImpactReport::ELASTIC => "elastic",
        ImpactReport::PLASTIC => "plastic",
        _ => "COLLAPSED",
    };
    format!(
        "{outcome}: max v1 {:.1} mm at {:.2} ms, residual v1 {:.1} mm, max u2 {:.1} mm, peak contact force {}, plastic work \
         {:.1} kJ",
        1e3 * report.max_v1,
        1e3 * report.max_v1_time,
        1e3 * report.residual_v1,
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
        };
        let mut samples = Vec::new();
        let column = Parameters::default().column_properties();
        let report = simulate(&column, &car, 2.0, &mut |sample| samples.push(*sample));
        (samples, ImpactReport::from(&report.expect("simulated")))
    }

    fn all(events: &mut Events, samples: &[Sample]) -> Vec<Event> {
        samples
            .iter()
            .flat_map(|sample| events.until(sample))
            .collect()
    }

    const EVERYTHING: [&str; 9] = [
        "contact",
        "percussion",
        "first yield of hinge 3",
        "first yield of hinge 1b",
        "first yield of hinge 1a",
        "first yield of hinge 2",
        "peak",
        "release",
        "rest",
    ];

    #[test]
    fn a_report_tells_when_things_happen() {
        let (samples, report) = impact();
        let mut events = Events::default();
        events.announce(&report);
        let told = all(&mut events, &samples);
        for (told, expected) in told.iter().zip(EVERYTHING) {
            assert!(told.text.starts_with(expected), "{told:?} {expected}");
        }
        assert_eq!(told.len(), EVERYTHING.len());
        assert!(told.is_sorted_by_key(|it| it.time));
        assert_eq!(told[2].time, report.first_yield_time[3]);
        assert_eq!(told[6].time, report.max_v1_time);
    }

    /// A running twin has its forecast when the first states are out: nothing is told twice, or not at all.
    #[test]
    fn a_report_may_come_late() {
        let (samples, report) = impact();
        for late in [1, 30, 600] {
            let mut events = Events::default();
            let mut told = all(&mut events, &samples[..late]);
            events.announce(&report);
            told.extend(all(&mut events, &samples[late..]));
            for (told, expected) in told.iter().zip(EVERYTHING) {
                assert!(told.text.starts_with(expected), "{told:?} {expected}");
            }
            assert_eq!(told.len(), EVERYTHING.len());
        }
    }

    /// A recording that lacks the report tells the same, to a step.
    #[test]
    fn states_alone_tell_the_same() {
        let (samples, report) = impact();
        let mut with = Events::default();
        with.announce(&report);
        let mut with = all(&mut with, &samples);
        with.retain(|it| !it.text.starts_with("rest"));
        let alone = all(&mut Events::default(), &samples);
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
