//! `itarl rollout`: what a policy does, without learning and without wind.

use std::fmt::Write;

use reward::Terms;
use runs::atomic;
use svenja::Morphology;

use super::{Outcome, print_line, subject::Subject};
use crate::{
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
    print_line(report(&subject, policy, &summary))?;
    Ok(Outcome::Done)
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

fn report(subject: &Subject, policy: &str, summary: &Summary) -> String {
    let hz = subject.experiment.control.frequency_hz;
    let bodies = subject.morphology.bodies();
    let contacts: Vec<_> = subject
        .morphology
        .contacts()
        .iter()
        .zip(&summary.contacts)
        .map(|(&body, share)| format!("{} {:.0} %", bodies[body].name, 100.0 * share))
        .collect();
    format!(
        "{}, policy {policy}, {} control steps ({:.1} s)\n\
         speed along heading  {:+.4} m per control step ({:+.3} m/s)\n\
         net displacement     {:.3} m\n\
         heading change       {:+.1} degrees\n\
         information          {:.4} nats per sensor\n\
         penalised contacts   {}\n\
         contacts             {}",
        subject.morphology.name(),
        summary.steps,
        summary.steps as f64 / hz,
        summary.advance_m,
        summary.advance_m * hz,
        summary.net_displacement_m,
        summary.heading_change_rad.to_degrees(),
        summary.intrinsic_nats,
        summary.penalised_contacts,
        contacts.join(", ")
    )
}
