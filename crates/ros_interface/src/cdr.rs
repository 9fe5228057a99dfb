//! The bytes of a message: an encapsulation header of four bytes, then CDR (OMG RTPS 10.2, XTypes 7.4).
//!
//! These are the bytes on the wire and the bytes in a recording. Padding is written as zeros; other writers, such as
//! Fast CDR, leave whatever was in memory, so that the bytes of equal messages may differ. Reading is bounded:
//! a message that announces more elements than it holds is rejected before memory is allocated for them.

use byteorder::{BigEndian, LittleEndian};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::interface::Message;

/// Encapsulation header that is written: plain CDR, little endian.
const LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];

/// Length of the encapsulation header \[bytes\].
const HEADER_LENGTH: usize = 4;

/// RTPS pads a payload to a multiple of four bytes, so up to three may follow the message.
const MAX_PADDING: usize = 3;

/// Why bytes cannot be read as a message, or a message cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum CdrError {
    /// The bytes are too few for an encapsulation header.
    #[error("{message}: expected at least 4 bytes of encapsulation header, found {found} bytes")]
    NoHeader {
        /// ROS name of the expected type.
        message: String,
        /// Number of bytes.
        found: usize,
    },
    /// The encapsulation is not plain CDR.
    #[error("{message}: expected plain CDR (encapsulation 00 00 or 00 01), found {:02x} {:02x}; let the sender use XCDR1", found[0], found[1])]
    Encapsulation {
        /// ROS name of the expected type.
        message: String,
        /// First two bytes.
        found: [u8; 2],
    },
    /// The bytes are not a message of the expected type.
    #[error(
        "{message}: the {length} bytes are not a message of this type: {source}; compare the sender's definition of the type"
    )]
    Content {
        /// ROS name of the expected type.
        message: String,
        /// Number of bytes.
        length: usize,
        /// What the decoder found.
        source: cdr_encoding::Error,
    },
    /// There are more bytes than the expected type has.
    #[error(
        "{message}: expected {expected} bytes, found {found}; compare the sender's definition of the type"
    )]
    TooLong {
        /// ROS name of the expected type.
        message: String,
        /// Number of bytes of the message that was read.
        expected: usize,
        /// Number of bytes.
        found: usize,
    },
    /// The message cannot be written.
    #[error("{message} cannot be written: {source}")]
    Write {
        /// ROS name of the type.
        message: String,
        /// Why.
        source: cdr_encoding::Error,
    },
}

/// The bytes of `message`, little endian, with encapsulation header.
///
/// # Errors
/// A sequence or string is longer than 32 bits can tell.
pub fn encode<M: Message>(message: &M) -> Result<Vec<u8>, CdrError> {
    encode_as::<M, M>(message)
}

/// The bytes of a message of type `M` whose content is in another library's struct with the same fields.
///
/// # Errors
/// As [`encode`].
pub fn encode_as<M: Message, Foreign: Serialize>(message: &Foreign) -> Result<Vec<u8>, CdrError> {
    encode_named(message, || M::INTERFACE.ros_name())
}

/// The bytes of a message whose type only its sender knows; `name` is what an error calls it.
///
/// # Errors
/// As [`encode`].
pub fn encode_named<Content: Serialize>(
    message: &Content,
    name: impl FnOnce() -> String,
) -> Result<Vec<u8>, CdrError> {
    let mut bytes = LITTLE_ENDIAN.to_vec();
    match cdr_encoding::to_writer::<_, LittleEndian, _>(&mut bytes, message) {
        Ok(()) => Ok(bytes),
        Err(source) => Err(CdrError::Write {
            message: name(),
            source,
        }),
    }
}

/// Reads a message from `bytes`, which begin with the encapsulation header; either byte order.
///
/// Allocates memory for what `bytes` hold, and at most 1 MiB in advance for each sequence that is being read: serde
/// trusts an announced length only up to there.
///
/// # Errors
/// The bytes are too few, too many (beyond padding), or not a message of this type.
pub fn decode<M: Message>(bytes: &[u8]) -> Result<M, CdrError> {
    decode_named(bytes, || M::INTERFACE.ros_name())
}

/// Reads a message whose type only its receiver knows, as [`decode`]; `name` is what an error calls it.
///
/// # Errors
/// As [`decode`].
pub fn decode_named<M: DeserializeOwned>(
    bytes: &[u8],
    name: impl Fn() -> String,
) -> Result<M, CdrError> {
    let Some((header, content)) = bytes.split_first_chunk::<HEADER_LENGTH>() else {
        return Err(CdrError::NoHeader {
            message: name(),
            found: bytes.len(),
        });
    };
    // The last two bytes of the header are options and say nothing about plain CDR.
    let read = match [header[0], header[1]] {
        [0, 0] => cdr_encoding::from_bytes::<M, BigEndian>(content),
        [0, 1] => cdr_encoding::from_bytes::<M, LittleEndian>(content),
        found => {
            return Err(CdrError::Encapsulation {
                message: name(),
                found,
            });
        }
    };
    let (message, consumed) = read.map_err(|source| CdrError::Content {
        message: name(),
        length: bytes.len(),
        source,
    })?;
    if content.len() - consumed > MAX_PADDING {
        return Err(CdrError::TooLong {
            message: name(),
            expected: consumed + HEADER_LENGTH,
            found: bytes.len(),
        });
    }
    Ok(message)
}
