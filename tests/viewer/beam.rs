//! The fibre beam in the viewer: what is written to the stream is where the beam has been.

use std::sync::Arc;

use column_twin::column::{Sample, simulate};
use column_twin::messages::column_twin_msgs::ImpactReport;
use column_twin::parameters::{Parameters, Value};
use column_twin::second_opinion::{BeamAnswer, BeamTask};
use column_twin::viewer::{ViewerItem, ViewerStream, from_samples};
use rerun::external::re_log_types::LogMsg;
use rerun::log::Chunk;
use rerun::sink::MemorySinkStorage;
use rerun::{LineStrips3D, Points3D};

use super::in_memory;

const MAGNIFICATION: f64 = 10.0;

/// A plastic hit on an HEB220 in this direction \[degrees\].
fn parameters(degrees: f64) -> Arc<Parameters> {
    let values = [
        ("vehicle.name", Value::from("rigid")),
        ("impact.mass", Value::from(1500.0)),
        ("impact.velocity", Value::from(5.0)),
        ("impact.direction", Value::from(degrees.to_radians())),
        ("viewer.magnification", Value::from(MAGNIFICATION)),
    ];
    let parameters = Parameters::default().with_changes(values);
    Arc::new(parameters.expect("admissible"))
}

/// The items of the impact by the two bars: forecast, states and result.
fn items(event_id: &str, parameters: &Parameters) -> Vec<ViewerItem> {
    let (column, impact) = (parameters.column_properties(), parameters.impact());
    let mut samples: Vec<Sample> = Vec::new();
    let report = simulate(&column, &impact, 2.0, &mut |sample| samples.push(*sample));
    let report = ImpactReport::from(&report.expect("simulated"));
    from_samples(event_id, 0, samples.into_iter().step_by(50), &report)
}

/// A stream of one column and what it has written.
pub struct Shown {
    stream: ViewerStream,
    storage: MemorySinkStorage,
}

impl Shown {
    pub fn new(parameters: &Arc<Parameters>) -> Self {
        let (stream, storage, options) = in_memory::stream();
        let stream = ViewerStream::new(stream, Arc::clone(parameters), options);
        Self {
            stream: stream.expect("a stream"),
            storage,
        }
    }

    /// What the stream has of these items, without what does not change.
    pub fn show(&mut self, items: impl IntoIterator<Item = ViewerItem>) -> Vec<Chunk> {
        self.stream.show(items).expect("written");
        self.stream.stream().flush_blocking().expect("written");
        let messages = self.storage.take();
        let chunks = messages.iter().filter_map(|message| match message {
            LogMsg::ArrowMsg(_, data) => Chunk::from_arrow_msg(data).ok(),
            _ => None,
        });
        chunks.filter(|it| !it.is_static()).collect()
    }
}

/// The lines of an entity, one row after the other.
fn strips(chunks: &[Chunk], entity: &str) -> Vec<Vec<Vec<[f32; 3]>>> {
    let component = LineStrips3D::descriptor_strips().component;
    let of_entity = chunks
        .iter()
        .filter(|it| it.entity_path().to_string() == entity);
    of_entity
        .flat_map(|chunk| {
            let rows = chunk.iter_slices::<&[[f32; 3]]>(component);
            rows.map(|row| row.into_iter().map(<[_]>::to_vec).collect())
                .collect::<Vec<_>>()
        })
        .collect()
}

/// The number of points of an entity in its last row.
fn points(chunks: &[Chunk], entity: &str) -> Option<usize> {
    let component = Points3D::descriptor_positions().component;
    let of_entity = chunks
        .iter()
        .filter(|it| it.entity_path().to_string() == entity);
    let counts = of_entity.flat_map(|chunk| {
        let rows = chunk.iter_slices::<[f32; 3]>(component);
        rows.map(<[_]>::len).collect::<Vec<_>>()
    });
    counts.last()
}

/// How far the node at the impact point is from the base, along the hit and at right angles to it, without the magnification \[m\].
fn at_impact_point(strip: &[[f32; 3]], answer: &BeamAnswer, parameters: &Parameters) -> [f64; 2] {
    let movement = answer.movement.as_ref().expect("just computed");
    assert_eq!(strip.len(), movement.heights.len());
    let below = parameters.column_properties().length_below;
    let node = movement
        .heights
        .iter()
        .position(|it| (it - below).abs() < 1e-9)
        .expect("a node at the impact point");
    let [x, y] = [0, 1].map(|k| f64::from(strip[node][k] - strip[0][k]) / MAGNIFICATION);
    let (sin, cos) = parameters.direction().sin_cos();
    [cos * x + sin * y, cos * y - sin * x]
}

#[test]
fn the_beam_is_shown_where_it_has_been_at_its_peak_and_at_rest() {
    for degrees in [0.0, 30.0] {
        let parameters = parameters(degrees);
        let task = BeamTask::of_parameters(&parameters).expect("a task");
        let answer = task.compute().expect("an answer");
        let beam = || ViewerItem::Beam {
            event_id: "car".into(),
            movement: Arc::clone(answer.movement.as_ref().expect("just computed")),
        };
        let mut items_of_car = items("car", &parameters);
        let result = items_of_car.pop().expect("a result");
        let mut shown = Shown::new(&parameters);

        // It comes while the column responds: the peak is shown at once, what remains with the result.
        let during = shown.show(items_of_car.into_iter().chain([beam()]));
        let peaks = strips(&during, "/second_opinion/peak");
        assert_eq!(peaks.len(), 1);
        let peak = &peaks[0][0];
        let [along, across] = at_impact_point(peak, &answer, &parameters);
        let found = &answer.beam;
        assert!((along - found.max_displacement_m).abs() < 1e-6, "{along}");
        assert!(strips(&during, "/second_opinion/rest").is_empty());
        let after = shown.show([result]);
        let rests = strips(&after, "/second_opinion/rest");
        assert_eq!(rests.len(), 1);
        let rest = &rests[0][0];
        let [remains, sideways] = at_impact_point(rest, &answer, &parameters);
        println!("{degrees} degrees: {along} and {across} m, at rest {remains} and {sideways} m");
        assert!((remains - found.residual_displacement_m).abs() < 1e-6);
        assert!((sideways.abs() - found.residual_sideways_m).abs() < 1e-6);
        let is_oblique = degrees > 0.0;
        assert_eq!(across.abs() > 1e-3, is_oblique, "{across}");
        assert!(across.abs() <= found.max_sideways_m + 1e-6);
        let yielded = points(&after, "/second_opinion/yielded").expect("fibres");
        assert!(yielded > 10, "{yielded}");
        // Nothing of the beam is behind the bars, whose flanges are 220 mm wide: the viewer looks from where the vehicle does not come
        // from.
        let face = 0.11;
        let side = if is_oblique { 1.0 } else { -1.0 };
        let mut lines = peak.iter().chain(rest);
        assert!(lines.all(|it| side * f64::from(it[1]) > face));

        // The next impact begins without the beam of the last one.
        let next = shown.show(items("other", &parameters));
        let without_lines: Vec<Vec<Vec<[f32; 3]>>> = vec![Vec::new()];
        for entity in ["/second_opinion/peak", "/second_opinion/rest"] {
            assert_eq!(strips(&next, entity), without_lines);
        }
        assert_eq!(points(&next, "/second_opinion/yielded"), Some(0));
        // The beam of an impact that is over is not shown in the next one.
        assert!(strips(&shown.show([beam()]), "/second_opinion/peak").is_empty());
    }
}

/// In a file it may come before the states and after the result.
#[test]
fn a_beam_is_shown_whenever_it_comes() {
    let parameters = parameters(0.0);
    let task = BeamTask::of_parameters(&parameters).expect("a task");
    let movement = Arc::new(task.movement().expect("a movement"));
    let of_car = items("car", &parameters);
    for place in [0, of_car.len()] {
        let mut items = of_car.clone();
        items.insert(
            place,
            ViewerItem::Beam {
                event_id: "car".into(),
                movement: Arc::clone(&movement),
            },
        );
        let chunks = Shown::new(&parameters).show(items);
        assert_eq!(strips(&chunks, "/second_opinion/peak").len(), 1, "{place}");
        assert_eq!(strips(&chunks, "/second_opinion/rest").len(), 1, "{place}");
        assert!(
            points(&chunks, "/second_opinion/yielded") > Some(10),
            "{place}"
        );
    }
}
