//! The Rust side of `overhead.py`: reads commands from the standard input, one per line, and answers each with seconds and a
//! checksum, so that both languages take turns on the same machine.
//!
//! `batch VEHICLE COUNT FROM TO THREADS`: a batch of impacts of a vehicle's own mass at equal steps of velocity \[m/s\].
//! `single VEHICLE COUNT VELOCITY`: so many impacts, one after another.

use std::error::Error;
use std::io::{self, BufRead, Write};
use std::num::NonZeroUsize;
use std::time::Instant;

use column_twin::parameters::Parameters;
use column_twin::study::{Batch, StudyColumn};

fn main() -> Result<(), Box<dyn Error>> {
    // `cargo bench` without arguments of ours: nothing to compare with.
    if !std::env::args().any(|argument| argument == "--serve") {
        println!("run crates/python/benches/overhead.py, which compares Rust and Python in turns");
        return Ok(());
    }
    let column = StudyColumn::undamaged(&Parameters::default())?;
    let mut output = io::stdout();
    for line in io::stdin().lock().lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let (seconds, sum) = match words.as_slice() {
            ["batch", vehicle, count, from, to, threads] => {
                let (count, from, to): (u64, f64, f64) =
                    (count.parse()?, from.parse()?, to.parse()?);
                many(&column, vehicle, count, [from, to], threads.parse()?)?
            }
            ["single", vehicle, count, velocity] => {
                one_by_one(&column, vehicle, count.parse()?, velocity.parse()?)?
            }
            _ => return Err(format!("expected batch or single; found {line}").into()),
        };
        writeln!(output, "{seconds:e} {sum:e}")?;
        output.flush()?;
    }
    Ok(())
}

fn many(
    column: &StudyColumn,
    vehicle: &str,
    count: u64,
    [from, to]: [f64; 2],
    threads: usize,
) -> Result<(f64, f64), Box<dyn Error>> {
    let start = Instant::now();
    let mut batch = Batch::default();
    batch.threads = NonZeroUsize::new(threads);
    let mut sum = 0.0;
    let step = (to - from) / (count - 1) as f64;
    batch.run(
        count,
        |index| {
            let impact = column.impact(Some(vehicle), None, from + step * index as f64)?;
            column.evaluate(&impact)
        },
        |evaluations| -> Result<(), Box<dyn Error>> {
            for evaluation in evaluations {
                sum += evaluation?.max_v1;
            }
            Ok(())
        },
    )?;
    Ok((start.elapsed().as_secs_f64(), sum))
}

fn one_by_one(
    column: &StudyColumn,
    vehicle: &str,
    count: u64,
    velocity: f64,
) -> Result<(f64, f64), Box<dyn Error>> {
    let start = Instant::now();
    let mut sum = 0.0;
    for _ in 0..count {
        let impact = column.impact(Some(vehicle), None, velocity)?;
        sum += column.evaluate(&impact)?.max_v1;
    }
    Ok((start.elapsed().as_secs_f64(), sum))
}
