//! Checks the seal of a recording while it is read.

use mcap::records::{MessageHeader, Metadata};

use crate::chain::{Chain, Hash, to_hex};
use crate::seal::{BEGIN, Beginning, PreviousRecording, SEAL, SealRecord};
use crate::seal_key::PublicKey;

/// Maximum number of seals that are kept; of more seals, every other one is forgotten.
const MAX_SEALS: usize = 1 << 16;

/// The seal of a file, and what it proves.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seal {
    /// The key by which it claims to be sealed; `None` if it cannot be read.
    pub public_key: Option<PublicKey>,
    /// Whether the key was made for this session: it then proves nothing about who has recorded.
    pub fresh_key: bool,
    /// Identifies all recordings of one run of a recorder, in hexadecimal digits.
    pub session: String,
    /// Number of recordings of the session before this one.
    pub recording: u64,
    /// The recording before this one in the same session.
    pub previous: Option<PreviousRecording>,
    /// Number of messages, from the beginning of the file, that are proved to be unchanged.
    pub covered: u64,
    /// Log time of the last of them \[ns\].
    pub covered_until: Option<i64>,
    /// Number of messages behind them.
    pub uncovered: u64,
    /// Whether the recorder ended the recording with a final seal; otherwise, messages may be missing at the end.
    pub is_final: bool,
    /// Why the seal does not hold; `None` if it holds.
    pub fault: Option<String>,
    /// What the last valid seal has signed.
    pub(crate) head: Hash,
}

impl Seal {
    /// Whether nothing that was sealed has been changed.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.fault.is_none()
    }
}

/// Follows the records of a file.
#[derive(Debug)]
pub(crate) struct SealCheck {
    messages: u64,
    state: State,
}

#[derive(Debug)]
enum State {
    /// Neither a metadata record nor a message was read.
    New,
    /// The file did not begin with the beginning of a seal.
    Unsealed {
        fault: Option<String>,
    },
    Sealed(Box<Following>),
}

/// A place in the file up to which the chain is as a seal states it.
#[derive(Debug, Clone)]
struct Place {
    seal: SealRecord,
    log_time: Option<u64>,
}

#[derive(Debug)]
struct Following {
    beginning: Result<Beginning, String>,
    /// Head of the chain after the beginning.
    begun: Hash,
    chain: Chain,
    log_time: Option<u64>,
    places: Vec<Place>,
    has_ended: bool,
    /// A metadata record follows the final seal.
    note_after_end: bool,
    fault: Option<String>,
}

impl SealCheck {
    pub fn new() -> Self {
        Self {
            messages: 0,
            state: State::New,
        }
    }

    /// Returns whether the record is a seal that covers everything before it.
    pub fn metadata(&mut self, record: &Metadata) -> bool {
        match &mut self.state {
            State::Sealed(following) => return following.metadata(record),
            State::New if record.name == BEGIN => {
                self.state = State::Sealed(Box::new(Following::new(record)));
            }
            State::New | State::Unsealed { fault: None }
                if record.name == SEAL || record.name == BEGIN =>
            {
                let fault = "the recording does not begin with the beginning of a seal".to_owned();
                self.state = State::Unsealed { fault: Some(fault) };
            }
            State::New => self.state = State::Unsealed { fault: None },
            State::Unsealed { .. } => {}
        }
        false
    }

    pub fn message(&mut self, topic: &Hash, header: &MessageHeader, data: &[u8]) {
        self.messages += 1;
        match &mut self.state {
            State::New => self.state = State::Unsealed { fault: None },
            State::Unsealed { .. } => {}
            State::Sealed(following) => following.message(topic, header, data),
        }
    }

    /// The attachment that repeats the final seal.
    pub fn attachment(&mut self, content: &[u8]) {
        if let State::Sealed(following) = &mut self.state {
            following.attachment(content);
        }
    }

    /// Whether the file turned out not to be sealed.
    pub fn is_unsealed(&self) -> bool {
        matches!(self.state, State::Unsealed { .. })
    }

    /// The result, once everything was read; `is_whole`: the file has the end of an MCAP file, and was not repaired;
    /// `index_fault`: why other readers may find something else in it.
    pub fn finish(self, is_whole: bool, index_fault: Option<String>) -> Option<Seal> {
        match self.state {
            State::New | State::Unsealed { fault: None } => None,
            State::Unsealed { fault } => Some(Seal {
                public_key: None,
                fresh_key: false,
                session: String::new(),
                recording: 0,
                previous: None,
                covered: 0,
                covered_until: None,
                uncovered: self.messages,
                is_final: false,
                fault,
                head: Chain::new().head(),
            }),
            State::Sealed(following) => Some(following.finish(is_whole, index_fault)),
        }
    }
}

impl Following {
    fn new(record: &Metadata) -> Self {
        let mut chain = Chain::new();
        chain.add_metadata(record);
        let beginning = Beginning::parse(&record.metadata);
        Self {
            fault: beginning
                .as_ref()
                .err()
                .map(|reason| format!("the beginning of the seal cannot be read: {reason}")),
            beginning,
            begun: chain.head(),
            chain,
            log_time: None,
            places: Vec::new(),
            has_ended: false,
            note_after_end: false,
        }
    }

    fn metadata(&mut self, record: &Metadata) -> bool {
        if record.name == SEAL {
            match SealRecord::parse(&record.metadata) {
                Ok(seal) => return self.seal(seal),
                Err(reason) => self.note(format!(
                    "the seal after message {} cannot be read: {reason}",
                    self.chain.messages()
                )),
            }
        } else {
            self.note_after_end |= self.has_ended;
            self.chain.add_metadata(record);
        }
        false
    }

    fn message(&mut self, topic: &Hash, header: &MessageHeader, data: &[u8]) {
        if self.has_ended {
            self.note("messages follow its last seal, with which the recording ended".to_owned());
        }
        self.chain.add_message(topic, header, data);
        self.log_time = Some(self.log_time.unwrap_or(0).max(header.log_time));
    }

    /// Returns whether the seal fits to everything before it.
    fn seal(&mut self, seal: SealRecord) -> bool {
        if self.has_ended {
            self.note("a seal follows the one with which the recording ended".to_owned());
        } else if (seal.head, seal.messages) != (self.chain.head(), self.chain.messages()) {
            let sealed_before = self.places.last().map_or(0, |it| it.seal.messages);
            self.note(format!(
                "something between message {sealed_before} and message {} was changed, added, removed or moved",
                seal.messages.max(self.chain.messages())
            ));
        } else {
            self.has_ended = seal.is_final;
            if self.places.len() == MAX_SEALS {
                let mut keep = true;
                self.places.retain(|_| {
                    keep = !keep;
                    keep
                });
            }
            self.places.push(Place {
                seal,
                log_time: self.log_time,
            });
            return true;
        }
        false
    }

    fn attachment(&mut self, content: &[u8]) {
        let Ok(beginning) = &self.beginning else {
            return;
        };
        let last = self.places.last().filter(|it| it.seal.is_final);
        let found = serde_json::from_slice(content).ok();
        if found.is_none() || found != last.map(|it| it.seal.to_json(beginning)) {
            self.note("its attachment is not that of its last seal".to_owned());
        }
    }

    /// Keeps the first fault.
    fn note(&mut self, fault: String) {
        self.fault.get_or_insert(fault);
    }

    fn finish(mut self, is_whole: bool, index_fault: Option<String>) -> Seal {
        let public_key = self.beginning.as_ref().ok().map(|it| it.public_key);
        let last = self.places.len();
        // Each seal signs everything before it, so that the last valid one decides.
        let valid = public_key.and_then(|key| {
            self.places
                .iter()
                .rposition(|it| it.seal.is_signed_by(&key))
        });
        if last > 0 && valid != Some(last - 1) {
            let messages = self.places[last - 1].seal.messages;
            self.note(format!(
                "the signature after message {messages} was not made with the key by which the recording is sealed"
            ));
        }
        if is_whole && !self.has_ended {
            self.note("its last seal is missing, although the recording was ended".to_owned());
        }
        if is_whole && self.note_after_end {
            self.note("a note follows the seal with which the recording ended".to_owned());
        }
        if let Some(reason) = index_fault {
            self.note(format!(
                "other readers may find something else in the file than the sealed messages: {reason}"
            ));
        }
        let place = valid.and_then(|index| self.places.get(index));
        let covered = place.map_or(0, |it| it.seal.messages);
        let time = place.and_then(|it| it.log_time);
        let beginning = self.beginning.as_ref().ok();
        Seal {
            public_key,
            fresh_key: beginning.is_some_and(|it| it.fresh_key),
            session: beginning.map_or(String::new(), |it| to_hex(&it.session)),
            recording: beginning.map_or(0, |it| it.recording),
            previous: beginning.and_then(|it| it.previous.clone()),
            covered,
            covered_until: time.map(|it| i64::try_from(it).unwrap_or(i64::MAX)),
            uncovered: self.chain.messages().saturating_sub(covered),
            is_final: self.fault.is_none() && self.has_ended,
            head: place.map_or(self.begun, |it| it.seal.head),
            fault: self.fault,
        }
    }
}
