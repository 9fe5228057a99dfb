//! Results under the names that programs see, which are a stable interface: the JSON of the command line, and the Python package.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - beam_fields.rs: What the fibre beam says of an impact, under the names that programs see
// - capacity_fields.rs: The capacity of a column under the names that programs see
// - impact_fields.rs: The outcome of one impact under the names that programs see

// The fields that programs see of something, each with its value. Before them stand what they are of and what the values share.
macro_rules! fields {
    ($(#[$about:meta])* $vis:vis struct $name:ident $(<$lifetime:lifetime>)? of($($from:ident: $of:ty),*) { $($shared:tt)* }
     $($(#[$meaning:meta])* $field:ident: $type:ty = $value:expr;)*) => {
        $(#[$about])*
        #[derive(Debug, Serialize)]
        $vis struct $name $(<$lifetime>)? {
            $($(#[$meaning])* $field: $type),*
        }

        impl $(<$lifetime>)? $name $(<$lifetime>)? {
            /// The fields of this.
            #[must_use]
            $vis fn of($($from: $of),*) -> Self {
                $($shared)*
                Self { $($field: $value),* }
            }
        }
    };
}

mod beam_fields;
mod capacity_fields;
mod impact_fields;

pub use beam_fields::BeamAnswer;
pub use capacity_fields::CapacityFields;
pub use impact_fields::{ImpactFields, Travel, outcome_word};
