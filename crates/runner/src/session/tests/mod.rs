//! The loop against the paper's equations, worked out again from what was recorded.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use config::Document;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use policy::Start;
use reward::{RobotState, Terms, Transition};

use super::{actor::Buffers, *};
use crate::experiment::{EvolutionSettings, Experiment, LearnerSettings};

mod checkpoints;

/// T
const T: usize = 60;

fn crawler() -> (Experiment, Morphology) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/models/crawler.toml");
    let text = format!(
        "model = 'crawler.toml'
        control.frequency_hz = 5
        physics = {{ frequency_hz = 50, iterations = 20 }}
        policy = {{ hidden_units = 3, samples = 6, initial_scale = 0.5 }}
        reward = {{ mix.xi = 0.75, scale = 10 }}
        perturbation = {{ every = 50, length = 7, flip_probability = 1 }}
        learning = {{ steps_per_update = {T}, rate = 2, decay = 0.01, momentum = 0.5 }}
        record = {{ steps = 1000, pose_every = 5 }}"
    );
    let experiment = Document::parse("crawler", &text).unwrap().read(Experiment::read).unwrap();
    // Its arm never touches the ground, and its forearm does now and then.
    let model = std::fs::read_to_string(path).unwrap();
    let model = model.replace("penalised = [\"upper arm\"]", "penalised = [\"forearm\"]");
    (experiment, Morphology::parse("crawler.toml", &model).unwrap())
}

fn session() -> (Session, Morphology) {
    (settled(1), crawler().1)
}

/// A cell of so many worlds that hasn't moved yet.
fn build(worlds: usize) -> Session {
    let (mut experiment, morphology) = crawler();
    experiment.learning.worlds = worlds;
    if worlds == EVOLVING {
        let settings = EvolutionSettings { sigma: 0.3, skip: 7 };
        experiment.learning.learner = LearnerSettings::Evolution(settings);
    }
    Session::build(&experiment, &morphology, None, 4).unwrap()
}

/// So many worlds are a population.
const EVOLVING: usize = 6;

fn settled(worlds: usize) -> Session {
    let mut session = build(worlds);
    while session.is_settling() {
        advance(&mut session);
    }
    session
}

/// A control step, alone.
fn advance(session: &mut Session) {
    control_step(&mut [session], &mut Solver::bullet()).remove(0).unwrap();
}

fn update(session: &mut Session) -> Row {
    while !session.is_to_learn() {
        advance(session);
    }
    session.learn().unwrap()
}

/// z, Delta and the momentum step, as they stand in the paper. Sums in another order differ by
/// roundings of numbers below 10.
#[test]
fn scores_and_rewards_move_the_parameters_as_the_paper_says() {
    let (mut session, _) = session();
    let n = session.policy.parameters().len();
    let mut change = vec![0.0; n];
    for _ in 0..3 {
        let before = session.policy.parameters().to_vec();
        let (mut z, mut delta) = (vec![0.0; n], vec![0.0; n]);
        for k in 1..=T {
            advance(&mut session);
            let terms = session.recording().terms;
            let r = terms[terms.len() - Terms::NAMES.len()];
            for i in 0..n {
                z[i] = 0.75 * z[i] + session.actors[0].buffers.score[i];
                delta[i] += (r * z[i] - delta[i]) / k as f64;
            }
        }
        session.learn().unwrap();
        for i in 0..n {
            change[i] = 2.0 * (delta[i] - 0.01 * before[i]) + 0.5 * change[i];
            let error = session.policy.parameters()[i] - (before[i] + change[i]);
            assert!(error.abs() < 1e-12, "parameter {i}: {error}");
        }
        assert!(change.iter().any(|d| d.abs() > 1e-6), "nothing is learned");
    }
}

/// What a world does in its first update is its own: the first one's is that of a cell of one world,
/// the others' is another. Then all have the parameters to which the mean of their gradients led.
#[test]
fn worlds_share_the_parameters_and_nothing_else() {
    let (mut one, mut three, mut four) = (settled(1), settled(3), settled(4));
    let start = one.policy.parameters().to_vec();
    let first = |session: &mut Session| {
        (0..T).for_each(|_| advance(session));
        // Steps, sum of rewards, trace, gradient.
        let gradient = |world| session.learner.state(world)[2 + start.len()..].to_vec();
        (0..session.worlds()).map(gradient).collect::<Vec<_>>()
    };
    let alone = first(&mut one);
    let together = first(&mut three);
    assert_eq!(together[0], alone[0]);
    assert_eq!(together, first(&mut four)[..3]);
    assert_ne!(together[0], together[1]);
    assert_ne!(together[1], together[2]);
    assert_eq!((one.control_steps(), three.control_steps()), (T as u64, 3 * T as u64));

    let displacements: Vec<_> = three.actors.iter().map(|actor| actor.sums.clone()).collect();
    let row = three.learn().unwrap();
    assert_eq!((row.update, row.control_steps), (1, 3 * T as u64));
    let alone = |sums, actor: &Actor| {
        update_sums::row([(sums, actor.episode.state())].into_iter(), T as u64)
    };
    let rows = displacements.iter().zip(&three.actors).map(|(sums, actor)| alone(sums, actor));
    let rows: Vec<Row> = rows.collect();
    let mean = |value: fn(&Row) -> f64| rows.iter().map(value).sum::<f64>() / 3.0;
    // Sums in another order, of numbers below 1.
    let values: [fn(&Row) -> f64; 3] =
        [|row| row.reward, |row| row.advance_m, |row| row.net_displacement_m];
    for value in values {
        assert!((value(&row) - mean(value)).abs() < 1e-14 && value(&row) != 0.0);
    }
    for i in 0..start.len() {
        let gradient = together.iter().map(|of_world| of_world[i]).sum::<f64>() / 3.0;
        let expected = start[i] + 2.0 * (gradient - 0.01 * start[i]);
        assert!((three.policy.parameters()[i] - expected).abs() < 1e-12, "parameter {i}");
    }
    advance(&mut three);
    for actor in &three.actors {
        assert_eq!(actor.policy.parameters(), three.policy.parameters());
    }
}

/// Each update is an episode from where the robots settled: a candidate does what any cell does with
/// its parameters, and the step goes where the better candidates are.
#[test]
fn a_population_evolves() {
    let mut session = settled(EVOLVING);
    let n = session.policy.parameters().len();
    let strategy = evolution::Strategy::new(EVOLVING, 0.3, 4).unwrap();
    let mut change = vec![0.0; n];
    let mut start = None;
    for generation in 0..3 {
        let theta = session.policy.parameters().to_vec();
        let mut fitness = [0.0; EVOLVING];
        session.begin_update().unwrap();
        let place = |actor: &Actor| actor.episode.state().centre_of_gravity_m;
        start.get_or_insert(place(&session.actors[0]));
        assert!(session.actors.iter().all(|actor| Some(place(actor)) == start));
        for step in 1..=T {
            advance(&mut session);
            for (world, actor) in session.actors.iter().enumerate() {
                let mut candidate = vec![0.0; n];
                strategy.candidate(generation, world, &theta, &mut candidate);
                assert_eq!(actor.policy.parameters(), candidate);
                if step > 7 {
                    fitness[world] += actor.terms.reward;
                }
            }
        }
        let mut gradient = vec![0.0; n];
        strategy.gradient(generation, &fitness, &mut gradient).unwrap();
        let row = session.learn().unwrap();
        assert_eq!(row.control_steps, (generation + 1) * (T * EVOLVING) as u64);
        for i in 0..n {
            change[i] = 2.0 * (gradient[i] - 0.01 * theta[i]) + 0.5 * change[i];
            let error = session.policy.parameters()[i] - (theta[i] + change[i]);
            assert!(error.abs() < 1e-12, "parameter {i}: {error}");
        }
        assert!(gradient.iter().any(|g| *g != 0.0));
    }
}

/// Flipped bits are executed, and the score is that of the policy's own output.
#[test]
fn the_wind_changes_what_is_done_and_not_what_is_learned() {
    let (mut session, _) = session();
    let (experiment, morphology) = crawler();
    let mut policy = build_policy(&experiment, &morphology, 4).unwrap();
    let mut n_flipped = 0;
    for step in 0..2 * T as u64 {
        let inputs = session.actors[0].episode.codec.inputs().to_vec();
        policy.set_parameters(session.policy.parameters()).unwrap();
        policy.set_random_state(&session.actors[0].policy.random_state()).unwrap();
        advance(&mut session);
        let Buffers { output, action, score, .. } = &session.actors[0].buffers;

        let is_active = step >= 50 && step % 50 < 7;
        n_flipped += usize::from(is_active);
        for (done, own) in action.iter().zip(output) {
            assert_eq!(done != own, is_active, "step {step}");
        }
        let executed: Vec<_> = action.iter().map(|&bit| if bit { 0.5 } else { -0.5 }).collect();
        assert_eq!(session.actors[0].episode.targets(), executed);

        let (mut own, mut own_score) = (vec![false; output.len()], vec![0.0; score.len()]);
        policy.act_and_score(&inputs, &mut own, &mut own_score).unwrap();
        assert_eq!((output, score), (&own, &own_score), "step {step}");
    }
    assert_eq!(n_flipped, 14);
}

/// Sum over s' of p(s'|s) ln(p(s'|s) / p(s')) with the pairs' own frequencies.
fn surprise(bins: &[u64]) -> f64 {
    let pairs: Vec<_> = bins.windows(2).map(|pair| (pair[0], pair[1])).collect();
    let (s, _) = pairs[pairs.len() - 1];
    let n_s = pairs.iter().filter(|pair| pair.0 == s).count() as f64;
    let mut successors = BTreeMap::new();
    for &(_, next) in pairs.iter().filter(|pair| pair.0 == s) {
        *successors.entry(next).or_insert(0.0) += 1.0;
    }
    let p = |next: &u64| {
        pairs.iter().filter(|pair| pair.1 == *next).count() as f64 / pairs.len() as f64
    };
    successors.iter().map(|(next, n)| n / n_s * (n / n_s / p(next)).ln()).sum()
}

/// Every term of the reward, from recorded poses, readings and contacts.
#[test]
fn rewards_are_what_the_record_makes_them() {
    let (mut session, morphology) = session();
    let first_bins = session.actors[0].episode.codec.bins().to_vec();
    let rows: Vec<_> = (0..4).map(|_| update(&mut session)).collect();
    let record = session.recording();
    let n_bodies = morphology.bodies().len();
    let n_steps = record.n_steps;
    assert_eq!((n_steps, record.layout.frames_per_step), (4 * T, 2));

    // Of the last frame, at a control step's end.
    let pose =
        |step: usize, body: usize| &record.poses[((2 * step + 1) * n_bodies + body) * 7..][..7];
    let centre_of_gravity = |step: usize| {
        let weighted = morphology.bodies().iter().enumerate().map(|(i, body)| {
            let p = pose(step, i);
            Vector3::new(p[0], p[1], p[2]).cast::<f64>() * body.mass_kg
        });
        weighted.sum::<Vector3<f64>>() / morphology.total_mass_kg()
    };
    let heading = |step: usize| {
        let q = pose(step, morphology.heading().body);
        let q = Quaternion::new(q[6], q[3], q[4], q[5]).cast::<f64>();
        UnitQuaternion::from_quaternion(q) * *morphology.heading().axis
    };
    let bins = |sensor: usize| -> Vec<u64> {
        let readings = record.sensors.chunks(morphology.n_readings());
        let later = readings.map(|reading| u64::from(reading[sensor] >= 0.0));
        [first_bins[sensor]].into_iter().chain(later).collect()
    };
    let positions = [bins(0), bins(1)];

    for step in 0..n_steps {
        let [r, raw, extrinsic, nats, _, intrinsic, penalty, xi] =
            record.terms[step * 8..][..8].try_into().unwrap();
        if step > 0 {
            let moved = centre_of_gravity(step) - centre_of_gravity(step - 1);
            // Poses are recorded in single precision, about 1e-7 of lengths below 2 m.
            let advance = moved.xy().dot(&heading(step).xy());
            assert!((raw - advance).abs() < 1e-6, "step {step}: {raw} {advance}");
        }
        assert_eq!(extrinsic, 5.0 * raw);

        // The window holds the last 100 pairs, of 101 readings, or those there are. Roundings.
        let window = (step + 1).saturating_sub(100)..step + 2;
        let information: f64 =
            positions.iter().map(|bins| surprise(&bins[window.clone()])).sum::<f64>() / 2.0;
        assert!((nats - information).abs() < 1e-12, "step {step}: {nats} {information}");
        let most = 2.0_f64.ln();
        assert!((intrinsic - 0.1 * nats / most).abs() < 1e-12, "step {step}");

        let touches = |body: usize| usize::from(record.contacts[step * n_bodies + body]);
        let n: usize = morphology.penalised().iter().map(|&body| touches(body)).sum();
        assert!((penalty - 10.0 * 0.0001 * n as f64).abs() < 1e-15, "step {step}");
        let mixed = (extrinsic.abs().powf(0.75) * intrinsic.powf(0.25)).powi(2);
        let expected = 10.0 * mixed.copysign(extrinsic) - penalty;
        assert!((r - expected).abs() < 1e-12, "step {step}: {r} {expected}");
        assert_eq!(xi, 0.75);
    }
    let penalised = record.terms.chunks(8).filter(|terms| terms[6] > 0.0).count();
    assert!((1..n_steps).contains(&penalised), "{penalised} steps with a penalty");

    for (row, terms) in rows.iter().zip(record.terms.chunks(8 * T)) {
        let mean = |term: usize| terms.chunks(8).map(|it| it[term]).sum::<f64>() / T as f64;
        assert_eq!((row.reward, row.advance_m), (mean(0), mean(1)));
        assert_eq!((row.intrinsic_nats, row.intrinsic), (mean(3), mean(5)));
        assert_eq!(row.control_steps, row.update * T as u64);
    }
}

#[test]
fn a_session_starts_from_what_another_has_exported() {
    let (mut one, morphology) = session();
    update(&mut one);
    let file = one.policy_file().unwrap();
    let (mut experiment, _) = crawler();
    let as_drawn = Session::build(&experiment, &morphology, None, 5).unwrap();
    experiment.policy.start = Start::File("/x".into());
    let started = Session::build(&experiment, &morphology, Some(&file), 5).unwrap();
    assert_eq!(started.policy.parameters(), one.policy.parameters());
    // What it draws is the seed's, wherever its parameters are from.
    assert_eq!(started.actors[0].policy.random_state(), as_drawn.actors[0].policy.random_state());

    let error = Session::build(&experiment, &morphology, None, 5).err().unwrap().to_string();
    assert!(error.starts_with("policy.initial: /x: safetensors: the file must be"), "{error}");
}

/// Where the body pitches by 60 degrees, a metre counts half: the heading's part in the XY plane isn't
/// normalised, as the documents say.
#[test]
fn a_heading_that_pitches_counts_less() {
    let (experiment, _) = crawler();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/models/crawler.toml");
    let model = std::fs::read_to_string(path).unwrap();
    let model = model.replace("start = {", "start = { rotation_deg = [60.0, 0.0, 0.0],");
    let morphology = Morphology::parse("crawler.toml", &model).unwrap();
    let body = Body::new(&experiment, &morphology).unwrap();
    let mut after = RobotState::default();
    body.read_state(&mut after);
    let mut before = after.clone();
    before.centre_of_gravity_m -= Vector3::new(0.3, 1.0, 0.2);
    let step = Transition::between(&before, &after);
    // Single precision.
    assert!((step.advance_m() - 0.5).abs() < 1e-6);
    for page in ["notation.md", "run-folders.md", "experiment-files.md"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(page);
        let page = std::fs::read_to_string(path).unwrap();
        let said =
            page.lines().filter(|line| line.contains("displacement of the centre of gravity"));
        assert!(page.contains("pitches") && said.count() > 0, "{page}");
    }
}

/// What a task sees of the robot is what is recorded of it, and moves as it's told to.
#[test]
fn a_task_sees_the_robot_as_it_is_recorded() {
    let (mut session, morphology) = session();
    let n = morphology.bodies().len();
    for _ in 0..30 {
        let before = session.actors[0].episode.state().clone();
        advance(&mut session);
        let state = session.actors[0].episode.state();
        let recorded = session.actors[0].episode.recorded(&[]);
        let last_frame = &recorded.poses[recorded.poses.len() - 7 * n..];
        for (body, pose) in state.bodies.iter().zip(last_frame.chunks(7)) {
            let (t, q) = (body.pose.translation.vector, body.pose.rotation.coords);
            let expected = [t.x, t.y, t.z, q.x, q.y, q.z, q.w].map(|value| value as f32);
            assert_eq!(pose, expected);
        }
        let contacts: Vec<_> = recorded.contacts.iter().map(|&it| it == 1).collect();
        assert_eq!(state.contacts, contacts);
        assert_eq!(state.readings, session.actors[0].episode.readings().values);
        assert_eq!(state.penalised_contacts, usize::from(contacts[2]));
        // Ten physics steps of 0.02 s: no body is faster in the mean than it is at its fastest, which the
        // servos' 2.5 rad/s on two arms of 0.3 m bound with a good margin.
        for (was, is) in before.bodies.iter().zip(&state.bodies) {
            let moved = is.pose.translation.vector - was.pose.translation.vector;
            assert!(moved.norm() < 0.2 * 5.0 && is.linear_velocity_m_s.norm() < 5.0);
        }
    }
}

/// A leg's joints are a chain, fixed parts in between or not, and legs aren't beside each other.
#[test]
fn neighbours_are_next_to_each_other_along_a_chain() {
    let neighbours = |model: &str| -> Vec<String> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models").join(model);
        let morphology = Morphology::open(&path).unwrap();
        let (experiment, _) = crawler();
        let layout = episode::robot_layout(&experiment, &morphology);
        let name = |position: usize| morphology.axis_name(morphology.sensors()[position]);
        layout.neighbours.iter().map(|&[a, b]| format!("{} - {}", name(a), name(b))).collect()
    };
    // Each leg: two axes of its hip with the knee, and the knee with the ankle.
    let svenja = neighbours("svenja.toml");
    assert_eq!(svenja.len(), 6 * 3, "{svenja:?}");
    // Six bends in a row, of two axes each.
    assert_eq!(neighbours("worm.toml").len(), 5 * 2 * 2);
}

/// `docs/run-folders.md` has the tensors that are written, whatever the kind and its connections, and
/// no other.
#[test]
fn the_document_has_the_tensors_that_are_written() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    let morphology = Morphology::open(&models.join("svenja.toml")).unwrap();
    let tensor = |name: &str| name.rsplit('/').next().unwrap_or_default().to_owned();
    let mut written = BTreeSet::new();
    for settings in [
        "kind = 'crbm'",
        "connectivity = 'per_actuator'",
        "connectivity = 'per_group', inputs = 'neighbours'",
        "kind = 'modular'",
        "kind = 'logistic'",
    ] {
        let text = format!("model = 'svenja.toml'\npolicy = {{ {settings} }}");
        let experiment = Document::parse("test", &text).unwrap().read(Experiment::read).unwrap();
        let policy = build_policy(&experiment, &morphology, 1).unwrap();
        let bytes = policy.to_safetensors().unwrap();
        let file = safetensors::SafeTensors::deserialize(&bytes).unwrap();
        written.extend(file.names().iter().map(|name| tensor(name)));
    }
    let page = include_str!("../../../../../docs/run-folders.md");
    let (_, section) = page.split_once("\n## `policy.safetensors`\n").unwrap();
    let section = section.split("\n## ").next().unwrap();
    let is_tensor = |word: &String| matches!(word.trim_end_matches("_mask"), "V" | "W" | "b" | "c");
    let named = section.split('`').skip(1).step_by(2).map(tensor).filter(is_tensor);
    assert_eq!(named.collect::<BTreeSet<_>>(), written);
}
