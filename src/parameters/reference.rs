//! The reference documentation of the parameters, generated from the table.

use std::fmt::Write;

use super::catalogue::catalogue;
use super::parameter::{Applies, Parameter};
use super::steel::STEEL_GRADES;
use super::table::PARAMETERS;
use super::value::{Value, readable};

/// The reference as Markdown, which is `docs/parameters.md`.
#[must_use]
pub fn markdown() -> String {
    let mut text = String::from(INTRODUCTION);
    let mut group = None;
    for parameter in PARAMETERS {
        let this = parameter.name.split_once('.').map(|(group, _)| group);
        if group != Some(this) {
            text.push_str(&heading(this.unwrap_or("Node")));
            group = Some(this);
        }
        text.push_str(&row(parameter));
    }
    text.push_str(&steels());
    text.push_str(&sections());
    text
}

const INTRODUCTION: &str = "\
# Parameters

This page is generated from the table of parameters (`src/parameters/table.rs`); do not edit it.

All units are SI.
Parameters come from ROS 2 parameter files and from `-p name:=value`; later ones override earlier ones.
A file looks like this, with groups nested or separated by dots:

```yaml
column_twin:
  ros__parameters:
    section.name: HEB220
    impact: {mass: 1500.0, velocity: 10.0}
```

`/**:` instead of `column_twin:` applies to every node, `/garage/a3/column_twin:` to the node in that namespace.
A whole number is accepted where a double is expected; NaN and infinity are rejected.
Arrays are written `[1.0, 2.5]` or as a YAML block sequence; their range applies to each element.
Ranges include their bounds; *or 0 (...)* gives the meaning of 0 where it is outside the range.
*Applies* tells when a change takes effect in the running node; *restart* means read-only while it runs.
";

fn heading(group: &str) -> String {
    let columns = "| name | type | unit | default | admissible | applies | meaning |\n|---|---|---|---|---|---|---|\n";
    format!("\n## {group}\n\n{columns}")
}

fn row(parameter: &Parameter) -> String {
    let default = match parameter.default_value() {
        Value::Double(number) => readable(number),
        Value::String(text) if text.is_empty() => "(empty)".to_owned(),
        other => other.plain(),
    };
    let applies = match parameter.applies {
        Applies::AtOnce => "at once",
        Applies::AfterResponse => "after the response",
        Applies::Restart => "restart",
    };
    format!(
        "| `{}` | {} | {} | {default} | {} | {applies} | {} |\n",
        parameter.name,
        parameter.kind(),
        parameter.unit,
        parameter.expectation(),
        parameter.meaning
    )
}

fn steels() -> String {
    let mut text = String::from(
        "\n## Steel grades\n\nNominal values for thicknesses up to 40 mm (EN 1993-1-1, table 3.1).\n\n\
         | name | E [GPa] | f_y [MPa] |\n|---|---|---|\n",
    );
    for grade in STEEL_GRADES {
        let _ = writeln!(
            text,
            "| {} | {} | {} |",
            grade.name,
            grade.young_modulus / 1e9,
            grade.yield_strength / 1e6
        );
    }
    text
}

fn sections() -> String {
    let mut text = String::from(
        "\n## Sections\n\nComputed from the dimensions of EN 10365 in `config/sections.csv`, root fillets included; bending about the \
         strong axis.\nNames are accepted in any case, with or without spaces; `HE 220 B` is `HEB220`.\n\n\
         | name | A [cm^2] | I [cm^4] | W_pl [cm^3] | mass [kg/m] |\n|---|---|---|---|---|\n",
    );
    for section in catalogue() {
        let properties = section.properties();
        let _ = writeln!(
            text,
            "| {} | {:.2} | {:.1} | {:.1} | {:.1} |",
            section.name,
            properties.area * 1e4,
            properties.second_moment * 1e8,
            properties.plastic_modulus * 1e6,
            properties.mass_per_length
        );
    }
    text
}
