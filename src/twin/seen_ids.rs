//! Identifiers of accepted impacts.

use std::collections::{HashSet, VecDeque};
use std::sync::Arc;

/// Maximum number of remembered identifiers. Repeated events with forgotten identifiers are rejected for their stamps.
pub const MAX_SEEN_IDS: usize = 1024;

/// The last [`MAX_SEEN_IDS`] identifiers.
#[derive(Debug, Default)]
pub(super) struct SeenIds {
    in_order: VecDeque<Arc<str>>,
    set: HashSet<Arc<str>>,
}

impl SeenIds {
    pub fn of(ids: &[Arc<str>]) -> Self {
        // Without room in advance: most columns of a fleet are never hit.
        let mut seen = Self::default();
        ids.iter().for_each(|id| seen.remember(Arc::clone(id)));
        seen
    }

    pub fn contains(&self, id: &str) -> bool {
        self.set.contains(id)
    }

    pub fn remember(&mut self, id: Arc<str>) {
        if self.in_order.len() == MAX_SEEN_IDS
            && let Some(oldest) = self.in_order.pop_front()
        {
            self.set.remove(&oldest);
        }
        if self.set.insert(Arc::clone(&id)) {
            self.in_order.push_back(id);
        }
    }

    pub fn clear(&mut self) {
        self.in_order.clear();
        self.set.clear();
    }

    /// All identifiers, the oldest first.
    pub fn to_vec(&self) -> Vec<Arc<str>> {
        self.in_order.iter().cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_newest_identifiers_are_kept() {
        let mut seen = SeenIds::of(&[]);
        let mut room = 0;
        for number in 0..10 * MAX_SEEN_IDS {
            seen.remember(number.to_string().into());
            if number == 2 * MAX_SEEN_IDS {
                room = seen.in_order.capacity();
            }
        }
        assert_eq!(
            (seen.set.len(), seen.in_order.len()),
            (MAX_SEEN_IDS, MAX_SEEN_IDS)
        );
        assert_eq!(seen.in_order.capacity(), room);
        assert!(seen.contains(&(9 * MAX_SEEN_IDS).to_string()));
        assert!(!seen.contains(&(9 * MAX_SEEN_IDS - 1).to_string()));
    }
}
