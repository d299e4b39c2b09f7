//! `itarl rollout`: what a policy does, without learning and without wind.

use std::fmt::{self, Write};

use figures::Information;
use reward::Terms;
use runs::atomic;
use serde::Serialize;
use svenja::Morphology;

use super::{Outcome, json::print_json, print_line, subject::Subject};
use crate::{
    catalogue::information,
    cli::Rollout,
    rollout::{RolloutStep, Summary, roll_out},
};

pub(super) fn rollout(arguments: &Rollout) -> anyhow::Result<Outcome> {
    let subject = Subject::open(&arguments.what)?;
    let default = if subject.cell.is_some() { "learned" } else { "neutral" };
    let policy = arguments.policy.as_deref().unwrap_or(default);
    let mut driver = subject.driver(policy, arguments.seed)?;
    let mut table = arguments.csv.is_some().then(|| header(&subject.morphology));
    let see = |step: &RolloutStep<'_>| {
        if let Some(table) = &mut table {
            *table += &row(step);
        }
        Ok(())
    };
    let Subject { experiment, morphology, .. } = &subject;
    let driver = (&mut driver, arguments.seed);
    let summary = roll_out(experiment, morphology, driver, arguments.steps, see)?;
    if let (Some(path), Some(table)) = (&arguments.csv, table) {
        atomic::write(path, table.as_bytes())?;
    }
    let report = Report::new(&subject, policy, &summary);
    match arguments.print.json {
        true => print_json("rollout", report)?,
        false => print_line(report)?,
    }
    Ok(Outcome::Done)
}

/// What a rollout came to.
#[derive(Serialize)]
struct Report<'a> {
    robot: &'a str,
    policy: &'a str,
    control_steps: u64,
    seconds: f64,
    speed_m_per_step: f64,
    speed_m_s: f64,
    net_displacement_m: f64,
    heading_change_rad: f64,
    intrinsic_nats: f64,
    #[serde(skip)]
    information: Option<Information>,
    penalised_contacts: u64,
    actuators: usize,
    still_actuators: usize,
    contacts: Vec<Contact<'a>>,
}

/// The share of steps in which a body touched something.
#[derive(Serialize)]
struct Contact<'a> {
    body: &'a str,
    share: f64,
}

impl<'a> Report<'a> {
    fn new(subject: &'a Subject, policy: &'a str, summary: &Summary) -> Self {
        let (hz, morphology) = (subject.experiment.control.frequency_hz, &subject.morphology);
        let contacts = morphology.contacts().iter().zip(&summary.contacts);
        let contact = |(&body, &share): (&usize, &f64)| Contact {
            body: &morphology.bodies()[body].name,
            share,
        };
        Self {
            robot: morphology.name(),
            policy,
            control_steps: summary.steps,
            seconds: summary.steps as f64 / hz,
            speed_m_per_step: summary.advance_m,
            speed_m_s: summary.advance_m * hz,
            net_displacement_m: summary.net_displacement_m,
            heading_change_rad: summary.heading_change_rad,
            intrinsic_nats: summary.intrinsic_nats,
            information: information(&subject.experiment),
            penalised_contacts: summary.penalised_contacts,
            actuators: summary.target_changes.len(),
            still_actuators: summary.still_actuators(),
            contacts: contacts.map(contact).collect(),
        }
    }
}

fn header(morphology: &Morphology) -> String {
    let mut columns: Vec<String> =
        ["step", "x_m", "y_m", "z_m", "advance_m", "heading_change_rad", "penalised_contacts"]
            .map(str::to_owned)
            .into();
    columns.extend(Terms::NAMES.map(str::to_owned));
    let axis = |&id: &svenja::AxisId| morphology.axis_name(id);
    columns.extend(morphology.sensors().iter().map(|id| format!("sensor {}", axis(id))));
    let body = |&body: &usize| format!("contact {}", morphology.bodies()[body].name);
    columns.extend(morphology.contacts().iter().map(body));
    columns.extend(morphology.actuators().iter().map(|id| format!("target {}", axis(id))));
    let quoted = columns.iter().map(|column| match column.contains([',', '"', '\n']) {
        true => format!("\"{}\"", column.replace('"', "\"\"")),
        false => column.clone(),
    });
    quoted.collect::<Vec<_>>().join(",") + "\n"
}

fn row(step: &RolloutStep<'_>) -> String {
    let mut line = step.step.to_string();
    let position_m: [f64; 3] = step.episode.state().centre_of_gravity_m.into();
    let did = &step.did;
    let numbers = position_m
        .into_iter()
        .chain([did.advance_m, did.heading_change_rad, did.penalised_contacts as f64])
        .chain(did.terms.as_array())
        .chain(step.episode.readings().values.iter().copied())
        .chain(step.episode.targets().iter().copied());
    for number in numbers {
        // Writing to a string can't fail.
        let _ = write!(line, ",{number}");
    }
    line + "\n"
}

impl fmt::Display for Report<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let contact = |it: &Contact<'_>| format!("{} {:.0} %", it.body, 100.0 * it.share);
        let contacts: Vec<_> = self.contacts.iter().map(contact).collect();
        let nats = |it: &Information| {
            let name = format!("information {}", it.symbol);
            format!("{name:<20} {:.4} {}\n", self.intrinsic_nats, it.axis_unit())
        };
        write!(
            formatter,
            "{}, policy {}, {} control steps ({:.1} s)\n\
             speed along heading  {:+.4} m per control step ({:+.3} m/s)\n\
             net displacement     {:.3} m\n\
             heading change       {:+.1} degrees\n\
             {}penalised contacts   {}\n\
             actuators at rest    {} of {}\n\
             contacts             {}",
            self.robot,
            self.policy,
            self.control_steps,
            self.seconds,
            self.speed_m_per_step,
            self.speed_m_s,
            self.net_displacement_m,
            self.heading_change_rad.to_degrees(),
            self.information.as_ref().map(nats).unwrap_or_default(),
            self.penalised_contacts,
            self.still_actuators,
            self.actuators,
            contacts.join(", ")
        )
    }
}
