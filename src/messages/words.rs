//! The words that people see for the numbers of phases and severities in messages. Those that call for somebody are capitals.

use super::column_twin::TwinStatus;

/// The word for a phase in `ColumnState`, `TwinStatus` and `ColumnStatus`.
#[must_use]
pub fn phase_word(phase: u8) -> &'static str {
    match phase {
        TwinStatus::IDLE => "idle",
        TwinStatus::APPROACH => "approach",
        TwinStatus::CONTACT => "contact",
        TwinStatus::FREE => "free",
        TwinStatus::REST => "rest",
        TwinStatus::COLLAPSED => "COLLAPSED",
        TwinStatus::FAULTED => "FAULTED",
        TwinStatus::SEVERED => "SEVERED",
        _ => "unknown",
    }
}

/// The word for a severity in `ImpactReport`, `TwinStatus` and `ColumnStatus`.
#[must_use]
pub fn severity_word(severity: u8) -> &'static str {
    match severity {
        TwinStatus::SEVERITY_NONE => "none",
        TwinStatus::SEVERITY_INSPECT => "inspect",
        TwinStatus::SEVERITY_RESTRICT => "RESTRICT",
        TwinStatus::SEVERITY_PROP => "PROP",
        TwinStatus::SEVERITY_EVACUATE => "EVACUATE",
        _ => "unknown",
    }
}
