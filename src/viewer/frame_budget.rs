//! How many frames of the scene are drawn.

/// Limits the mean rate of frames. Unused frames are saved up to a limit, so that a whole impact is shown millisecond by
/// millisecond, while a column that never comes to rest costs no more than the mean rate.
#[derive(Debug, Clone)]
pub struct FrameBudget {
    per_second: f64,
    max_saved: f64,
    saved: f64,
    /// Time of the last call of [`take`](Self::take) \[ns\].
    last_call: Option<i64>,
}

impl FrameBudget {
    /// A budget of `per_second` frames per second, of which `max_saved` can be saved up.
    #[must_use]
    pub fn new(per_second: f64, max_saved: f64) -> Self {
        Self {
            per_second,
            max_saved,
            saved: max_saved,
            last_call: None,
        }
    }

    /// Takes one frame at the time `now` \[ns\], if there is one; a time that runs backwards earns nothing.
    pub fn take(&mut self, now: i64) -> bool {
        let passed = now.saturating_sub(self.last_call.unwrap_or(now)).max(0);
        self.last_call = Some(now);
        self.saved = (self.saved + 1e-9 * passed as f64 * self.per_second).min(self.max_saved);
        if self.saved < 1.0 {
            return false;
        }
        self.saved -= 1.0;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At a thousand states per second the first impact is shown completely, and then 60 frames per second.
    #[test]
    fn a_budget_is_spent_and_earned() {
        let mut budget = FrameBudget::new(60.0, 120.0);
        let mut frames = |from: i64, to: i64| {
            let times = (from..to).map(|millisecond| millisecond * 1_000_000);
            times.filter(|now| budget.take(*now)).count()
        };
        assert_eq!(frames(0, 100), 100);
        let later = frames(1_000, 11_000);
        assert!((600..=725).contains(&later), "{later}");
        // A time that runs backwards earns nothing.
        assert!(frames(0, 50) <= 50);
    }
}
