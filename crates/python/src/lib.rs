//! The native part of the Python package `column_twin`: it computes, and hands plain numbers, bytes and JSON to the Python
//! sources in `python/column_twin/`, which are the interface that users see.
//!
//! Whatever computes for longer than microseconds releases the GIL.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - batch.rs: Many impacts at once, in rows of bytes that numpy reads as a structured array
// - beam_columns.rs: What the fibre beam says of the cells of a map, as columns for Python
// - capacity.rs: The capacity of a column for Python
// - checks.rs: Checks of impacts by the one table of parameters, as on the command line
// - column.rs: A column for Python
// - fault.rs: Faults as Python exceptions, with the texts that the command line prints
// - history.rs: One impact with its history for Python
// - impacts.rs: Many impacts on one column: all of them are checked, and then computed
// - risk.rs: Risk studies for Python
// - sensors.rs: What the sensors of a column read, and what struck it by their readings
// - study.rs: Damage maps and critical velocities for Python
// - values.rs: Values from Python to Rust and back

mod batch;
mod beam_columns;
mod capacity;
mod checks;
mod column;
mod fault;
mod history;
mod impacts;
mod risk;
mod sensors;
mod study;
mod values;

use pyo3::prelude::*;

/// The native part of the package `column_twin`; use the package instead.
#[pymodule(name = "_native")]
mod native {
    use pyo3::prelude::*;

    use column_twin::assessment::Action;
    use column_twin::column::{HINGE_NAMES, HINGES};
    use column_twin::parameters::{CRITERION_NAMES, catalogue};
    use column_twin::shape::action_colour;

    use super::SectionRow;
    #[pymodule_export]
    use super::column::Column;

    /// Version of the package and of the library.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");

    /// The catalogue of vehicles with the source of every number, as JSON.
    #[pymodule_export]
    const VEHICLES_JSON: &str = include_str!("../../../config/vehicles.json");

    /// Bytes of one row of a batch.
    #[pymodule_export]
    const ROW_BYTES: usize = super::batch::ROW_BYTES;

    /// Bytes of one cell of a map.
    #[pymodule_export]
    const CELL_BYTES: usize = super::batch::CELL_BYTES;

    /// The colour of each action, least severe first, as the figures of the program have it: red, green, blue.
    #[pyfunction]
    fn action_colours() -> [[u8; 3]; 5] {
        [
            Action::None,
            Action::Inspect,
            Action::Restrict,
            Action::Shore,
            Action::Evacuate,
        ]
        .map(action_colour)
    }

    /// Names of the criteria, to which the numbers in a batch refer.
    #[pyfunction]
    fn criteria() -> Vec<&'static str> {
        CRITERION_NAMES.to_vec()
    }

    /// Names of the hinges, to which the numbers in a history refer.
    #[pyfunction]
    fn hinges() -> [&'static str; HINGES] {
        HINGE_NAMES
    }

    /// The catalogue of rolled sections: name, then h, b, tw, tf, r, A, I, W_pl and mass per length in SI units.
    #[pyfunction]
    fn sections() -> Vec<SectionRow> {
        catalogue().iter().map(super::section_row).collect()
    }
}

/// A section of the catalogue: its name and numbers in SI units.
type SectionRow = (String, [f64; 9]);

fn section_row(section: &column_twin::parameters::CatalogueSection) -> SectionRow {
    let (d, p) = (&section.dimensions, section.properties());
    let numbers = [
        d.depth,
        d.width,
        d.web_thickness,
        d.flange_thickness,
        d.root_radius,
        p.area,
        p.second_moment,
        p.plastic_modulus,
        p.mass_per_length,
    ];
    (section.name.clone(), numbers)
}
