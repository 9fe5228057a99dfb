//! Tests of the figures with the reference responses and with degenerate histories.

use std::sync::LazyLock;

use resvg::tiny_skia::Path as PathData;
use resvg::usvg::{Group, Node, Tree};

use super::reference::{Reference, spectrum_of};
use super::*;
use crate::column::{End, HINGES, HingeReport, Outcome, Report, Sample, YieldExponents};

fn svg<'f>(figures: &'f [(String, String)], name: &str) -> &'f str {
    &figures.iter().find(|(figure, _)| figure == name).unwrap().1
}

/// Parses the fonts once for all tests.
static RASTER: LazyLock<raster::Raster> = LazyLock::new(raster::Raster::new);

fn tree(svg: &str) -> Tree {
    RASTER.tree(svg).unwrap()
}

/// Calls `found` with every node below a group.
fn visit<'t>(group: &'t Group, found: &mut dyn FnMut(&'t Node)) {
    for node in group.children() {
        found(node);
        if let Node::Group(inner) = node {
            visit(inner, found);
        }
    }
}

/// The points of all strokes of one colour, in coordinates of the canvas.
fn stroke_points(tree: &Tree, colour: plotters::style::RGBColor) -> Vec<(f32, f32)> {
    let mut points = Vec::new();
    visit(tree.root(), &mut |node| {
        let Node::Path(path) = node else { return };
        let stroked = path.stroke().is_some_and(|stroke| match stroke.paint() {
            resvg::usvg::Paint::Color(paint) => {
                (paint.red, paint.green, paint.blue) == (colour.0, colour.1, colour.2)
            }
            _ => false,
        });
        if stroked {
            points.extend(path_points(path.data()));
        }
    });
    points
}

fn path_points(data: &PathData) -> impl Iterator<Item = (f32, f32)> + '_ {
    data.points().iter().map(|point| (point.x, point.y))
}

/// Texts with their bounding boxes on the displayed page.
fn texts(tree: &Tree) -> Vec<(String, resvg::tiny_skia::Rect)> {
    let mut texts = Vec::new();
    visit(tree.root(), &mut |node| {
        if let Node::Text(text) = node {
            let content: String = text.chunks().iter().map(|chunk| chunk.text()).collect();
            texts.push((content.trim().to_owned(), text.abs_bounding_box()));
        }
    });
    texts
}

/// More than `least` texts are on the page, and none overlaps another.
fn assert_texts_are_apart(name: &str, svg: &str, least: usize) {
    let tree = tree(svg);
    let (width, height) = (tree.size().width(), tree.size().height());
    let texts = texts(&tree);
    assert!(texts.len() > least, "{name} has only {} texts", texts.len());
    for (number, (text, place)) in texts.iter().enumerate() {
        let inside = place.left() >= 0.0
            && place.top() >= 0.0
            && place.right() <= width
            && place.bottom() <= height;
        assert!(inside, "{name}: {text:?} leaves the page: {place:?}");
        for (other, other_place) in &texts[number + 1..] {
            let apart = place.right() <= other_place.left()
                || other_place.right() <= place.left()
                || place.bottom() <= other_place.top()
                || other_place.bottom() <= place.top();
            assert!(apart, "{name}: {text:?} overlaps {other:?}");
        }
    }
}

#[test]
fn every_text_is_on_the_page_and_none_overlaps_another() {
    for reference in [Reference::ellipse(), Reference::duan_chen()] {
        for (name, svg) in draw_svg(&reference.response()).unwrap() {
            assert_texts_are_apart(&name, &svg, 10);
        }
    }
}

#[test]
fn the_curve_of_v1_peaks_where_the_reference_does() {
    let reference = Reference::ellipse();
    let figures = draw_svg(&reference.response()).unwrap();
    let tree = tree(svg(&figures, "fig5_horizontal_displacement"));
    let points = stroke_points(&tree, page::colour::IMPACT_POINT);
    // The line of the legend is to the left of the axis or above the plot; the curve starts at time zero.
    let left = page::LEFT as f32;
    let right = (page::CANVAS.0 as i32 - page::RIGHT) as f32;
    let bottom = (page::CANVAS.1 as i32 - page::BOTTOM) as f32;
    let curve: Vec<_> = points.into_iter().filter(|point| point.1 > 700.0).collect();
    assert!(curve.len() > 400);
    // Coordinates are integers: the peak is the middle of the highest points.
    let height = curve.iter().map(|point| point.1).fold(f32::MAX, f32::min);
    let highest: Vec<_> = curve.iter().filter(|point| point.1 <= height).collect();
    let middle = (highest[0].0 + highest[highest.len() - 1].0) / 2.0;
    let time = (middle - left) / (right - left) * 50.0;
    assert!((time - 19.79).abs() < 0.2, "peak at {time} ms");
    let zero = curve
        .iter()
        .copied()
        .reduce(|a, b| if b.0 < a.0 { b } else { a })
        .unwrap();
    assert!(
        (zero.1 - bottom).abs() < 3.0,
        "v1 starts at zero: {zero:?}, {bottom}"
    );
}

#[test]
fn the_stack_of_the_ledger_meets_the_supply() {
    let reference = Reference::ellipse();
    for sample in &reference.samples {
        let stack = sample.impact_loss
            + sample.plastic_work
            + sample.damping_work
            + sample.elastic_energy
            + sample.kinetic_energy;
        let first = &reference.samples[0];
        let supply = reference.report.input_energy + first.elastic_energy + sample.load_work
            - first.load_work;
        assert!((stack - supply).abs() < 1e-3 * supply);
    }
}

#[test]
fn every_file_is_written_completely() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("new/plots");
    let reference = Reference::ellipse();
    let files = draw_all(&folder, &reference.response()).unwrap();
    assert_eq!(files.len(), 24);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 24);
    for file in &files {
        let content = fs::read(file).unwrap();
        if file.extension().is_some_and(|ending| ending == "png") {
            let picture = resvg::tiny_skia::Pixmap::decode_png(&content).unwrap();
            assert_eq!((picture.width(), picture.height()), (1600, 1000));
            let colours: std::collections::HashSet<_> = picture
                .pixels()
                .iter()
                .map(|pixel| (pixel.red(), pixel.green(), pixel.blue()))
                .collect();
            assert!(colours.len() > 20, "{} is empty", file.display());
        }
    }
    // To look at the figures of the tests.
    if let Some(kept) = std::env::var_os("COLUMN_TWIN_KEEP_FIGURES") {
        draw_all(Path::new(&kept), &reference.response()).unwrap();
    }
    // Drawing again gives the same bytes.
    let path = folder.join("mn_path_1a.png");
    let again = draw_svg(&reference.response()).unwrap();
    let again = RASTER.png(svg(&again, "mn_path_1a")).unwrap();
    assert_eq!(fs::read(path).unwrap(), again);
}

#[test]
fn a_folder_that_cannot_be_created_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let reference = Reference::ellipse();
    let fault = draw_all(&file.join("plots"), &reference.response()).unwrap_err();
    assert!(fault.to_string().contains("plots"), "{fault}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// Checks that every figure of a history can be drawn and that its texts stay on the page.
fn draws(samples: &[Sample], report: &Report) {
    let spectrum = spectrum_of(samples);
    let response = ResponseHistory {
        title: "a degenerate history, with a title that is much longer than the page is wide, \
                so that it has to be shortened: 1500 kg at 10 m/s, 1 m above the base, < & > \" '",
        samples,
        report,
        spectrum: Some(&spectrum),
        yield_surface: YieldExponents {
            alpha: 50.0,
            beta: 1.0,
            gamma: 1.0,
        },
        resistance_moment: 1.0,
        resistance_axial: 1e9,
        beam: None,
        ..Reference::ellipse().response()
    };
    for (name, svg) in draw_svg(&response).unwrap() {
        // Layout finds every possible fault; rendering takes longer.
        if name == "contact_force" {
            RASTER.png(&svg).unwrap();
        }
        for (text, place) in texts(&tree(&svg)) {
            let inside = place.left() >= -1.0 && place.right() <= 961.0;
            assert!(inside, "{name}: {text:?} leaves the page: {place:?}");
        }
    }
}

fn nothing_happened() -> Report {
    Report {
        outcome: Outcome::Elastic,
        end: End::DurationReached,
        end_time: 0.0,
        max_v1: 0.0,
        max_v1_time: 0.0,
        residual_v1: None,
        max_u2: 0.0,
        residual_u2: None,
        first_contact_time: None,
        release_time: None,
        contact_duration: 0.0,
        impactor_velocity: 0.0,
        peak_contact_force: 0.0,
        peak_contact_force_time: None,
        impact_impulses: 0,
        total_impact_impulse: 0.0,
        impulse: 0.0,
        input_energy: 0.0,
        column_kinetic_energy: 0.0,
        impactor_kinetic_energy: 0.0,
        elastic_energy_change: 0.0,
        plastic_work: 0.0,
        impact_loss: 0.0,
        damping_work: 0.0,
        load_work: 0.0,
        ledger_residual: 0.0,
        max_dynamic_factor: [1.0; HINGES],
        steps: 0,
        hinges: [HingeReport::default(); HINGES],
        vehicle: Default::default(),
        webs: Default::default(),
        base: Default::default(),
    }
}

#[test]
fn degenerate_histories_can_be_drawn() {
    let report = nothing_happened();
    let at = |time, v1| Sample {
        time,
        v1,
        ..Sample::default()
    };
    draws(&[at(0.0, 0.0)], &report);
    draws(&[at(0.0, 0.0), at(0.0, 0.0)], &report);
    draws(&[at(0.0, 1e-15), at(1e-9, 1e-15)], &report);
    draws(&[at(0.0, 1e12), at(1e6, -1e12)], &report);
    draws(
        &[
            at(0.0, f64::NAN),
            at(f64::INFINITY, f64::INFINITY),
            at(1.0, 1.0),
        ],
        &report,
    );
    assert!(matches!(
        draw_svg(&ResponseHistory {
            samples: &[],
            ..Reference::ellipse().response()
        }),
        Err(FigureError::NoSamples)
    ));
}

#[test]
fn a_collapse_with_many_impact_impulses_can_be_drawn() {
    let mut impulse = 0.0;
    let samples: Vec<_> = (0..30_000)
        .map(|number| {
            let time = f64::from(number) * 1e-5;
            let mut sample = Sample {
                time,
                v1: time.powi(4),
                ..Sample::default()
            };
            sample.impact_impulse = if number % 7 == 0 {
                1000.0 * (-time * 30.0).exp()
            } else {
                0.0
            };
            impulse += sample.impact_impulse;
            sample.impulse = impulse;
            sample.hinges[3].moment = (time * 900.0).sin() * 2.0;
            sample
        })
        .collect();
    let report = Report {
        outcome: Outcome::Collapsed,
        end: End::Collapsed,
        end_time: 0.3,
        first_contact_time: Some(0.0),
        release_time: Some(1e-5),
        impact_impulses: 4286,
        total_impact_impulse: impulse,
        impulse,
        ..nothing_happened()
    };
    draws(&samples, &report);
}

/// The spectrum of states that were published 50 times per second was drawn, and was wrong at every period; that of a miss was an
/// empty figure.
#[test]
fn a_spectrum_is_drawn_only_of_a_contact_whose_every_step_is_known() {
    let reference = Reference::ellipse();
    let response = reference.response();
    let is_drawn = |response: &ResponseHistory<'_>| {
        let figures = draw_svg(response).unwrap();
        figures
            .iter()
            .any(|(name, _)| name == "contact_force_spectrum")
    };
    assert!(is_drawn(&response));
    assert!(!is_drawn(&ResponseHistory {
        spectrum: None,
        ..response
    }));
    assert!(!is_drawn(&ResponseHistory {
        report: &nothing_happened(),
        ..response
    }));
}

/// Figures of a risk study with a known limit state: all texts are on the page, none overlaps another, and the bar of a
/// probability is where its number says.
#[test]
fn the_figures_of_a_risk_study() {
    use crate::assessment::Action;
    use crate::study::Batch;
    use crate::study::risk::{
        Departure, DepartureSampler, Exposure, LimitState, MeasureRisk, RiskResult, RiskStudy,
        Scenario, StudyRunError,
    };

    struct Speed;
    impl LimitState for Speed {
        fn action(&self, departure: &Departure) -> Option<Action> {
            Some(match departure.velocity * departure.force_factor {
                v if v > 12.0 => Action::Shore,
                v if v > 10.0 => Action::Restrict,
                v if v > 6.0 => Action::Inspect,
                _ => Action::None,
            })
        }
    }
    let scenario = Scenario::shipped("motorway").unwrap();
    let sampler = DepartureSampler::new(&scenario, 1);
    let study = RiskStudy::new(&sampler, &Speed);
    let done = |_: &_| Ok::<_, StudyRunError>(());
    let (tally, _) = study.run(&Batch::default(), 0..5000, done).unwrap();
    for (vehicles, years) in [(1.0, 1.0), (20_000.0, 50.0)] {
        let exposure = Exposure::new(&scenario, vehicles, years);
        let result = RiskResult::new(&scenario, &tally, exposure, 0.95);
        let title = "HEB 220, 4 m high: column beside a motorway";
        assert_eq!(risk_svg(title, &result, &[]).unwrap().len(), 3);
        let measures: Vec<_> = scenario
            .measures
            .iter()
            .map(|measure| {
                let behind = RiskStudy::new(&sampler, &Speed).behind(measure);
                let (tally, _) = behind.run(&Batch::default(), 0..2000, done).unwrap();
                let with = RiskResult::new(&scenario, &tally, exposure, 0.95);
                MeasureRisk::new(measure, None, &result, &with)
            })
            .collect();
        let figures = risk_svg(title, &result, &measures).unwrap();
        assert_eq!(figures.len(), 4);
        assert!(svg(&figures, "risk_measures").contains("guard rail n2"));
        for (name, svg) in &figures {
            assert_texts_are_apart(name, svg, 15);
        }
        let traffic = format!("{vehicles} vehicles per day");
        assert!(svg(&figures, "risk_probability").contains(&traffic));
        // No sample reached the most severe one, and the figure does not show a probability of 0.
        assert!(svg(&figures, "risk_probability").contains("none seen; below"));
    }
}

mod estimates {
    use super::*;
    use crate::estimation::{
        ComparedMean, CredibleInterval, Detection, ImpactEstimate, Onset, RecordedImpact,
        SensorComparison,
    };
    use crate::sensors::{Quantity, Sensor};

    fn interval(mean: f64, half: f64) -> CredibleInterval {
        CredibleInterval {
            mean,
            low: mean - half,
            high: mean + half,
        }
    }

    /// An estimate 10 s after the beginning of the readings and later, whose displacements are known within `half` \[m\].
    fn estimate(after_contact: f64, half: f64) -> ImpactEstimate {
        let unknown = interval(f64::NAN, f64::NAN);
        ImpactEstimate {
            data_until: 10.0 + after_contact,
            contact_time: unknown,
            mass: unknown,
            velocity: unknown,
            momentum: unknown,
            mass_velocity_correlation: f64::NAN,
            peak_v1: interval(0.05, half),
            residual_v1: interval(0.03, half),
            yielded: 1.0,
            collapsed: 0.0,
            capacity_ratio: unknown,
            action: Vec::new(),
            vehicle_probabilities: Vec::new(),
            effective_sample_size: 100.0,
            doubtful_sensors: Vec::new(),
            scale_not_confirmed: Vec::new(),
            vehicle_by_beam: false,
        }
    }

    fn sensor(quantity: Quantity) -> Sensor {
        Sensor {
            name: format!("{:x<40}", quantity.word()),
            quantity,
            height: 1.0,
            range: 0.0,
            noise: 0.0,
            bias: 0.0,
            gain_error: 0.0,
            rate: 1e4,
            bandwidth: 5e3,
            reversed: false,
            fibre: 0.0,
        }
    }

    fn impact(estimates: Vec<ImpactEstimate>, means: &[ComparedMean]) -> RecordedImpact {
        let compared = |sensor| SensorComparison {
            sensor,
            counts: sensor != 1,
            means: means.to_vec(),
        };
        RecordedImpact {
            further: None,
            detection: Detection {
                contact: Onset {
                    time: 10.0,
                    deviation: 1e-4,
                },
                confirmed_at: 10.01,
                sensor: 0,
                zeros: vec![(0.0, 0.0); Quantity::ALL.len()],
            },
            estimates,
            comparisons: (0..Quantity::ALL.len()).map(compared).collect(),
        }
    }

    fn drawn(impact: &RecordedImpact) -> Vec<(String, String)> {
        let sensors = Quantity::ALL.map(sensor);
        let title = "column garage_a3, readings of a/folder/with/a/long/name/readings_of_the_night_shift.csv, and more of it";
        estimate_svg(&EstimateFigures {
            title,
            sensors: &sensors,
            impact,
        })
        .unwrap()
    }

    #[test]
    fn the_figures_of_an_estimate() {
        let estimates = [0.005, 0.01, 0.05, 0.2, 0.35];
        let estimates = estimates.map(|time| estimate(time, 2e-4 / time)).to_vec();
        let means: Vec<_> = (0..60)
            .map(|index| ComparedMean {
                time: 1e-3 * f64::from(index) - 2e-3,
                measured: (0.1 * f64::from(index)).sin(),
                predicted: interval((0.1 * f64::from(index)).cos(), 0.5),
            })
            .collect();
        let inside = means
            .iter()
            .filter(|it| (it.measured - it.predicted.mean).abs() <= 0.5);
        let words = format!("{} of 60 means are within the band", inside.count());
        let figures = drawn(&impact(estimates, &means));
        assert_eq!(figures.len(), 1 + Quantity::ALL.len());
        for (name, svg) in &figures {
            assert_texts_are_apart(name, svg, 10);
            let is_doubtful = name.starts_with("sensor_displacement");
            assert_eq!(svg.contains("does not count"), is_doubtful, "{name}");
            assert!(
                name == "estimate_forecast" || svg.contains(&words),
                "{name}"
            );
        }
        let forecast = svg(&figures, "estimate_forecast");
        assert!(forecast.contains("peak 50.00 mm (49.43 to 50.57 mm)"));
        // The mean of the peak stays at 50 mm, so its line is level; it ends at the right end of the axis, 0.35 s after contact.
        let points = stroke_points(&tree(forecast), page::colour::IMPACT_POINT);
        let line: Vec<_> = points.into_iter().filter(|point| point.1 > 700.0).collect();
        assert_eq!(line.len(), 5);
        assert!(line.iter().all(|point| point.1 == line[0].1), "{line:?}");
        let right = (page::CANVAS.0 as i32 - page::RIGHT) as f32;
        assert!((line[4].0 - right).abs() < 3.0, "{line:?}");
    }

    #[test]
    fn degenerate_estimates_can_be_drawn() {
        let mean = |time, measured| ComparedMean {
            time,
            measured,
            predicted: interval(f64::NAN, f64::NAN),
        };
        for (estimates, means) in [
            (Vec::new(), Vec::new()),
            (vec![estimate(0.0, 0.0)], vec![mean(0.0, 0.0)]),
            (vec![estimate(0.005, 1e9)], vec![mean(0.0, f64::NAN)]),
            (
                vec![estimate(0.005, f64::NAN), estimate(0.1, f64::INFINITY)],
                vec![mean(-1e-3, 1e300), mean(0.0, f64::NEG_INFINITY)],
            ),
        ] {
            for (name, svg) in drawn(&impact(estimates, &means)) {
                assert!(texts(&tree(&svg)).len() > 5, "{name}");
            }
        }
    }
}

mod both_models {
    use std::path::Path;

    use super::*;
    use crate::parameters::{Parameters, parse_override};
    use crate::report::ReportedImpact;

    fn impact(overrides: &[&str]) -> ReportedImpact {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/heb220_s355.yaml");
        let overrides: Vec<_> = overrides.iter().map(|text| parse_override(text)).collect();
        let parameters = Parameters::load(&[file], &overrides).unwrap();
        ReportedImpact::simulated(&parameters).unwrap()
    }

    /// In the plane of the two bars, out of it, straight at the weak axis, and a collapse.
    fn impacts() -> Vec<ReportedImpact> {
        let lorry = [
            "vehicle.name:=lorry_8t",
            "impact.velocity:=9.0",
            "impact.direction:=0.3",
        ];
        vec![
            impact(&[
                "vehicle.name:=rigid",
                "impact.mass:=1500.0",
                "impact.velocity:=10.0",
            ]),
            impact(&lorry),
            impact(&["impact.velocity:=25.0", "impact.direction:=1.5707963"]),
            impact(&[
                "vehicle.name:=lorry_8t",
                "impact.velocity:=25.0",
                "top.load:=1.5e6",
            ]),
        ]
    }

    #[test]
    fn the_figures_of_both_models_can_be_read() {
        for (number, impact) in impacts().iter().enumerate() {
            let figures = draw_svg(&impact.history()).unwrap();
            for name in ["second_opinion_shape", "second_opinion_displacement"] {
                let svg = svg(&figures, name);
                assert_texts_are_apart(name, svg, 10);
                if let Some(kept) = std::env::var_os("COLUMN_TWIN_KEEP_FIGURES") {
                    let png = RASTER.png(svg).unwrap();
                    fs::write(Path::new(&kept).join(format!("{name}_{number}.png")), png).unwrap();
                }
            }
        }
    }

    /// Extent to the right and upwards of the strokes of a colour below the heading, on the canvas.
    fn extent(tree: &Tree, colour: plotters::style::RGBColor) -> (f64, f64) {
        let points = stroke_points(tree, colour);
        let drawn = points.iter().filter(|point| point.1 > 700.0);
        let drawn: Vec<_> = drawn.map(|it| (f64::from(it.0), f64::from(it.1))).collect();
        let span = |values: Vec<f64>| {
            let high = values.iter().copied().fold(f64::MIN, f64::max);
            high - values.iter().copied().fold(f64::MAX, f64::min)
        };
        let right = drawn.iter().map(|it| it.0).collect();
        (span(right), span(drawn.iter().map(|it| it.1).collect()))
    }

    #[test]
    fn shapes_of_both_models_have_the_scale_that_is_named() {
        let impact = &impacts()[1];
        let figures = draw_svg(&impact.history()).unwrap();
        let tree = tree(svg(&figures, "second_opinion_shape"));
        let texts = texts(&tree);
        let named = texts.iter().find_map(|(text, _)| {
            let text = text.strip_prefix("Displacements are drawn ")?;
            text.split(' ').next()?.parse::<f64>().ok()
        });
        let named = named.expect("a magnification");
        let beam = impact.beam.as_ref().unwrap();
        let way = |nodes: &[[f64; 3]], k: usize| {
            let moved = nodes.iter().map(|it| it[k]);
            let (low, high) = moved.fold((0.0_f64, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
            high - low
        };
        for (colour, displaced) in [
            (page::colour::IMPACTOR, way(&beam.peak, 0)),
            (page::colour::IMPACT_POINT, impact.report.max_v1),
            (
                page::colour::TOP,
                way(&beam.peak, 1).max(way(beam.remains.as_ref().unwrap(), 1)),
            ),
        ] {
            let (right, up) = extent(&tree, colour);
            let found = (right / displaced) / (up / 4.0);
            assert!((found / named - 1.0).abs() < 0.02, "{found} for {named}");
        }
    }

    #[test]
    fn there_are_no_figures_of_a_beam_that_was_not_asked() {
        let impact = impact(&["beam.mode:=off"]);
        let figures = draw_svg(&impact.history()).unwrap();
        let named = |(name, _): &(String, String)| name.starts_with("second_opinion");
        assert!(!figures.iter().any(named));
    }
}
