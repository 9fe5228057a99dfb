//! The four pages of a report: what the first one says, and how all of them print.

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

use super::recordings::{report_of, three_impacts, typed};

/// The file in `config/` of a column whose checks can all be made.
fn config(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join("config").join(name).display().to_string()
}

/// The report of `simulate` with these options.
fn simulated(folder: &Path, name: &str, options: &str) -> (PathBuf, String) {
    let path = folder.join(format!("{name}.html"));
    let line = format!("simulate {options} --report {}", path.display());
    let (code, _, stderr) = typed(folder, &line);
    assert_eq!(code, 0, "{line}: {stderr}");
    let html = std::fs::read_to_string(&path).unwrap();
    (path, html)
}

/// The text of an element and what is in it, without the elements.
fn text_of(html: &str) -> String {
    let mut text = String::new();
    let mut is_element = false;
    for letter in html.chars() {
        match letter {
            '<' => is_element = true,
            '>' => {
                is_element = false;
                text.push(' ');
            }
            _ if !is_element => text.push(letter),
            _ => (),
        }
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The sheets of a report, each as HTML.
fn sheets(html: &str) -> Vec<&str> {
    let body = &html[..html.find("class=\"annex\"").unwrap_or(html.len())];
    body.split("<div class=\"sheet").skip(1).collect()
}

const DETAILS: &str =
    "project: Car park North\nsite: Harbour Street 12\nauthor: A. Miller\nrevision: B\n";

/// The first page names the model that decides, as the JSON of the same hit has it.
#[test]
fn the_first_page_names_the_model_that_decides() {
    let folder = TempDir::new().unwrap();
    for (name, further, expected) in [
        (
            "oblique",
            "--direction 90",
            "Model that decides: the fibre beam. The fibre beam has a peak of ",
        ),
        (
            "bars",
            "--direction 90 -p beam.mode:=off",
            "Model that decides: the two bars alone.",
        ),
        (
            "numbers",
            &format!("--config {}", config("heb220_paper.yaml")),
            "Model that decides: the two bars alone; the annex gives the reason why there is no second opinion.",
        ),
    ] {
        let (_, html) = simulated(
            folder.path(),
            name,
            &format!("--mass 1500 --velocity 10 {further}"),
        );
        let first = text_of(sheets(&html)[0]);
        assert!(first.contains(expected), "{name}: {first}");
    }
}

/// The title and the sketch had the component of the speed in the plane of the two bars, and the sentences told the motion by it:
/// "0.0000036 km/h", "stays elastic" and "moment 0 %" below the headline EVACUATE.
#[test]
fn the_report_of_an_oblique_hit_states_the_whole_vehicle() {
    let folder = TempDir::new().unwrap();
    for (angle, bends) in [
        (
            "90",
            "at right angles to the web and bends the column about its weak axis z-z.",
        ),
        (
            "45",
            "at 45° to the web and bends the column about both axes, the strong one y-y and the weak one z-z.",
        ),
    ] {
        let options = format!(
            "--config {} --vehicle lorry_8t --velocity 6 --direction {angle}",
            config("heb220_s355.yaml")
        );
        let (_, html) = simulated(folder.path(), angle, &options);
        let sheets = sheets(&html);
        let [first, second] = [0, 1].map(|index| text_of(sheets[index]));
        for text in [
            &*format!("8000 kg at 6 m/s (21.6 km/h), {angle}° to the web, 1.25 m above the base"),
            "21.6 km/h (6 m/s)",
            &*format!("hit, {angle}°"),
            bends,
            "Bow that remains: ",
            "yielded by the fibre beam: kink ",
        ] {
            assert!(first.contains(text), "{angle}: no {text:?} in {first}");
        }
        for text in [
            "21.60 km/h (6.000 m/s)",
            "the column yields by the fibre beam",
        ] {
            assert!(second.contains(text), "{angle}: no {text:?} in {second}");
        }
        let body = text_of(&sheets.concat());
        for text in [
            "stays elastic",
            "15.27 km/h",
            "0.0000036",
            "shear 0 %",
            "moment 0 %",
        ] {
            assert!(!body.contains(text), "{angle}: {text:?} in {body}");
        }
        // The bow is that of the beam, and no check of the base is met by the component alone.
        assert!(!second.contains("less than L/10000"), "{angle}: {second}");
        for row in sheets[1].split("<tr").map(text_of) {
            let is_met_by_nothing = row.contains("Base") && row.contains(" 0 % met");
            assert!(!is_met_by_nothing, "{angle}: {row}");
        }
    }
}

/// The bow of the two bars stood before that of the fibre beam, which decided, as if both were one quantity.
#[test]
fn the_bow_of_the_first_page_is_that_of_the_model_that_decides() {
    let folder = TempDir::new().unwrap();
    let options = format!(
        "--config {} --vehicle forklift --velocity 4.2 -p section.name:=HEA240 -p support.base:=pinned -p support.top:=pinned \
         -p geometry.length_below:=0.75 -p geometry.length_above:=5.25 -p top.load:=4.2e5",
        config("heb220_s355.yaml")
    );
    let (_, html) = simulated(folder.path(), "bow", &options);
    let sheets = sheets(&html);
    let first = text_of(sheets[0]);
    assert!(
        first.contains("Model that decides: the fibre beam."),
        "{first}"
    );
    let millimetres_after = |words: &str| {
        let place = first
            .find(words)
            .unwrap_or_else(|| panic!("no {words:?} in {first}"));
        let rest = &first[place + words.len()..];
        rest.split(" mm").next().unwrap_or_default().to_owned()
    };
    assert_eq!(
        millimetres_after("displacement of the impact point "),
        millimetres_after(", keeps ")
    );
    let third = text_of(sheets[2]);
    for text in ["By the fibre beam.", "By the two bars."] {
        assert!(third.contains(text), "{text:?}: {third}");
    }
}

/// A fractured column had the residual displacement "none", which reads as zero.
#[test]
fn a_column_that_fractures_within_the_range_has_no_residual_of_none() {
    let folder = TempDir::new().unwrap();
    let options = format!(
        "--config {} --vehicle lorry_8t --velocity 8.3",
        config("heb220_s355.yaml")
    );
    let (_, html) = simulated(folder.path(), "range", &options);
    let sheets = sheets(&html);
    let fourth = text_of(sheets[3]);
    assert!(fourth.contains(" fractures evacuate"), "{fourth}");
    assert!(!fourth.contains(" none evacuate"), "{fourth}");
    // The style keeps the words of this column whole.
    assert!(html.contains("<td class=\"word\">evacuate</td>"));
}

/// The bow decided, and nothing on the first lines told that the anchors require the same action.
#[test]
fn every_cause_of_the_action_is_on_the_first_lines() {
    let folder = TempDir::new().unwrap();
    let options = format!("--config {}", config("heb220_s355.yaml"));
    let (_, html) = simulated(folder.path(), "car", &options);
    let first = text_of(sheets(&html)[0]);
    let causes = "Cause: the column stays bent further than the buckling curves allow for. Residual bow of the bent part: L/91; limit L/250. \
                  Also: the anchors of the base may be broken.";
    assert!(first.contains(causes), "{first}");
}

/// May people stay, and what must be looked at: both are answered before a page is turned, after the action, its cause and the
/// number with its limit.
#[test]
fn the_first_page_answers_both_questions_of_the_engineer() {
    let folder = TempDir::new().unwrap();
    let details = folder.path().join("details.yaml");
    std::fs::write(&details, DETAILS).unwrap();
    let options = format!(
        "--config {} --vehicle lorry_8t --velocity 8 --report-details {}",
        config("heb220_s355.yaml"),
        details.display()
    );
    let (_, html) = simulated(folder.path(), "lorry", &options);
    let sheets = sheets(&html);
    assert_eq!(sheets.len(), 4);
    let first = text_of(sheets[0]);
    let mut place = 0;
    for text in [
        "SHORE: clear the structure that the column carries, and have it shored.",
        "Cause: ",
        "; limit ",
        "Bow that remains: ",
        "= L/",
        "Model that decides: ",
        "Range of the verdict: ",
        "May people stay?",
        "Not where the column carries the building.",
        "Places to inspect",
        "Base plate and anchors",
        "Welds at base and top",
        "Splice, beam connections",
        "Elevation",
        "Plan",
        "Project Car park North",
        "Revision B",
        "Author A. Miller",
        "Signature",
        "Checker",
    ] {
        let found = first[place..].find(text);
        let found = found.unwrap_or_else(|| panic!("no {text:?} after {place} in {first}"));
        place += found;
    }
    // No abbreviation and no tag of a source stands in the headline.
    let headline = html.split("class=\"headline\">").nth(1).unwrap();
    let headline = &headline[..headline.find('<').unwrap()];
    assert!(
        !headline.contains("rad") && !headline.contains('['),
        "{headline}"
    );
}

/// The load has one value and is named once; earlier reports printed 500 kN carried and N_Ed of 271 kN.
#[test]
fn a_report_names_one_load_once() {
    let folder = TempDir::new().unwrap();
    let options = format!(
        "--config {} --vehicle lorry_8t --velocity 8",
        config("heb220_s355.yaml")
    );
    let (_, html) = simulated(folder.path(), "load", &options);
    assert_eq!(html.matches("The applied load N of ").count(), 1);
    assert!(!html.contains("Axial load carried"));
    assert_eq!(html.matches("<th scope=\"row\">Axial load</th>").count(), 1);
}

/// What is not given is left empty for a pen, and what is given wrongly is named with its line.
#[test]
fn the_title_block_has_lines_to_be_filled_in() {
    let folder = TempDir::new().unwrap();
    let (path, html) = simulated(folder.path(), "plain", "--mass 1500");
    for label in ["Project", "Site", "Date", "Revision", "Author", "Checker"] {
        let empty = format!("<td colspan=\"2\"><small>{label}</small> </td>");
        assert!(html.contains(&empty), "{label}");
    }
    assert_eq!(html.matches("<small>Signature</small>").count(), 2);
    std::fs::write(folder.path().join("bad.yaml"), "project: A\nauthr: B\n").unwrap();
    for line in [
        "simulate --report x.html --report-details bad.yaml",
        "simulate --report x.html --report-details nowhere.yaml",
        "simulate --report-details bad.yaml",
    ] {
        let (code, _, stderr) = typed(folder.path(), line);
        assert_eq!(code, 2, "{line}: {stderr}");
    }
    let (_, _, stderr) = typed(
        folder.path(),
        "simulate --report x.html --report-details bad.yaml",
    );
    assert!(
        stderr.contains("line 2") && stderr.contains("authr"),
        "{stderr}"
    );
    // All parameters are beside the report, and those of the node are nowhere in it.
    let beside = std::fs::read_to_string(path.with_extension("parameters.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&beside).unwrap();
    let names = json["parameter_sets"][0]["parameters"].as_array().unwrap();
    for name in ["publish_rate", "record.mode", "geometry.length_below"] {
        assert!(names.iter().any(|it| it["name"] == name), "{name}");
    }
    for name in ["publish_rate", "record.", "viewer.", "use_sim_time"] {
        assert!(!html.contains(name), "{name}");
    }
}

/// A recording of several impacts has its table and title block before them, and four pages for each.
#[test]
fn a_report_about_several_impacts_has_a_cover_and_four_pages_for_each() {
    let recording = three_impacts();
    let (code, html, stderr) = report_of(&recording.path(), &[]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    assert_eq!(sheets(&html).len(), 8);
    assert_eq!(html.matches("class=\"cover\"").count(), 1);
    assert_eq!(html.matches("class=\"title-block\"").count(), 1);
    for anchor in ["impact-1", "impact-2", "annex-1", "annex-2"] {
        assert_eq!(
            html.matches(&format!("id=\"{anchor}\"")).count(),
            1,
            "{anchor}"
        );
    }
}

/// Chromium as Debian packages it prints the report as PDF.
fn printed(folder: &Path, html: &Path) -> PathBuf {
    let pdf = html.with_extension("pdf");
    let output = Command::new("chromium")
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
        ])
        .args(["--disable-background-networking", "--no-pdf-header-footer"])
        .arg(format!(
            "--user-data-dir={}",
            folder.join("chromium").display()
        ))
        .arg(format!("--print-to-pdf={}", pdf.display()))
        .arg(html)
        .output()
        .expect("chromium");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    pdf
}

/// The text of every page.
fn pages(pdf: &Path) -> Vec<String> {
    let output = Command::new("pdftotext")
        .arg("-layout")
        .arg(pdf)
        .arg("-")
        .output();
    let text = String::from_utf8(output.expect("pdftotext of poppler-utils").stdout).unwrap();
    let pages = text.split('\u{c}').map(str::to_owned);
    pages.filter(|page| !page.trim().is_empty()).collect()
}

/// Whatever the hit, its body is four pages, of which each begins where it has to, and the annex follows on the fifth.
#[test]
#[ignore = "slow: Chromium and poppler-utils"]
fn the_body_of_a_printed_report_is_four_pages() {
    let folder = TempDir::new().unwrap();
    let [paper, real] = ["heb220_paper.yaml", "heb220_s355.yaml"].map(config);
    let long = folder.path().join("long.yaml");
    let names = [
        "project",
        "site",
        "client",
        "document",
        "revision",
        "date",
        "author",
        "checker",
        "hit_direction",
    ];
    let text: String = names
        .iter()
        .map(|name| format!("{name}: {}\n", "Harbour street ".repeat(5).trim()))
        .collect();
    std::fs::write(&long, text).unwrap();
    let long = long.display();
    let all = column_twin::parameters::CRITERION_NAMES.join("','");
    for (name, options, headline) in [
        ("car", format!("--config {real}"), ""),
        (
            "lorry",
            format!("--config {real} --vehicle lorry_8t --velocity 8"),
            "SHORE: ",
        ),
        (
            "elastic",
            format!("--config {real} --mass 100 --velocity 1"),
            "NONE: ",
        ),
        (
            "collapse",
            format!("--config {real} --mass 20000 --velocity 20"),
            "EVACUATE: ",
        ),
        (
            "across",
            format!("--config {real} --vehicle lorry_8t --velocity 6 --direction 90"),
            "EVACUATE: ",
        ),
        (
            "oblique",
            format!("--config {real} --vehicle lorry_8t --velocity 6 --direction 45"),
            "",
        ),
        // The tables of both models pushed the last one of the third page onto a page of its own.
        (
            "by_the_beam",
            format!(
                "--config {real} -p section.name:=HEA200 -p top.load:=3.0e5 --vehicle suv --velocity 6"
            ),
            "INSPECT: ",
        ),
        (
            "paper",
            format!("--config {paper} --mass 1500 --velocity 10"),
            "AT LEAST ",
        ),
        (
            "long",
            format!(
                "--config {real} --velocity 14 --report-details {long} -p column_id:=<b>{}</b>",
                "x".repeat(200)
            ),
            "",
        ),
        (
            "every_check",
            format!("--config {paper} -p assessment.criteria:=['{all}']"),
            "",
        ),
    ] {
        let (html, _) = simulated(folder.path(), name, &options);
        let pages = pages(&printed(folder.path(), &html));
        let begins = |page: usize, text: &str| {
            let body = pages.get(page).map_or("", String::as_str);
            assert!(
                body.contains(text),
                "{name}, page {}: no {text:?} in {body}",
                page + 1
            );
        };
        begins(0, headline);
        begins(0, "May people stay?");
        begins(0, "Places to inspect");
        begins(0, "Signature");
        begins(1, "What hit what");
        begins(1, "Checks that decide");
        begins(2, "The column after the hit");
        begins(2, "Base reactions");
        begins(2, "Axial resistance that is left");
        begins(3, "How sure this is");
        begins(3, "Limits of the model");
        begins(3, "Neighbouring members");
        let annex = pages
            .iter()
            .position(|page| page.trim_start().starts_with("Annex"));
        assert_eq!(annex, Some(4), "{name}: the annex does not begin on page 5");
    }
}
