//! Where the numbers of the report come from.

/// The program and its build.
pub(super) fn program() -> String {
    format!("column_twin {}", env!("CARGO_PKG_VERSION"))
}

/// The build, which decides the last bits of every number.
pub(super) fn build() -> Option<String> {
    #[cfg(feature = "record")]
    return Some(crate::evidence::build().to_owned());
    #[cfg(not(feature = "record"))]
    None
}
