//! The equations of the paper, implemented a second time from the angles and compared with the core: elastic law
//! (Eqs 22-25), internal forces (Eqs 10, 16), equations of motion in the discrete form of the conserving midpoint rule
//! (`docs/theory.md`, section 5), static equilibrium.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

mod example;

use column_mechanics::{
    BarForces, ColumnProperties, Displacement, Model, PlasticFlow, Progress, Response, Sample,
    State, begin_impact, residual_state, step,
};
use example::example;

/// A bar's chord: extent along the column, across it, length, angle.
#[derive(Clone, Copy)]
struct Chord {
    x: f64,
    v: f64,
    length: f64,
    angle: f64,
}

/// Derivatives of a chord's length and angle with respect to its extents, or their finite counterparts.
struct Gradient {
    length: [f64; 2],
    angle: [f64; 2],
}

/// Chords of bars a and b (Eqs 3, 4, 7, 8).
fn chords(p: &ColumnProperties, u: &Displacement) -> [Chord; 2] {
    [p.length_below - u.u1, p.length_above + u.u1 - u.u2].map(|x| Chord {
        x,
        v: u.v1,
        length: x.hypot(u.v1),
        angle: u.v1.atan2(x),
    })
}

/// Eq 10.
fn gradient(chord: &Chord) -> Gradient {
    let (sin, cos) = chord.angle.sin_cos();
    Gradient {
        length: [cos, sin],
        angle: [-sin / chord.length, cos / chord.length],
    }
}

/// `Delta l = 2 r_m . Delta r / (l_n + l_{n+1})`,
/// `Delta theta = (Delta theta / sin Delta theta) (r_m x Delta r) / (l_n l_{n+1})`.
fn discrete_gradient(from: &Chord, to: &Chord) -> Gradient {
    let (x, v) = ((from.x + to.x) / 2.0, (from.v + to.v) / 2.0);
    let turn = to.angle - from.angle;
    let ratio = if turn.abs() < 1e-4 {
        1.0 + turn * turn / 6.0
    } else {
        turn / turn.sin()
    };
    let (sum, area) = (from.length + to.length, from.length * to.length);
    Gradient {
        length: [2.0 * x / sum, 2.0 * v / sum],
        angle: [-v * ratio / area, x * ratio / area],
    }
}

/// `B^T S` on `v1, u1, beta1, u2`, and the sum of the absolute terms of each.
fn internal_forces(
    p: &ColumnProperties,
    [a, b]: &[Gradient; 2],
    [below, above]: [BarForces; 2],
    spring_u2: f64,
) -> [(f64, f64); 4] {
    let [m_1a, m_3] = below.moment;
    let [m_1b, m_2] = above.moment;
    let terms: [Vec<f64>; 4] = [
        vec![
            below.normal * a.length[1],
            (m_1a + m_3) * a.angle[1],
            above.normal * b.length[1],
            (m_1b + m_2) * b.angle[1],
        ],
        vec![
            -below.normal * a.length[0],
            -(m_1a + m_3) * a.angle[0],
            above.normal * b.length[0],
            (m_1b + m_2) * b.angle[0],
        ],
        vec![m_1b, -m_1a],
        vec![
            p.top_spring_stiffness * spring_u2,
            -above.normal * b.length[0],
            -(m_1b + m_2) * b.angle[0],
        ],
    ];
    terms.map(|terms| {
        (
            terms.iter().sum(),
            terms.iter().map(|term| term.abs()).sum(),
        )
    })
}

/// Forces of both bars from the uncoupled springs `6 EI/L` and `EA/L` (Eqs 47-50) and the plastic deformation.
fn elastic_forces(p: &ColumnProperties, state: &State) -> [BarForces; 2] {
    let u = &state.displacement;
    let [a, b] = chords(p, u);
    let bar = |chord: Chord, length: f64, turn: f64, plastic: &PlasticFlow| {
        let spring = 6.0 * p.bending_stiffness / length;
        let elongation = chord.length - length - plastic.elongation[0] - plastic.elongation[1];
        BarForces {
            normal: p.axial_rigidity / length * elongation,
            moment: [
                spring * (chord.angle + turn - plastic.rotation[0]),
                spring * (chord.angle - plastic.rotation[1]),
            ],
        }
    };
    [
        bar(a, p.length_below, -u.beta1, &state.plastic.below),
        bar(b, p.length_above, u.beta1, &state.plastic.above),
    ]
}

fn mean(one: &BarForces, other: &BarForces) -> BarForces {
    BarForces {
        normal: 0.5 * (one.normal + other.normal),
        moment: [0, 1].map(|k| 0.5 * (one.moment[k] + other.moment[k])),
    }
}

fn largest(worst: &mut f64, value: f64) {
    assert!(value.is_finite());
    *worst = worst.max(value);
}

/// Columns of the paper's kind, undamaged and without damping.
const COLUMNS: [&[&str]; 4] = [
    &[],
    &[
        "yield_surface.alpha:=1.0",
        "yield_surface.beta:=1.3",
        "yield_surface.gamma:=1.0",
    ],
    &["top.mass:=300.0", "impact.restitution:=0.4"],
    &[
        "geometry.length_below:=2.5",
        "geometry.length_above:=1.5",
        "top.spring_stiffness:=0.0",
        "top.load:=0.2e+6",
        "impact.velocity:=6.0",
    ],
];

#[test]
fn conserving_midpoint_satisfies_the_equations_of_motion_over_every_smooth_step() {
    for column in COLUMNS {
        let (p, impact) = example(column);
        let model = Model::new(&p).expect("a column");
        let mass = p.mass_per_length * (p.length_below + p.length_above) / 3.0;
        let mut state = State::at_rest(&model);
        begin_impact(&model, &mut state, impact).expect("an impact");
        let (mut checked, mut motion, mut law) = (0, [0.0; 4], 0.0);
        for _ in 0..3_000 {
            let before = state;
            step(&model, &mut state).expect("a step");
            let [was, is] = [before, state].map(|s| s.impactor.expect("an impactor"));
            let events = state.impact_impulse > 0.0 || was.released_at != is.released_at;
            if events || was.closed != is.closed {
                continue;
            }
            checked += 1;
            let secs = p.step_nanos as f64 * 1e-9;
            let moving = mass + if is.closed { is.impact.mass } else { 0.0 };
            let [from, to] = [&before, &state].map(|s| chords(&p, &s.displacement));
            let gradients = [0, 1].map(|k| discrete_gradient(&from[k], &to[k]));
            let forces = [
                mean(&before.forces.below, &state.forces.below),
                mean(&before.forces.above, &state.forces.above),
            ];
            let u2 = 0.5 * (before.displacement.u2 + state.displacement.u2);
            let internal = internal_forces(&p, &gradients, forces, u2);
            let (v, w) = (&before.velocity, &state.velocity);
            let inertia = [
                moving * (w.v1 - v.v1) / secs,
                mass * (w.u1 - v.u1) / secs,
                0.0,
                p.top_mass * (w.u2 - v.u2) / secs,
            ];
            let momentum = [moving * v.v1, mass * v.u1, 0.0, p.top_mass * v.u2];
            for row in 0..4 {
                let load = if row == 3 { p.top_load } else { 0.0 };
                let (force, terms) = internal[row];
                // An acceleration is a difference of momenta, which are therefore terms of the balance, too.
                let scale = terms + load + momentum[row].abs() / secs;
                largest(
                    &mut motion[row],
                    (inertia[row] + force - load).abs() / scale,
                );
            }
            let moved = state.displacement.v1 - before.displacement.v1;
            let rate = 0.5 * (v.v1 + w.v1);
            assert!((moved - secs * rate).abs() <= 1e-15 + 1e-9 * moved.abs());
            let [below, above] = elastic_forces(&p, &state);
            for (found, expected) in [(state.forces.below, below), (state.forces.above, above)] {
                largest(
                    &mut law,
                    (found.normal - expected.normal).abs() / p.resistance_axial,
                );
                for k in 0..2 {
                    let error = found.moment[k] - expected.moment[k];
                    largest(&mut law, error.abs() / p.resistance_moment);
                }
            }
        }
        let shown = motion.map(|residual| format!("{residual:.1e}")).join(", ");
        println!("{column:?}: {checked} steps, motion {shown}, elastic law {law:.1e}");
        assert!(checked > 2_900);
        assert!(motion.iter().all(|&residual| residual <= 1e-9));
        assert!(law <= 1e-9);
        assert!(state.ledger.plastic_work > 0.0);
    }
}

/// Largest of the four equations of equilibrium (Eq 16) of a sample's forces, relative to their terms.
fn out_of_balance(p: &ColumnProperties, sample: &Sample) -> f64 {
    let u = Displacement {
        v1: sample.v1,
        u1: sample.u1,
        beta1: sample.beta1,
        u2: sample.u2,
    };
    let [below, above, top, base] = sample.hinges;
    assert_eq!(below.normal_force, base.normal_force);
    assert_eq!(above.normal_force, top.normal_force);
    let forces = [(below, base), (above, top)].map(|(joint, end)| BarForces {
        normal: joint.normal_force,
        moment: [joint.moment, end.moment],
    });
    let gradients = chords(p, &u).map(|chord| gradient(&chord));
    let internal = internal_forces(p, &gradients, forces, u.u2);
    let loads = [0.0, 0.0, 0.0, p.top_load];
    // Forces are compared with forces, the moment with the resistance of the hinges.
    let force = internal[1].1 + internal[3].1 + p.top_load;
    let scales = [force, force, p.resistance_moment, force];
    (0..4)
        .map(|row| (internal[row].0 - loads[row]).abs() / scales[row])
        .fold(0.0, f64::max)
}

#[test]
fn residual_state_is_a_static_equilibrium() {
    for scheme in [
        "solver.scheme:=midpoint",
        "solver.scheme:=conserving_midpoint",
    ] {
        for column in COLUMNS {
            let (p, impact) = example(&[&[scheme], column].concat());
            let model = Model::new(&p).expect("a column");
            let mut state = State::at_rest(&model);
            let mut response = Response::begin(&model, &mut state, impact, 0.5).expect("an impact");
            let end = loop {
                if let Progress::Over(end) = response
                    .advance(&model, &mut state, u64::MAX)
                    .expect("a step")
                {
                    break end;
                }
            };
            let rest = residual_state(&model, &state).expect("an equilibrium");
            let sample = rest.sample(&model);
            let residual = out_of_balance(&p, &sample);
            println!(
                "{scheme} {column:?}: residual v1 {:.6} m, out of balance {residual:.1e}",
                sample.v1
            );
            assert!(residual <= 1e-9);
            assert!(sample.v1 > 1e-3);
            assert_eq!(rest.plastic, state.plastic);
            assert_eq!((sample.v1_rate, sample.u1_rate), (0.0, 0.0));
            let report = response.report(&model, &state, end);
            assert_eq!(report.residual_v1, Some(sample.v1));
            // The balance distinguishes an equilibrium from a state in motion.
            assert!(out_of_balance(&p, &state.sample(&model)) > 1e-6);

            // Stepped without an impactor, it stays where it is.
            let mut later = rest;
            for _ in 0..500 {
                step(&model, &mut later).expect("a step");
            }
            let moved = (later.displacement.v1 - sample.v1).abs();
            assert!(moved <= 1e-10 && !later.is_flowing(), "{moved}");
        }
    }
}
