//! Consistency of the parameters of a verdict: its load and its buckling lengths.

use crate::parameters::inconsistency::Inconsistency;
use crate::parameters::section::dimensions_of;
use crate::parameters::settings::Settings;

/// A limit of redistribution counts only with a spring that takes the load and with a proof.
pub(super) fn redistribution_is_proven(settings: &Settings, found: &mut Vec<Inconsistency>) {
    const LIMIT: &str = "top.redistribution_limit";
    const PROOF: &str = "top.redistribution_proof";
    const SPRING: &str = "top.spring_stiffness";
    let top = &settings.top;
    let has_limit = top.redistribution_limit > 0.0;
    let has_proof = !top.redistribution_proof.trim().is_empty();
    let mut reject = |names: &[&'static str], message: &str| {
        found.push(Inconsistency {
            names: names.to_vec(),
            message: message.to_owned(),
        });
    };
    if has_limit && !has_proof {
        reject(
            &[PROOF, LIMIT],
            "is required, because top.redistribution_limit is given; name the proof, or omit the limit: nothing then counts",
        );
    }
    if has_proof && !has_limit {
        reject(
            &[LIMIT, PROOF],
            "is required, because top.redistribution_proof is given; give the force in N that is proven, or omit the proof",
        );
    }
    if has_limit && top.spring_stiffness == 0.0 {
        reject(
            &[SPRING, LIMIT],
            "is 0, so that nothing is redistributed; give the stiffness in N/m of the structure that takes the load, or omit \
             top.redistribution_limit",
        );
    }
}

/// Of a weak axis that is not known there is no buckling length.
pub(super) fn weak_axis_is_known(settings: &Settings, found: &mut Vec<Inconsistency>) {
    if settings.capacity.buckling_factor_weak > 0.0 && dimensions_of(&settings.section).is_none() {
        found.push(Inconsistency {
            names: vec![
                "capacity.buckling_factor_weak",
                "section.name",
                "section.area",
                "section.second_moment",
            ],
            message:
                "has no effect, because the resistance about the weak axis of a user-defined section is not known; give \
                 section.name without overriding its properties, or omit the factor"
                    .to_owned(),
        });
    }
}
