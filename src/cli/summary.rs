//! The summary of one impact, for a person and for programs.

use std::fmt::{self, Display, Formatter};
use std::time::Duration;

use column_twin::assessment::{ActionRange, ImpactEvaluation};
use column_twin::column::{
    ForceSpectrum, HINGES, HingeReport, MAX_ELASTIC_IMPACT_IMPULSES, Outcome, Report,
};
use column_twin::figures::units::{Unit, significant};
use column_twin::observables::{HINGE_PLACES, WEB_PLACES};
use column_twin::parameters::{NoShear, readable};
use column_twin::report::{
    EnergyBalance, base_rows, end_in_words, in_kilo, instead_of_a_residual, outcome_in_words,
};
use column_twin::results::{BeamAnswer, ImpactFields, Travel};
use column_twin::second_opinion::{NoSecondOpinion, SecondOpinion};

/// Width of a terminal \[characters\].
const WIDTH: usize = 80;

/// The summary of one impact. [`Display`] gives the text for a person, [`json`](Self::json) the same for programs.
#[derive(Debug, Clone, Copy)]
pub struct Summary<'a> {
    /// One line that describes column and impact.
    pub title: &'a str,
    /// Name of the vehicle; empty if it is given by numbers.
    pub vehicle_name: &'a str,
    /// How it travels.
    pub travel: Travel,
    /// The outcome, and what it means.
    pub evaluation: &'a ImpactEvaluation,
    /// Computing time of the solver, without histories and figures.
    pub solve_time: Duration,
    /// What the fibre beam says, or why it says nothing, with its computing time; `None` where it was not asked.
    pub second_opinion: Option<(&'a Result<SecondOpinion, NoSecondOpinion>, Duration)>,
    /// The response spectrum of the contact force; `None` where its history was not asked.
    pub spectrum: Option<&'a ForceSpectrum>,
}

impl Summary<'_> {
    /// The summary as one JSON object.
    ///
    /// # Errors
    /// None in practice: numbers that are not finite become null.
    pub fn json(&self) -> serde_json::Result<String> {
        let fields = ImpactFields::of(
            self.evaluation,
            self.vehicle_name,
            self.travel,
            self.solve_time,
        );
        let fields = match self.spectrum {
            Some(spectrum) => fields.with_spectrum(spectrum),
            None => fields,
        };
        serde_json::to_string_pretty(&match self.second_opinion {
            Some((opinion, solve_time)) => fields.with_beam(BeamAnswer::of(opinion, solve_time)),
            None => fields,
        })
    }

    fn report(&self) -> &Report {
        &self.evaluation.report
    }

    fn time(&self, secs: f64) -> String {
        Unit::time(self.report().end_time).show(secs)
    }

    fn outcome(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let report = self.report();
        let verdict = outcome_in_words(report.outcome);
        let end = end_in_words(report.end);
        let by = match self.second_opinion {
            Some((Ok(opinion), _)) if opinion.decides => ", by the two bars",
            _ => "",
        };
        writeln!(f, "Outcome    {verdict}{by}")?;
        writeln!(f, "Ended      at {} ({end})", self.time(report.end_time))
    }

    /// The verdict, before everything else.
    fn verdict(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match (&self.evaluation.assessment, &self.evaluation.capacity_fault) {
            (Some(assessment), _) => {
                // Neither line is broken, so that the number that decides stands in the second one.
                let [what, why] = assessment.first_lines();
                writeln!(f, "Action     {what}\n           {why}")?;
                wrapped(f, "", assessment.reservations().trim_start())?;
            }
            (None, Some(fault)) => wrapped(f, "Action", &format!("NOT ASSESSED: {fault}"))?,
            (None, None) => wrapped(
                f,
                "Action",
                "NOT ASSESSED: the capacity of the column could not be computed",
            )?,
        }
        if let Some(range) = &self.evaluation.range {
            wrapped(f, "Range", &range.to_string())?;
        }
        match self.second_opinion {
            Some((Ok(opinion), _)) => wrapped(f, "Beam", &opinion.to_string()),
            Some((Err(reason), _)) => wrapped(f, "Beam", &reason.to_string()),
            None => Ok(()),
        }
    }

    /// One assumption after the other, with what it leads to.
    fn range(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(range) = &self.evaluation.range else {
            return Ok(());
        };
        writeln!(
            f,
            "\n{:<45}{:>12}{:>12}  action",
            "Range: one assumption changed at a time", "peak v1", "residual"
        )?;
        for it in &range.variations {
            let report = &it.report;
            let unit = Unit::length(report.max_v1);
            let instead = instead_of_a_residual(report.outcome).to_owned();
            let (peak, residual) = match report.residual_v1 {
                None => (instead, String::new()),
                Some(residual) => (unit.show(report.max_v1), unit.show(residual)),
            };
            writeln!(
                f,
                "  {:<16}{:<27}{peak:>12}{residual:>12}  {}",
                it.assumption.name(),
                it.instead,
                it.action.name()
            )?;
        }
        let not_varied: Vec<_> = range
            .not_varied
            .iter()
            .map(|(assumption, reason)| format!("{} ({reason})", assumption.in_words()))
            .collect();
        if !not_varied.is_empty() {
            wrapped(f, "Not varied", &not_varied.join("; "))?;
        }
        Ok(())
    }

    /// What the column still carries; whether it stands is never said without it.
    fn capacity(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(remaining) = &self.evaluation.remaining else {
            return Ok(());
        };
        let unit = Unit::force(remaining.undamaged.force);
        let bound = |is_lower: bool| if is_lower { "at least " } else { "" };
        writeln!(
            f,
            "\n{:<32}{:>14}{:>14}{:>14}",
            "Axial capacity in the plane", "undamaged", "now", "ratio"
        )?;
        writeln!(
            f,
            "  {:<30}{:>14}{:>14}{:>14}",
            "force of the push-down",
            unit.show(remaining.undamaged.force),
            format!(
                "{}{}",
                bound(remaining.now.is_lower_bound()),
                unit.show(remaining.now.force)
            ),
            format!("{:.1} %", 100.0 * remaining.ratio),
        )?;
        let lines = [
            (
                "applied load N, gamma_M = 1.0",
                Unit::force(remaining.carried_load).show(remaining.carried_load),
            ),
            (
                "N_u = ratio x strong axis",
                unit.show(remaining.axial_capacity),
            ),
            (
                "reserve N_u / N",
                remaining
                    .reserve
                    .map_or("none is carried".into(), |it| significant(it, 3)),
            ),
            (
                "EN 1993-1-1, strong axis",
                format!("{} when undamaged", unit.show(remaining.strong.force)),
            ),
            (
                "EN 1993-1-1, weak axis",
                remaining.weak.map_or("not known".into(), |it| {
                    format!("{} when undamaged", unit.show(it.force))
                }),
            ),
            (
                "remaining resistance",
                remaining
                    .resistance
                    .map_or("not known".into(), |it| unit.show(it)),
            ),
        ];
        lines
            .iter()
            .try_for_each(|(name, value)| writeln!(f, "  {name:<32}{value}"))
    }

    /// The vehicle: its crush and the energy that it absorbs, and the plateau of the column over its force.
    fn vehicle(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let evaluation = self.evaluation;
        let plateau = Unit::force(evaluation.plateau).show(evaluation.plateau);
        let report = self.report();
        let name = match self.vehicle_name {
            "" => "user-defined",
            name => name,
        };
        writeln!(f, "\nVehicle: {name}")?;
        let Some(front) = evaluation.front_force else {
            writeln!(f, "  {:<32}none: all energy goes into the column", "crush")?;
            return writeln!(f, "  {:<32}{plateau}", "plastic plateau F0");
        };
        let crushed = &report.vehicle;
        for index in 0..crushed.masses {
            let unit = Unit::length(crushed.max_crush[index]);
            let energy = Unit::energy(crushed.dissipated[index]);
            writeln!(
                f,
                "  {:<32}{} (permanent {}), absorbs {}",
                format!("crush of spring {}", index + 1),
                unit.show(crushed.max_crush[index]),
                unit.show(crushed.permanent_crush[index]),
                energy.show(crushed.dissipated[index]),
            )?;
        }
        writeln!(
            f,
            "  {:<32}{plateau} / {} = {}",
            "plateau F0 / crush force",
            Unit::force(front).show(front),
            significant(evaluation.plateau / front, 3),
        )
    }

    /// What the number of the peak displacement is worth.
    fn accuracy(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let evaluation = self.evaluation;
        let step = evaluation.step;
        writeln!(f, "\nAccuracy of the peak displacement")?;
        writeln!(
            f,
            "  {:<32}{}{}",
            "time step",
            Unit::time(step).show(step),
            evaluation.error_estimate.map_or(String::new(), |error| {
                format!("; relative error about {error:.1e}")
            })
        )?;
        if let Some(band) = evaluation.range.as_ref().and_then(ActionRange::band) {
            let unit = Unit::length(self.report().max_v1);
            let one = |index: usize, value: Option<f64>| match band[index].report.outcome {
                Outcome::Collapsed => "collapse".to_owned(),
                Outcome::Fractured => "a fractured hinge, web or base".to_owned(),
                Outcome::Elastic | Outcome::Plastic => {
                    let instead = || instead_of_a_residual(band[index].report.outcome).to_owned();
                    value.map_or_else(instead, |value| unit.show(value))
                }
            };
            let [least, most] = band.map(|it| readable(100.0 * it.hardening_ratio));
            for (name, values) in [
                ("peak v1", band.map(|it| Some(it.report.max_v1))),
                ("residual v1", band.map(|it| it.report.residual_v1)),
            ] {
                let (from, to) = (one(0, values[0]), one(1, values[1]));
                let name = format!("{name}, band of the steel");
                match from == to {
                    true => writeln!(f, "  {name:<32}{from} at both ends")?,
                    false => writeln!(f, "  {name:<32}{from} to {to}")?,
                }
            }
            let ends = match band[0].softens {
                true => format!("{least} % with buckling to {most} % without"),
                false => format!("{least} to {most} % without buckling"),
            };
            writeln!(f, "  {:<32}{ends}", "hardening of the steel")?;
        }
        let factors = self.report().max_dynamic_factor;
        let largest = factors.into_iter().fold(1.0, f64::max);
        if largest > 1.0 {
            writeln!(
                f,
                "  {:<32}at most {largest:.3} on the strength of a hinge",
                "dynamic increase factor"
            )?;
        }
        Ok(())
    }

    fn displacements(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let report = self.report();
        let (v1, u2) = (Unit::length(report.max_v1), Unit::length(report.max_u2));
        // Round-off of the solver is not a residual.
        let residual = |value: Option<f64>, unit: Unit| match value {
            None => instead_of_a_residual(report.outcome).to_owned(),
            Some(value) if value.abs() < 1e-15 => unit.show(0.0),
            Some(value) => unit.show(value),
        };
        writeln!(
            f,
            "\n{:<32}{:>14}{:>14}{:>14}",
            "Displacements", "peak", "time", "residual"
        )?;
        writeln!(
            f,
            "  {:<30}{:>14}{:>14}{:>14}",
            "v1  of the impact point",
            v1.show(report.max_v1),
            self.time(report.max_v1_time),
            residual(report.residual_v1, v1),
        )?;
        writeln!(
            f,
            "  {:<30}{:>14}{:>14}{:>14}",
            "u2  of the top, downwards",
            u2.show(report.max_u2),
            "",
            residual(report.residual_u2, u2),
        )
    }

    fn contact(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let report = self.report();
        writeln!(f, "\nContact")?;
        let Some(first) = report.first_contact_time else {
            return writeln!(f, "  none: the impactor did not reach the column");
        };
        let force = Unit::force(report.peak_contact_force);
        let at = report.peak_contact_force_time;
        let lines = [
            ("first contact", self.time(first)),
            (
                "last separation",
                report
                    .release_time
                    .map_or("none".into(), |time| self.time(time)),
            ),
            ("duration", self.time(report.contact_duration)),
            (
                "impact impulses",
                format!(
                    "{}, {} N s in total",
                    report.impact_impulses,
                    significant(report.total_impact_impulse, 4)
                ),
            ),
            (
                "peak contact force",
                format!(
                    "{}{}",
                    force.show(report.peak_contact_force),
                    at.map_or(String::new(), |time| format!(" at {}", self.time(time)))
                ),
            ),
            (
                "impulse with impact impulses",
                format!("{} N s", significant(report.impulse, 5)),
            ),
            (
                "final velocity of the impactor",
                format!("{} m/s", significant(report.impactor_velocity, 4)),
            ),
        ];
        lines
            .iter()
            .try_for_each(|(name, value)| writeln!(f, "  {name:<32}{value}"))
    }

    fn hinges(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\n{:<24}{:>14}{:>24}{:>16}",
            "Hinges in order of yield", "first yield", "plastic rotation", "utilisation"
        )?;
        let mut order: Vec<usize> = (0..HINGES).collect();
        let when = |hinge: usize| {
            self.report().hinges[hinge]
                .first_yield
                .unwrap_or(f64::INFINITY)
        };
        order.sort_by(|one, other| when(*one).total_cmp(&when(*other)));
        for hinge in order {
            let HingeReport {
                first_yield,
                max_utilisation,
                plastic_rotation,
                ..
            } = self.report().hinges[hinge];
            writeln!(
                f,
                "  {:<3}{:<19}{:>14}{:>24}{:>16}",
                HINGE_PLACES[hinge].name,
                HINGE_PLACES[hinge].words,
                first_yield.map_or("never".into(), |time| self.time(time)),
                format!(
                    "{:.5} rad {:>6.2}°",
                    plastic_rotation,
                    plastic_rotation.to_degrees()
                ),
                format!("{max_utilisation:.3}"),
            )?;
        }
        self.webs(f)
    }

    /// The shear of the webs, or why it is not evaluated.
    fn webs(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(why) = self.evaluation.no_shear {
            return match why {
                NoShear::SwitchedOff => Ok(()),
                NoShear::WebNotKnown => {
                    writeln!(f)?;
                    wrapped(f, "Shear", &format!("not evaluated: {why}."))
                }
            };
        }
        writeln!(
            f,
            "\n{:<24}{:>14}{:>24}{:>16}",
            "Webs in shear", "first yield", "plastic angle", "utilisation"
        )?;
        for (web, place) in self.report().webs.iter().zip(WEB_PLACES) {
            writeln!(
                f,
                "  {:<22}{:>14}{:>24}{:>16}",
                place.words,
                web.first_yield
                    .map_or("never".into(), |time| self.time(time)),
                format!(
                    "{:.5} rad {:>6.2}°",
                    web.plastic_angle,
                    web.plastic_angle.to_degrees()
                ),
                format!("{:.3}", web.max_utilisation),
            )?;
        }
        Ok(())
    }

    /// What the base has to bear.
    fn base(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let rows = base_rows(&self.report().base);
        if rows.is_empty() {
            return Ok(());
        }
        writeln!(
            f,
            "\n{:<32}{:>14}{:>14}{:>16}",
            "Base, means over 1 ms", "shear", "moment", "normal force"
        )?;
        for (name, forces) in rows {
            let [shear, moment, normal] = in_kilo(forces);
            writeln!(
                f,
                "  {name:<30}{:>14}{:>14}{:>16}",
                format!("{shear} kN"),
                format!("{moment} kNm"),
                format!("{normal} kN"),
            )?;
        }
        Ok(())
    }

    fn energy(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let report = self.report();
        let balance = EnergyBalance::from(report);
        let supplied = balance.supplied();
        let row = |f: &mut Formatter<'_>, name: &str, energy: f64| {
            let part = if supplied > 0.0 {
                100.0 * energy / supplied
            } else {
                0.0
            };
            writeln!(
                f,
                "  {name:<32}{} J{part:>10.2} %",
                aligned(energy, supplied)
            )
        };
        writeln!(f, "\nEnergy balance at the end")?;
        balance
            .spent
            .iter()
            .try_for_each(|entry| row(f, &entry.name, entry.energy))?;
        row(f, "sum", balance.sum())?;
        row(f, "supplied by the impactor", balance.by_impactor)?;
        row(f, "supplied by the load", balance.by_load)?;
        row(f, "supplied in total", supplied)?;
        writeln!(
            f,
            "  {:<32}{:.1e} of the energy of the impactor",
            "largest residual of a step", report.ledger_residual
        )
    }
}

/// An energy with a number of decimals that suits the magnitude of the sum.
fn aligned(energy: f64, sum: f64) -> String {
    let decimals =
        (5.0 - sum.abs().max(f64::MIN_POSITIVE).log10().floor()).clamp(0.0, 9.0) as usize;
    // Otherwise an energy of -1e-12 would be printed as -0.
    let shown = if energy.abs() < 0.5 * 10f64.powi(-(decimals as i32)) {
        0.0
    } else {
        energy
    };
    format!("{shown:>18.decimals$}")
}

impl Display for Summary<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.verdict(f)?;
        writeln!(f, "\n{}\n", self.title)?;
        self.outcome(f)?;
        self.capacity(f)?;
        self.displacements(f)?;
        self.range(f)?;
        self.accuracy(f)?;
        self.vehicle(f)?;
        self.contact(f)?;
        self.hinges(f)?;
        self.base(f)?;
        self.energy(f)?;
        writeln!(
            f,
            "\nSolved in {} ({} steps)",
            Unit::time(self.solve_time.as_secs_f64()).show(self.solve_time.as_secs_f64()),
            self.report().steps,
        )?;
        if self.report().restitution_ended_early() {
            writeln!(
                f,
                "Rattling   from impact impulse {MAX_ELASTIC_IMPACT_IMPULSES} on the restitution was 0"
            )?;
        }
        Ok(())
    }
}

/// A text behind its name, in lines that fit into a terminal.
pub(super) fn wrapped(f: &mut impl fmt::Write, name: &str, text: &str) -> fmt::Result {
    let mut line = format!("{name:<10}");
    let indent = line.len();
    for word in text.split(' ') {
        let has_words = line.len() > indent;
        if has_words && line.chars().count() + 1 + word.chars().count() > WIDTH {
            writeln!(f, "{line}")?;
            line = " ".repeat(indent);
        }
        line.push(' ');
        line.push_str(word);
    }
    writeln!(f, "{line}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::reference::Reference;
    use column_twin::assessment::respond_and_rest;
    use column_twin::parameters::Parameters;

    /// The evaluation of this report on the paper's column, with the state in which the program leaves it.
    fn evaluated(report: &Report) -> ImpactEvaluation {
        let paper = concat!(env!("CARGO_MANIFEST_DIR"), "/config/heb220_paper.yaml");
        let parameters = Parameters::load(&[paper.into()], &[]).unwrap();
        let (properties, impact) = (parameters.column_properties(), parameters.impact());
        let duration = parameters.response_duration();
        let (_, rest) = respond_and_rest(&properties, &impact, duration).unwrap();
        ImpactEvaluation::complete(&parameters, &properties, &impact, (*report, rest)).unwrap()
    }

    fn summary<'a>(evaluation: &'a ImpactEvaluation) -> Summary<'a> {
        Summary {
            title: "HEB220, 1500 kg at 10 m/s (36.00 km/h), 1 m above the base",
            vehicle_name: "rigid",
            travel: Travel {
                velocity: 10.0,
                direction: 0.0,
                in_plane: 10.0,
            },
            evaluation,
            solve_time: Duration::from_micros(5300),
            second_opinion: None,
            spectrum: None,
        }
    }

    fn text(report: &Report) -> String {
        summary(&evaluated(report)).to_string()
    }

    #[test]
    fn the_summary_has_the_expected_text() {
        let reference = Reference::ellipse();
        let text = text(&reference.report);
        println!("{text}");
        assert_eq!(text, include_str!("../../tests/data/summary_ellipse.txt"));
    }

    #[test]
    fn no_line_behind_the_two_of_the_action_is_wider_than_a_terminal() {
        let mut report = Reference::duan_chen().report;
        report.hinges[0].plastic_rotation = -1.234_567;
        report.residual_v1 = None;
        report.first_contact_time = None;
        for outcome in [
            Outcome::Elastic,
            Outcome::Plastic,
            Outcome::Collapsed,
            Outcome::Fractured,
        ] {
            for line in text(&Report { outcome, ..report }).lines().skip(2) {
                assert!(line.chars().count() <= 80, "{line:?}");
            }
        }
    }

    #[test]
    fn programs_get_numbers_and_nulls() {
        let mut report = Reference::ellipse().report;
        report.hinges[2].first_yield = None;
        report.release_time = None;
        report.impulse = f64::NAN;
        report.vehicle.masses = 2;
        report.vehicle.max_crush = [0.5, 0.1, 0.0];
        report.vehicle.velocity = [-1.0, -2.0, 0.0];
        report.max_dynamic_factor = [1.1, 1.2, 1.3, 1.4];
        let evaluation = evaluated(&report);
        let json = summary(&evaluation).json().unwrap();
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(json["vehicle"], "rigid");
        assert_eq!(json["crush_max_m"], serde_json::json!([0.5, 0.1]));
        assert_eq!(
            json["vehicle_velocity_m_s"],
            serde_json::json!([-1.0, -2.0])
        );
        assert_eq!(
            json["dynamic_factor_max"],
            serde_json::json!([1.1, 1.2, 1.3, 1.4])
        );
        let number = |name: &str| json[name].as_f64().expect(name);
        let ratio = number("residual_capacity_n") / number("undamaged_capacity_n");
        assert!((ratio - number("capacity_ratio")).abs() < 1e-12 && ratio < 0.95);
        let reserve = number("axial_capacity_n") / number("carried_load_n");
        assert!((reserve - number("reserve")).abs() < 1e-12 && reserve > 1.0);
        assert_eq!(number("dt_s"), 2e-5);
        assert!(number("error_estimate") < 1e-2);
        let criteria = json["criteria"].as_array().unwrap();
        let deciding = criteria
            .iter()
            .find(|it| it["name"] == json["deciding_criterion"])
            .expect("the deciding criterion is listed");
        assert_eq!(deciding["action"], json["action"]);
        for name in ["name", "edition", "value", "limit", "margin", "tag"] {
            assert!(criteria.iter().all(|it| it.get(name).is_some()), "{name}");
        }
        assert_eq!(json["max_v1_m"], report.max_v1);
        assert_eq!(json["outcome"], "plastic");
        assert_eq!(json["end"], "at_rest");
        assert_eq!(json["solve_time_s"], 0.0053);
        assert!(json["release_time_s"].is_null() && json["impulse_n_s"].is_null());
        assert_eq!(json["hinges"]["3"]["first_yield_s"], 0.000_317);
        assert!(json["hinges"]["2"]["first_yield_s"].is_null());
        let names: Vec<_> = json["hinges"].as_object().unwrap().keys().collect();
        assert_eq!(names, ["1a", "1b", "2", "3"]);
    }
}
