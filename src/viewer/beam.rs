//! The fibre beam in front of the two bars in a Rerun stream: its axis at its peak and at rest, and the fibres that have yielded.

use std::sync::Arc;

use column_beam::Movement;
use rerun::{LineStrip3D, LineStrips3D, Points3D, Radius, RecordingStreamResult};

use super::branch::Branch;
use super::camera::Outlook;
use super::colour;
use super::labels::{self, Label};
use super::point::Point3;
use super::rerun_types::{color, time_columns};
use super::scene::Drawing;
use super::timeline::Moment;
use crate::shape::{Heading, PlanePoint};

/// The entities of the beam.
pub(super) const ENTITIES: &str = "second_opinion";

/// Its axis at the peak.
const PEAK: &str = "second_opinion/peak";
/// Its axis at rest.
const REST: &str = "second_opinion/rest";
/// The fibres that have yielded.
const YIELDED: &str = "second_opinion/yielded";

/// Plastic strain from which on a fibre has the colour of full yielding \[A\]: about twelve times the strain at which S355 yields.
pub(super) const FULL_STRAIN: f64 = 0.02;

/// The axis of the beam at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisMark {
    /// From the base to the top.
    pub points: Vec<Point3>,
    /// What it is, and how far the column is bent.
    pub label: Label,
}

/// The beam in front of the two bars, with the magnification of these.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamMark {
    /// When its impact point is furthest along the hit.
    pub peak: AxisMark,
    /// At rest; `None` after a collapse.
    pub rest: Option<AxisMark>,
    /// The fibres that have yielded, with their plastic strains.
    pub yielded: Vec<(Point3, f64)>,
}

impl Drawing {
    /// The fibre beam that has moved so. All of it is shifted towards the viewer, so that the bars hide nothing of it.
    #[must_use]
    pub fn beam(&self, movement: &Movement) -> BeamMark {
        let heading = Heading::new(movement.direction);
        let outlook = Outlook::of(heading);
        let drawn = |place: [f64; 3], moved: [f64; 3]| {
            heading.in_space([0, 1, 2].map(|k| place[k] + self.magnification * moved[k]))
        };
        let axis = |nodes: &[[f64; 3]]| -> Vec<[f64; 3]> {
            let nodes = movement.heights.iter().zip(nodes);
            nodes
                .map(|(height, moved)| drawn([0.0, 0.0, *height], *moved))
                .collect()
        };
        let peak = axis(&movement.peak);
        let rest = movement.remains.as_deref().map(axis);
        let fibres = movement.yielded.iter();
        let fibres: Vec<_> = fibres
            .map(|fibre| (drawn(fibre.place, fibre.moved), fibre.plastic_strain))
            .collect();
        let places = peak.iter().chain(rest.iter().flatten());
        let places = places.chain(fibres.iter().map(|(place, _)| place));
        let farthest = places
            .map(|place| outlook.away(place[1]))
            .fold(f64::NEG_INFINITY, f64::max);
        let shift = outlook.away(self.front() - farthest);
        let shifted = |[x, y, z]: [f64; 3]| [x, y + shift, z].map(|it| it as f32);
        let points = |axis: Vec<[f64; 3]>| axis.into_iter().map(shifted).collect();
        let most = fibres.iter().map(|(_, strain)| *strain).fold(0.0, f64::max);
        let yields = match fibres.is_empty() {
            true => String::new(),
            false => format!("\nplastic strain up to {:.1} %", 100.0 * most),
        };
        let largest = bent(&movement.peak);
        let texts = match movement.remains.as_deref() {
            Some(remains) => [
                format!("fibre beam at its peak: {largest}"),
                format!("fibre beam at rest: {}{yields}", bent(remains)),
            ],
            None => [
                format!("fibre beam gives way: {largest}{yields}"),
                String::new(),
            ],
        };
        let [peak_label, rest_label] = self.beam_labels(texts, outlook);
        BeamMark {
            peak: AxisMark {
                points: points(peak),
                label: peak_label,
            },
            rest: rest.map(|it| AxisMark {
                points: points(it),
                label: rest_label,
            }),
            yielded: fibres
                .iter()
                .map(|(place, strain)| (shifted(*place), *strain))
                .collect(),
        }
    }

    /// Labels one below the other, beside the middle of the upper bar, in the column of the labels of the hinges.
    fn beam_labels(&self, texts: [String; 2], outlook: Outlook) -> [Label; 2] {
        let point = self.camera().metres_per_point();
        let mut upper_end = self.lengths.below + 0.5 * self.lengths.above;
        texts.map(|text| {
            let [width, height] = labels::size(&text).map(|it| point * it);
            let place = PlanePoint::new(self.beside_hinges() + 0.5 * width, upper_end);
            upper_end -= height;
            Label {
                place: outlook.in_space(place, self.front()),
                text,
            }
        })
    }
}

/// The largest distance of the axis from that of the undamaged column, in words.
fn bent(nodes: &[[f64; 3]]) -> String {
    let distances = nodes.iter().map(|[along, across, _]| along.hypot(*across));
    format!("{:.0} mm", 1e3 * distances.fold(0.0, f64::max))
}

/// The colour of a fibre with this plastic strain.
fn of_strain(strain: f64) -> colour::Rgb {
    colour::of_utilisation(0.5 + 0.5 * strain / FULL_STRAIN)
}

/// Sends colours and sizes, which all beams of one column share.
///
/// # Errors
/// The stream rejects the data.
pub(super) fn send_statics(stream: &Branch, drawing: &Drawing) -> RecordingStreamResult<()> {
    let radius = |part: f64| Radius::new_scene_units((part * drawing.lengths.total()) as f32);
    for (entity, rgb, part) in [
        (PEAK, colour::BEAM_PEAK, 0.0025),
        (REST, colour::BEAM_REST, 0.004),
    ] {
        let line = LineStrips3D::update_fields()
            .with_colors([color(rgb)])
            .with_radii([radius(part)]);
        stream.log_static(entity, &line)?;
        let label = Points3D::update_fields()
            .with_colors([color(rgb)])
            .with_radii([radius(0.0)])
            .with_show_labels(true);
        stream.log_static(entity, &label)?;
    }
    let fibres = Points3D::update_fields().with_radii([radius(0.0035)]);
    stream.log_static(YIELDED, &fibres)
}

/// The beam of an impact, of which a stream shows what belongs to the impact so far: from its peak on the axis there, and from the
/// result on what remains. It comes while the states do, after the result, or before the states.
#[derive(Default)]
pub(super) struct ShownBeam {
    known: Option<Known>,
    /// The last moment of which something was sent of this impact.
    last: Option<Moment>,
}

struct Known {
    event_id: Arc<str>,
    /// When it is at its peak, since the beginning of the impact \[s\].
    peak_time: f64,
    mark: BeamMark,
    /// Its peak has been sent.
    is_sent: bool,
}

impl ShownBeam {
    /// Takes the beam of an impact in the place of the one before.
    pub fn take(&mut self, event_id: Arc<str>, movement: &Movement, drawing: &Drawing) {
        self.known = Some(Known {
            event_id,
            peak_time: movement.largest()[0],
            mark: drawing.beam(movement),
            is_sent: false,
        });
    }

    /// Shows of the beam what belongs to the present impact, if it is that of this impact. `at` is the moment so many seconds after
    /// the beginning of the impact, `ended` that of its result.
    ///
    /// # Errors
    /// The stream rejects the data.
    pub fn show(
        &mut self,
        stream: &Branch,
        present: Option<&str>,
        at: impl Fn(f64) -> Moment,
        ended: Option<Moment>,
    ) -> RecordingStreamResult<()> {
        let known = self.known.as_mut();
        let Some(known) = known.filter(|it| present == Some(&*it.event_id)) else {
            return Ok(());
        };
        if !known.is_sent {
            known.is_sent = true;
            // What an earlier estimate of the impact has shown would otherwise come after it.
            let peak = at(known.peak_time);
            let peak = self.last.map_or(peak, |last| later(last, peak));
            send_axis(stream, PEAK, peak, Some(&known.mark.peak))?;
            self.last = Some(peak);
        }
        if let Some(end) = ended {
            send_axis(stream, REST, end, known.mark.rest.as_ref())?;
            send_fibres(stream, end, &known.mark.yielded)?;
            self.last = self.last.map(|last| later(last, end));
        }
        Ok(())
    }

    /// Shows no beam from this moment on, and forgets it, unless it is that of the impact of this identifier, which begins now.
    ///
    /// # Errors
    /// The stream rejects the data.
    pub fn clear(
        &mut self,
        stream: &Branch,
        moment: Moment,
        begins: Option<&str>,
    ) -> RecordingStreamResult<()> {
        let waits = |it: &Known| !it.is_sent && begins == Some(&*it.event_id);
        self.known = self.known.take().filter(waits);
        if self.last.take().is_none() {
            return Ok(());
        }
        send_axis(stream, PEAK, moment, None)?;
        send_axis(stream, REST, moment, None)?;
        send_fibres(stream, moment, &[])
    }
}

fn later(one: Moment, other: Moment) -> Moment {
    match one.impact_time > other.impact_time {
        true => one,
        false => other,
    }
}

fn send_axis(
    stream: &Branch,
    entity: &str,
    moment: Moment,
    mark: Option<&AxisMark>,
) -> RecordingStreamResult<()> {
    let count = || [usize::from(mark.is_some())];
    let strips = mark.map(|it| LineStrip3D::from_iter(it.points.iter().copied()));
    let line = LineStrips3D::update_fields().with_strips(strips);
    let label = Points3D::update_fields()
        .with_positions(mark.map(|it| it.label.place))
        .with_labels(mark.map(|it| it.label.text.as_str()));
    let data = line.columns(count())?.chain(label.columns(count())?);
    stream.send_columns(entity, time_columns([moment]), data)
}

fn send_fibres(
    stream: &Branch,
    moment: Moment,
    fibres: &[(Point3, f64)],
) -> RecordingStreamResult<()> {
    let points = Points3D::update_fields()
        .with_positions(fibres.iter().map(|(place, _)| *place))
        .with_colors(fibres.iter().map(|(_, strain)| color(of_strain(*strain))));
    stream.send_columns(
        YIELDED,
        time_columns([moment]),
        points.columns([fibres.len()])?,
    )
}
