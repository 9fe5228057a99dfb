//! The cost of an opinion, and the Rust side of `opensees.py`, so that the beam and OpenSees take turns on the same machine.
//!
//! `cargo bench --package column_beam --bench cost` prints the cost of opinions on a column as the references know it and on one with
//! all effects. With `--serve`, it reads commands from the standard input, one per line, and answers each with a line of JSON:
//!
//! - `cases`: the columns and hits of the references, each with the mesh and the step that both programs take;
//! - `time CASE same` and `time CASE automatic`: processor time to the peak \[ms\], peak \[m\], time of the peak \[s\], and time steps
//!   up to it, with this mesh and step or with those that the beam chooses.

use std::error::Error;
use std::io::{self, BufRead, Write};

use column_beam::{BeamColumn, BeamModel, Hit};
use serde_json::{Value, json};

#[expect(dead_code, reason = "the tests use more of it")]
#[path = "../tests/beam/cases.rs"]
mod cases;
#[expect(dead_code, reason = "the tests use more of it")]
#[path = "../tests/beam/reference.rs"]
mod reference;

use cases::{Case, impact_case, plane_cases};
use reference::{column, cpu, hit, hit_by_a_car, vehicle};

fn main() -> Result<(), Box<dyn Error>> {
    if !std::env::args().any(|argument| argument == "--serve") {
        return opinions();
    }
    let mut all = plane_cases();
    for kind in ["plane impact", "3D impact"] {
        all.extend(cases::cases(kind).iter().map(impact_case));
    }
    let mut output = io::stdout();
    for line in io::stdin().lock().lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let answer = match words.as_slice() {
            ["cases"] => all.iter().map(shown).collect::<Result<Value, _>>()?,
            ["time", case, choice @ ("same" | "automatic")] => {
                let case = &all[case.parse::<usize>()?];
                match *choice {
                    "same" => time(&as_the_reference(case)?, &case.hit)?,
                    _ => time(&case.column, &case.hit)?,
                }
            }
            _ => return Err(format!("expected cases or time; found {line}").into()),
        };
        writeln!(output, "{answer}")?;
        output.flush()?;
    }
    Ok(())
}

/// The column with as many elements as the reference has, and its step.
fn as_the_reference(case: &Case) -> Result<BeamColumn, Box<dyn Error>> {
    // The mesh of the references is that of the beam for a vehicle in the plane that crushes.
    let crushes = hit(1000.0, 0.1, Some(vehicle(1000.0, 1e6, None)), 0.0);
    let elements = heights(&case.column, &crushes)?.len() - 1;
    let step_nanos = (case.step * 1e9).round() as u64;
    Ok(BeamColumn {
        elements,
        step_nanos,
        ..case.column
    })
}

fn heights(column: &BeamColumn, hit: &Hit) -> Result<Vec<f64>, Box<dyn Error>> {
    Ok(BeamModel::new(column)?.movement(hit, None)?.heights)
}

fn shown(case: &Case) -> Result<Value, Box<dyn Error>> {
    let same = as_the_reference(case)?;
    Ok(json!({
        "name": format!("{} {}", case.name, case.hardening).trim(),
        "column": same,
        "in_space": case.column.torsion_constant.is_some(),
        "torsional_rigidity": same.torsion_constant.map(|it| it * same.steel.shear_modulus()),
        "heights": heights(&same, &case.hit)?,
        "mass": case.hit.impact.mass,
        "velocity": case.hit.impact.velocity,
        "direction": case.hit.direction,
        "front": case.front,
        "step": case.step,
        "peak": case.peak,
        "time": case.time,
    }))
}

/// Processor time from the mesh to the peak, and the response.
fn time(column: &BeamColumn, hit: &Hit) -> Result<Value, Box<dyn Error>> {
    let model = BeamModel::new(column)?;
    // The clock is read in one step alone, because it costs time itself.
    let (mut steps, mut last) = (0_u64, 0);
    let [peak, _, time] = model.respond_in_steps(hit, |is_peak| {
        steps += 1;
        if is_peak {
            last = steps;
        }
    })?;
    let (mut steps, mut end) = (0, f64::NAN);
    let began = cpu();
    model.respond_in_steps(hit, |_| {
        steps += 1;
        if steps == last {
            end = cpu();
        }
    })?;
    Ok(json!({ "ms": end - began, "peak": peak, "time": time, "steps": last }))
}

/// The cost of opinions, as a table.
fn opinions() -> Result<(), Box<dyn Error>> {
    println!(
        "| vehicle | direction | column | response [ms] | opinion [ms] | steps | evaluations | elements |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (name, soft) in [("rigid", None), ("front of 600 kN", Some(6e5))] {
        for degrees in [0.0, 10.0, 45.0, 90.0] {
            for (effects, all) in [("as the references", false), ("with all effects", true)] {
                let mut it = column("HEB220", 355e6, 1e-3);
                it.top_load = 0.5e6;
                it.top_spring_stiffness = 1e7;
                if all {
                    hit_by_a_car(&mut it);
                }
                let front = soft.map(|force| vehicle(1500.0, 1.5e6, Some(force)));
                let hit = hit(1500.0, 10.0, front, degrees);
                let model = BeamModel::new(&it)?;
                let began = cpu();
                model.respond(&hit)?;
                let response = cpu() - began;
                let began = cpu();
                let (found, _) = BeamModel::new(&it)?.simulate(&hit, None)?;
                let opinion = cpu() - began;
                println!(
                    "| {name} | {degrees} degrees | {effects} | {response:.1} | {opinion:.1} | {} | {} | {} |",
                    found.steps, found.evaluations, found.elements,
                );
            }
        }
    }
    Ok(())
}
