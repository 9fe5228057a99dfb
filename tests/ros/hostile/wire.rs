//! RTPS messages byte by byte, as an attacker makes them: nothing here checks that they make sense.

/// The first bytes of the GUIDs of one participant.
pub type Prefix = [u8; 12];
/// An endpoint of a participant.
pub type EntityId = [u8; 4];

pub const UNKNOWN: EntityId = [0; 4];
pub const PARTICIPANT: EntityId = [0, 0, 1, 0xc1];
pub const SPDP_WRITER: EntityId = [0, 1, 0, 0xc2];
pub const SPDP_READER: EntityId = [0, 1, 0, 0xc7];
pub const PUBLICATIONS_WRITER: EntityId = [0, 0, 3, 0xc2];
pub const PUBLICATIONS_READER: EntityId = [0, 0, 3, 0xc7];
pub const SUBSCRIPTIONS_WRITER: EntityId = [0, 0, 4, 0xc2];
pub const SUBSCRIPTIONS_READER: EntityId = [0, 0, 4, 0xc7];
pub const TOPICS_WRITER: EntityId = [0, 0, 2, 0xc2];
pub const TOPICS_READER: EntityId = [0, 0, 2, 0xc7];

pub const PAD: u8 = 0x01;
pub const ACKNACK: u8 = 0x06;
pub const HEARTBEAT: u8 = 0x07;
pub const GAP: u8 = 0x08;
pub const INFO_TS: u8 = 0x09;
pub const INFO_SRC: u8 = 0x0c;
pub const INFO_DST: u8 = 0x0e;
pub const INFO_REPLY: u8 = 0x0f;
pub const NACK_FRAG: u8 = 0x12;
pub const HEARTBEAT_FRAG: u8 = 0x13;
pub const DATA: u8 = 0x15;
pub const DATA_FRAG: u8 = 0x16;

const LITTLE_ENDIAN: u8 = 0x01;
/// DATA carries a serialized value.
const DATA_FLAG: u8 = 0x04;
const INLINE_QOS: u8 = 0x02;
const PL_CDR_LE: [u8; 4] = [0, 3, 0, 0];

/// Length of the header of a message.
pub const HEADER: usize = 20;

/// A message under construction.
#[derive(Debug, Clone)]
pub struct Datagram(pub Vec<u8>);

impl Datagram {
    pub fn from(source: Prefix) -> Self {
        let mut bytes = b"RTPS\x02\x04\x01\x0f".to_vec();
        bytes.extend(source);
        Self(bytes)
    }

    pub fn submessage(mut self, id: u8, flags: u8, content: &[u8]) -> Self {
        self.0.extend([id, flags | LITTLE_ENDIAN]);
        let length = u16::try_from(content.len()).expect("short");
        self.0.extend(length.to_le_bytes());
        self.0.extend(content);
        self
    }

    pub fn to(self, destination: Prefix) -> Self {
        self.submessage(INFO_DST, 0, &destination)
    }

    pub fn stamp(self, seconds: u32, fraction: u32) -> Self {
        let content = [seconds.to_le_bytes(), fraction.to_le_bytes()].concat();
        self.submessage(INFO_TS, 0, &content)
    }

    /// Replies to go to this port of this machine.
    pub fn reply_to(self, port: u16) -> Self {
        let content = [&1_u32.to_le_bytes()[..], &locator(port)].concat();
        self.submessage(INFO_REPLY, 0, &content)
    }

    pub fn source(self, source: Prefix) -> Self {
        let content = [&[0, 0, 0, 0, 2, 4, 1, 15][..], &source].concat();
        self.submessage(INFO_SRC, 0, &content)
    }

    pub fn data(self, reader: EntityId, writer: EntityId, number: i64, payload: &[u8]) -> Self {
        let content = [
            &[0, 0, 16, 0][..],
            &reader,
            &writer,
            &sequence_number(number),
            payload,
        ]
        .concat();
        self.submessage(DATA, DATA_FLAG, &content)
    }

    /// A value with inline quality of service.
    pub fn data_with_qos(
        self,
        reader: EntityId,
        writer: EntityId,
        number: i64,
        qos: &Parameters,
        payload: &[u8],
    ) -> Self {
        let content = [
            &[0, 0, 16, 0][..],
            &reader,
            &writer,
            &sequence_number(number),
            &qos.end(),
            payload,
        ]
        .concat();
        self.submessage(DATA, DATA_FLAG | INLINE_QOS, &content)
    }

    pub fn data_frag(self, reader: EntityId, writer: EntityId, fragment: &Fragment<'_>) -> Self {
        let content = [
            &[0, 0, 28, 0][..],
            &reader,
            &writer,
            &sequence_number(fragment.number),
            &fragment.first.to_le_bytes(),
            &fragment.count.to_le_bytes(),
            &fragment.size.to_le_bytes(),
            &fragment.sample_size.to_le_bytes(),
            fragment.bytes,
        ]
        .concat();
        self.submessage(DATA_FRAG, 0, &content)
    }

    pub fn heartbeat(
        self,
        reader: EntityId,
        writer: EntityId,
        first: i64,
        last: i64,
        count: i32,
    ) -> Self {
        let content = [
            &reader[..],
            &writer,
            &sequence_number(first),
            &sequence_number(last),
            &count.to_le_bytes(),
        ]
        .concat();
        self.submessage(HEARTBEAT, 0, &content)
    }

    pub fn gap(self, reader: EntityId, writer: EntityId, start: i64, set: &Set) -> Self {
        let content = [
            &reader[..],
            &writer,
            &sequence_number(start),
            &set.of_sequence_numbers(),
        ]
        .concat();
        self.submessage(GAP, 0, &content)
    }

    pub fn acknack(self, reader: EntityId, writer: EntityId, set: &Set, count: i32) -> Self {
        let content = [
            &reader[..],
            &writer,
            &set.of_sequence_numbers(),
            &count.to_le_bytes(),
        ]
        .concat();
        self.submessage(ACKNACK, 0, &content)
    }

    pub fn nack_frag(
        self,
        reader: EntityId,
        writer: EntityId,
        number: i64,
        set: &Set,
        count: i32,
    ) -> Self {
        let content = [
            &reader[..],
            &writer,
            &sequence_number(number),
            &set.of_fragments(),
            &count.to_le_bytes(),
        ]
        .concat();
        self.submessage(NACK_FRAG, 0, &content)
    }

    pub fn heartbeat_frag(self, reader: EntityId, writer: EntityId, number: i64) -> Self {
        let content = [
            &reader[..],
            &writer,
            &sequence_number(number),
            &7_u32.to_le_bytes(),
            &1_i32.to_le_bytes(),
        ]
        .concat();
        self.submessage(HEARTBEAT_FRAG, 0, &content)
    }
}

/// What a DATA_FRAG claims, and what it carries.
pub struct Fragment<'a> {
    pub number: i64,
    pub first: u32,
    pub count: u16,
    pub size: u16,
    pub sample_size: u32,
    pub bytes: &'a [u8],
}

/// A set of numbers from `base` on.
pub struct Set {
    pub base: i64,
    pub bits: u32,
    pub words: Vec<u32>,
}

impl Set {
    pub fn empty(base: i64) -> Self {
        Self {
            base,
            bits: 0,
            words: Vec::new(),
        }
    }

    /// `base` and the 255 numbers after it.
    pub fn full(base: i64) -> Self {
        Self {
            base,
            bits: 256,
            words: vec![u32::MAX; 8],
        }
    }

    fn bitmap(&self) -> Vec<u8> {
        let words = std::iter::once(&self.bits).chain(&self.words);
        words.flat_map(|word| word.to_le_bytes()).collect()
    }

    fn of_sequence_numbers(&self) -> Vec<u8> {
        [&sequence_number(self.base)[..], &self.bitmap()].concat()
    }

    fn of_fragments(&self) -> Vec<u8> {
        let base = u32::try_from(self.base).expect("a fragment number");
        [&base.to_le_bytes()[..], &self.bitmap()].concat()
    }
}

/// High word first, whatever the byte order within the words.
fn sequence_number(number: i64) -> [u8; 8] {
    let bytes = number.to_le_bytes();
    let (low, high) = bytes.split_at(4);
    [high, low].concat().try_into().expect("eight bytes")
}

/// A UDP port on 127.0.0.1.
pub fn locator(port: u16) -> [u8; 24] {
    let mut bytes = [0; 24];
    bytes[0] = 1;
    bytes[4..6].copy_from_slice(&port.to_le_bytes());
    bytes[20..].copy_from_slice(&[127, 0, 0, 1]);
    bytes
}

/// A list of parameters, as discovery sends them.
#[derive(Debug, Clone, Default)]
pub struct Parameters(Vec<u8>);

impl Parameters {
    pub fn with(mut self, id: u16, value: &[u8]) -> Self {
        let padding = value.len().next_multiple_of(4) - value.len();
        let length = u16::try_from(value.len() + padding).expect("short");
        self.0.extend(id.to_le_bytes());
        self.0.extend(length.to_le_bytes());
        self.0.extend(value);
        self.0.extend(vec![0; padding]);
        self
    }

    pub fn with_text(self, id: u16, text: &str) -> Self {
        let length = u32::try_from(text.len() + 1).expect("short");
        let value = [&length.to_le_bytes()[..], text.as_bytes(), &[0]].concat();
        self.with(id, &value)
    }

    /// The list with its end marker.
    pub fn end(&self) -> Vec<u8> {
        [&self.0[..], &[1, 0, 0, 0]].concat()
    }

    /// As the value of a DATA.
    pub fn payload(&self) -> Vec<u8> {
        [&PL_CDR_LE[..], &self.end()].concat()
    }
}

/// The announcement of a participant that listens on this port of this machine.
pub fn participant(prefix: Prefix, port: u16) -> Parameters {
    let guid = [&prefix[..], &PARTICIPANT].concat();
    let forever = [0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0xff];
    Parameters::default()
        .with(0x0015, &[2, 4, 0, 0])
        .with(0x0016, &[1, 15, 0, 0])
        .with(0x0050, &guid)
        .with(0x0058, &0x0000_0c3f_u32.to_le_bytes())
        .with(0x0032, &locator(port))
        .with(0x0031, &locator(port))
        .with(0x0002, &forever)
}

/// The announcement of a reader or writer that is reliable and volatile.
pub fn endpoint(
    prefix: Prefix,
    entity: EntityId,
    topic: &str,
    type_name: &str,
    port: u16,
) -> Parameters {
    let reliable = [2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 16];
    Parameters::default()
        .with(0x005a, &[&prefix[..], &entity].concat())
        .with(0x0050, &[&prefix[..], &PARTICIPANT].concat())
        .with_text(0x0005, topic)
        .with_text(0x0007, type_name)
        .with(0x001a, &reliable)
        .with(0x001d, &[0; 4])
        .with(0x002f, &locator(port))
}

/// The submessages of a message: id, flags and content of each.
pub fn submessages(datagram: &[u8]) -> Vec<(u8, u8, &[u8])> {
    let mut rest = datagram.get(HEADER..).unwrap_or_default();
    let mut found = Vec::new();
    while let [id, flags, low, high, after @ ..] = rest {
        let length = match u16::from_le_bytes([*low, *high]) {
            0 if *id != PAD && *id != INFO_TS => after.len(),
            length => usize::from(length).min(after.len()),
        };
        found.push((*id, *flags, &after[..length]));
        rest = &after[length..];
    }
    found
}
