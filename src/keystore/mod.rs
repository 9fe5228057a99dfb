//! What the enclaves of twins, of monitors and of operators may do: keystores of the crate `sros2_keystore` for the topics and services
//! of this program.
//!
//! The permissions follow from the one table of [`endpoints`](crate::endpoints).

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - plan.rs: Which enclaves a keystore for some twins needs
// - role.rs: What an enclave is for, and what its programs may therefore do
// - zenoh.rs: The same permissions as configurations of Zenoh: of a router that grants them by certificate, and of the sessions
//   that connect to it

mod plan;
mod role;
mod zenoh;

pub use plan::{PlanError, PlannedEnclave, Twins, plan};
pub use role::{Role, access};
pub use zenoh::ZenohSite;

/// Common name of the authority of a keystore.
pub const AUTHORITY_NAME: &str = "column_twin CA";

/// What the policy file for `ros2 security` says of its origin.
pub const POLICY_ORIGIN: &str =
    "Made by `column-twin keystore policy` from the table of the node's topics and services.";
