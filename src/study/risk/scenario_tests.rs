//! Tests of the shipped scenarios and of files of users.

use super::*;
use crate::parameters::{Parameters, Provenance};

#[test]
fn every_shipped_scenario_is_complete_and_has_its_sources() {
    let names: Vec<_> = scenario_names().collect();
    assert_eq!(names, ["motorway", "urban", "courtyard", "parking_garage"]);
    for name in names {
        let scenario = Scenario::shipped(name).unwrap();
        let of_classes = scenario
            .classes
            .iter()
            .flat_map(|it| [&it.mass, &it.force_factor]);
        for input in scenario
            .distributions()
            .map(|(_, input)| input)
            .chain(of_classes)
        {
            let tag = input.tag.unwrap_or_else(|| panic!("{name}: {input:?}"));
            assert!(input.source.len() > 5, "{name}: {input:?}");
            if tag == Provenance::Read {
                assert!(input.source.contains("JCSS"), "{name}: {input:?}");
            }
        }
        RiskColumn::new(&Parameters::default(), &scenario).unwrap();
    }
    // The values of the JCSS Probabilistic Model Code, 2.18.
    for (name, mean) in [
        ("motorway", 80.0),
        ("urban", 40.0),
        ("courtyard", 15.0),
        ("parking_garage", 10.0),
    ] {
        let scenario = Scenario::shipped(name).unwrap();
        assert!(
            (scenario.speed.distribution.mean() - mean).abs() < 1e-3 * mean,
            "{name}"
        );
        assert!((scenario.angle.distribution.mean() - 10.0).abs() < 1e-9);
        assert!((scenario.deceleration.distribution.mean() - 4.0).abs() < 1e-9);
        assert_eq!(scenario.encroachment_rate.distribution.mean(), 1e-10);
    }
}

/// The shares of the classes are those of the distributions of the masses of cars and of lorries, so that all classes together have
/// the distribution of the source, truncated at the outermost limits.
#[test]
fn the_classes_together_have_the_law_of_the_source() {
    let no_limits = [f64::NEG_INFINITY, f64::INFINITY];
    let cars = Distribution::normal(1500.0, 400.0, no_limits).unwrap();
    let lorries = Distribution::normal(20e3, 12e3, no_limits).unwrap();
    for name in scenario_names() {
        let scenario = Scenario::shipped(name).unwrap();
        for distribution in [cars, lorries] {
            let heavy = distribution == lorries;
            let group: Vec<_> = scenario
                .classes
                .iter()
                .filter(|it| (it.mass.distribution.limits()[0] > 3200.0) == heavy)
                .collect();
            let total: f64 = group.iter().map(|it| it.share).sum();
            let limits: Vec<[f64; 2]> = group
                .iter()
                .map(|it| it.mass.distribution.limits())
                .collect();
            let Some(([first, _], [_, last])) = limits.first().zip(limits.last()) else {
                assert!(heavy && name == "parking_garage");
                continue;
            };
            let whole = distribution.probability(*last) - distribution.probability(*first);
            for (class, [lower, upper]) in group.iter().zip(&limits) {
                let share =
                    (distribution.probability(*upper) - distribution.probability(*lower)) / whole;
                assert!(
                    (class.share - total * share).abs() < 2e-6,
                    "{name}: {}",
                    class.vehicle
                );
            }
            assert!(limits.windows(2).all(|pair| pair[0][1] == pair[1][0]));
        }
    }
}

#[test]
fn a_users_file_replaces_whole_entries() {
    let text = r#"{"scenarios": [{"name": "hall", "based_on": "parking_garage",
        "speed_km_h": {"distribution": "normal", "mean": 8, "sd": 3},
        "classes": [{"vehicle": "forklift", "share": 1, "mass_kg": {"distribution": "fixed", "value": 6000}}]}]}"#;
    let error = Scenario::from_json("hall.json", text, "hall").unwrap_err();
    assert_eq!(error.entry, "scenarios.hall.speed_km_h", "{error}");
    let text = text.replace("\"sd\": 3", "\"sd\": 3, \"min\": 0");
    let hall = Scenario::from_json("hall.json", &text, "hall").unwrap();
    assert_eq!(hall.speed.tag, None);
    assert_eq!(hall.classes.len(), 1);
    assert_eq!(hall.classes[0].height, Some(0.75));
    assert_eq!(
        hall.deceleration,
        Scenario::shipped("parking_garage").unwrap().deceleration
    );
    // A shipped scenario that the file does not have.
    assert!(Scenario::from_json("hall.json", &text, "urban").is_ok());
    let unknown = Scenario::from_json("hall.json", &text, "hal")
        .unwrap_err()
        .to_string();
    assert_eq!(
        unknown,
        "hall.json: scenarios: found no scenario named hal; expected one of hall, motorway, urban, courtyard, parking_garage"
    );
}

#[test]
fn wrong_entries_are_named_with_what_is_expected() {
    let scenario = |entry: &str| {
        format!(r#"{{"scenarios": [{{"name": "x", "based_on": "urban", {entry}}}]}}"#)
    };
    for (entry, expected) in [
        (
            r#""speed_km_h": {"distribution": "lognormal", "mean": 10, "sd": -5}"#,
            "f.json: scenarios.x.speed_km_h.sd: found -5; expected a finite number > 0",
        ),
        (
            r#""speed_km_h": {"distribution": "normal", "mean": 10, "sd": 5, "min": 50, "max": 20}"#,
            "f.json: scenarios.x.speed_km_h.min: found 50 with max 20; expected a lower limit (min) less than the upper limit (max)",
        ),
        (
            r#""speed_km_h": {"distribution": "normal", "mean": 10, "sd": 5, "min": -10, "max": 20}"#,
            "f.json: scenarios.x.speed_km_h: found normal, mean 10, sd 5, from -10 to 20; expected values from 0 to 216 km/h; cut the distribution with min and max",
        ),
        (
            r#""angle_deg": {"distribution": "rayleigh", "mean": 10, "sd": 10, "max": 90}"#,
            "f.json: scenarios.x.angle_deg.sd: found 10; expected nothing: the distribution rayleigh has no such number",
        ),
        (
            r#""distance_m": {"distribution": "fixed"}"#,
            "f.json: scenarios.x.distance_m.value: found nothing; expected a number, as the distribution fixed needs it",
        ),
        (
            r#""distance_m": {"distribution": "gumbel", "mean": 2}"#,
            "f.json: scenarios.x.distance_m.distribution: found gumbel; expected fixed, normal, lognormal, rayleigh or uniform",
        ),
        (
            r#""encroachment_rate_per_m": {"distribution": "uniform", "min": 0, "max": 1e-9}"#,
            "f.json: scenarios.x.encroachment_rate_per_m: found uniform, from 0 to 0.000000001; expected one value: distribution fixed",
        ),
        (
            r#""classes": []"#,
            "f.json: scenarios.x.classes: found 0 classes; expected 1 to 16",
        ),
        (
            r#""classes": [{"vehicle": "mid_car", "share": 0.5, "mass_kg": {"distribution": "fixed", "value": 1500}}]"#,
            "f.json: scenarios.x.classes: found shares that add up to 0.500000; expected shares that add up to 1; correct the shares",
        ),
        (
            r#""classes": [{"vehicle": "mid_car", "share": -1, "mass_kg": {"distribution": "fixed", "value": 1500}}]"#,
            "f.json: scenarios.x.classes[0].share: found -1; expected a share from 0 to 1",
        ),
    ] {
        let fault = Scenario::from_json("f.json", &scenario(entry), "x").unwrap_err();
        assert_eq!(fault.to_string(), expected);
    }
    let unknown = Scenario::from_json("f.json", &scenario(r#""sped": 1"#), "x").unwrap_err();
    assert!(
        unknown
            .to_string()
            .starts_with("f.json: scenarios.x.sped: found an unknown entry; expected one of name,")
    );
    let broken = Scenario::from_json("f.json", "{", "x")
        .unwrap_err()
        .to_string();
    assert!(broken.contains("line 1"), "{broken}");
    let mut urban = Scenario::shipped("urban").unwrap();
    for (distribution, expected) in [
        (
            "speed_km_h=lognormal:12:-5",
            "--distribution: speed_km_h.sd: found -5; expected a finite number > 0",
        ),
        (
            "speed=fixed:1",
            "--distribution: the name: found speed; expected one of speed_km_h,",
        ),
        (
            "speed_km_h",
            "--distribution: the distribution: found speed_km_h; expected name=distribution:numbers",
        ),
        (
            "speed_km_h=lognormal:12",
            "--distribution: speed_km_h: found lognormal:12; expected normal:MEAN:SD or lognormal:MEAN:SD",
        ),
        (
            "speed_km_h=fixed:x",
            "--distribution: speed_km_h: found fixed:x; expected numbers after the distribution",
        ),
    ] {
        let fault = urban
            .set("--distribution", distribution)
            .unwrap_err()
            .to_string();
        assert!(fault.starts_with(expected), "{fault}");
    }
}
