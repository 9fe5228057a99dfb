//! The paper's example (Table 1).

use column_mechanics::{
    ColumnProperties, CrushCurve, CrushSpring, ElasticLaw, Impact, RateLaw, RateProperties, Scheme,
    Support, Vehicle, YieldExponents,
};

/// The paper's column and impact, with the conserving midpoint rule and steps of 20 microseconds.
pub fn paper() -> (ColumnProperties, Impact) {
    let young_modulus = 210.0e9;
    let properties = ColumnProperties {
        length_below: 1.0,
        length_above: 3.0,
        axial_rigidity: young_modulus * 91.0e-4,
        bending_stiffness: young_modulus * 8091.0e-8,
        mass_per_length: 70.1,
        resistance_moment: 0.307e6,
        resistance_axial: 3.23e6,
        yield_surface: YieldExponents {
            alpha: 2.0,
            beta: 2.0,
            gamma: 2.0,
        },
        elastic_law: ElasticLaw::Uncoupled,
        base: Support::BuiltIn,
        top: Support::BuiltIn,
        hinge_stiffness: [None; 4],
        top_spring_stiffness: 10.0e6,
        top_mass: 0.0,
        top_load: 0.5e6,
        damping_ratio: 0.0,
        rate: None,
        hardening_ratio: 0.0,
        softening: None,
        base_connection: None,
        ultimate_rotation: 0.0,
        shear: None,
        scheme: Scheme::ConservingMidpoint,
        step_nanos: 20_000,
    };
    let impact = Impact {
        mass: 1500.0,
        velocity: 10.0,
        gap: 0.0,
        restitution: 0.0,
        vehicle: None,
        bumper_height: 0.0,
        transverse_force: 0.0,
    };
    (properties, impact)
}

/// A lorry of 8 t whose cargo slides before it strikes the cab.
#[allow(dead_code, reason = "not every test needs a vehicle")]
pub fn lorry() -> Vehicle {
    let spring = |points: &[[f64; 2]], unloading_stiffness, slack| CrushSpring {
        envelope: CrushCurve::new(points).expect("a curve"),
        unloading_stiffness,
        slack,
    };
    let front = [
        [0.3, 300e3],
        [0.6, 500e3],
        [0.7, 1500e3],
        [0.9, 1500e3],
        [1.0, 800e3],
        [2.0, 1000e3],
    ];
    let cargo = [[0.4 / 3.0, 400e3], [1.0, 400e3]];
    let springs = [spring(&front, 15e6, 0.0), spring(&cargo, 6e6, 0.05)];
    Vehicle::new(&[5500.0, 2500.0], &springs).expect("a vehicle")
}

/// Strain rate of a section of 220 mm by a law.
fn rate(law: RateLaw) -> RateProperties {
    RateProperties {
        law,
        time_constant: 1e-3,
        max_factor: 1.25,
        hinge_length: 0.22,
        section_height: 0.22,
    }
}

/// Strain rate after the CEB for S355, `f_y + 6 MPa ln(e / 5e-5)`.
#[allow(dead_code, reason = "not every test needs it")]
pub fn ceb() -> RateProperties {
    rate(RateLaw::Logarithmic {
        c: 6.0 / 355.0,
        reference: 5e-5,
    })
}

/// The paper's example with some values changed, `name:=value` each, by the names of the program's parameters.
#[allow(dead_code, reason = "not every test changes values by name")]
pub fn example(changes: &[&str]) -> (ColumnProperties, Impact) {
    let (mut p, mut impact) = paper();
    for change in changes {
        let (name, value) = change.split_once(":=").expect("name:=value");
        let number = || value.parse::<f64>().expect("a number");
        match name {
            "geometry.length_below" => p.length_below = number(),
            "geometry.length_above" => p.length_above = number(),
            "yield_surface.alpha" => p.yield_surface.alpha = number(),
            "yield_surface.beta" => p.yield_surface.beta = number(),
            "yield_surface.gamma" => p.yield_surface.gamma = number(),
            "hinge.elastic_law" if value == "coupled" => p.elastic_law = ElasticLaw::Coupled,
            "hinge.elastic_law" if value == "uncoupled" => p.elastic_law = ElasticLaw::Uncoupled,
            "support.top" if value == "pinned" => p.top = Support::Pinned,
            "top.spring_stiffness" => p.top_spring_stiffness = number(),
            "top.mass" => p.top_mass = number(),
            "top.load" => p.top_load = number(),
            "damping.ratio" => p.damping_ratio = number(),
            "rate.law" if value == "logarithmic" => p.rate = Some(ceb()),
            "rate.law" if value == "cowper_symonds" => {
                p.rate = Some(rate(RateLaw::CowperSymonds { d: 3200.0, q: 5.0 }));
            }
            "hardening.ratio" => p.hardening_ratio = number(),
            "impact.mass" => impact.mass = number(),
            "impact.velocity" => impact.velocity = number(),
            "impact.gap" => impact.gap = number(),
            "impact.restitution" => impact.restitution = number(),
            "impact.transverse_force" => impact.transverse_force = number(),
            "vehicle.name" if value == "lorry" => {
                impact.vehicle = Some(lorry());
                impact.mass = lorry().total_mass();
            }
            "solver.scheme" if value == "midpoint" => p.scheme = Scheme::Midpoint,
            "solver.scheme" if value == "conserving_midpoint" => {
                p.scheme = Scheme::ConservingMidpoint;
            }
            "solver.dt" => p.step_nanos = (number() * 1e9).round() as u64,
            _ => panic!("unknown change: {change}"),
        }
    }
    (p, impact)
}
