//! Comparison of the slip of a base plate with that of an engineer's fibre beam on springs.

use std::fmt::Write as _;
use std::path::Path;

use crate::column::{BaseResistance, ColumnProperties, Report, respond};
use crate::parameters::{Parameters, parse_override};

/// A hit that the engineer computed.
struct Hit {
    words: &'static str,
    vehicle: &'static str,
    /// \[m/s\]
    velocity: f64,
    /// Of the impact point above the base \[m\].
    height: f64,
    /// That of the engineer \[mm\].
    slip: f64,
}

const HITS: [Hit; 4] = [
    Hit {
        words: "car, 50 km/h, 0.5 m",
        vehicle: "mid_car",
        velocity: 13.9,
        height: 0.5,
        slip: 39.0,
    },
    Hit {
        words: "SUV, 40 km/h, 0.5 m",
        vehicle: "suv",
        velocity: 11.1,
        height: 0.5,
        slip: 124.0,
    },
    Hit {
        words: "lorry, 18 km/h, 1.25 m",
        vehicle: "lorry_8t",
        velocity: 5.0,
        height: 1.25,
        slip: 0.0,
    },
    Hit {
        words: "forklift, 14 km/h, 0.75 m",
        vehicle: "forklift",
        velocity: 3.9,
        height: 0.75,
        slip: 15.0,
    },
];

/// Height of the column \[m\].
const HEIGHT: f64 = 4.0;

/// The partial factor of anchors, by which the engineer's design resistances are smaller than those of the program.
const ANCHOR_FACTOR: f64 = 1.25;

/// Loads on the column \[N\]: the one that the review gives beside the plate, and the one that it gives beside the hits.
const LOADS: [f64; 2] = [490e3, 556e3];

/// Largest deviation of a slip from that of the engineer, both with characteristic resistances and a web that does not yield: 15 % less
/// resistance multiplies the slip of the car by four.
const TOLERANCE: f64 = 0.3;

impl Hit {
    fn column(&self, shear: &str, load: f64) -> (Parameters, ColumnProperties) {
        let overrides = [
            format!("geometry.length_below:={:?}", self.height),
            format!("geometry.length_above:={:?}", HEIGHT - self.height),
            format!("top.load:={load:?}"),
            format!("shear.model:={shear}"),
            "hardening.ratio:=0.0".to_owned(),
            "softening.model:=none".to_owned(),
            "base.connection:=plate".to_owned(),
            "base.plate_thickness:=0.03".to_owned(),
            "base.plate_length:=0.4".to_owned(),
            "base.plate_width:=0.4".to_owned(),
            "base.anchor_count:=4".to_owned(),
            "base.anchor_diameter:=0.024".to_owned(),
            "base.anchor_grade:='8.8'".to_owned(),
            "base.anchor_distance:=0.14".to_owned(),
            "base.concrete:=C25/30".to_owned(),
            format!("vehicle.name:={}", self.vehicle),
            format!("impact.velocity:={:?}", self.velocity),
        ];
        let overrides = overrides.map(|text| parse_override(&text));
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/heb220_s355.yaml");
        let parameters = Parameters::load(&[file], &overrides).expect("a column on a plate");
        let properties = parameters.column_properties();
        (parameters, properties)
    }

    fn respond(
        &self,
        (shear, load): (&str, f64),
        change: impl Fn(BaseResistance) -> BaseResistance,
    ) -> Report {
        let (parameters, properties) = self.column(shear, load);
        let connection = properties.base_connection.expect("a plate");
        let properties = ColumnProperties {
            base_connection: Some(change(connection)),
            ..properties
        };
        let duration = parameters.response_duration();
        respond(&properties, &parameters.impact(), duration).expect("a response")
    }

    /// The slip \[mm\] of a base whose anchors give way without end.
    fn slip(&self, shear: &str, load: f64, factor: f64) -> f64 {
        let weakened = |it: BaseResistance| BaseResistance {
            tension: it.tension / factor,
            anchor_shear: it.anchor_shear / factor,
            ..it.without_limits()
        };
        1e3 * self.respond((shear, load), weakened).base.slip
    }
}

/// The chapter of the page, and the ratios of the slips where the engineer has any. Asserts what it states.
pub(super) fn chapter() -> (String, [f64; 3]) {
    let mut text = CHAPTER.to_owned();
    let mut ratios = Vec::new();
    for hit in HITS {
        let [rigid, loaded] = LOADS.map(|load| hit.slip("none", load, 1.0));
        let [load, _] = LOADS;
        let design = hit.slip("none", load, ANCHOR_FACTOR);
        let sheared = hit.slip("web", load, 1.0);
        let end = match hit.respond(("web", load), |it| it).base.fractured {
            Some(_) => "anchors sheared off",
            None => "the anchors hold",
        };
        assert_eq!(end == "the anchors hold", hit.slip == 0.0, "{}", hit.words);
        let ratio = match hit.slip > 0.0 {
            true => {
                let ratio = rigid / hit.slip;
                assert!((ratio - 1.0).abs() <= TOLERANCE, "{}: {ratio}", hit.words);
                ratios.push(ratio);
                format!("{ratio:.2}")
            }
            false => {
                let slips = [rigid, loaded, design, sheared];
                assert_eq!(slips, [0.0; 4], "{}", hit.words);
                "-".to_owned()
            }
        };
        let _ = writeln!(
            text,
            "| {} | {:.0} | {rigid:.1} | {ratio} | {loaded:.1} | {design:.1} | {sheared:.1} | {end} |",
            hit.words, hit.slip,
        );
    }
    text += READING;
    (text, ratios.try_into().expect("three hits that slip"))
}

const CHAPTER: &str = "
## A base plate that slips

The engineer who reviewed the verdicts put a fibre beam on elastic-plastic springs for a base plate: HEB 220 in S355, 4 m high, on 400 x 400 x 30 mm with four M24 8.8 at 140 mm from the axis, whose anchors never fracture.
This beam has no shear of its web, as the two bars with `shear.model: none`; the last slips belong to a column whose web yields.
Neither hardening, softening nor strain rate is counted, and the cars have the front that meets a narrow object.
Under 490 kN the plate bears 378 kN of shear, and 322 kN with the partial factor of 1.25 of the anchors. The review names both resistances, and not which one its springs had; it gives 490 kN beside the plate and 556 kN beside the hits.

| hit | slip, engineer [mm] | web that does not yield, 490 kN [mm] | ratio | the same, 556 kN [mm] | the same, 490 kN, with the partial factor [mm] | web that yields, 490 kN [mm] | the anchors as the program has them |
|---|---|---|---|---|---|---|---|
";

const READING: &str = "
The slips are as uncertain as the resistance: the forces of the fronts are just above what the column bears, so that 15 % less resistance multiplies the slips by 1.3 to 4.4.
With a web that yields, foot and web share the movement, and the weaker one takes most of it.
The program ends a response once the anchors have slipped by 0.3 of their diameter, 7.2 mm here: in the three hits that slip its verdict is that the anchors are sheared off, as the engineer's, and no larger slip is computed.
This compares two models, and no measurement.
";
