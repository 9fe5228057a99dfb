//! Equal runs are equal bit for bit, on every processor; a saved run continues as if it had not been interrupted; mirrored
//! runs are mirrored; a step does not allocate.

mod example;

use column_mechanics::{
    BarForces, Impact, Model, PlasticFlow, Progress, Report, Response, Sample, State, StepError,
    begin_impact, simulate, step,
};
use example::example;
use serde::Serialize;
use serde_json::Value;

const SCHEMES: [&str; 2] = [
    "solver.scheme:=midpoint",
    "solver.scheme:=conserving_midpoint",
];

const DUAN_CHEN: [&str; 3] = [
    "yield_surface.alpha:=1.0",
    "yield_surface.beta:=1.3",
    "yield_surface.gamma:=1.0",
];

/// The bits of every number of some data, in the order of its fields.
fn bits(data: &impl Serialize) -> Vec<u64> {
    fn collect(value: &Value, into: &mut Vec<u64>) {
        match value {
            Value::Number(number) => {
                into.push(number.as_f64().expect("a number").to_bits());
            }
            Value::Array(values) => values.iter().for_each(|value| collect(value, into)),
            Value::Object(fields) => fields.values().for_each(|value| collect(value, into)),
            Value::Bool(flag) => into.push(u64::from(*flag)),
            Value::Null => into.push(u64::MAX),
            Value::String(_) => {}
        }
    }
    let mut all = Vec::new();
    collect(&serde_json::to_value(data).expect("plain data"), &mut all);
    all
}

/// Columns that reach every function of the mechanics: powers with common and uncommon exponents, both elastic laws,
/// damping, rebounds, a deformable vehicle of two masses, both laws of the strain rate, hardening.
const GOLDEN_COLUMNS: [&[&str]; 6] = [
    &[],
    &[
        "yield_surface.alpha:=1.0",
        "yield_surface.beta:=1.3",
        "yield_surface.gamma:=1.0",
        "hinge.elastic_law:=coupled",
        "damping.ratio:=0.02",
        "top.mass:=300.0",
    ],
    &[
        "yield_surface.alpha:=1.7",
        "yield_surface.beta:=2.6",
        "yield_surface.gamma:=1.9",
        "impact.restitution:=0.5",
        "impact.gap:=0.001",
    ],
    &[
        "vehicle.name:=lorry",
        "impact.velocity:=6.0",
        "impact.gap:=0.001",
    ],
    &[
        "yield_surface.alpha:=1.0",
        "yield_surface.beta:=1.3",
        "yield_surface.gamma:=1.0",
        "rate.law:=logarithmic",
        "hardening.ratio:=0.01",
    ],
    &[
        "yield_surface.alpha:=1.7",
        "yield_surface.beta:=2.6",
        "yield_surface.gamma:=1.0",
        "hinge.elastic_law:=coupled",
        "rate.law:=cowper_symonds",
    ],
];

/// A digest of each golden column's response with both schemes, every step and the report included. It changes with
/// every change of the last bit of any result, after which older recordings no longer verify.
const GOLDEN: [[u64; 2]; 6] = [
    [0x2ddf_506c_8ed9_dbb7, 0xf713_ccf2_f8fe_57fc],
    [0xb26b_2a48_9cc7_c909, 0x0439_76a2_4062_8f21],
    [0xaf92_6c80_f45b_0bbf, 0x3e6c_87f8_babd_c2fa],
    [0xb6f3_32a3_eff8_d507, 0x5a9e_ad86_33d8_3f0c],
    [0x1ec9_992f_7edc_5cf0, 0x5385_b26d_f156_c3de],
    [0x272e_21b5_c468_f4bc, 0xd360_2dc5_2617_18bc],
];

/// Fields that the report has gained since the digests were taken; they are no results of these rigid impacts,
/// or follow from the others.
const ADDED_FIELDS: [&str; 3] = ["vehicle", "max_dynamic_factor", "base"];

/// Digest of every step of a response and of its report.
fn digest(changes: &[&str]) -> u64 {
    let (properties, impact) = example(changes);
    let model = Model::new(&properties).expect("a column");
    let mut state = State::at_rest(&model);
    let mut response = Response::begin(&model, &mut state, impact, 0.05).expect("an impact");
    let mut digest = 0_u64;
    let mut add = |bits: u64| digest = digest.rotate_left(5).wrapping_mul(0x9e37_79b9) ^ bits;
    loop {
        let progress = response.advance(&model, &mut state, 1).expect("a step");
        add(state.hash());
        if let Progress::Over(end) = progress {
            let mut report =
                serde_json::to_value(response.report(&model, &state, end)).expect("plain data");
            let fields = report.as_object_mut().expect("an object");
            fields.retain(|name, _| !ADDED_FIELDS.contains(&name.as_str()));
            bits(&report).into_iter().for_each(add);
            return digest;
        }
    }
}

#[test]
fn golden_responses_have_their_bits() {
    let found =
        GOLDEN_COLUMNS.map(|column| SCHEMES.map(|scheme| digest(&[&[scheme], column].concat())));
    assert_eq!(found, GOLDEN, "found {found:#x?}");
    if std::env::var_os(SHOWS_POWERS).is_some() {
        println!("system powers {:x}", system_power());
    }
}

/// With this variable in its environment, the test of the golden responses prints the digest of the system's own powers.
const SHOWS_POWERS: &str = "COLUMN_MECHANICS_SHOWS_SYSTEM_POWERS";

/// The system's own powers, which choose their code by processor.
#[allow(
    clippy::disallowed_methods,
    reason = "what the mechanics must not call"
)]
fn system_power() -> u64 {
    (1..20_000).fold(0, |digest: u64, k| {
        let x = f64::from(k) / 20_000.0;
        digest.rotate_left(1) ^ x.powf(1.3).to_bits() ^ x.atan().to_bits()
    })
}

/// Runs the golden responses again in a process whose C library believes that the processor has neither FMA nor AVX2.
#[test]
#[cfg(all(target_arch = "x86_64", target_os = "linux", target_env = "gnu"))]
fn golden_responses_have_the_same_bits_without_fma_and_avx2() {
    let child = std::process::Command::new(std::env::current_exe().expect("this program"))
        .args(["--exact", "golden_responses_have_their_bits", "--nocapture"])
        .env(SHOWS_POWERS, "1")
        .env(
            "GLIBC_TUNABLES",
            "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-FMA_Usable,-AVX2_Usable",
        )
        .output()
        .expect("a child process");
    let output = String::from_utf8_lossy(&child.stdout);
    assert!(child.status.success(), "{output}");
    assert!(output.contains("1 passed"), "{output}");
    assert!(output.contains("system powers "), "{output}");
    if std::arch::is_x86_feature_detected!("fma") {
        // Otherwise the child would have proved nothing.
        let same = format!("system powers {:x}", system_power());
        assert!(
            !output.contains(&same),
            "the tunables had no effect: {output}"
        );
    }
}

/// Without its utilisations and dynamic factors a response is faster, and otherwise the same.
#[test]
fn a_response_that_is_not_observed_moves_as_one_that_is_bit_for_bit() {
    for column in GOLDEN_COLUMNS {
        let (properties, impact) = example(column);
        let model = Model::new(&properties).expect("a column");
        let mut state = State::at_rest(&model);
        let mut response = Response::begin(&model, &mut state, impact, 0.05).expect("an impact");
        let (mut other, mut unobserved) = (state, response);
        loop {
            let progress = response.advance(&model, &mut state, 1).expect("a step");
            let same = unobserved.advance_unobserved(&model, &mut other, 1, 1);
            assert_eq!((progress, state), (same.expect("a step"), other));
            if let Progress::Over(end) = progress {
                let [observed, found] = [
                    response.report(&model, &state, end),
                    unobserved.report(&model, &other, end),
                ];
                let motion =
                    |it: Report| (it.outcome, it.max_v1, it.residual_v1, it.impulse, it.base);
                assert_eq!(motion(observed), motion(found));
                assert!(observed.hinges[0].max_utilisation >= found.hinges[0].max_utilisation);
                break;
            }
        }
    }
}

#[test]
fn two_runs_are_equal_bit_for_bit() {
    for scheme in SCHEMES {
        for exponents in [&[][..], &DUAN_CHEN[..]] {
            let overrides = [
                &[scheme, "impact.restitution:=0.5", "impact.gap:=0.01"],
                exponents,
            ]
            .concat();
            let run = || {
                let (properties, impact) = example(&overrides);
                let mut samples: Vec<Vec<u64>> = Vec::new();
                let report = simulate(&properties, &impact, 0.06, &mut |sample: &Sample| {
                    samples.push(bits(sample));
                })
                .expect("a response");
                (bits(&report), samples)
            };
            let (first, second) = (run(), run());
            assert!(first.1.len() > 1_000);
            assert!(first == second, "{scheme}");
        }
    }
}

#[test]
fn equal_runs_have_equal_hashes_and_different_runs_do_not() {
    let hashes = |velocity: f64| {
        let (properties, impact) = example(&[]);
        let model = Model::new(&properties).expect("a column");
        let mut state = State::at_rest(&model);
        begin_impact(&model, &mut state, Impact { velocity, ..impact }).expect("an impact");
        (0..1_000)
            .map(|_| {
                step(&model, &mut state).expect("a step");
                state.hash()
            })
            .collect::<Vec<_>>()
    };
    let (first, second) = (hashes(10.0), hashes(10.0));
    assert_eq!(first, second);
    let next = hashes(10.0_f64.next_up());
    assert!(first.iter().zip(&next).all(|(one, other)| one != other));
}

/// Saved to text and read back at many instants: in the approach, in contact, after release.
#[test]
fn a_continued_run_equals_the_uninterrupted_one() {
    let columns: [&[&str]; 2] = [
        &[
            "impact.restitution:=0.3",
            "damping.ratio:=0.01",
            "top.mass:=500.0",
        ],
        &["vehicle.name:=lorry", "solver.dt:=1.0e-4"],
    ];
    for (scheme, column) in SCHEMES
        .into_iter()
        .flat_map(|scheme| columns.map(|column| (scheme, column)))
    {
        let (properties, impact) = example(&[&[scheme, "impact.gap:=0.001"], column].concat());
        let model = Model::new(&properties).expect("a column");
        let mut state = State::at_rest(&model);
        let mut response = Response::begin(&model, &mut state, impact, 0.2).expect("an impact");
        let (mut other_state, mut other_response) = (state, response);
        let mut saves = 0;
        loop {
            if state.step.is_multiple_of(7) {
                let saved = serde_json::to_string(&(&other_state, &other_response)).expect("saved");
                let read: (State, Response) = serde_json::from_str(&saved).expect("read");
                assert_eq!(
                    bits(&read),
                    bits(&(&state, &response)),
                    "step {}",
                    state.step
                );
                (other_state, other_response) = read;
                saves += 1;
            }
            let progress = response.advance(&model, &mut state, 1).expect("a step");
            let other = other_response
                .advance(&model, &mut other_state, 1)
                .expect("a step");
            assert_eq!(progress, other);
            assert_eq!(bits(&state), bits(&other_state), "step {}", state.step);
            assert_eq!(state.hash(), other_state.hash());
            if let Progress::Over(end) = progress {
                assert_eq!(
                    bits(&response.report(&model, &state, end)),
                    bits(&other_response.report(&model, &other_state, end))
                );
                break;
            }
        }
        assert!(saves > 100);
    }
}

/// The approach in one macro-step and in single steps leads to the same.
#[test]
fn coasting_in_one_macro_step_or_in_steps_is_the_same() {
    for (scheme, vehicle) in SCHEMES
        .into_iter()
        .flat_map(|scheme| [&[][..], &["vehicle.name:=lorry"]].map(|vehicle| (scheme, vehicle)))
    {
        let (properties, impact) = example(&[&[scheme, "impact.gap:=0.1"], vehicle].concat());
        let model = Model::new(&properties).expect("a column");
        let run = |macro_step: u64| {
            let mut state = State::at_rest(&model);
            let mut response =
                Response::begin(&model, &mut state, impact, 0.03).expect("an impact");
            while let Progress::Running = response
                .advance(&model, &mut state, macro_step)
                .expect("a step")
            {}
            (bits(&state), bits(&response))
        };
        assert_eq!(run(1), run(u64::MAX), "{scheme}");
    }
}

/// The bits of a state with every transverse quantity multiplied by `sign`; adding zero makes -0 and 0 the same.
fn mirrored(state: &State, sign: f64) -> Vec<u64> {
    let u = &state.displacement;
    let mut numbers = vec![
        sign * u.v1,
        u.u1,
        sign * u.beta1,
        u.u2,
        sign * state.velocity.v1,
        state.velocity.u1,
        state.velocity.u2,
        state.ledger.plastic_work,
        state.ledger.damping_work,
    ];
    let bar = |forces: &BarForces, plastic: &PlasticFlow| {
        [
            forces.normal,
            sign * forces.moment[0],
            sign * forces.moment[1],
            plastic.elongation[0],
            plastic.elongation[1],
            sign * plastic.rotation[0],
            sign * plastic.rotation[1],
        ]
    };
    numbers.extend(bar(&state.forces.below, &state.plastic.below));
    numbers.extend(bar(&state.forces.above, &state.plastic.above));
    numbers.into_iter().map(|x| (x + 0.0).to_bits()).collect()
}

#[test]
fn mirrored_motions_are_mirrored_bit_for_bit() {
    let columns: [&[&str]; 5] = [
        &[],
        &DUAN_CHEN,
        &["rate.law:=logarithmic", "hardening.ratio:=0.01"],
        &[
            "yield_surface.alpha:=1.0",
            "yield_surface.beta:=1.0",
            "top.mass:=200.0",
        ],
        &[
            "hinge.elastic_law:=coupled",
            "damping.ratio:=0.02",
            "support.top:=pinned",
        ],
    ];
    for scheme in SCHEMES {
        for column in columns {
            let (properties, _) = example(&[&[scheme], column].concat());
            let model = Model::new(&properties).expect("a column");
            let start = |speed: f64| {
                let mut state = State::at_rest(&model);
                state.velocity.v1 = speed;
                state
            };
            let (mut one, mut other) = (start(20.0), start(-20.0));
            for number in 0..2_000 {
                step(&model, &mut one).expect("a step");
                step(&model, &mut other).expect("a step");
                assert_eq!(
                    mirrored(&one, 1.0),
                    mirrored(&other, -1.0),
                    "{scheme} {column:?} step {number}"
                );
            }
            assert!(one.ledger.plastic_work > 0.0);
        }
    }
}

#[test]
fn a_step_does_not_allocate() {
    let columns: [&[&str]; 6] = [
        &[],
        &DUAN_CHEN,
        &["rate.law:=cowper_symonds", "hardening.ratio:=0.01"],
        &[
            "vehicle.name:=lorry",
            "impact.velocity:=2.0",
            "solver.dt:=1.0e-3",
        ],
        &[
            "impact.restitution:=0.9",
            "impact.gap:=0.02",
            "top.mass:=100.0",
            "damping.ratio:=0.05",
        ],
        // Corners of the surface and a load near the squash load: line search, halvings, collapse.
        &[
            "yield_surface.alpha:=1.0",
            "yield_surface.beta:=1.0",
            "top.spring_stiffness:=0.0",
            "top.load:=3.0e+6",
            "impact.mass:=20000.0",
            "solver.dt:=1.0e-3",
        ],
    ];
    for scheme in SCHEMES {
        for column in columns {
            let (properties, impact) = example(&[&[scheme, "solver.dt:=5.0e-5"], column].concat());
            let model = Model::new(&properties).expect("a column");
            let mut state = State::at_rest(&model);
            let mut response = Response::begin(&model, &mut state, impact, 1.0).expect("an impact");
            let (initial, mut steps) = (state, 0);
            let followed = allocation_counter::measure(|| {
                while steps < 1_000 {
                    steps += 1;
                    if response.advance(&model, &mut state, 1) != Ok(Progress::Running) {
                        break;
                    }
                }
            });
            assert_eq!(followed.count_total, 0, "{scheme} {column:?}");
            let mut state = initial;
            let mut last = Ok(());
            let stepped = allocation_counter::measure(|| {
                for _ in 0..1_000 {
                    last = step(&model, &mut state);
                    if last.is_err() {
                        break;
                    }
                }
            });
            assert_eq!(stepped.count_total, 0, "{scheme} {column:?}");
            assert!(
                matches!(last, Ok(()) | Err(StepError::Collapsed(_))),
                "{last:?}"
            );
            let separated = state.impactor.expect("an impactor").released_at.is_some();
            println!("{scheme} {column:?}: {steps} steps, {last:?}, separated {separated}");
            assert!(separated || last.is_err(), "{scheme} {column:?}");
        }
    }
}
