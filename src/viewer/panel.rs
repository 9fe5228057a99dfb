//! The panel beside the scene, as Markdown: what the impact does to the column, what hits it, and what the colours mean.

use super::beam;
use super::camera::comes_from_a_side;
use super::item::Announcement;
use super::plots;
use super::scene::{Drawing, force};
use crate::column::{HINGES, share_in_plane};
use crate::messages::column_twin_msgs::ImpactReport;
use crate::messages::words::verdict_in_words;
use crate::observables::HINGE_PLACES;
use crate::parameters::degrees;
use crate::study::VehicleLimits;
use printable::is_printable;

/// The entity of the panel.
pub const PANEL: &str = "panel";

/// What the panel says of an impact.
#[derive(Debug, Clone, Copy)]
pub enum Told<'a> {
    /// Nothing has hit the column yet.
    Nothing,
    /// An impact whose forecast is not known yet.
    Begun,
    /// The forecast of an impact.
    Forecast(&'a Announcement),
    /// The result of an impact.
    Result(&'a Announcement),
}

/// The whole panel.
#[must_use]
pub fn panel(drawing: &Drawing, told: Told<'_>) -> String {
    let verdict = match told {
        Told::Nothing => "## No impact yet\n".to_owned(),
        Told::Begun => "## Impact: its forecast is being computed\n".to_owned(),
        Told::Forecast(it) => verdict("Forecast", it),
        Told::Result(it) => verdict("Result", it),
    };
    format!("{verdict}\n{}\n{}", vehicle(drawing), legend(drawing))
}

/// The panel with the table of how fast each vehicle may hit the column at rest next.
#[must_use]
pub fn with_critical_velocities(panel: &str, vehicles: &[VehicleLimits]) -> String {
    let velocity = |velocity: Option<f64>| match velocity {
        None => "-".to_owned(),
        Some(velocity) => format!("{velocity:.1}"),
    };
    let rows: Vec<_> = vehicles
        .iter()
        .map(|it| {
            let name = match &*it.vehicle {
                "" => "user-defined".to_owned(),
                name => escaped(name),
            };
            let velocities = format!("{} / {}", velocity(it.restrict), velocity(it.evacuate));
            [format!("{name}, {:.0} kg", it.mass), velocities]
        })
        .collect();
    format!(
        "{panel}\n**How fast a vehicle may hit the column next**\n\n{}",
        table(["Vehicle", "RESTRICT / EVACUATE from \\[m/s\\]"], &rows)
    )
}

/// The outcome in words, for a heading.
#[must_use]
pub fn outcome(report: &ImpactReport) -> &'static str {
    match report.outcome {
        ImpactReport::ELASTIC => "elastic, no hinge yields",
        ImpactReport::PLASTIC => "plastic, the column does not collapse in the model",
        ImpactReport::FRACTURED => "FRACTURED, a hinge, a web or the base is fractured",
        _ => "COLLAPSED",
    }
}

/// Outcome, and the numbers that matter.
fn verdict(kind: &str, announced: &Announcement) -> String {
    let report = &*announced.report;
    let [measure, reason] = action(report);
    let mut text = format!("# {measure}\n\n## {kind}: {}\n\n", outcome(report));
    if !reason.is_empty() {
        text.push_str(&format!("{reason}.\n\n"));
    }
    text.push_str(&format!("Impact {}. ", escaped(&announced.event_id)));
    text.push_str(&hinges(report));
    text.push_str("\n\n");
    text.push_str(&table(["Quantity", "Value"], &rows(report)));
    text
}

/// What has to be done, and why, both without a full stop.
fn action(report: &ImpactReport) -> [String; 2] {
    let words = verdict_in_words(report.action, &report.action_reason);
    let (measure, reason) = words.split_once(". ").unwrap_or((&words, ""));
    [measure, reason].map(|text| escaped(text.trim_end_matches('.')))
}

/// Which hinges yield, in words.
fn hinges(report: &ImpactReport) -> String {
    let yielded: Vec<_> = (0..HINGES)
        .filter(|hinge| report.first_yield_time.get_or(*hinge, f64::NAN).is_finite())
        .map(|hinge| HINGE_PLACES[hinge].to_string())
        .collect();
    match &yielded[..] {
        [] => "All hinges stay elastic.".to_owned(),
        [one] => format!("Hinge {one} yields."),
        [first @ .., last] => format!("Hinges {} and {last} yield.", first.join(", ")),
    }
}

/// Quantities and values of a report; what is not known is left out.
fn rows(report: &ImpactReport) -> Vec<[String; 2]> {
    let mut rows = Vec::new();
    let mut add = |known: f64, name: &str, value: String| {
        if known.is_finite() {
            rows.push([name.to_owned(), value]);
        }
    };
    let largest = format!(
        "{:.1} mm at {:.1} ms",
        1e3 * report.max_v1,
        1e3 * report.max_v1_time
    );
    add(report.max_v1, "Peak displacement v1", largest);
    let residual = format!("{:.1} mm", 1e3 * report.residual_v1);
    add(report.residual_v1, "Residual v1", residual);
    let peak = report.peak_contact_force;
    add(peak, "Peak contact force", force(peak));
    let work = format!("{:.1} kJ", 1e-3 * report.plastic_work);
    add(report.plastic_work, "Plastic work in the hinges", work);
    let crush = report.max_crush.iter().zip(&*report.permanent_crush);
    for (index, (largest, permanent)) in crush.enumerate() {
        let crush = format!(
            "{:.0} mm, permanent {:.0} mm",
            1e3 * largest,
            1e3 * permanent
        );
        add(*largest, &format!("Crush of spring {}", index + 1), crush);
    }
    let dissipated: f64 = report.vehicle_dissipated.iter().sum();
    if dissipated > 0.0 {
        let work = format!("{:.1} kJ", 1e-3 * dissipated);
        add(dissipated, "Energy absorbed by the vehicle", work);
    }
    let capacity = format!(
        "{}, undamaged {}",
        force(report.residual_capacity),
        force(report.undamaged_capacity)
    );
    add(report.residual_capacity, "Residual capacity", capacity);
    let reserve = format!("{:.2} times the load", report.reserve);
    add(report.reserve, "Reserve", reserve);
    rows
}

/// The vehicle and how it is drawn.
fn vehicle(drawing: &Drawing) -> String {
    let body = &drawing.vehicle;
    let [length, width, height] = body.size;
    let name = escaped(&drawing.vehicle_name);
    let travel = travel(drawing);
    if !body.is_real() {
        return format!(
            "**Vehicle: rigid mass, as in the paper.** \
             It does not crush: forces and displacements are far above the values of a real vehicle. \
             The block ({length} m long) is a symbol, not to scale.{travel}\n"
        );
    }
    let parts = match &body.names().collect::<Vec<_>>()[..] {
        [_] => String::new(),
        names => format!("Masses, front first: {}. ", names.join(", ")),
    };
    format!(
        "**Vehicle: {name}.** \
         {parts}Body {length} m long, {width} m wide, {height} m high, to scale (size of its class, assumed). \
         Its nose shortens by the crush of spring 1 and turns from blue to orange.{travel}\n"
    )
}

/// Whence a vehicle comes that does not travel in the direction 0, as sentences.
fn travel(drawing: &Drawing) -> String {
    let direction = drawing.heading.direction();
    if direction == 0.0 {
        return String::new();
    }
    let component = match share_in_plane(direction) < 1.0 {
        true => {
            " The two bars see the component of the hit in this plane: speed, crush, forces and displacements here belong to it, \
             and the vehicle goes as far as the bars do along its path."
        }
        false => "",
    };
    let side = match comes_from_a_side(drawing.heading) {
        true => ", and the picture shows the column from the side where it does not come from",
        false => "",
    };
    format!(
        " It travels in the direction of {}{side}.{component}",
        degrees(direction)
    )
}

/// What colours, arrows and arcs mean.
fn legend(drawing: &Drawing) -> String {
    let scale = if drawing.magnification == 1.0 {
        "to scale".to_owned()
    } else {
        format!("magnified {} times", drawing.magnification)
    };
    let rows = [
        (
            "Ball at a hinge",
            "green: elastic; red: yields; orange: has yielded, elastic again".to_owned(),
        ),
        (
            "Steel",
            "grey: 0 %, yellow: 50 %, red: 100 % utilised (yields)".to_owned(),
        ),
        (
            "Pink arrow",
            format!(
                "contact force on the two bars, 1 m = {}",
                force(drawing.force_per_metre)
            ),
        ),
        ("Cyan arrow", "load P on the top, same scale".to_owned()),
        (
            "Violet arc",
            format!(
                "moment of a hinge, 270° = M_p = {:.0} kN m",
                1e-3 * drawing.resistance_moment
            ),
        ),
        (
            "Green lines",
            "axis of the fibre beam, the second opinion, in front of the bars; light: at its peak; dark: at rest".to_owned(),
        ),
        (
            "Dots beside them",
            format!(
                "fibres of the beam that have yielded; yellow: just; red: plastic strain of {:.0} % and more",
                100.0 * beam::FULL_STRAIN
            ),
        ),
        ("Displacements", scale),
    ];
    let crushes = drawing.vehicle.is_real();
    let plots = plots::ALL
        .iter()
        .filter(|plot| crushes || !plot.is_of_vehicle());
    let plots = plots.map(|plot| [plot.title, plot.symbols].map(str::to_owned));
    let rows = rows.map(|(sign, meaning)| [sign.to_owned(), meaning]);
    let rows: Vec<_> = rows.into_iter().chain(plots).collect();
    format!("**Legend**\n\n{}", table(["Sign", "Meaning"], &rows))
}

/// A table of two columns with these headings.
fn table([one, other]: [&str; 2], rows: &[[String; 2]]) -> String {
    let mut text = format!("| {one} | {other} |\n|---|---|\n");
    for [name, value] in rows {
        text.push_str(&format!("| {name} | {value} |\n"));
    }
    text
}

/// Text from outside, which must not become Markdown.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        if character.is_ascii_punctuation() {
            escaped.push('\\');
        }
        escaped.push(match is_printable(character) {
            true => character,
            false => ' ',
        });
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::{Impact, simulate};
    use crate::messages::column_twin_msgs::PerMass;
    use crate::parameters::Parameters;
    use crate::shape::VehicleBody;
    use crate::viewer::Announcement;

    fn announced() -> Announcement {
        let column = Parameters::default().column_properties();
        let report = simulate(&column, &Impact::rigid(1500.0, 10.0), 2.0, &mut |_| ());
        Announcement {
            stamp: 0,
            event_id: "car_7".into(),
            report: Box::new(ImpactReport::from(&report.expect("simulated"))),
        }
    }

    /// The heading: what is read first.
    fn heading(text: &str) -> &str {
        let mut lines = text.lines();
        lines.find(|it| it.starts_with("## ")).expect("a heading")
    }

    #[test]
    fn the_outcome_is_the_heading_below_the_measure() {
        let drawing = Drawing::new(&Parameters::default());
        let mut announced = announced();
        let text = panel(&drawing, Told::Forecast(&announced));
        let largest = 1e3 * announced.report.max_v1;
        let largest = format!("| Peak displacement v1 | {largest:.1} mm at");
        assert_eq!(
            heading(&text),
            "## Forecast: plastic, the column does not collapse in the model"
        );
        assert!(
            text.contains("Impact car\\_7. Hinges 1a (below the impact), 1b"),
            "{text}"
        );
        assert!(text.contains(&largest), "{text}");
        announced.report.outcome = ImpactReport::COLLAPSED;
        announced.report.residual_v1 = f64::NAN;
        let text = panel(&drawing, Told::Result(&announced));
        assert_eq!(heading(&text), "## Result: COLLAPSED");
        assert!(
            !text.contains("NaN") && !text.contains("Residual v1"),
            "{text}"
        );
        announced.report.outcome = ImpactReport::ELASTIC;
        announced.report.first_yield_time = [f64::NAN; HINGES].into();
        let text = panel(&drawing, Told::Result(&announced));
        assert!(text.contains("All hinges stay elastic."), "{text}");
    }

    /// Action and what decides it, crush and energy of the vehicle, residual capacity and reserve are in words.
    #[test]
    fn action_vehicle_and_capacity_are_in_words() {
        let drawing = Drawing::new(&Parameters::default());
        let mut announced = announced();
        let text = |announced: &Announcement| panel(&drawing, Told::Result(announced));
        let unknown = text(&announced);
        assert!(unknown.starts_with("# UNKNOWN\n"), "{unknown}");
        assert!(!unknown.contains("capacity") && !unknown.contains("Crush of"));
        let report = &mut announced.report;
        report.outcome = ImpactReport::FRACTURED;
        report.action = ImpactReport::ACTION_EVACUATE;
        report.action_reason = "Let nobody in. Cause: hinge rotation.".to_owned();
        report.max_crush = PerMass::first(&[0.62, 0.09, 0.0], 2);
        report.permanent_crush = PerMass::first(&[0.55, 0.01, 0.0], 2);
        report.vehicle_dissipated = PerMass::first(&[150e3, 2e3, 0.0], 2);
        report.undamaged_capacity = 2.7e6;
        report.residual_capacity = 1.1e6;
        report.reserve = 2.2;
        let text = text(&announced);
        assert_eq!(
            heading(&text),
            "## Result: FRACTURED, a hinge, a web or the base is fractured"
        );
        for part in [
            "# EVACUATE\\: Let nobody in\n\n## Result: FRACTURED,",
            "\n\nCause\\: hinge rotation.\n\n",
            "| Crush of spring 1 | 620 mm, permanent 550 mm |",
            "| Crush of spring 2 | 90 mm, permanent 10 mm |",
            "| Energy absorbed by the vehicle | 152.0 kJ |",
            "| Residual capacity | 1100 kN, undamaged 2700 kN |",
            "| Reserve | 2.20 times the load |",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }

    #[test]
    fn critical_velocities_follow_the_verdict() {
        let limits = |vehicle: &str, restrict, evacuate| VehicleLimits {
            vehicle: vehicle.into(),
            mass: 1_500.0,
            restrict,
            evacuate,
        };
        let vehicles = [
            limits("", Some(0.0), Some(3.5)),
            limits("mid_car", Some(2.0), None),
        ];
        let text = with_critical_velocities("## Result\n", &vehicles);
        assert_eq!(heading(&text), "## Result");
        assert!(
            text.contains("| user-defined, 1500 kg | 0.0 / 3.5 |"),
            "{text}"
        );
        assert!(text.contains("| mid\\_car, 1500 kg | 2.0 / - |"), "{text}");
    }

    #[test]
    fn the_legend_gives_the_scales_of_the_drawing() {
        let mut drawing = Drawing::new(&Parameters::default());
        let text = panel(&drawing, Told::Nothing);
        assert_eq!(heading(&text), "## No impact yet");
        for part in [
            "1 m = 1000 kN",
            "270° = M_p = 294 kN m",
            "| Displacements | to scale |",
            "| Shortening | u1 at the impact, u2 at the top, both downwards (Figure 6) |",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
        drawing.magnification = 5.0;
        let text = panel(&drawing, Told::Begun);
        assert!(text.contains("magnified 5 times"), "{text}");
    }

    /// A reader cannot take the paper's rigid mass for a real vehicle, nor an assumed size for a measured one.
    #[test]
    fn the_vehicle_is_named_for_what_it_is() {
        let mut drawing = Drawing::new(&Parameters::default());
        let text = panel(&drawing, Told::Nothing);
        assert!(
            text.contains("**Vehicle: rigid mass, as in the paper.**"),
            "{text}"
        );
        assert!(text.contains("a symbol, not to scale"), "{text}");
        drawing.vehicle = VehicleBody::assumed(8_000.0, &[0.0, 0.0]);
        drawing.vehicle_name = "lorry_8t".to_owned();
        let text = panel(&drawing, Told::Nothing);
        for part in [
            "**Vehicle: lorry\\_8t.**",
            "Masses, front first: cab and chassis, load.",
            "Body 8 m long, 2.5 m wide, 3.4 m high, to scale",
            "assumed",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }

    #[test]
    fn text_from_outside_is_no_markdown() {
        assert_eq!(escaped("a|b\n# c"), "a\\|b \\# c");
    }
}
