//! The prepared responses of a fleet's columns with sensors: those of equal columns are prepared once, in the background, and
//! shared.
//!
//! A kind is a column at rest with its damage and its parameters but for the names. Kinds are prepared one after another, in the
//! order in which they came, as many as [`MAX_LIBRARIES`] and [`MAX_LIBRARY_BYTES`] allow. A kind beyond these bounds is prepared
//! when another one has no column any more, or by the thread that estimates, when an impact on one of its columns has been detected: the
//! estimate then comes some seconds later.

use std::collections::{BTreeMap, HashMap};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rustix::thread::CpuSet;

use super::notifier::Notifier;
use super::real_time::lower_priority;
use crate::estimation::{EstimatorError, Library};
use crate::parameters::Parameters;
use crate::standing::StandingColumn;

/// The thread's name.
pub const LIBRARY_THREAD: &str = "column_twin/library"; // the system shows the first 15 characters

/// Its stack \[B\]: a response needs a few kilobytes, and the memory may be locked.
const STACK: usize = 1 << 20;

/// Most kinds of columns whose responses are prepared before an impact.
pub const MAX_LIBRARIES: usize = 32;

/// Most memory that prepared responses take \[B\], about.
pub const MAX_LIBRARY_BYTES: usize = 1 << 30;

/// Maximum sleep between two checks of the stop flag.
const MAX_SLEEP: Duration = Duration::from_secs(3600);

/// A kind of columns.
pub(super) type Kind = u64;

/// What was counted of the libraries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LibraryStatistics {
    /// Different columns with sensors.
    pub kinds: usize,
    /// Those for which everything is prepared.
    pub complete: usize,
    /// Those that are not prepared before an impact, because there are too many.
    pub beyond: usize,
    /// Memory of the prepared responses, about \[B\].
    pub bytes: usize,
    /// Impacts whose estimates had to wait until responses were prepared for them alone.
    pub waited: u64,
}

/// All libraries of a fleet.
#[derive(Debug, Default)]
pub(super) struct Libraries {
    shelf: Mutex<Shelf>,
    notifier: Notifier,
    stop: AtomicBool,
    waited: AtomicU64,
}

#[derive(Debug, Default)]
struct Shelf {
    kinds: BTreeMap<Kind, OneKind>,
    by_hash: HashMap<u64, Vec<Kind>>,
    next: Kind,
}

#[derive(Debug)]
struct OneKind {
    hash: u64,
    parameters: Arc<Parameters>,
    column: StandingColumn,
    /// Nothing of it is prepared.
    base: Library,
    /// The newest state, with at least one hypothesis.
    prepared: Option<Library>,
    is_complete: bool,
    /// Whether it is within the bounds.
    is_admitted: bool,
    columns: usize,
}

impl Libraries {
    /// Starts the thread that prepares.
    pub fn start(self: &Arc<Self>, processors: Option<CpuSet>) -> std::io::Result<JoinHandle<()>> {
        let shared = Arc::clone(self);
        thread::Builder::new()
            .name(LIBRARY_THREAD.to_owned())
            .stack_size(STACK)
            .spawn(move || {
                // With a real-time priority it must not compute: those who estimate prepare what they need.
                if lower_priority(processors.as_ref()) {
                    shared.run();
                }
            })
    }

    /// Lets the thread end after its present response.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::SeqCst);
        self.notifier.notify();
    }

    /// Enters a column; its kind, and the library with which that begins.
    ///
    /// # Errors
    /// No sensors, none that is fast enough to detect an impact, or parameters that make no column.
    pub fn enter(
        &self,
        parameters: &Arc<Parameters>,
        column: &StandingColumn,
    ) -> Result<(Kind, Library), EstimatorError> {
        let hash = hash(parameters, column);
        let known = self.shelf().enter(hash, parameters, column);
        let entered = match known {
            Some(known) => known,
            None => {
                // Not while the shelf is locked, because it takes a few milliseconds.
                let base = Library::new(parameters, column.clone())?;
                let mut shelf = self.shelf();
                match shelf.enter(hash, parameters, column) {
                    Some(known) => known,
                    None => shelf.add(hash, parameters, column, base),
                }
            }
        };
        self.notifier.notify();
        Ok(entered)
    }

    /// A column of this kind is of another one now, or cannot be struck any more.
    pub fn leave(&self, kind: Kind) {
        self.shelf().leave(kind);
        self.notifier.notify();
    }

    /// What is prepared for a kind so far, and whether the rest will be.
    pub fn newest(&self, kind: Kind) -> (Option<Library>, bool) {
        let shelf = self.shelf();
        let known = shelf.kinds.get(&kind);
        let newest = known.and_then(|it| it.prepared.clone());
        (newest, known.is_some_and(|it| it.is_admitted))
    }

    /// Counts an impact that has to wait.
    pub fn count_waiting(&self) {
        self.waited.fetch_add(1, Ordering::Relaxed);
    }

    pub fn statistics(&self) -> LibraryStatistics {
        let shelf = self.shelf();
        let kinds = || shelf.kinds.values();
        LibraryStatistics {
            kinds: shelf.kinds.len(),
            complete: kinds().filter(|it| it.is_complete).count(),
            beyond: kinds().filter(|it| !it.is_admitted).count(),
            bytes: kinds()
                .filter(|it| it.is_admitted)
                .map(|it| it.base.bytes())
                .sum(),
            waited: self.waited.load(Ordering::Relaxed),
        }
    }

    /// Held for looking up and entering only, never while something is computed.
    fn shelf(&self) -> MutexGuard<'_, Shelf> {
        self.shelf.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self) {
        while !self.stop.load(Ordering::SeqCst) {
            let next = self.shelf().next_to_prepare();
            match next {
                Some((kind, library)) => self.prepare(kind, library),
                None => self.notifier.wait(MAX_SLEEP),
            }
        }
    }

    /// Prepares everything for a kind, unless its columns have gone.
    fn prepare(&self, kind: Kind, mut library: Library) {
        loop {
            let before = library.prepared();
            let is_complete = library.prepare_one();
            if self.stop.load(Ordering::Relaxed) {
                return;
            }
            let is_news = is_complete || library.prepared() > before;
            if is_news && !self.shelf().publish(kind, &library, is_complete) || is_complete {
                return;
            }
        }
    }
}

impl Shelf {
    /// Enters another column of a kind that is known.
    fn enter(
        &mut self,
        hash: u64,
        parameters: &Arc<Parameters>,
        column: &StandingColumn,
    ) -> Option<(Kind, Library)> {
        let candidates = self.by_hash.get(&hash)?;
        let kinds = &mut self.kinds;
        for kind in candidates {
            let Some(known) = kinds.get_mut(kind) else {
                continue;
            };
            if known.column == *column && known.parameters.differs_by_names_only(parameters) {
                known.columns += 1;
                return Some((*kind, known.base.clone()));
            }
        }
        None
    }

    fn add(
        &mut self,
        hash: u64,
        parameters: &Arc<Parameters>,
        column: &StandingColumn,
        base: Library,
    ) -> (Kind, Library) {
        let kind = self.next;
        self.next += 1;
        self.by_hash.entry(hash).or_default().push(kind);
        let entered = (kind, base.clone());
        self.kinds.insert(
            kind,
            OneKind {
                hash,
                parameters: Arc::clone(parameters),
                column: column.clone(),
                base,
                prepared: None,
                is_complete: false,
                is_admitted: false,
                columns: 1,
            },
        );
        self.admit();
        entered
    }

    fn leave(&mut self, kind: Kind) {
        let Some(known) = self.kinds.get_mut(&kind) else {
            return;
        };
        known.columns -= 1;
        if known.columns > 0 {
            return;
        }
        let hash = known.hash;
        self.kinds.remove(&kind);
        if let Some(same) = self.by_hash.get_mut(&hash) {
            same.retain(|it| *it != kind);
            if same.is_empty() {
                self.by_hash.remove(&hash);
            }
        }
        self.admit();
    }

    /// Admits further kinds, in their order, as far as the bounds allow.
    fn admit(&mut self) {
        let admitted = self.kinds.values().filter(|it| it.is_admitted);
        let (mut count, mut bytes) = admitted.fold((0, 0), |(count, bytes), it| {
            (count + 1, bytes + it.base.bytes())
        });
        for kind in self.kinds.values_mut().filter(|it| !it.is_admitted) {
            let more = kind.base.bytes();
            if count == MAX_LIBRARIES || bytes + more > MAX_LIBRARY_BYTES {
                return;
            }
            kind.is_admitted = true;
            (count, bytes) = (count + 1, bytes + more);
        }
    }

    fn next_to_prepare(&self) -> Option<(Kind, Library)> {
        let next = self
            .kinds
            .iter()
            .find(|(_, it)| it.is_admitted && !it.is_complete);
        next.map(|(kind, it)| (*kind, it.prepared.as_ref().unwrap_or(&it.base).clone()))
    }

    /// Takes the newest state of a library; `false` if no column needs it any more.
    fn publish(&mut self, kind: Kind, library: &Library, is_complete: bool) -> bool {
        let Some(known) = self.kinds.get_mut(&kind) else {
            return false;
        };
        known.prepared = Some(library.clone());
        known.is_complete = is_complete;
        true
    }
}

/// Equal for columns that differ by their names only.
fn hash(parameters: &Parameters, column: &StandingColumn) -> u64 {
    let mut hasher = DefaultHasher::new();
    parameters.without_names().hash(&mut hasher);
    column.impact_height.to_bits().hash(&mut hasher);
    if let Some(damage) = &column.damage {
        damage.displacement.v1.to_bits().hash(&mut hasher);
    }
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Value;

    fn parameters(column_id: &str, load: f64) -> Arc<Parameters> {
        let values: [(&str, Value); 7] = [
            ("column_id", column_id.into()),
            ("top.load", load.into()),
            ("sensors.names", vec!["laser".to_owned()].into()),
            ("sensors.laser.quantity", "displacement".into()),
            ("sensors.laser.height", 1.0.into()),
            ("sensors.laser.noise", 1e-4.into()),
            ("sensors.laser.rate", 1e3.into()),
        ];
        Arc::new(Parameters::from_values(values).expect("admissible"))
    }

    #[test]
    fn equal_columns_share_a_library_until_the_last_one_leaves() {
        let libraries = Libraries::default();
        let enter = |name: &str, load: f64| {
            let parameters = parameters(name, load);
            let column = StandingColumn::undamaged(&parameters);
            libraries.enter(&parameters, &column).expect("sensors").0
        };
        let (a, b, other) = (enter("a", 1e5), enter("b", 1e5), enter("c", 2e5));
        assert_eq!((a == b, a == other), (true, false));
        assert_eq!(libraries.statistics().kinds, 2);
        libraries.leave(a);
        assert_eq!(libraries.statistics().kinds, 2);
        libraries.leave(b);
        assert_eq!(libraries.statistics().kinds, 1);
        assert_ne!(enter("a", 1e5), a, "a new kind");
    }

    #[test]
    fn kinds_beyond_the_bound_wait_until_another_one_is_free() {
        let libraries = Libraries::default();
        let kinds: Vec<Kind> = (0..=MAX_LIBRARIES)
            .map(|number| {
                let parameters = parameters("a", 1e5 + number as f64);
                let column = StandingColumn::undamaged(&parameters);
                libraries.enter(&parameters, &column).expect("sensors").0
            })
            .collect();
        let statistics = libraries.statistics();
        assert_eq!(
            (statistics.kinds, statistics.beyond),
            (MAX_LIBRARIES + 1, 1)
        );
        assert!(statistics.bytes <= MAX_LIBRARY_BYTES, "{statistics:?}");
        assert!(!libraries.newest(kinds[MAX_LIBRARIES]).1);
        libraries.leave(kinds[3]);
        assert!(libraries.newest(kinds[MAX_LIBRARIES]).1);
        assert_eq!(libraries.statistics().beyond, 0);
    }
}
