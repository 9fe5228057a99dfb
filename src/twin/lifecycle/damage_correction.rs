//! Corrects the damage by a measurement on the column at rest.

use super::Twin;
use crate::time::Nanos;
use crate::twin::command::Accepted;
use crate::twin::damage_correction::{ResidualMeasurement, correct};
use crate::twin::output::{NoticeLevel, Output, Outputs};
use crate::twin::rejection::{Rejection, RejectionCode};

impl Twin {
    /// Corrects the damage by a measurement. Where the model agrees with it within its standard deviation, nothing changes.
    ///
    /// # Errors
    /// The column is not at rest or does not stand, or the measurement does not fit to its damage.
    pub(super) fn correct_damage(
        &mut self,
        measured: &ResidualMeasurement,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<Accepted, Rejection> {
        if self.response.is_some() {
            let reason = "the column is responding to an impact; measure when it is at rest";
            return Err(Rejection::new(RejectionCode::NotAtRest, reason));
        }
        self.at_rest.check_standing()?;
        let (correction, corrected) = correct(&self.at_rest, measured, now)?;
        if let Some(corrected) = corrected {
            self.forbid_resuming();
            self.at_rest = corrected;
            if let Some(last) = &mut self.registry.life.last_impact {
                last.residual_v1 = None;
            }
            self.correct_beam(measured);
            self.assess();
            self.forget_other_critical_velocities();
            self.forget_range();
        }
        let life = &mut self.registry.life;
        life.corrections_since_reset = life.corrections_since_reset.saturating_add(1);
        life.last_correction = Some(correction);
        let text = format!("by {}: {}", measured.source, correction.in_words());
        out.notice(NoticeLevel::Warning, now, text);
        out.put(Output::DamageCorrected(correction));
        self.status.set_changed();
        self.journal.set_checkpoint_due();
        self.save(now, out);
        Ok(Accepted::DamageCorrected(correction))
    }
}
