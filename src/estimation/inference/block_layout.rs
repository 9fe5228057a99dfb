//! The blocks of time over which readings are averaged. They grow with the time after contact.
//!
//! Vibrations whose phase the model cannot predict for long average out, and there are few blocks.

/// Before contact, from which the blocks begin \[ms\].
const LEAD: i32 = 2;

/// A block is as long as this part of the time from contact to its beginning, in whole milliseconds.
const PART: i32 = 5;

/// Longest block \[ms\], unless the column has a longer period: what happens late after contact, such as a collapse, has to be told within
/// 20 ms, and a vehicle that leaves must not be hidden in the mean of a long time.
const LONGEST: i32 = 10;

/// A span of time after contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Block {
    /// Its beginning \[s\]; negative before contact.
    pub start: f64,
    /// \[s\]
    pub length: f64,
}

impl Block {
    /// The share of a mean over a fifth of the time since contact that it is, at most 1: the error of a model is alike over so long, and
    /// shorter means of it are not as many errors.
    pub fn share_of_mean(&self) -> f64 {
        (f64::from(PART) * self.length / self.start.max(f64::MIN_POSITIVE)).min(1.0)
    }
}

/// The blocks until `horizon` after contact \[s\], for a column with this period \[s\].
pub(super) fn layout(horizon: f64, period: f64) -> Vec<Block> {
    let seconds = |milliseconds: i32| 1e-3 * f64::from(milliseconds);
    let mut layout = Vec::new();
    let longest = LONGEST.max((1e3 * period).ceil() as i32);
    let mut begin = -LEAD;
    while f64::from(begin) < 1e3 * horizon {
        let most = (begin / PART).clamp(1, longest);
        // Blocks end where the longest ones do, as estimates are due.
        let length = most.min(longest - begin.rem_euclid(longest));
        layout.push(Block {
            start: seconds(begin),
            length: seconds(length),
        });
        begin += length;
    }
    layout
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks used to grow to 80 ms: a vehicle that left after 0.3 s was not noticed, and a collapse was told 28 ms after it had become
    /// inevitable.
    #[test]
    fn no_block_hides_what_happens_late() {
        for (period, longest) in [(9e-3, 10e-3), (14.2e-3, 15e-3)] {
            let blocks = layout(0.5, period);
            for pair in blocks.windows(2) {
                assert!((pair[0].start + pair[0].length - pair[1].start).abs() < 1e-12);
            }
            for block in &blocks {
                assert!(block.length <= longest + 1e-12, "{block:?}");
                assert!(block.length <= 1e-3_f64.max(0.2 * block.start) + 1e-12);
            }
            let ends: Vec<f64> = blocks.iter().map(|it| it.start + it.length).collect();
            let last = ends.last().expect("a block");
            // An estimate is due at each of these times.
            for due in (0..).map(|it| f64::from(it) * longest) {
                if due > *last {
                    break;
                }
                assert!(ends.iter().any(|end| (end - due).abs() < 1e-9), "{due}");
            }
        }
    }

    /// Of a constant misfit, shorter means make no smaller one: they count as the means do that grow with the time.
    #[test]
    fn shorter_means_count_as_parts_of_those_that_grow() {
        let blocks = layout(0.5, 9e-3);
        for span in [9.9e-3..0.0499, 0.0999..0.4999] {
            let growing = libm::log(span.end / span.start) / libm::log(1.2);
            let means = blocks.iter().filter(|it| span.contains(&it.start));
            let counted: f64 = means.map(Block::share_of_mean).sum();
            let ratio = counted / growing;
            assert!((ratio - 1.0).abs() < 0.15, "{counted} {growing}");
        }
        // Lengths are whole milliseconds: 1 ms of 1.8 at 9 ms. The last block before the end of a longest one is what is left until there.
        let is_cut = |block: &&Block| {
            let ends = (block.start + block.length) / 10e-3;
            (ends - ends.round()).abs() < 1e-9
        };
        let early = blocks.iter().filter(|it| it.start < 0.0499 && !is_cut(it));
        assert!(early.map(Block::share_of_mean).all(|it| it > 0.5));
        let first = blocks.iter().filter(|it| it.start < 5.5e-3);
        assert!(first.map(Block::share_of_mean).all(|it| it > 0.999));
    }
}
