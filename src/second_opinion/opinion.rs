//! What the beam says of an impact beside the two bars, and where its verdict counts.

use std::fmt::{self, Display, Formatter};

use column_beam::{BeamOutcome, Outcome as BeamEnd, is_in_plane};
use serde::{Deserialize, Serialize};

use super::answer::{BeamAnswer, BeamTask};
use super::beam::NoSecondOpinion;
use super::criteria::input_of;
use crate::assessment::{
    Action, ActionRange, Assessment, AssessmentInput, OtherModel, ResidualCapacity, assess,
};
use crate::column::{Outcome, Report, is_seen_by_the_bars};
use crate::parameters::{BeamMode, Parameters, readable};

/// Factor by which the peak displacements of both models may differ, up or down, before the verdict of the beam counts for that
/// reason. Where nothing yields, the phase of the vibration alone makes a difference of 15 %.
pub const BAND: f64 = 1.25;

/// Share of the capacity left by the two bars below which what the beam leaves makes its verdict count \[A\]: the 5 % by which the
/// capacity may be too high.
const LEAST_CAPACITY: f64 = 0.95;

/// Residual bow over the height up to which the bow is no reason for the verdict of the beam to count \[A\]: that of a new column.
const BOW_OF_NEW: f64 = 1e-3;

/// Bow of earlier impacts from which on it is said that a hit bends the column back \[m\].
const LEAST_BOW: f64 = 1e-3;

/// Plastic shear angle of a web from which on shear governs \[rad\].
const SHEAR_GOVERNS: f64 = 1e-3;

/// What the beam says of an impact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SecondOpinion {
    /// What it has computed.
    pub beam: BeamOutcome,
    /// Direction of the hit \[rad\].
    pub direction: f64,
    /// Largest axial force that the undamaged column bears, and the one that the impact leaves \[N\], bowed about the axes of
    /// `beam.bow_axes`: about both at once, or held about the other one.
    pub capacity: [f64; 2],
    /// Its peak displacement along the hit over the peak `v1` of the two bars; `None` where they do not move.
    pub ratio_to_two_bars: Option<f64>,
    /// Why its verdict counts; empty where that of the two bars stands alone.
    pub counts: Vec<WhyItCounts>,
    /// Its verdict by the criteria that the two bars are judged with; `None` without the capacities of the two bars.
    // It follows from the rest.
    #[serde(skip)]
    pub assessment: Option<Assessment>,
    /// Whether its verdict is the one that holds, because it counts and is more severe.
    #[serde(skip)]
    pub decides: bool,
}

/// Why the verdict of the beam counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WhyItCounts {
    /// `beam.mode` is `governing`.
    Governing,
    /// The vehicle travels out of the plane of the two bars.
    OutOfPlane,
    /// The column collapses or fractures by one of both models only.
    Collapse,
    /// The column yields by one of both models only.
    Yielding,
    /// The peak displacements differ by more than [`BAND`].
    Peak,
    /// A web shears plastically, by one of both models or by both.
    Shear,
    /// The beam keeps a larger residual bow than the two bars by more than [`BAND`], somewhere between the supports.
    Bow,
    /// The beam leaves less of the axial capacity than 95 % of what the two bars leave.
    Capacity,
}

impl SecondOpinion {
    /// The beam's opinion on the impact of these parameters beside this report of the two bars and the capacity that they find; its
    /// verdict is still to be weighed.
    ///
    /// # Errors
    /// Why there is no second opinion.
    pub fn beside(
        parameters: &Parameters,
        report: &Report,
        remaining: Option<ResidualCapacity>,
    ) -> Result<Self, NoSecondOpinion> {
        let task = BeamTask::of_parameters(parameters)?;
        let answer = task.compute()?;
        let mut opinion = Self::new(&answer, task.direction(), parameters, report);
        if let Some(input) = remaining.and_then(|it| input_of(parameters, report, it)) {
            opinion.judge(&input);
        }
        Ok(opinion)
    }

    /// Finds its verdict, by all on which the verdict of the two bars depends.
    fn judge(&mut self, bars: &AssessmentInput) {
        let beam = self.seen_by_the_beam(bars);
        let [of_beam, of_bars] = [&beam, bars].map(|it| it.remaining.ratio);
        // Where a column gives way, there is nothing to compare.
        let bows = beam.largest_bow().zip(bars.largest_bow());
        let gives_way = [&beam, bars].map(|it| it.collapsed || it.fractured);
        let both_stand = gives_way == [false; 2];
        let has_larger_bow = bows.is_some_and(|(of_beam, of_bars)| {
            of_beam > BAND * of_bars && of_beam > BOW_OF_NEW * bars.height()
        });
        let leaves_less = of_beam < LEAST_CAPACITY * of_bars;
        let remains = [WhyItCounts::Bow, WhyItCounts::Capacity];
        self.counts.retain(|why| !remains.contains(why));
        let found = remains.into_iter().zip([has_larger_bow, leaves_less]);
        let found = found.filter(|(_, holds)| *holds && both_stand);
        self.counts.extend(found.map(|(why, _)| why));
        self.assessment = Some(assess(&beam));
    }

    /// What this answer of the beam to a hit in this direction \[rad\] says beside the report of the two bars; its verdict is still
    /// to be found.
    #[must_use]
    pub fn new(
        answer: &BeamAnswer,
        direction: f64,
        parameters: &Parameters,
        report: &Report,
    ) -> Self {
        let mut opinion = Self {
            beam: answer.beam,
            direction,
            capacity: answer.capacity,
            ratio_to_two_bars: None,
            counts: Vec::new(),
            assessment: None,
            decides: false,
        };
        let [[peak, _], _] = opinion.from_undamaged();
        let ratio = peak / report.max_v1;
        let is_seen = is_seen_by_the_bars(direction) && ratio.is_finite();
        opinion.ratio_to_two_bars = is_seen.then_some(ratio);
        opinion.counts = opinion.why(parameters.settings().beam.mode, report);
        opinion
    }

    /// The same opinion with its verdict, by all on which the verdict of the two bars depends; where it counts and is more severe,
    /// that of the two bars becomes it, and `range` contains it.
    #[must_use]
    pub fn weighed(
        &self,
        input: &AssessmentInput,
        bars: &mut Assessment,
        range: Option<&mut ActionRange>,
    ) -> Self {
        let mut opinion = Self {
            decides: false,
            ..self.clone()
        };
        opinion.judge(input);
        opinion.weigh(bars, range);
        opinion
    }

    /// Makes the verdict of the two bars, and its range, the more severe one of both, where that of the beam counts.
    pub fn weigh(&mut self, bars: &mut Assessment, range: Option<&mut ActionRange>) {
        let Some(verdict) = self.assessment.as_ref().filter(|_| !self.counts.is_empty()) else {
            return;
        };
        self.decides = bars.yield_to(verdict, &self.counts_because());
        if !self.decides {
            bars.seen_in_space();
        }
        if let Some(range) = range.filter(|_| self.decides) {
            range.with_another_model(verdict);
        }
    }

    fn why(&self, mode: BeamMode, report: &Report) -> Vec<WhyItCounts> {
        let gives_way = [
            !report.outcome.stands(),
            self.beam.outcome == BeamEnd::Collapse,
        ];
        let yields = [report.outcome != Outcome::Elastic, self.has_yielded()];
        let has_another_peak = self
            .ratio_to_two_bars
            .is_some_and(|ratio| !(1.0 / BAND..=BAND).contains(&ratio));
        let of_bars = report.webs.iter().map(|web| web.plastic_angle.abs());
        let shears = of_bars
            .chain(self.beam.residual_shear_angle_rad)
            .any(|angle| angle > SHEAR_GOVERNS);
        [
            (WhyItCounts::Governing, mode == BeamMode::Governing),
            (WhyItCounts::OutOfPlane, self.is_out_of_plane()),
            (WhyItCounts::Collapse, gives_way[0] != gives_way[1]),
            (WhyItCounts::Yielding, yields[0] != yields[1]),
            (WhyItCounts::Peak, has_another_peak),
            (WhyItCounts::Shear, shears),
        ]
        .into_iter()
        .filter_map(|(why, holds)| holds.then_some(why))
        .collect()
    }

    /// All on which its verdict depends, from that of the two bars.
    #[must_use]
    pub fn seen_by_the_beam(&self, bars: &AssessmentInput) -> AssessmentInput {
        let beam = &self.beam;
        let stands = beam.outcome != BeamEnd::Collapse;
        let [peak, residual] = self.from_undamaged().map(|[x, y]| libm::hypot(x, y));
        bars.by_another_model(&OtherModel {
            collapsed: !stands,
            yielded: self.has_yielded(),
            kink: beam.residual_kink_rad,
            shear_angle: beam.residual_shear_angle_rad,
            residual: stands.then_some(residual),
            bow: stands.then_some(beam.residual_bow_m),
            peak,
            capacity: self.capacity,
            base_shear: beam.base_shear_n,
        })
    }

    /// Peak and residual displacement of the impact point, each along the hit and, as a magnitude, at right angles to it \[m\], from
    /// where the impact point is in the undamaged column, as in the two bars. What remains is NaN after a collapse.
    #[must_use]
    pub fn from_undamaged(&self) -> [[f64; 2]; 2] {
        let beam = &self.beam;
        let [along, across] = beam.displaced_before_m;
        [
            [beam.max_displacement_m, beam.max_sideways_m],
            [beam.residual_displacement_m, beam.residual_sideways_m],
        ]
        .map(|[there, sideways]| [along + there, across.abs() + sideways])
    }

    /// Two displacements of the impact point \[m\] in words, of which the one across the hit is named where the vehicle travels out of the
    /// plane of the two bars.
    #[must_use]
    pub fn along_and_across(&self, [along, across]: [f64; 2]) -> String {
        match self.is_out_of_plane() {
            true => format!(
                "{} along the hit and {} across it",
                millimetres(along),
                millimetres(across)
            ),
            false => millimetres(along),
        }
    }

    /// How far earlier impacts had left the impact point on the side from which the vehicle came \[m\]; `None` where they had not.
    fn bent_back(&self) -> Option<f64> {
        let bow = -self.beam.displaced_before_m[0];
        (bow > LEAST_BOW).then_some(bow)
    }

    /// Whether the vehicle travels out of the plane of the two bars.
    fn is_out_of_plane(&self) -> bool {
        is_out_of_plane(self.direction)
    }

    /// Why the verdict counts, as a part of a sentence; empty where it does not.
    #[must_use]
    pub fn counts_because(&self) -> String {
        let words: Vec<_> = self.counts.iter().map(|why| self.in_words(*why)).collect();
        match words.as_slice() {
            [] => String::new(),
            [one] => one.clone(),
            [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
        }
    }

    fn in_words(&self, why: WhyItCounts) -> String {
        match why {
            WhyItCounts::Governing => "beam.mode is governing".to_owned(),
            WhyItCounts::OutOfPlane => format!(
                "the vehicle travels at {} degrees to the plane of the two bars",
                readable((self.direction.to_degrees() * 1e4).round() / 1e4)
            ),
            WhyItCounts::Collapse => "the column gives way by one of both models only".to_owned(),
            WhyItCounts::Yielding => "the steel yields by one of both models only".to_owned(),
            WhyItCounts::Peak => {
                format!(
                    "the peaks differ by more than a factor of {}",
                    readable(BAND)
                )
            }
            WhyItCounts::Shear => "the web yields in shear".to_owned(),
            WhyItCounts::Bow => format!(
                "the beam keeps a bow of {} at a height of {:.2} m, which is more than {} times that of the two bars",
                millimetres(self.beam.residual_bow_m),
                self.beam.residual_bow_height_m,
                readable(BAND)
            ),
            WhyItCounts::Capacity => format!(
                "the beam leaves less than {:.0} % of the share of the axial capacity that the two bars leave",
                100.0 * LEAST_CAPACITY
            ),
        }
    }

    /// Whether the steel has yielded, now or in an earlier impact, beyond what residual stresses alone make it yield.
    #[must_use]
    pub fn has_yielded(&self) -> bool {
        self.beam.outcome != BeamEnd::Elastic && self.beam.yielded_beyond_residual_stress
    }

    /// How the response of the beam ends, in the words of the two bars.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        match self.beam.outcome {
            BeamEnd::Elastic => Outcome::Elastic,
            BeamEnd::Plastic => Outcome::Plastic,
            BeamEnd::Collapse => Outcome::Collapsed,
        }
    }

    /// Whether both models agree on the peak, on what remains, and on how the response ends.
    #[must_use]
    pub fn agrees(&self) -> bool {
        let parts = [
            WhyItCounts::Collapse,
            WhyItCounts::Yielding,
            WhyItCounts::Peak,
            WhyItCounts::Bow,
            WhyItCounts::Capacity,
        ];
        self.ratio_to_two_bars.is_some() && !parts.iter().any(|it| self.counts.contains(it))
    }

    /// What the beam would have done; `None` without the capacities of the two bars.
    #[must_use]
    pub fn action(&self) -> Option<Action> {
        self.assessment.as_ref().map(|it| it.action)
    }
}

/// Whether a vehicle that travels in this direction \[rad\] leaves the plane of the two bars.
#[must_use]
pub fn is_out_of_plane(direction: f64) -> bool {
    !is_in_plane(direction)
}

/// A length in millimetres with three digits.
fn millimetres(metres: f64) -> String {
    let value = 1e3 * metres;
    let decimals = match value.abs() {
        size if size >= 99.95 => 0,
        size if size >= 9.995 => 1,
        _ => 2,
    };
    format!("{value:.decimals$} mm")
}

/// What the beam says, and how it compares, in two sentences.
impl Display for SecondOpinion {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let beam = &self.beam;
        let [peak, residual] = self.from_undamaged();
        write!(
            f,
            "the fibre beam has a peak of {}",
            self.along_and_across(peak)
        )?;
        match beam.outcome {
            BeamEnd::Collapse => f.write_str(" and COLLAPSES")?,
            BeamEnd::Elastic => f.write_str(" and stays elastic")?,
            BeamEnd::Plastic => write!(
                f,
                ", keeps {} and {:.0} % of its axial capacity",
                self.along_and_across(residual),
                100.0 * (self.capacity[1] / self.capacity[0]).min(1.0),
            )?,
        }
        match self.ratio_to_two_bars {
            Some(ratio) => write!(f, "; its peak is {ratio:.2} times that of the two bars")?,
            None => f.write_str("; the two bars do not see this hit")?,
        }
        if let Some(bow) = self.bent_back() {
            write!(
                f,
                ". Earlier impacts had left the impact point {} on the side from which the vehicle came: the beam bends the column \
                 back, while the two bars add each impact to the bow",
                millimetres(bow)
            )?;
        }
        let action = self.action().map_or("no", Action::name);
        if self.counts.is_empty() {
            return f.write_str(match self.bent_back() {
                Some(_) => ". The verdict is that of the two bars.",
                None => ". Both agree, and the verdict is that of the two bars.",
            });
        }
        write!(
            f,
            ". Its verdict ({action}) counts, because {}",
            self.counts_because()
        )?;
        f.write_str(match self.decides {
            true => "; it decides.",
            false => "; that of the two bars is as severe or more.",
        })
    }
}
