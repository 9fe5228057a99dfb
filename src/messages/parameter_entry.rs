//! One parameter of a message.

/// One parameter in a [`ColumnParameters`](super::column_twin_msgs::ColumnParameters) message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterEntry<'a> {
    /// A number; NaN leaves the parameter unchanged.
    Number(f64),
    /// A name or a choice; an empty text leaves the parameter unchanged.
    Text(&'a str),
}

impl ParameterEntry<'_> {
    /// Whether the parameter is left unchanged. An infinite number is a value, which is rejected later.
    pub fn is_unchanged(self) -> bool {
        match self {
            Self::Number(number) => number.is_nan(),
            Self::Text(text) => text.is_empty(),
        }
    }
}
