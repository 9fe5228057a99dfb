//! One vehicle that hits several columns one after another: which impacts follow from its event, when each is due, and what is left
//! of the vehicle behind a column that gives way.

use crate::column::{End, Outcome, VehicleReport};
use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin_msgs::{ImpactEvent, RowImpactEvent};
use crate::messages::std_msgs::Header;
use crate::parameters::{crushed_name, split_crush};
use crate::time::{INVALID_STAMP_REASON, Nanos};
use crate::twin::{ForecastEnd, NoticeLevel, Output, ReportOutput, Striking};
use printable::Printable;

/// Most columns of one event.
pub const MAX_ROW_COLUMNS: usize = 100;

/// Longest time from the stamp of an event to a given impact \[s\].
pub const MAX_ROW_OFFSET: f64 = 60.0;

/// Longest distance between two columns \[m\].
pub const MAX_ROW_DISTANCE: f64 = 1000.0;

/// Most vehicles that are on their way to further columns at the same time.
pub const MAX_ROWS: usize = 64;

/// Speed below which a vehicle counts as stopped \[m/s\].
const STOPPED: f64 = 0.1;

/// Time from the stamp of an impact after which its forecast is no longer expected: the longest `response.duration` with some
/// time to compute it.
const FORECAST_PATIENCE: Nanos = 120_000_000_000;

const NANOS_PER_SEC: f64 = 1e9;

/// How an impact of a row begins.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Begin {
    /// At this time after the stamp of the event \[ns\].
    At(Nanos),
    /// With what the column before leaves of the vehicle, this far from it \[m\].
    After(f64),
}

/// An event whose own numbers are right.
#[derive(Debug, Clone, PartialEq)]
pub struct RowImpact {
    message: RowImpactEvent,
    stamp: Nanos,
    begins: Vec<Begin>,
}

impl RowImpact {
    /// # Errors
    /// Everything that is wrong with the message by itself. What it says of the vehicle is checked by each column.
    pub fn new(message: RowImpactEvent) -> Result<Self, Vec<String>> {
        let mut faults = Vec::new();
        let ids = &message.column_ids;
        if message.event_id.is_empty() {
            faults.push(
                "event_id is empty; give every event its own identifier, with which the identifiers of its impacts begin"
                    .to_owned(),
            );
        }
        if ids.is_empty() || ids.len() > MAX_ROW_COLUMNS {
            faults.push(format!(
                "column_ids has {} columns; expected 1 to {MAX_ROW_COLUMNS}",
                ids.len()
            ));
        }
        for (index, id) in ids.iter().enumerate().take(MAX_ROW_COLUMNS) {
            if ids[..index].contains(id) {
                faults.push(format!(
                    "column_ids names column {:?} twice; expected each column once",
                    Printable(id).to_string()
                ));
            }
        }
        for (name, list) in [
            ("offsets", &message.offsets),
            ("distances", &message.distances),
        ] {
            if !list.is_empty() && list.len() != ids.len() {
                faults.push(format!(
                    "{name} has {} values for {} columns; expected one for each, or none",
                    list.len(),
                    ids.len()
                ));
            }
        }
        let stamp = message.header.stamp.to_nanos();
        if stamp.is_none() {
            faults.push(INVALID_STAMP_REASON.to_owned());
        }
        if let (true, Some(stamp)) = (faults.is_empty(), stamp) {
            let begins = begins_of(&message, &mut faults);
            if faults.is_empty() {
                return Ok(Self {
                    message,
                    stamp,
                    begins,
                });
            }
        }
        Err(faults)
    }

    /// The identifier of the event.
    #[must_use]
    pub fn event_id(&self) -> &str {
        &self.message.event_id
    }

    /// The columns, in their order.
    #[must_use]
    pub fn column_ids(&self) -> &[String] {
        &self.message.column_ids
    }

    /// The impact on every column as the event describes it, for a look at whether the columns would take them. What hits a
    /// column after another one is not known yet and has the stamp of the event.
    #[must_use]
    pub fn described(&self) -> Vec<ImpactEvent> {
        let begins = self.begins.iter().enumerate();
        begins
            .map(|(index, begin)| {
                let offset = match begin {
                    Begin::At(offset) => *offset,
                    Begin::After(_) => 0,
                };
                self.impact(index, self.stamp.saturating_add(offset))
            })
            .collect()
    }

    /// What is wrong with the event, of which each column has told what hits it: a vehicle that is left to the parameters has to
    /// be the same for all columns.
    #[must_use]
    pub fn differing_vehicles(&self, striking: &[Striking]) -> Option<String> {
        let is_open = split_crush(&self.message.vehicle).0.trim().is_empty();
        let first = striking.first().filter(|_| is_open)?;
        let same = |it: &&Striking| {
            it.vehicle == first.vehicle
                && it.impact.vehicle == first.impact.vehicle
                && it.impact.mass == first.impact.mass
        };
        let other = striking.iter().position(|it| !same(&it))?;
        Some(format!(
            "the parameters of the columns {:?} and {:?} give different vehicles (vehicle.*), but it is one that hits them; name it in \
             the event",
            self.message.column_ids[0], self.message.column_ids[other]
        ))
    }

    fn impact(&self, index: usize, stamp: Nanos) -> ImpactEvent {
        impact(&self.message, index, Time::from_nanos(stamp))
    }
}

/// The impact on a column as an event describes it, at this stamp or that of the event.
fn impact(message: &RowImpactEvent, index: usize, stamp: Option<Time>) -> ImpactEvent {
    let RowImpactEvent {
        header,
        event_id,
        vehicle,
        mass,
        velocity,
        gap,
        restitution,
        height,
        direction,
        column_ids,
        ..
    } = message;
    let column_id = &column_ids[index];
    ImpactEvent {
        header: Header {
            stamp: stamp.unwrap_or(header.stamp),
            frame_id: header.frame_id.clone(),
        },
        column_id: column_id.clone(),
        event_id: format!("{event_id}/{column_id}"),
        vehicle: vehicle.clone(),
        mass: *mass,
        velocity: *velocity,
        gap: *gap,
        restitution: *restitution,
        height: *height,
        direction: *direction,
    }
}

fn begins_of(message: &RowImpactEvent, faults: &mut Vec<String>) -> Vec<Begin> {
    let mut begins = Vec::new();
    let mut last = 0.0;
    for index in 0..message.column_ids.len() {
        let left_open = if index == 0 { 0.0 } else { f64::NAN };
        let offset = message.offsets.get(index).copied().unwrap_or(left_open);
        let column = Printable(&message.column_ids[index]).to_string();
        if offset.is_nan() {
            let distance = message.distances.get(index).copied().unwrap_or(f64::NAN);
            if index == 0 {
                faults.push(format!(
                    "the offset of the first column, {column:?}, is NaN; expected a number, because no column is before it"
                ));
            } else if !(distance > 0.0 && distance <= MAX_ROW_DISTANCE) {
                faults.push(format!(
                    "the distance of column {column:?} from the one before is {distance} m; expected a number above 0, at most \
                     {MAX_ROW_DISTANCE} m, where no offset is given"
                ));
            }
            begins.push(Begin::After(distance));
            continue;
        }
        if !(last..=MAX_ROW_OFFSET).contains(&offset) {
            faults.push(format!(
                "the offset of column {column:?} is {offset} s; expected {last} s, the offset of the column before, to {MAX_ROW_OFFSET} s, \
                 or NaN"
            ));
        } else {
            last = offset;
        }
        begins.push(Begin::At((offset * NANOS_PER_SEC).round() as Nanos));
    }
    begins
}

/// What an impact leaves of the vehicle.
#[derive(Debug, Clone, PartialEq)]
pub enum LeftOver {
    /// It goes on behind the column.
    GoesOn {
        /// Its speed \[m/s\].
        velocity: f64,
        /// When its response has ended, after the stamp \[s\].
        at: f64,
        /// How far it has come by then behind the place of the column \[m\].
        place: f64,
    },
    /// It does not get any further, for this reason.
    Ends(String),
}

impl LeftOver {
    /// What the impact of a forecast or a result leaves of its vehicle. A column that stands has stopped the vehicle or thrown it
    /// back. Behind one that gives way the vehicle keeps the speed of the end of the response; the debris is not counted.
    #[must_use]
    pub fn of(output: &ReportOutput) -> Self {
        let report = &output.report;
        let word = match (report.outcome, report.end) {
            (_, End::NotConverged) => {
                return Self::Ends(
                    "the response could not be computed to its end, so that the residual motion of the vehicle is not known"
                        .to_owned(),
                );
            }
            (Outcome::Elastic | Outcome::Plastic, _) => {
                return Self::Ends("the column stands and has stopped the vehicle".to_owned());
            }
            (Outcome::Collapsed, _) => "the column has collapsed",
            (Outcome::Fractured, _) => "the column is fractured",
        };
        let velocity = report.impactor_velocity;
        if velocity < STOPPED {
            return Self::Ends(format!(
                "{word}, but the vehicle has stopped ({velocity:.3} m/s)"
            ));
        }
        Self::GoesOn {
            velocity,
            at: report.end_time,
            // The vehicle pushes the column in front of it, or has just left it.
            place: report.max_v1,
        }
    }
}

/// An impact that its column has, and that it may still reject. The next one may depend on its forecast.
#[derive(Debug)]
struct OnItsWay {
    row: RowImpact,
    /// The column that is hit, and when.
    at: usize,
    stamp: Nanos,
}

/// An impact that is kept until its column accepts its stamp.
#[derive(Debug)]
struct ToCome {
    event: ImpactEvent,
    stamp: Nanos,
    /// Its row, and its place there.
    row: RowImpact,
    at: usize,
}

/// Impacts of a row that no column computes: the vehicle does not get there, or the column rejects them.
#[derive(Debug, Clone, PartialEq)]
pub struct NotHit {
    /// The impacts, as the event described them.
    pub impacts: Vec<ImpactEvent>,
    /// Why.
    pub reason: String,
    /// ERROR if something that should have been known is not.
    pub level: NoticeLevel,
    /// Whether they were rejected: with the whole event, or alone when they were due.
    pub is_rejected: bool,
}

/// The rows under way. Knows neither threads nor clocks; time is passed in.
#[derive(Debug, Default)]
pub struct Rows {
    on_their_way: Vec<OnItsWay>,
    to_come: Vec<ToCome>,
    ended: Vec<NotHit>,
}

impl Rows {
    /// Takes an event whose impacts the columns would take.
    ///
    /// # Errors
    /// [`MAX_ROWS`] vehicles are on their way already.
    pub fn begin(&mut self, row: RowImpact) -> Result<(), String> {
        let under_way = self.on_their_way.len() + self.to_come.len();
        if under_way >= MAX_ROWS {
            return Err(format!(
                "{under_way} impacts of other vehicles on several columns are still to come; at most {MAX_ROWS} may be; send the event when \
                 they have happened"
            ));
        }
        for (index, begin) in row.begins.iter().enumerate() {
            if let Begin::At(offset) = begin {
                let stamp = row.stamp.saturating_add(*offset);
                self.to_come.push(ToCome {
                    event: row.impact(index, stamp),
                    stamp,
                    row: row.clone(),
                    at: index,
                });
            }
        }
        Ok(())
    }

    /// The impacts that are due, in the order of their stamps: those that are not further ahead than `max_ahead` \[ns\] of their
    /// column, by its identifier.
    pub fn due(&mut self, now: Nanos, max_ahead: impl Fn(&str) -> Nanos) -> Vec<ImpactEvent> {
        let is_due = |it: &ToCome| it.stamp.saturating_sub(max_ahead(&it.event.column_id)) <= now;
        let (mut due, later): (Vec<_>, Vec<_>) = self.to_come.drain(..).partition(is_due);
        self.to_come = later;
        due.sort_by_key(|it| it.stamp);
        due.into_iter()
            .map(|it| {
                let ToCome {
                    event,
                    stamp,
                    row,
                    at,
                } = it;
                self.on_their_way.push(OnItsWay { row, at, stamp });
                event
            })
            .collect()
    }

    /// An event is rejected, for which somebody may wait.
    pub fn reject(&mut self, message: &RowImpactEvent, reason: &str) {
        let columns = message.column_ids.len().min(MAX_ROW_COLUMNS);
        self.ended.push(NotHit {
            impacts: (0..columns)
                .map(|index| impact(message, index, None))
                .collect(),
            reason: reason.to_owned(),
            level: NoticeLevel::Warning,
            is_rejected: true,
        });
    }

    /// Whether nothing is under way, so that no output matters.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.on_their_way.is_empty() && self.to_come.is_empty() && self.ended.is_empty()
    }

    /// The stamp of the next impact that is kept.
    #[must_use]
    pub fn next_stamp(&self) -> Option<Nanos> {
        self.to_come.iter().map(|it| it.stamp).min()
    }

    /// Takes an output of a column. `crush` gives the largest crush of each spring of a vehicle after an impact: from what hit the
    /// column, and what that has crushed.
    pub fn take(
        &mut self,
        column_id: &str,
        output: &Output,
        crush: impl Fn(&Striking, &VehicleReport) -> Vec<f64>,
    ) {
        let (event_id, found) = match output {
            // The result comes where there is no forecast.
            Output::Forecast(found) | Output::Report(found) => (&found.event_id, Ok(found)),
            Output::Withdrawn(it) if !it.was_known && it.end != ForecastEnd::NotComputed => {
                (&it.impact.event_id, Err(&it.reason))
            }
            Output::Rejected(it) => (&it.event_id, Err(&it.rejection.reason)),
            _ => return,
        };
        let is_awaited = |it: &OnItsWay| {
            it.row.column_ids()[it.at] == column_id && it.row.event_id_at(it.at) == **event_id
        };
        let Some(place) = self.on_their_way.iter().position(is_awaited) else {
            return;
        };
        let OnItsWay { row, at, stamp } = self.on_their_way.swap_remove(place);
        let found = match found {
            Ok(found) => found,
            Err(reason) if matches!(output, Output::Rejected(_)) => {
                let event = row.impact(at, stamp);
                return self.rejected(&row, at, event, reason);
            }
            Err(reason) => {
                let reason =
                    format!("no forecast gives the residual motion of the vehicle: {reason}");
                return self.end(&row, at, &reason, NoticeLevel::Error);
            }
        };
        let (velocity, ended, way) = match LeftOver::of(found) {
            LeftOver::GoesOn {
                velocity,
                at,
                place,
            } => (velocity, at, place),
            LeftOver::Ends(reason) => {
                let level = match found.report.end {
                    End::NotConverged => NoticeLevel::Error,
                    _ => NoticeLevel::Info,
                };
                return self.end(&row, at, &reason, level);
            }
        };
        let next = at + 1;
        let Some(Begin::After(distance)) = row.begins.get(next) else {
            return;
        };
        let rest = (distance - way).max(0.0) / velocity;
        let contact = stamp.saturating_add(((ended + rest) * NANOS_PER_SEC).round() as Nanos);
        let striking = &found.striking;
        let name = split_crush(&striking.vehicle).0;
        let vehicle = match &striking.impact.vehicle {
            Some(_) => crushed_name(name, &crush(striking, &found.report.vehicle)),
            None => striking.vehicle.to_string(),
        };
        let event = ImpactEvent {
            vehicle,
            mass: striking.impact.mass,
            velocity,
            gap: 0.0,
            ..row.impact(next, contact)
        };
        self.to_come.push(ToCome {
            event,
            stamp: contact,
            row,
            at: next,
        });
    }

    /// An impact did not reach its column.
    pub fn not_submitted(&mut self, event: &ImpactEvent, reason: &str) {
        let is_its = |it: &OnItsWay| it.row.event_id_at(it.at) == event.event_id;
        if let Some(place) = self.on_their_way.iter().position(is_its) {
            let OnItsWay { row, at, .. } = self.on_their_way.swap_remove(place);
            self.rejected(&row, at, event.clone(), reason);
        }
    }

    /// The column of an impact rejects it, and what depends on it does not happen.
    fn rejected(&mut self, row: &RowImpact, at: usize, event: ImpactEvent, why: &str) {
        let reason = format!(
            "the impact on column {:?} was rejected: {why}",
            event.column_id
        );
        self.ended.push(NotHit {
            impacts: vec![event],
            reason: reason.clone(),
            level: NoticeLevel::Error,
            is_rejected: true,
        });
        self.end(row, at, &reason, NoticeLevel::Error);
    }

    /// Gives up the rows whose forecasts should have come long ago.
    pub fn give_up(&mut self, now: Nanos) {
        let is_late = |it: &OnItsWay| now.saturating_sub(it.stamp) > FORECAST_PATIENCE;
        while let Some(place) = self.on_their_way.iter().position(is_late) {
            let OnItsWay { row, at, .. } = self.on_their_way.swap_remove(place);
            let reason = format!(
                "the forecast of the impact on column {:?} did not arrive",
                row.column_ids()[at]
            );
            self.end(&row, at, &reason, NoticeLevel::Error);
        }
    }

    /// Gives up everything that is still to come, at a stop.
    pub fn stop(&mut self) {
        let reason = "the node is stopping";
        for OnItsWay { row, at, .. } in std::mem::take(&mut self.on_their_way) {
            self.end(&row, at, reason, NoticeLevel::Error);
        }
        for ToCome { event, row, at, .. } in std::mem::take(&mut self.to_come) {
            self.ended.push(NotHit {
                impacts: vec![event],
                reason: reason.to_owned(),
                level: NoticeLevel::Error,
                is_rejected: false,
            });
            self.end(&row, at, reason, NoticeLevel::Error);
        }
    }

    /// What has ended since the last call.
    pub fn take_ended(&mut self) -> Vec<NotHit> {
        std::mem::take(&mut self.ended)
    }

    /// The columns that depend on the impact on column `at` are not hit.
    fn end(&mut self, row: &RowImpact, at: usize, why: &str, level: NoticeLevel) {
        let followers = row.begins[at + 1..].iter();
        let followers = followers.take_while(|it| matches!(it, Begin::After(_)));
        let count = followers.count();
        if count == 0 {
            return;
        }
        let impacts = (at + 1..=at + count)
            .map(|index| row.impact(index, row.stamp))
            .collect();
        let hit = &row.column_ids()[at];
        self.ended.push(NotHit {
            impacts,
            reason: format!("the row ends at column {hit:?}: {why}"),
            level,
            is_rejected: false,
        });
    }
}

impl RowImpact {
    fn event_id_at(&self, index: usize) -> String {
        format!(
            "{}/{}",
            self.message.event_id, self.message.column_ids[index]
        )
    }
}
