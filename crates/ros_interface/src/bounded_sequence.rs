//! A bounded sequence of a message, such as `float64[<=3]`.

use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A sequence of at most `N` elements, which are stored in place: a message with such fields needs no memory for them.
///
/// Reading a longer sequence is an error.
#[derive(Clone, Copy)]
pub struct BoundedSequence<T, const N: usize> {
    elements: [T; N],
    length: usize,
}

impl<T: Copy + Default, const N: usize> BoundedSequence<T, N> {
    /// The first elements of `elements`, at most `N`.
    #[must_use]
    pub fn first(elements: &[T], count: usize) -> Self {
        let mut sequence = Self::default();
        for element in elements.iter().take(count.min(N)) {
            sequence.elements[sequence.length] = *element;
            sequence.length += 1;
        }
        sequence
    }
}

impl<T: Copy, const N: usize> BoundedSequence<T, N> {
    /// The element at `index`, or `missing` where the sequence is shorter, as one from another program may be.
    #[must_use]
    pub fn get_or(&self, index: usize, missing: T) -> T {
        self.get(index).copied().unwrap_or(missing)
    }
}

/// All elements of an array, which has at most `N`.
impl<T: Copy + Default, const N: usize, const M: usize> From<[T; M]> for BoundedSequence<T, N> {
    fn from(elements: [T; M]) -> Self {
        const { assert!(M <= N, "the array is longer than the bound") }
        Self::first(&elements, M)
    }
}

impl<T: Copy + Default, const N: usize> Default for BoundedSequence<T, N> {
    fn default() -> Self {
        Self {
            elements: [T::default(); N],
            length: 0,
        }
    }
}

impl<T, const N: usize> Deref for BoundedSequence<T, N> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.elements[..self.length]
    }
}

/// The elements can be changed, their number cannot.
impl<T, const N: usize> DerefMut for BoundedSequence<T, N> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.elements[..self.length]
    }
}

impl<T: PartialEq, const N: usize> PartialEq for BoundedSequence<T, N> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: fmt::Debug, const N: usize> fmt::Debug for BoundedSequence<T, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

impl<T: Serialize, const N: usize> Serialize for BoundedSequence<T, N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (**self).serialize(serializer)
    }
}

impl<'de, T: Copy + Default + Deserialize<'de>, const N: usize> Deserialize<'de>
    for BoundedSequence<T, N>
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(Elements(PhantomData))
    }
}

struct Elements<T, const N: usize>(PhantomData<T>);

impl<'de, T: Copy + Default + Deserialize<'de>, const N: usize> Visitor<'de> for Elements<T, N> {
    type Value = BoundedSequence<T, N>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a sequence of at most {N} elements")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut access: A) -> Result<Self::Value, A::Error> {
        let mut sequence = BoundedSequence::default();
        while let Some(element) = access.next_element()? {
            let Some(place) = sequence.elements.get_mut(sequence.length) else {
                return Err(A::Error::invalid_length(N + 1, &self));
            };
            *place = element;
            sequence.length += 1;
        }
        Ok(sequence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Three = BoundedSequence<f64, 3>;

    #[test]
    fn a_sequence_has_the_elements_that_count() {
        assert!(Three::default().is_empty());
        assert_eq!(*Three::first(&[1.0, 2.0, 3.0], 2), [1.0, 2.0]);
        assert_eq!(
            *Three::first(&[1.0, 2.0, 3.0, 4.0], usize::MAX),
            [1.0, 2.0, 3.0]
        );
        assert_ne!(Three::first(&[0.0], 1), Three::default());
        let mut two = Three::from([1.0, 2.0]);
        two[1] = 4.0;
        assert_eq!(*two, [1.0, 4.0]);
        assert_eq!((two.get_or(1, 9.0), two.get_or(2, 9.0)), (4.0, 9.0));
    }

    #[test]
    fn a_sequence_beyond_its_bound_is_an_error() {
        let read = |text| serde_json::from_str::<Three>(text);
        assert!(read("[]").expect("no element").is_empty());
        assert_eq!(*read("[1, 2, 3]").expect("three elements"), [1.0, 2.0, 3.0]);
        let error = read("[1, 2, 3, 4]").expect_err("four elements").to_string();
        assert!(
            error.contains("expected a sequence of at most 3 elements"),
            "{error}"
        );
    }
}
