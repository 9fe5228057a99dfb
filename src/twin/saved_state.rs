//! What outlives a restart: the damage of the column, as text.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::input::Nanos;
use super::output::{Output, Outputs};
use super::parameter_change::{self, AtRest, what_the_column_is};
use super::present::{Condition, equilibrium};
use super::stepping::{condition_after, no_equilibrium};
use super::{Life, Twin};
use crate::column::{
    Displacement, Model, ModelError, PerBar, PlasticFlow, Report, State, residual_state,
};
use crate::parameters::Parameters;

/// First entry of a state file.
const FORMAT: &str = "column_twin state";

/// Version of the content that is written, and the only one that is read.
const VERSION: u32 = 1;

/// The damage of the column, and which impacts it comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedState {
    /// The column.
    pub column_id: Arc<str>,
    /// Digest of what the column is: its lengths, section, steel, resistances, hinges and supports.
    pub fingerprint: Arc<str>,
    /// When it was taken \[ns\] since the epoch.
    pub stamp: Nanos,
    /// Whether it stands.
    pub condition: SavedCondition,
    /// Height of hinges 1a and 1b above the base \[m\].
    pub impact_height: f64,
    /// Displacements in the residual equilibrium.
    pub displacement: Displacement,
    /// Plastic deformation of the hinges.
    pub plastic: PerBar<PlasticFlow>,
    /// Work dissipated in the hinges since the last reset \[J\].
    pub plastic_work_since_reset: f64,
    /// Accepted impacts since the last reset.
    pub impacts_since_reset: u32,
    /// Refused impacts since the last reset.
    pub refused_since_reset: u64,
    /// The last accepted impact; empty if there was none.
    pub last_event_id: Arc<str>,
    /// Identifiers of accepted impacts, the oldest first, at most [`MAX_SEEN_IDS`](super::MAX_SEEN_IDS).
    pub seen_ids: Vec<Arc<str>>,
}

/// Whether a saved column stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SavedCondition {
    /// It stands.
    Standing,
    /// It has collapsed.
    Collapsed,
    /// It cannot be computed any further, for this reason.
    Faulted(Arc<str>),
}

impl From<&Condition> for SavedCondition {
    fn from(condition: &Condition) -> Self {
        match condition {
            Condition::Standing => Self::Standing,
            Condition::Collapsed => Self::Collapsed,
            Condition::Faulted(reason) => Self::Faulted(Arc::clone(reason)),
        }
    }
}

impl From<&SavedCondition> for Condition {
    fn from(saved: &SavedCondition) -> Self {
        match saved {
            SavedCondition::Standing => Self::Standing,
            SavedCondition::Collapsed => Self::Collapsed,
            SavedCondition::Faulted(reason) => Self::Faulted(Arc::clone(reason)),
        }
    }
}

/// Why a text is not the state of this column.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SavedStateError {
    /// It is no JSON of the expected form.
    #[error("it is truncated or no state file of column_twin: {0}")]
    Malformed(String),
    /// It is of another format or version.
    #[error(
        "it has format \"{format}\", version {version}; expected \"{FORMAT}\", version {VERSION}"
    )]
    Foreign {
        /// What it says it is.
        format: String,
        /// Its version.
        version: u32,
    },
    /// Its checksum is not that of its content.
    #[error("its checksum does not fit its content: it was damaged or edited")]
    Checksum,
    /// It is of another column.
    #[error("it is of column \"{found}\"; this twin is of column \"{expected}\"")]
    OtherColumn {
        /// Whose it is.
        found: String,
        /// Whose it should be.
        expected: String,
    },
    /// The column has other properties than when it was damaged.
    #[error(
        "the parameters of column \"{0}\" (lengths, section, steel, resistances, hinges or supports) are not those \
         that it was damaged with; with the old ones the file can be used again"
    )]
    OtherParameters(String),
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Envelope<Content> {
    format: String,
    version: u32,
    /// SHA-256 over the content as compact JSON.
    checksum: String,
    content: Content,
}

/// What can be read of any version.
#[derive(Deserialize)]
struct Label {
    format: String,
    version: u32,
}

impl SavedState {
    /// The text of a state file.
    ///
    /// # Errors
    /// None that is known of: numbers and texts can be written as JSON.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(&Envelope {
            format: FORMAT.to_owned(),
            version: VERSION,
            checksum: checksum(self)?,
            content: self,
        })
    }

    /// Reads the text of a state file of the column that has these parameters.
    ///
    /// # Errors
    /// It is truncated, foreign, damaged, or of another column.
    pub fn from_json(text: &str, parameters: &Parameters) -> Result<Self, SavedStateError> {
        let malformed = |error: serde_json::Error| SavedStateError::Malformed(error.to_string());
        let Label { format, version } = serde_json::from_str(text).map_err(malformed)?;
        if format != FORMAT || version != VERSION {
            let format = super::impacts::shortened(&format);
            return Err(SavedStateError::Foreign { format, version });
        }
        let read: Envelope<Self> = serde_json::from_str(text).map_err(malformed)?;
        if checksum(&read.content).map_err(malformed)? != read.checksum {
            return Err(SavedStateError::Checksum);
        }
        let expected = &parameters.settings().column_id;
        if *read.content.column_id != **expected {
            return Err(SavedStateError::OtherColumn {
                found: super::impacts::shortened(&read.content.column_id),
                expected: expected.clone(),
            });
        }
        if *read.content.fingerprint != *fingerprint(parameters) {
            return Err(SavedStateError::OtherParameters(expected.clone()));
        }
        Ok(read.content)
    }
}

/// Digest of what the column is.
pub(super) fn fingerprint(parameters: &Parameters) -> String {
    let json = serde_json::to_string(&what_the_column_is(parameters)).unwrap_or_default();
    hex(&Sha256::digest(json))
}

fn checksum(content: &SavedState) -> Result<String, serde_json::Error> {
    Ok(hex(&Sha256::digest(serde_json::to_vec(content)?)))
}

pub(super) fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}"); // a String takes everything
        text
    })
}

impl Twin {
    /// The damage as it is to be kept: without what the present response will add.
    pub fn saved_state(&self, now: Nanos) -> SavedState {
        SavedState {
            column_id: Arc::clone(&self.column_id),
            fingerprint: Arc::clone(&self.fingerprint),
            stamp: now,
            condition: SavedCondition::from(&self.condition),
            impact_height: self.at_rest.model.properties.length_below,
            displacement: self.at_rest.state.displacement,
            plastic: self.at_rest.state.plastic,
            plastic_work_since_reset: self.life.plastic_work,
            impacts_since_reset: self.life.impacts,
            refused_since_reset: self.life.refused,
            last_event_id: Arc::clone(&self.life.last_event_id),
            seen_ids: self.seen.to_vec(),
        }
    }

    /// As it was when it was saved; where the load is another one now, in its new equilibrium.
    pub(super) fn restore(&mut self, saved: &SavedState) -> Result<(), ModelError> {
        let mut properties = self.parameters.column_properties();
        parameter_change::move_joint(&mut properties, saved.impact_height);
        let model = Model::new(&properties)?;
        let mut state = State::settled(&model, saved.displacement, saved.plastic);
        self.condition = Condition::from(&saved.condition);
        if self.condition == Condition::Standing {
            let is_as_saved =
                residual_state(&model, &state).is_some_and(|now| is_same_place(&now, &state));
            match equilibrium(&model, &state) {
                _ if is_as_saved => {}
                Some(now) => state = now,
                None => self.condition = no_equilibrium(),
            }
        }
        self.at_rest = AtRest { model, state };
        self.life = Life {
            impacts: saved.impacts_since_reset,
            refused: saved.refused_since_reset,
            plastic_work: saved.plastic_work_since_reset,
            last_event_id: Arc::clone(&saved.last_event_id),
        };
        Ok(())
    }

    pub(super) fn save(&self, now: Nanos, out: &mut impl Outputs) {
        out.put(Output::Save(Arc::new(self.saved_state(now))));
    }

    /// The state as it will be when the present response is over.
    pub(super) fn save_forecast(
        &self,
        report: &Report,
        residual: Option<State>,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let Some(run) = &self.run else {
            return;
        };
        let mut saved = self.saved_state(now);
        saved.condition = SavedCondition::from(&condition_after(report, residual.as_ref()));
        if let Some(residual) = residual {
            saved.displacement = residual.displacement;
            saved.plastic = residual.plastic;
        }
        saved.impact_height = run.model.properties.length_below;
        saved.plastic_work_since_reset += report.plastic_work;
        out.put(Output::Save(Arc::new(saved)));
    }
}

/// Whether two equilibria are one, found twice: nearer to each other than anybody can measure.
fn is_same_place(a: &State, b: &State) -> bool {
    const NEAR: f64 = 1e-9; // m and rad
    let (a, b) = (&a.displacement, &b.displacement);
    [a.v1 - b.v1, a.u1 - b.u1, a.beta1 - b.beta1, a.u2 - b.u2]
        .iter()
        .all(|off| off.abs() < NEAR)
}
