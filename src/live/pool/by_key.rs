//! Columns in the order of a key, from which each can be taken out: a binary heap that allocates nothing after the start.

/// The place of a column that is not in the heap.
const NOWHERE: u32 = u32::MAX;

/// Columns by their keys, and those with equal keys by their indices.
#[derive(Debug)]
pub struct ByKey<K> {
    heap: Vec<(K, u32)>,
    /// Where each column is in the heap.
    places: Box<[u32]>,
}

impl<K: Ord + Copy> ByKey<K> {
    /// For so many columns, none of which has a key.
    pub fn new(columns: usize) -> Self {
        Self {
            heap: Vec::with_capacity(columns),
            places: vec![NOWHERE; columns].into(),
        }
    }

    /// The column with the smallest key.
    pub fn first(&self) -> Option<(K, u32)> {
        self.heap.first().copied()
    }

    /// Gives a column this key, or none.
    pub fn set(&mut self, column: u32, key: Option<K>) {
        let place = self.places[column as usize];
        if place != NOWHERE {
            let place = place as usize;
            self.heap.swap_remove(place);
            self.places[column as usize] = NOWHERE;
            if place < self.heap.len() {
                self.settle(place);
            }
        }
        if let Some(key) = key {
            self.heap.push((key, column));
            self.settle(self.heap.len() - 1);
        }
    }

    /// Moves the entry at this place to where it belongs.
    fn settle(&mut self, mut place: usize) {
        while place > 0 && self.heap[place] < self.heap[(place - 1) / 2] {
            place = self.exchange(place, (place - 1) / 2);
        }
        loop {
            let children = 2 * place + 1..(2 * place + 3).min(self.heap.len());
            let smallest = children.min_by_key(|it| self.heap[*it]);
            let Some(child) = smallest.filter(|it| self.heap[*it] < self.heap[place]) else {
                break;
            };
            place = self.exchange(place, child);
        }
        self.places[self.heap[place].1 as usize] = place as u32;
    }

    /// Exchanges two entries; the place of the second one, where the first one is now.
    fn exchange(&mut self, one: usize, other: usize) -> usize {
        self.heap.swap(one, other);
        self.places[self.heap[one].1 as usize] = one as u32;
        other
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn the_order_is_that_of_a_sorted_set() {
        const COLUMNS: u32 = 40;
        let mut heap = ByKey::new(COLUMNS as usize);
        let mut keys = [None; COLUMNS as usize];
        let mut sorted = BTreeSet::new();
        let mut number = 1_u64;
        let mut draw = |below: u64| {
            number = number
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (number >> 33) % below
        };
        for _ in 0..20_000 {
            let column = draw(u64::from(COLUMNS)) as u32;
            let key = Some(draw(20)).filter(|it| *it > 4);
            heap.set(column, key);
            if let Some(before) = std::mem::replace(&mut keys[column as usize], key) {
                sorted.remove(&(before, column));
            }
            sorted.extend(key.map(|it| (it, column)));
            assert_eq!(heap.first(), sorted.first().copied());
        }
        assert!(sorted.len() > 10, "{}", sorted.len());
    }
}
