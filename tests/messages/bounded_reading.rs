//! Bytes from outside are a message or an error: never a panic, never the memory that they announce.

use column_twin::messages::Message;
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::cdr::{self, CdrError};
use column_twin::messages::column_twin_msgs::{ColumnState, ImpactEvent};
use column_twin::messages::std_msgs;
use proptest::prelude::*;

use super::golden_bytes::golden;
use super::{ForEachType, for_each_type};

/// What reading may take: serde believes an announced length up to 1 MiB, once per level of nested sequences, of
/// which the deepest type has two.
const MEMORY_BOUND: u64 = 4 << 20;

/// Reads as every type; what can be read must survive being written and read again.
struct ReadAsEverything<'a>(&'a [u8]);

impl ForEachType for ReadAsEverything<'_> {
    fn visit<M: Message + PartialEq + std::fmt::Debug>(&mut self) {
        let mut read = None;
        let memory = allocation_counter::measure(|| read = cdr::decode::<M>(self.0).ok());
        assert!(
            memory.bytes_max < MEMORY_BOUND,
            "{}: {} bytes",
            M::INTERFACE.ros_name(),
            memory.bytes_max
        );
        if let Some(message) = read {
            let bytes = cdr::encode(&message).unwrap();
            let again = cdr::encode(&cdr::decode::<M>(&bytes).unwrap()).unwrap();
            assert_eq!(bytes, again, "{}", M::INTERFACE.ros_name());
        }
    }
}

struct EveryPrefix;

impl ForEachType for EveryPrefix {
    fn visit<M: Message + PartialEq + std::fmt::Debug>(&mut self) {
        let whole = golden()[&M::INTERFACE.ros_name()].bytes();
        for length in 0..whole.len() {
            assert!(
                cdr::decode::<M>(&whole[..length]).is_err(),
                "{length} bytes of {}",
                M::INTERFACE.ros_name()
            );
        }
    }
}

#[test]
fn a_truncated_message_is_an_error_wherever_it_ends() {
    for_each_type(&mut EveryPrefix);
}

/// Puts each announced length in turn (and everything else that stands at such a place) to 1 GB and to the most.
#[test]
fn an_announced_length_is_not_believed() {
    for entry in golden().into_values() {
        let whole = entry.bytes();
        for at in (4..whole.len().saturating_sub(3)).step_by(4) {
            for length in [1_u32 << 30, u32::MAX] {
                let mut bytes = whole.clone();
                bytes[at..at + 4].copy_from_slice(&length.to_le_bytes());
                for_each_type(&mut ReadAsEverything(&bytes));
            }
        }
    }
}

#[test]
fn one_gigabyte_string_is_rejected_without_taking_it() {
    let bytes = [&[0, 1, 0, 0][..], &(1_u32 << 30).to_le_bytes(), b"abc\0"].concat();
    let memory = allocation_counter::measure(|| {
        assert!(matches!(
            cdr::decode::<std_msgs::String>(&bytes),
            Err(CdrError::Content { .. })
        ));
    });
    assert!(memory.bytes_max < 1024, "{} bytes", memory.bytes_max);
}

proptest! {
    #[test]
    fn arbitrary_bytes_do_not_panic(
        encapsulation in prop_oneof![Just([0_u8, 1, 0, 0]), Just([0, 0, 0, 0]), any::<[u8; 4]>()],
        content in prop::collection::vec(prop_oneof![3 => Just(0_u8), 1 => Just(1), 1 => any::<u8>()], 0..600),
    ) {
        for_each_type(&mut ReadAsEverything(&[&encapsulation[..], &content].concat()));
    }
}

#[test]
fn errors_say_what_was_expected_and_found() {
    let state = cdr::encode(&ColumnState::default()).unwrap();
    let error = cdr::decode::<ImpactEvent>(&state).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!(
            "column_twin_msgs/msg/ImpactEvent: expected 92 bytes, found {}; compare the sender's definition of the type",
            state.len()
        )
    );
    let error = cdr::decode::<Time>(&[0, 3, 0, 0, 1, 2]).unwrap_err();
    assert!(error.to_string().contains("found 00 03"), "{error}");
    let error = cdr::decode::<Time>(&[0, 1]).unwrap_err();
    assert!(error.to_string().contains("found 2 bytes"), "{error}");
    let error = cdr::decode::<Time>(&[0, 1, 0, 0, 9]).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("builtin_interfaces/msg/Time: the 5 bytes are not a message of this type"),
        "{error}"
    );
}

/// The padding of RTPS and the other byte order, as other vendors may send them.
#[test]
fn padding_and_big_endian_are_read() {
    let time = Time { sec: 1, nanosec: 2 };
    let little = [
        &[0, 1, 0, 0][..],
        &1_i32.to_le_bytes(),
        &2_u32.to_le_bytes(),
    ]
    .concat();
    let big = [
        &[0, 0, 0, 0][..],
        &1_i32.to_be_bytes(),
        &2_u32.to_be_bytes(),
    ]
    .concat();
    assert_eq!(cdr::decode::<Time>(&little).unwrap(), time);
    assert_eq!(cdr::decode::<Time>(&big).unwrap(), time);
    assert_eq!(
        cdr::decode::<Time>(&[&little[..], &[7; 3]].concat()).unwrap(),
        time
    );
    assert!(matches!(
        cdr::decode::<Time>(&[&little[..], &[7; 4]].concat()),
        Err(CdrError::TooLong { .. })
    ));
}

/// NaN means something in our messages, and its bits survive.
#[test]
fn nan_and_infinity_keep_their_bits() {
    let event = ImpactEvent {
        mass: f64::NEG_INFINITY,
        gap: f64::from_bits(0x7ff8_0000_0000_1234),
        ..Default::default()
    };
    let read: ImpactEvent = cdr::decode(&cdr::encode(&event).unwrap()).unwrap();
    assert_eq!(read.mass, f64::NEG_INFINITY);
    assert_eq!(read.gap.to_bits(), event.gap.to_bits());
}
