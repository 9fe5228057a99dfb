//! Sensors: what they read, detection, and estimates, against signals of a fibre-beam model of other authorship.

mod beam_signals;
mod cadence;
mod collapses;
mod detection;
mod estimates;
mod lies;
mod live;
mod made_impacts;
mod ranks;
mod readings;
mod signals;
mod sway;
mod unseen_impacts;
