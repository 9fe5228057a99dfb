//! The reference documentation of the parameters, generated from the table.

use std::fmt::Write;

use super::catalogue::catalogue;
use super::parameter::{Admissible, Applies, DefaultValue, Parameter};
use super::qos_overrides::QOS_PARAMETERS;
use super::sensors::SENSOR_PARAMETERS;
use super::steel::STEEL_GRADES;
use super::table::PARAMETERS;
use super::value::{Kind, Value, readable};
use super::vehicles::{Provenance, vehicle_catalogue};

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
    for parameter in SENSOR_PARAMETERS {
        text.push_str(&row(parameter));
    }
    text.push_str(SENSORS);
    text.push_str(&heading("qos_overrides"));
    for parameter in QOS_PARAMETERS {
        text.push_str(&row(parameter));
    }
    text.push_str(QOS_OVERRIDES);
    text.push_str(&steels());
    text.push_str(&sections());
    text.push_str(&vehicles());
    text
}

/// The types of the keywords of the Python package, which is `crates/python/python/column_twin/_keywords.py`: one for each
/// parameter, with two underscores for a dot, so that editors complete them and type checkers find a wrong one. Sensors are
/// named by their users and have none.
#[must_use]
pub fn python_keywords() -> String {
    let mut text = String::from(PYTHON_INTRODUCTION);
    text.push_str("class ParameterKeywords(TypedDict, total=False):\n    \"\"\"A parameter, by its name.\"\"\"\n\n");
    for parameter in PARAMETERS {
        let kind = match parameter.admissible {
            Admissible::Choice(words) => {
                let words: Vec<_> = words.iter().map(|word| format!("\"{word}\"")).collect();
                format!("Literal[{}]", words.join(", "))
            }
            _ => match parameter.kind() {
                Kind::Bool => "bool",
                Kind::Integer => "Whole",
                Kind::Double => "Number",
                Kind::String => "Text",
                Kind::DoubleArray => "Numbers",
                Kind::StringArray => "Sequence[str]",
            }
            .to_owned(),
        };
        text.push_str(&keyword(parameter, &kind));
    }
    text.push_str(PYTHON_AXES);
    let is_number = |it: &&Parameter| matches!(it.kind(), Kind::Integer | Kind::Double);
    for parameter in PARAMETERS.iter().filter(is_number) {
        text.push_str(&keyword(parameter, "AxisNumbers"));
    }
    text
}

/// A line of a keyword, with what editors show of it.
fn keyword(parameter: &Parameter, kind: &str) -> String {
    let name = parameter.name.replace('.', "__");
    let unit = match parameter.unit {
        "" => String::new(),
        unit => format!(" [{unit}]"),
    };
    let meaning = parameter.meaning.replace('\\', "\\\\").replace('"', "'");
    format!("    {name}: {kind}\n    \"\"\"{meaning}{unit}\"\"\"\n")
}

const PYTHON_INTRODUCTION: &str = "\
\"\"\"The keywords of every parameter.

This file is generated from the table of parameters (src/parameters/table.rs); do not edit it.
\"\"\"

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, TypedDict, Union

import numpy as np
import numpy.typing as npt

from ._range import AxisNames, AxisNumbers

Number = Union[float, \"np.number[Any]\"]
Whole = Union[int, \"np.integer[Any]\"]
Numbers = Union[Sequence[float], npt.NDArray[Any]]
Text = Union[str, \"os.PathLike[str]\"]


";

const PYTHON_AXES: &str = "


class AxisKeywords(TypedDict, total=False):
    \"\"\"An axis of a map.\"\"\"

    mass: AxisNumbers
    \"\"\"total mass of the vehicle [kg]\"\"\"
    velocity: AxisNumbers
    \"\"\"speed of the vehicle [m/s]\"\"\"
    height: AxisNumbers
    \"\"\"height of the impact point above the base [m]; the height of the column remains\"\"\"
    direction: AxisNumbers
    \"\"\"direction of travel of the vehicle [rad], above -pi to pi; 0 bends the column about its strong axis. A text is in degrees, as on the command line\"\"\"
    section: AxisNames
    \"\"\"sections of the catalogue\"\"\"
";

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
A whole number is accepted where a double is expected; NaN (but for `impact.mass`) and infinity are rejected.
Arrays are written `[1.0, 2.5]` or as a YAML block sequence; their range applies to each element.
Ranges include their bounds; *or 0 (...)* gives the meaning of 0 where it is outside the range.
*Applies* states when a change takes effect in the running node; *restart* means read-only while it runs.
";

const SENSORS: &str = "
`<name>` is an element of `sensors.names`: each sensor has all of these parameters, and `sensors.names` may be given before or after \
them; a later file or override replaces the whole list.
Readings are relative to the column at rest, as it was before the impact.
`config/sensors_industrial.yaml` is an example.

```yaml
sensors:
  names: [top_laser]
  top_laser: {quantity: displacement, height: 2.5, noise: 1.0e-4}
```
";

const QOS_OVERRIDES: &str = "
`<topic>` is the full name of a topic, after remapping, and `<end>` is `publisher` or `subscription`.
Each of these parameters exists only if it is given, at the start; the others of the topic stay as \
[the table of the topics](messages.md#topics-and-services) states them.

```yaml
qos_overrides:
  /column_state:
    publisher: {reliability: best_effort, depth: 10}
```
";

fn heading(group: &str) -> String {
    let columns = "| name | type | unit | default | admissible | applies | meaning |\n|---|---|---|---|---|---|---|\n";
    format!("\n## {group}\n\n{columns}")
}

fn row(parameter: &Parameter) -> String {
    let default = match parameter.default_value() {
        _ if matches!(parameter.default, DefaultValue::Required(_)) => "(required)".to_owned(),
        Value::Double(number) => readable(number),
        Value::String(text) if text.is_empty() => "(empty)".to_owned(),
        other => other.plain(),
    };
    let applies = match parameter.applies {
        Applies::AtOnce => "immediately",
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

fn vehicles() -> String {
    let mut text = String::from(
        "\n## Vehicles\n\nFrom `config/vehicles.json`; `rigid` is the paper's rigid mass.\nMasses and springs are listed from the front; \
         each spring is in front of the mass of the same row.\nThe curve gives the force of the full width of the front over its crush, \
         and its last slope continues; a narrow object meets half of it up to a crush of 0.40 m, rising to all of it at 0.55 m.\n\
         Every number has the tag of its source: ",
    );
    let tags = Provenance::ALL.map(|tag| format!("[{tag}] {}", tag.meaning()));
    let _ = writeln!(
        text,
        "{}.\n`column-twin vehicles` prints the sources.\n\n\
         | name | mass [kg] | crush [m] : force [kN] | unloading [MN/m] | narrow object | contact height [m] | scatter of the force |\n\
         |---|---|---|---|---|---|---|",
        tags.join(", ")
    );
    for vehicle in vehicle_catalogue() {
        for (index, spring) in vehicle.springs.iter().enumerate() {
            let mass = vehicle.masses.value.kg[index];
            let curve: Vec<_> = spring.value.points.iter().map(curve_point).collect();
            let _ = write!(
                text,
                "| {} | {mass} [{}] | {} [{}] | {} |",
                if index == 0 {
                    vehicle.name.as_str()
                } else {
                    ""
                },
                vehicle.masses.tag,
                curve.join(", "),
                spring.tag,
                readable(spring.value.unloading_stiffness_n_m / 1e6),
            );
            let _ = match index {
                0 => writeln!(
                    text,
                    " {} [{}] | {} [{}] | {} % [{}] |",
                    if vehicle.narrow_object.value.on {
                        "yes"
                    } else {
                        "no"
                    },
                    vehicle.narrow_object.tag,
                    vehicle.contact_height.value.height_m,
                    vehicle.contact_height.tag,
                    (100.0 * vehicle.force_variation.value.coefficient).round(),
                    vehicle.force_variation.tag,
                ),
                _ => writeln!(text, " | | |"),
            };
        }
    }
    text
}

/// A point of a force-crush curve: crush \[m\] and force \[kN\].
fn curve_point([crush, force]: &[f64; 2]) -> String {
    format!("{} : {}", rounded(*crush), rounded(force / 1e3))
}

/// Without the digits that only round-off fills.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
