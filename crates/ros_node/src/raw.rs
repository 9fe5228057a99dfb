//! Messages as encoded bytes.

use std::fmt;
use std::sync::Arc;

use serde::de::{SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Encapsulation header of plain CDR, little endian, which RustDDS writes and peers on common processors send.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// The bytes of a message, including the encapsulation header.
///
/// The serde implementations are for CDR only: they write the bytes after the header unchanged, and read all remaining
/// bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Raw(Arc<[u8]>);

/// The bytes have another encapsulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected plain CDR, little endian (00 01), found the first bytes {0:02x?}; rewrite the recording with that encoding"
)]
pub struct NotPlainCdr([u8; 2]);

impl Raw {
    /// From bytes that begin with the header of plain CDR, little endian.
    ///
    /// # Errors
    /// They begin with another header, which would differ from the one on the wire.
    pub fn new(bytes: Arc<[u8]>) -> Result<Self, NotPlainCdr> {
        match *bytes {
            [0, 1, _, _, ..] => Ok(Self(bytes)),
            [first, second, ..] => Err(NotPlainCdr([first, second])),
            _ => Err(NotPlainCdr([0; 2])),
        }
    }

    /// All bytes, including the header.
    #[must_use]
    pub fn bytes(&self) -> &Arc<[u8]> {
        &self.0
    }
}

impl Serialize for Raw {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // Single bytes have neither length prefix nor alignment in CDR.
        let content = &self.0[HEADER.len()..];
        let mut tuple = serializer.serialize_tuple(content.len())?;
        for byte in content {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

impl<'de> Deserialize<'de> for Raw {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct All;
        impl<'de> Visitor<'de> for All {
            type Value = Raw;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("bytes")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut bytes: A) -> Result<Raw, A::Error> {
                let mut all = HEADER.to_vec();
                // The end of the input is an error for a CDR reader; here it ends the message.
                while let Ok(Some(byte)) = bytes.next_element::<u8>() {
                    all.push(byte);
                }
                Ok(Raw(all.into()))
            }
        }
        deserializer.deserialize_tuple(usize::MAX, All)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use byteorder::LittleEndian;

    #[test]
    fn bytes_are_unchanged() {
        let bytes: Arc<[u8]> = [&HEADER[..], &[7, 0, 255, 3, 9]].concat().into();
        let raw = Raw::new(Arc::clone(&bytes)).expect("plain");
        let mut written = HEADER.to_vec();
        cdr_encoding::to_writer::<_, LittleEndian, _>(&mut written, &raw).expect("written");
        assert_eq!(*written, *bytes);
        let (read, _) = cdr_encoding::from_bytes::<Raw, LittleEndian>(&written[4..]).expect("read");
        assert_eq!(read, raw);
    }

    #[test]
    fn other_encapsulations_are_rejected() {
        for bytes in [&[0, 0, 0, 0, 1][..], &[0, 7, 0, 0], &[0, 1, 0], &[]] {
            assert!(Raw::new(bytes.into()).is_err(), "{bytes:?}");
        }
    }
}
