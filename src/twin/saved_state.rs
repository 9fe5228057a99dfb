//! The damage of the column as text, which survives a restart of the program.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::assessed::LastImpact;
use super::damage_correction::DamageCorrection;
use super::life::Life;
use super::opinion_state::KnownBeamDamage;
use super::plant::{Condition, Plant, make_of};
use super::registry::printable;
use crate::column::{
    ColumnProperties, Displacement, ModelError, PerBar, PerBarHinges, PlasticFlow, WebState,
};
use crate::parameters::{Parameters, SectionShape};
use crate::standing::{Damage, StandingColumn};
use crate::time::Nanos;
use printable::Hexadecimal;

/// Format name in every state file.
const FORMAT: &str = "column_twin state";

/// The format version that this program writes, and the only one that it reads: version 3 has the damage of the beam in another form,
/// and the names of version 2 and of those before it are others.
const VERSION: u32 = 4;

/// The damage of the column, and the impacts that caused it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedState {
    /// Identifier of the column.
    pub column_id: Arc<str>,
    /// Digest of the properties to which the damage belongs: lengths, section, steel, resistances, hinges and supports.
    pub fingerprint: Arc<str>,
    /// When the state was saved \[ns since the epoch\].
    pub stamp: Nanos,
    /// Whether the column stands.
    pub condition: Condition,
    /// Height of hinges 1a and 1b above the base \[m\].
    pub impact_height: f64,
    /// Displacements in the residual equilibrium.
    pub displacement: Displacement,
    /// Plastic deformation of the hinges.
    pub plastic: PerBar<PlasticFlow>,
    /// Accumulated plastic rotations \[rad\].
    pub accumulated_rotation: PerBarHinges,
    /// Hardening of the webs; `None` where no web has yielded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub webs: Option<PerBar<WebState>>,
    /// Work dissipated in the hinges and webs since the last reset \[J\].
    pub plastic_work_since_reset: f64,
    /// Accepted impacts since the last reset.
    pub impacts_since_reset: u32,
    /// Rejected impacts since the last reset.
    pub rejected_since_reset: u64,
    /// Identifier of the last accepted impact; empty if there was none.
    pub last_event_id: Arc<str>,
    /// The last impact; `None` before the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_impact: Option<LastImpact>,
    /// Measurements by which the damage was corrected or confirmed since the last reset.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub corrections_since_reset: u32,
    /// The last of them; `None` without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_correction: Option<DamageCorrection>,
    /// The damage as the beam knows it.
    #[serde(default, skip_serializing_if = "KnownBeamDamage::is_undamaged")]
    pub beam: KnownBeamDamage,
    /// Whether the column may have a further damage, because an earlier state file could not be used; until the next reset.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_damage_unknown: bool,
    /// Identifiers of accepted impacts, the oldest first, at most [`MAX_SEEN_IDS`](super::MAX_SEEN_IDS).
    pub seen_ids: Vec<Arc<str>>,
}

/// Why a text is not a saved state of this column.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SavedStateError {
    /// The text is not JSON of the expected form.
    #[error("it is truncated, or not a state file of column_twin: {0}")]
    Malformed(String),
    /// An earlier version of the program wrote the text.
    #[error(
        "an earlier version of column_twin wrote it (format version {0}; this one reads version {VERSION}): examine the column and \
         call ~/reset if it is undamaged, or go on with the program that wrote the file"
    )]
    EarlierVersion(u32),
    /// The text has another format, or a later version.
    #[error(
        "it has format \"{format}\", version {version}; expected \"{FORMAT}\", version {VERSION}"
    )]
    OtherVersion {
        /// The format found.
        format: String,
        /// The version found.
        version: u32,
    },
    /// The checksum does not match the content.
    #[error("its checksum does not match its content: it was damaged or edited")]
    Checksum,
    /// The state belongs to another column.
    #[error("it belongs to column \"{found}\", but this is the twin of column \"{expected}\"")]
    OtherColumn {
        /// The column in the file.
        found: String,
        /// The column of this twin.
        expected: String,
    },
    /// The properties of the column differ from those with which it was damaged.
    #[error(
        "the lengths, section, steel, resistances, hinges or supports of column \"{0}\" differ from those with which it \
         was damaged; with the previous parameters the file can be used again"
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

/// The part that every version has.
#[derive(Deserialize)]
struct Header {
    format: String,
    version: u32,
}

impl SavedState {
    /// The damage of a column at rest.
    pub(super) fn new(
        column_id: &Arc<str>,
        fingerprint: &Arc<str>,
        plant: &Plant,
        life: &Life,
        seen_ids: Vec<Arc<str>>,
        now: Nanos,
    ) -> Self {
        let Life {
            impacts_since_reset,
            rejected_since_reset,
            plastic_work_since_reset,
            last_event_id,
            last_impact,
            corrections_since_reset,
            last_correction,
            beam,
            is_damage_unknown,
        } = life.clone();
        Self {
            column_id: Arc::clone(column_id),
            fingerprint: Arc::clone(fingerprint),
            stamp: now,
            condition: plant.condition.clone(),
            impact_height: plant.impact_height(),
            displacement: plant.state.displacement,
            plastic: plant.state.plastic,
            accumulated_rotation: plant.state.accumulated_rotation(),
            webs: plant.state.sheared_webs(),
            plastic_work_since_reset,
            impacts_since_reset,
            rejected_since_reset,
            last_event_id,
            last_impact,
            corrections_since_reset,
            last_correction,
            beam,
            is_damage_unknown,
            seen_ids,
        }
    }

    /// What the column has been through.
    pub(super) fn life(&self) -> Life {
        Life {
            impacts_since_reset: self.impacts_since_reset,
            rejected_since_reset: self.rejected_since_reset,
            plastic_work_since_reset: self.plastic_work_since_reset,
            last_event_id: Arc::clone(&self.last_event_id),
            last_impact: self.last_impact.clone(),
            corrections_since_reset: self.corrections_since_reset,
            last_correction: self.last_correction,
            beam: match (&self.beam, self.has_yielded()) {
                (KnownBeamDamage::Undamaged, true) => KnownBeamDamage::not_saved(),
                (known, _) => known.clone(),
            },
            is_damage_unknown: self.is_damage_unknown,
        }
    }

    /// The column at rest with this damage. Under a different load it is in the new equilibrium.
    ///
    /// # Errors
    /// The column is impossible.
    pub(super) fn plant(&self, properties: &ColumnProperties) -> Result<Plant, ModelError> {
        Plant::restored(properties, &self.standing(), self.condition.clone())
    }

    /// Whether a hinge or a web of the two bars has yielded.
    fn has_yielded(&self) -> bool {
        self.plastic != PerBar::<PlasticFlow>::default() || self.webs.is_some()
    }

    /// The column at rest that was saved.
    fn standing(&self) -> StandingColumn {
        StandingColumn {
            impact_height: self.impact_height,
            damage: Some(Damage {
                displacement: self.displacement,
                plastic: self.plastic,
                accumulated_rotation: self.accumulated_rotation,
                webs: self.webs,
            }),
        }
    }

    /// The text of a state file.
    ///
    /// # Errors
    /// A value cannot be represented in JSON.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(&Envelope {
            format: FORMAT.to_owned(),
            version: VERSION,
            checksum: checksum(self)?,
            content: self,
        })
    }

    /// Reads the text of a state file for the column with these parameters.
    ///
    /// # Errors
    /// The text is truncated or damaged, has another format, or belongs to another column.
    pub fn from_json(text: &str, parameters: &Parameters) -> Result<Self, SavedStateError> {
        let malformed = |error: serde_json::Error| SavedStateError::Malformed(error.to_string());
        let Header { format, version } = serde_json::from_str(text).map_err(malformed)?;
        if format == FORMAT && version < VERSION {
            return Err(SavedStateError::EarlierVersion(version));
        }
        if format != FORMAT || version != VERSION {
            let format = printable(&format);
            return Err(SavedStateError::OtherVersion { format, version });
        }
        let read: Envelope<Self> = serde_json::from_str(text).map_err(malformed)?;
        if checksum(&read.content).map_err(malformed)? != read.checksum {
            return Err(SavedStateError::Checksum);
        }
        let expected = &parameters.settings().column_id;
        if *read.content.column_id != **expected {
            return Err(SavedStateError::OtherColumn {
                found: printable(&read.content.column_id),
                expected: expected.clone(),
            });
        }
        if *read.content.fingerprint != *fingerprint(parameters) {
            return Err(SavedStateError::OtherParameters(expected.clone()));
        }
        Ok(read.content)
    }
}

/// Files without a correction of the damage are those of programs that know none.
#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes a reference"
)]
fn is_zero(number: &u32) -> bool {
    *number == 0
}

/// Digest of the properties to which a damage belongs: lengths, section, steel, resistances, hinges and supports.
pub(super) fn fingerprint(parameters: &Parameters) -> String {
    let mut json =
        serde_json::to_string(&make_of(&parameters.column_properties())).unwrap_or_default();
    // The fibres of an I section and of a hollow one may be equal in number, and so may the properties of the two bars.
    let shape = &parameters.settings().section.shape;
    if *shape != SectionShape::IOrH {
        json += &serde_json::to_string(shape).unwrap_or_default();
    }
    Hexadecimal(&Sha256::digest(json)).to_string()
}

fn checksum(content: &SavedState) -> Result<String, serde_json::Error> {
    let digest = Sha256::digest(serde_json::to_vec(content)?);
    Ok(Hexadecimal(&digest).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Value;

    /// Without the shear of the web, the two bars of both have the same properties.
    #[test]
    fn a_damage_belongs_to_the_shape_of_the_section() {
        let with_shape = |shape: &str| {
            let by_numbers = [
                ("section.name", Value::from("")),
                ("section.shape", shape.into()),
                ("section.area", 74.9e-4.into()),
                ("section.second_moment", 4471e-8.into()),
                ("section.mass_per_length", 58.8.into()),
                ("section.height", 0.2.into()),
                ("section.width", 0.2.into()),
                ("section.web_thickness", 0.01.into()),
                ("resistance.moment", 1.885e5.into()),
                ("shear.model", "none".into()),
                ("softening.model", "none".into()),
            ];
            let column = Parameters::default().with_changes(by_numbers);
            column.expect("consistent")
        };
        let [i_or_h, hollow] = ["i_or_h", "rectangular_hollow"].map(with_shape);
        assert_eq!(i_or_h.column_properties(), hollow.column_properties());
        assert_ne!(fingerprint(&i_or_h), fingerprint(&hollow));
    }
}
