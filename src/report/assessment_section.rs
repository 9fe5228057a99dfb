//! The residual capacity as a table.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::facts::fact;
use super::words::short;
use crate::column::{BucklingResistance, Capacity, CapacityEnd};
use crate::figures::units::{Unit, significant};

/// The residual capacity, undamaged against now.
pub(super) fn capacity(assessed: &Assessed) -> Markup {
    let remaining = &assessed.remaining;
    let force = |si: f64| Unit::force(si).show(si);
    let governs = |is_weak: bool| match is_weak {
        true => "the weak axis governs",
        false => "the plane of the impact governs",
    };
    html! {
        table.facts {
            tbody {
                (fact("Push-down of the undamaged column", capacity_in_words(&remaining.undamaged)))
                (fact("Push-down of the column as it is", capacity_in_words(&remaining.now)))
                (fact("Ratio, damage index", format!("{} of the undamaged column; D = {}", significant(remaining.ratio, 3), significant(remaining.damage, 3))))
                (fact("N_u", format!("{}: this ratio times the resistance about the strong axis", force(remaining.axial_capacity))))
                (fact("Reserve, N_u / N", remaining.reserve.map_or("none: no compressive load".to_owned(), |it| significant(it, 3))))
                (fact("Buckling resistance, strong axis", resistance(&remaining.strong)))
                (fact("Buckling resistance, weak axis", remaining.weak.as_ref().map_or(
                    "not known: the dimensions of the section are not given".to_owned(), resistance)))
                (fact("Remaining resistance", match (remaining.resistance, remaining.weak_axis_governs()) {
                    (Some(found), Some(is_weak)) => format!("{}; {}", force(found), governs(is_weak)),
                    _ => "not known without the weak axis".to_owned(),
                }))
            }
        }
        p.note {
            "The push-down finds the largest static force in the plane of the impact, with the plastic deformation as it is and a \
             bow of " (Unit::length(remaining.undamaged.imperfection).show(remaining.undamaged.imperfection))
            ". It is too stiff for slender columns, so that its ratio alone counts, times the buckling resistance of the code. The \
             model is plane: about the weak axis the same ratio is assumed to be left [A]."
        }
    }
}

fn capacity_in_words(capacity: &Capacity) -> String {
    let force = Unit::force(capacity.force).show(capacity.force);
    match capacity.end {
        CapacityEnd::NoEquilibrium => {
            "0 kN: the column has no equilibrium and carries nothing".to_owned()
        }
        _ if capacity.is_lower_bound() => {
            format!("at least {force}: the push-down could not be followed to its end")
        }
        _ => format!(
            "{force}, at a displacement of {}",
            Unit::length(capacity.v1).show(capacity.v1)
        ),
    }
}

fn resistance(resistance: &BucklingResistance) -> String {
    format!(
        "{} (EN 1993-1-1, 6.3.1: curve {}, buckling length {} m, slenderness {})",
        Unit::force(resistance.force).show(resistance.force),
        format!("{:?}", resistance.curve).to_lowercase(),
        short(resistance.buckling_length),
        significant(resistance.slenderness, 3),
    )
}
