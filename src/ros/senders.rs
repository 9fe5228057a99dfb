//! Which senders the node accepts, and how often: an allow-list and a rate limit per sender, independent of DDS security.
//!
//! A sender is a participant, known by the prefix of its GUID. Without DDS security anybody can forge a GUID: the list keeps
//! mistakes away, and the limits keep a runaway sender from starving the others, but neither stops an attacker.

use std::collections::HashMap;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::parameters::{AllowedSender, SendersSettings};
use crate::twin::{Rejection, RejectionCode};
use ros_node::guid_prefix::GuidPrefix;
use ros_node::log_limit::LogLimit;
use ros_node::security::Peers;

/// Most senders whose rates are known at a time. Of more, the one that has been silent for the longest is forgotten.
const MAX_SENDERS: usize = 256;

/// Most rejections that are logged and recorded per [`TELLING_PERIOD`]; further ones are only counted.
const MAX_TOLD: u64 = 10;

/// Period of [`MAX_TOLD`].
const TELLING_PERIOD: Duration = Duration::from_secs(10);

/// Knows the proven identities of participants: DDS security does, and without it there are none.
#[derive(Debug)]
pub(super) struct Identities {
    peers: Arc<Peers>,
    is_secure: bool,
}

impl Identities {
    /// Those of the peers of a node; `is_secure` if it has an enclave.
    pub fn new(peers: Arc<Peers>, is_secure: bool) -> Self {
        Self { peers, is_secure }
    }

    /// The enclave of a participant; `None` if it is not proven. SROS 2 makes it the common name of the certificate, which has
    /// no other part.
    fn enclave(&self, sender: GuidPrefix) -> Option<String> {
        let subject = self.peers.subject(sender).filter(|_| self.is_secure)?;
        let enclave = subject.strip_prefix("CN=")?;
        Some(enclave.to_owned())
    }
}

/// The allow-list, the rates of the senders, and what was rejected.
pub(super) struct Senders {
    allowed: Vec<AllowedSender>,
    identities: Identities,
    rates: Option<Mutex<Rates>>,
    not_allowed: AtomicU64,
    too_fast: AtomicU64,
    telling: Mutex<LogLimit>,
}

impl fmt::Debug for Senders {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut it = f.debug_struct("Senders");
        it.field("allowed", &self.allowed).finish_non_exhaustive()
    }
}

/// A message that is not taken.
#[derive(Debug)]
pub(super) struct Rejected {
    pub rejection: Rejection,
    /// Whether to log and to record it.
    pub is_told: bool,
}

impl Senders {
    pub fn new(settings: &SendersSettings, identities: Identities) -> Self {
        let SendersSettings {
            allowed,
            max_rate,
            burst,
        } = settings;
        let limit = Limit {
            rate: *max_rate,
            burst: f64::from(*burst),
        };
        Self {
            // The list was checked with the parameters.
            allowed: allowed.iter().filter_map(|it| it.parse().ok()).collect(),
            identities,
            rates: (*max_rate > 0.0).then(|| Mutex::new(Rates::new(limit))),
            not_allowed: AtomicU64::new(0),
            too_fast: AtomicU64::new(0),
            telling: Mutex::new(LogLimit::new(MAX_TOLD, TELLING_PERIOD)),
        }
    }

    /// Warns about enclaves in the list if no identity can be proven.
    pub fn warn_of_enclaves(&self) {
        let enclaves = self.allowed.iter();
        let enclaves = enclaves.filter(|it| matches!(it, AllowedSender::Enclave(_)));
        for enclave in enclaves.filter(|_| !self.identities.is_secure) {
            tracing::warn!(
                "senders.allowed names the enclave {enclave}, but this node runs without DDS security, so that the entry \
                 matches no sender"
            );
        }
    }

    /// Whether anything is limited.
    pub fn is_limited(&self) -> bool {
        !self.allowed.is_empty() || self.rates.is_some()
    }

    /// Messages and requests of senders that are not in the list.
    pub fn not_allowed(&self) -> u64 {
        self.not_allowed.load(Ordering::Relaxed)
    }

    /// Messages and requests that exceeded the rate.
    pub fn too_fast(&self) -> u64 {
        self.too_fast.load(Ordering::Relaxed)
    }

    /// Takes a message or a request of a sender.
    ///
    /// # Errors
    /// The sender is not in the list, or sends too often.
    pub fn admit(&self, sender: impl Into<GuidPrefix>, now: Instant) -> Result<(), Rejected> {
        let sender = sender.into();
        self.admit_stream(sender, now)?;
        let Some(limit) = self.limit_exceeded(sender, now) else {
            return Ok(());
        };
        let Limit { rate, burst } = limit;
        let reason = format!(
            "the sender with the GUID {sender} exceeds senders.max_rate, {rate} per second after a burst of {burst}"
        );
        Err(self.rejected(&self.too_fast, RejectionCode::SenderTooFast, reason, now))
    }

    /// Takes a part of a stream, of which no rate is too high.
    ///
    /// # Errors
    /// The sender is not in the list.
    pub fn admit_stream(
        &self,
        sender: impl Into<GuidPrefix>,
        now: Instant,
    ) -> Result<(), Rejected> {
        let sender = sender.into();
        if self.is_allowed(sender) {
            return Ok(());
        }
        let reason = format!("the sender with the GUID {sender} is not in senders.allowed");
        let code = RejectionCode::SenderNotAllowed;
        Err(self.rejected(&self.not_allowed, code, reason, now))
    }

    fn rejected(
        &self,
        counter: &AtomicU64,
        code: RejectionCode,
        reason: String,
        now: Instant,
    ) -> Rejected {
        counter.fetch_add(1, Ordering::Relaxed);
        let mut telling = self.telling.lock().unwrap_or_else(PoisonError::into_inner);
        let untold = telling.admit(now);
        let hidden = match untold {
            Some(hidden @ 1..) => {
                format!(" ({hidden} rejections before this one are only counted)")
            }
            _ => String::new(),
        };
        Rejected {
            rejection: Rejection::new(code, format!("{reason}{hidden}")),
            is_told: untold.is_some(),
        }
    }

    fn is_allowed(&self, sender: GuidPrefix) -> bool {
        if self.allowed.is_empty() {
            return true;
        }
        let enclave = self.identities.enclave(sender);
        let is = |it: &AllowedSender| it.is(&sender.0, enclave.as_deref());
        self.allowed.iter().any(is)
    }

    fn limit_exceeded(&self, sender: GuidPrefix, now: Instant) -> Option<Limit> {
        let rates = self.rates.as_ref()?;
        let mut rates = rates.lock().unwrap_or_else(PoisonError::into_inner);
        (!rates.take(sender, now)).then_some(rates.limit)
    }
}

/// At most `burst` at once, and `rate` per second after that.
#[derive(Debug, Clone, Copy)]
struct Limit {
    rate: f64,
    burst: f64,
}

/// What a sender may still send.
#[derive(Debug, Clone, Copy)]
struct Allowance {
    left: f64,
    last: Instant,
}

impl Allowance {
    fn full(limit: Limit, now: Instant) -> Self {
        Self {
            left: limit.burst,
            last: now,
        }
    }

    fn take(&mut self, limit: Limit, now: Instant) -> bool {
        let since = now.saturating_duration_since(self.last).as_secs_f64();
        self.left = (self.left + since * limit.rate).min(limit.burst);
        self.last = now;
        let is_enough = self.left >= 1.0;
        if is_enough {
            self.left -= 1.0;
        }
        is_enough
    }
}

/// The allowances of the senders.
#[derive(Debug)]
struct Rates {
    limit: Limit,
    known: HashMap<GuidPrefix, Allowance>,
    /// Of all senders together that are not known yet, so that fresh GUIDs give no fresh allowance.
    newcomers: Option<Allowance>,
}

impl Rates {
    fn new(limit: Limit) -> Self {
        Self {
            limit,
            known: HashMap::with_capacity(MAX_SENDERS),
            newcomers: None,
        }
    }

    fn take(&mut self, sender: GuidPrefix, now: Instant) -> bool {
        let limit = self.limit;
        if let Some(allowance) = self.known.get_mut(&sender) {
            return allowance.take(limit, now);
        }
        let newcomers = self.newcomers.get_or_insert(Allowance::full(limit, now));
        if !newcomers.take(limit, now) {
            return false;
        }
        if self.known.len() >= MAX_SENDERS {
            let silent = self.known.iter().min_by_key(|(_, it)| it.last);
            let silent = silent.map(|(sender, _)| *sender);
            silent.and_then(|it| self.known.remove(&it));
        }
        let mut allowance = Allowance::full(limit, now);
        let is_taken = allowance.take(limit, now);
        self.known.insert(sender, allowance);
        is_taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::GUID_PREFIX_BYTES;

    fn settings(allowed: &[&str], max_rate: f64, burst: u32) -> SendersSettings {
        SendersSettings {
            allowed: allowed.iter().map(|it| (*it).to_owned()).collect(),
            max_rate,
            burst,
        }
    }

    fn senders(allowed: &[&str], max_rate: f64, burst: u32) -> Senders {
        let nobody = Identities::new(Arc::default(), false);
        Senders::new(&settings(allowed, max_rate, burst), nobody)
    }

    fn sender(number: u32) -> GuidPrefix {
        let mut prefix = [7; GUID_PREFIX_BYTES];
        prefix[..4].copy_from_slice(&number.to_be_bytes());
        GuidPrefix(prefix)
    }

    #[test]
    fn an_empty_list_admits_everybody() {
        let senders = senders(&[], 0.0, 10);
        assert!(!senders.is_limited());
        assert!((0..1_000).all(|number| senders.admit(sender(number), Instant::now()).is_ok()));
    }

    #[test]
    fn only_listed_senders_are_admitted() {
        let now = Instant::now();
        let peers = Peers::default();
        peers.take_joined(sender(3), "CN=/operator", now);
        let settings = settings(&["00000001", "/operator"], 0.0, 10);
        let senders = Senders::new(&settings, Identities::new(Arc::new(peers), true));
        let admitted = [1, 2, 3].map(|number| senders.admit(sender(number), now).is_ok());
        assert_eq!(admitted, [true, false, true]);
        let rejected = senders.admit(sender(2), now).expect_err("is not listed");
        assert_eq!(rejected.rejection.code, RejectionCode::SenderNotAllowed);
        assert!(
            rejected.rejection.reason.contains("000000020707"),
            "{rejected:?}"
        );
        assert_eq!((senders.not_allowed(), senders.too_fast()), (2, 0));
    }

    #[test]
    fn a_sender_has_a_burst_and_then_a_rate() {
        let senders = senders(&[], 10.0, 5);
        let start = Instant::now();
        let sent = |from: Instant, count: u64| {
            let times = (0..count).map(|it| from + Duration::from_millis(it));
            times
                .filter(|now| senders.admit(sender(1), *now).is_ok())
                .count()
        };
        assert_eq!(sent(start, 50), 5);
        // A second later 10 are earned, of which the burst is kept.
        assert_eq!(sent(start + Duration::from_secs(1), 50), 5);
        // Another sender is not concerned.
        assert!(senders.admit(sender(2), start).is_ok());
        assert_eq!(senders.too_fast(), 90);
    }

    #[test]
    fn a_flood_of_fresh_guids_needs_no_memory_and_gets_no_further_than_one_sender() {
        let senders = senders(&[], 10.0, 5);
        let now = Instant::now();
        let admitted = (0..100_000).filter(|number| senders.admit(sender(*number), now).is_ok());
        assert_eq!(admitted.count(), 5);
        let later = (0..10_000).filter(|number| {
            let now = now + Duration::from_millis(u64::from(*number) * 100);
            senders.admit(sender(*number), now).is_ok()
        });
        assert!(later.count() > MAX_SENDERS);
        let rates = senders
            .rates
            .as_ref()
            .expect("limited")
            .lock()
            .expect("whole");
        assert_eq!(rates.known.len(), MAX_SENDERS);
        assert!(rates.known.capacity() <= 4 * MAX_SENDERS);
    }

    #[test]
    fn a_rejected_sender_cannot_fill_a_log() {
        let senders = senders(&["ffffffff"], 0.0, 10);
        let start = Instant::now();
        let told = |now: Instant| {
            let rejected =
                (0..1_000).map(|_| senders.admit(sender(1), now).expect_err("not listed"));
            let told: Vec<_> = rejected.filter(|it| it.is_told).collect();
            assert_eq!(told.len() as u64, MAX_TOLD);
            told
        };
        told(start);
        let next = told(start + TELLING_PERIOD);
        assert!(
            next[0].rejection.reason.contains("(990 rejections"),
            "{:?}",
            next[0]
        );
        assert_eq!(senders.not_allowed(), 2_000);
    }
}
