//! Bytes as hexadecimal digits.

use std::fmt;

/// Writes bytes as two lower-case digits each, without separators.
#[derive(Debug, Clone, Copy)]
pub struct Hexadecimal<'a>(pub &'a [u8]);

impl fmt::Display for Hexadecimal<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_byte_has_two_digits() {
        assert_eq!(Hexadecimal(&[0, 0x0f, 0xa5]).to_string(), "000fa5");
        assert_eq!(Hexadecimal(&[]).to_string(), "");
    }
}
