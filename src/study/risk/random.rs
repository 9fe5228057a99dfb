//! Random numbers that depend on the seed and on the number of the sample only.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// What random numbers are for. Streams with different purposes are independent of one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// The samples of which the result consists.
    Sample = 1,
    /// The designs from which the critical velocities are interpolated; they are no part of the result.
    Design = 2,
    /// A first look at the speeds at the column; they are no part of the result either.
    Pilot = 3,
}

/// A source of random numbers: sample `i` has the stream `i` of the cipher ChaCha with 8 rounds, keyed with the seed.
/// Whichever thread draws it, and in whichever order, it gets the same numbers on every processor.
#[derive(Debug, Clone)]
pub(super) struct Streams {
    start: ChaCha8Rng,
}

impl Streams {
    pub(super) fn new(seed: u64, purpose: Purpose) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8] = purpose as u8;
        Self {
            start: ChaCha8Rng::from_seed(key),
        }
    }

    /// The numbers of one sample.
    pub(super) fn numbers(&self, index: u64) -> Numbers {
        let mut stream = self.start.clone();
        stream.set_stream(index);
        Numbers { stream }
    }
}

/// The random numbers of one sample, as many as it needs.
#[derive(Debug, Clone)]
pub(super) struct Numbers {
    stream: ChaCha8Rng,
}

impl Numbers {
    /// The next number, uniform between 0 and 1, both excluded.
    pub(super) fn next(&mut self) -> f64 {
        // 53 bits and a half, which lies between 0 and 1 whatever the bits are.
        ((self.stream.next_u64() >> 11) as f64 + 0.5) * (1.0 / (1_u64 << 53) as f64)
    }

    /// The next numbers.
    pub(super) fn take<const COUNT: usize>(&mut self) -> [f64; COUNT] {
        std::array::from_fn(|_| self.next())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_has_its_own_numbers_in_any_order() {
        let streams = Streams::new(7, Purpose::Sample);
        let forwards: Vec<[f64; 10]> = (0..50).map(|index| streams.numbers(index).take()).collect();
        let backwards: Vec<[f64; 10]> = (0..50)
            .rev()
            .map(|index| streams.numbers(index).take())
            .collect();
        assert!(forwards.iter().eq(backwards.iter().rev()));
        let other: [f64; 10] = Streams::new(7, Purpose::Design).numbers(0).take();
        assert_ne!(forwards[0], other);
        let other: [f64; 10] = Streams::new(8, Purpose::Sample).numbers(0).take();
        assert_ne!(forwards[0], other);
    }

    /// The cipher's own test vector: key 0, stream 0, 8 rounds; the first bytes are those of the eSTREAM submission's set.
    #[test]
    fn the_numbers_are_those_of_the_cipher() {
        let mut stream = ChaCha8Rng::from_seed([0; 32]);
        let mut bytes = [0; 8];
        stream.fill_bytes(&mut bytes);
        assert_eq!(bytes, [0x3e, 0x00, 0xef, 0x2f, 0x89, 0x5f, 0x40, 0xd6]);
    }

    /// Mean and variance of a uniform distribution, and no correlation between neighbouring samples, within four standard errors.
    #[test]
    fn the_numbers_are_uniform() {
        let streams = Streams::new(1, Purpose::Sample);
        let count = 40_000;
        let numbers: Vec<f64> = (0..count)
            .map(|index| streams.numbers(index).take::<3>()[1])
            .collect();
        let n = count as f64;
        let mean = numbers.iter().sum::<f64>() / n;
        assert!((mean - 0.5).abs() < 4.0 * (1.0 / 12.0 / n).sqrt());
        let variance = numbers.iter().map(|it| (it - 0.5).powi(2)).sum::<f64>() / n;
        assert!((variance - 1.0 / 12.0).abs() < 4.0 * (1.0 / 180.0 / n).sqrt());
        let product = numbers
            .windows(2)
            .map(|it| (it[0] - 0.5) * (it[1] - 0.5))
            .sum::<f64>()
            / n;
        assert!(product.abs() < 4.0 / 12.0 / n.sqrt());
    }
}
