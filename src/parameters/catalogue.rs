//! The catalogue of rolled sections: HEA, HEB, HEM and IPE of EN 10365, from `config/sections.csv`.

use std::sync::LazyLock;

use serde::Deserialize;

use super::spelling::may_be_misspelt;
use crate::column::{RolledSection, SectionProperties};

/// A section of the catalogue.
#[derive(Debug, Clone, PartialEq)]
pub struct CatalogueSection {
    /// Such as `HEB220`.
    pub name: String,
    /// Nominal dimensions.
    pub dimensions: RolledSection,
}

static CATALOGUE: LazyLock<Vec<CatalogueSection>> = LazyLock::new(|| {
    rows()
        .map(|row| {
            row.expect("config/sections.csv is embedded in the program and tested")
                .section()
        })
        .collect()
});

/// Every section known by name, family by family, smallest first.
#[must_use]
pub fn catalogue() -> &'static [CatalogueSection] {
    &CATALOGUE
}

impl CatalogueSection {
    /// The section of this name, in any case and with or without spaces; `HE 220 B` is `HEB220`.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        let wanted = normal_form(name);
        catalogue().iter().find(|section| section.name == wanted)
    }

    /// The section of the same series that is this many sizes heavier than the one of this name; `None` where the series ends
    /// before.
    #[must_use]
    pub fn heavier(name: &str, sizes: usize) -> Option<&'static Self> {
        let own = Self::named(name)?;
        let family = |section: &Self| {
            section
                .name
                .trim_end_matches(|c: char| c.is_ascii_digit())
                .to_owned()
        };
        let of_series = catalogue().iter().filter(|it| family(it) == family(own));
        of_series.skip_while(|it| it.name != own.name).nth(sizes)
    }

    /// The names closest to a misspelt one, closest first, at most three.
    #[must_use]
    pub fn nearest(name: &str) -> Vec<String> {
        if !may_be_misspelt(name) {
            return Vec::new();
        }
        let wanted = normal_form(name);
        let mut ranked: Vec<_> = catalogue()
            .iter()
            .map(|section| {
                let letters = strsim::damerau_levenshtein(&wanted, &section.name);
                (
                    letters,
                    size_of(&wanted).abs_diff(size_of(&section.name)),
                    &section.name,
                )
            })
            .collect();
        ranked.sort();
        let Some(best) = ranked.first().map(|(letters, ..)| *letters) else {
            return Vec::new();
        };
        ranked
            .into_iter()
            .take_while(|(letters, ..)| *letters == best && *letters <= 2)
            .map(|(.., name)| name.clone())
            .take(3)
            .collect()
    }

    /// The properties that the mechanics needs.
    #[must_use]
    pub fn properties(&self) -> SectionProperties {
        self.dimensions.properties()
    }
}

/// `heb 220`, `HE 220 B` and `HEB-220` are all `HEB220`.
fn normal_form(name: &str) -> String {
    let joined: String = name
        .chars()
        .filter(|c| !c.is_whitespace() && *c != '-')
        .map(|c| c.to_ascii_uppercase())
        .collect();
    let standard = joined.strip_prefix("HE").and_then(|rest| {
        let family = rest
            .chars()
            .last()
            .filter(|letter| matches!(letter, 'A' | 'B' | 'M'))?;
        let size = rest.strip_suffix(family)?;
        (!size.is_empty() && size.bytes().all(|byte| byte.is_ascii_digit()))
            .then(|| format!("HE{family}{size}"))
    });
    standard.unwrap_or(joined)
}

/// The number in a section's name; 0 if there is none.
fn size_of(name: &str) -> u32 {
    let digits: String = name
        .chars()
        .skip_while(|c| !c.is_ascii_digit())
        .take_while(char::is_ascii_digit)
        .collect();
    digits.parse().unwrap_or(0)
}

/// A line of the file: dimensions in mm, then published values, against which the tests check the computed ones.
#[derive(Debug, Deserialize)]
struct CatalogueRow {
    name: String,
    h_mm: f64,
    b_mm: f64,
    tw_mm: f64,
    tf_mm: f64,
    r_mm: f64,
    #[cfg(test)]
    published_area_cm2: f64,
    #[cfg(test)]
    published_second_moment_cm4: f64,
    #[cfg(test)]
    published_plastic_modulus_cm3: f64,
    #[cfg(test)]
    published_mass_kg_per_m: f64,
}

fn rows() -> impl Iterator<Item = csv::Result<CatalogueRow>> {
    let text: &'static str = include_str!("../../config/sections.csv");
    csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(text.as_bytes())
        .into_deserialize()
}

impl CatalogueRow {
    fn section(self) -> CatalogueSection {
        CatalogueSection {
            name: self.name,
            dimensions: RolledSection {
                depth: self.h_mm / 1e3,
                width: self.b_mm / 1e3,
                web_thickness: self.tw_mm / 1e3,
                flange_thickness: self.tf_mm / 1e3,
                root_radius: self.r_mm / 1e3,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guards every dimension against typing errors: the published values depend on all of them.
    #[test]
    fn every_section_has_its_published_properties() {
        for row in rows() {
            let row = row.expect("a line of config/sections.csv does not parse");
            let published = [
                (row.published_area_cm2 * 1e-4, 1e-3),
                (row.published_second_moment_cm4 * 1e-8, 1e-3),
                (row.published_plastic_modulus_cm3 * 1e-6, 1e-3),
                (row.published_mass_kg_per_m, 5e-3), // printed with two or three digits
            ];
            let section = row.section();
            let computed = section.properties();
            let computed = [
                computed.area,
                computed.second_moment,
                computed.plastic_modulus,
                computed.mass_per_length,
            ];
            for (computed, (published, tolerance)) in computed.into_iter().zip(published) {
                assert!(
                    (computed / published - 1.0).abs() < tolerance,
                    "{}: {computed} {published}",
                    section.name
                );
            }
        }
    }

    #[test]
    fn the_four_families_are_complete() {
        let h_sizes = "100 120 140 160 180 200 220 240 260 280 300 320 340 360 400 450 500 550 600 650 700 800 900 1000";
        let i_sizes = "80 100 120 140 160 180 200 220 240 270 300 330 360 400 450 500 550 600";
        let mut expected = Vec::new();
        for (family, sizes) in [
            ("HEA", h_sizes),
            ("HEB", h_sizes),
            ("HEM", h_sizes),
            ("IPE", i_sizes),
        ] {
            expected.extend(sizes.split(' ').map(|size| format!("{family}{size}")));
        }
        let names: Vec<_> = catalogue()
            .iter()
            .map(|section| section.name.clone())
            .collect();
        assert_eq!(names, expected);
    }

    /// The yield strengths of the grades are valid up to 40 mm.
    #[test]
    fn no_flange_is_thicker_than_40_mm() {
        assert!(
            catalogue()
                .iter()
                .all(|section| section.dimensions.flange_thickness <= 0.040)
        );
    }

    #[test]
    fn a_section_has_many_spellings() {
        for spelling in [
            "HEB220",
            "heb 220",
            "HE 220 B",
            "he220b",
            "HEB-220",
            " Heb\t220 ",
        ] {
            assert_eq!(
                CatalogueSection::named(spelling).map(|section| section.name.as_str()),
                Some("HEB220")
            );
        }
        for unknown in ["", "HE", "HEB", "HEB221", "220", "HEBé"] {
            assert_eq!(CatalogueSection::named(unknown), None);
        }
    }

    #[test]
    fn nearest_names() {
        assert_eq!(CatalogueSection::nearest("HEB225"), ["HEB220"]);
        assert_eq!(CatalogueSection::nearest("heb 290")[0], "HEB280");
        assert_eq!(CatalogueSection::nearest("IPE 310")[0], "IPE300");
        assert!(CatalogueSection::nearest("W14x90").is_empty());
    }
}
