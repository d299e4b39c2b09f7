//! Worlds for whoever decides about the robots in them: episodes of one robot in step, in lanes, without
//! a policy of their own, without learning and without wind.
//!
//! Each world has the bits of an episode alone, as a rollout lives it: those of its seed and of the
//! targets that it gets, whatever happens beside it.

use anyhow::{Context, bail, ensure};
use svenja::Morphology;

use super::{Episode, Evaluation, Solver, simulate};
use crate::experiment::Experiment;

/// The most worlds that are stepped together here.
pub const MOST_WORLDS: usize = 4096;

/// What became of a world in a control step.
#[derive(Clone, Debug)]
pub enum Stepped {
    /// It did something, which was worth something.
    Did(Evaluation),
    /// It blew up, for this reason, and stays as it was before until it begins anew.
    BlewUp(String),
}

/// Episodes in step.
pub struct Worlds {
    experiment: Experiment,
    morphology: Morphology,
    solver: Solver,
    /// Where the robot has settled: a snapshot of its world.
    settled: Vec<u8>,
    worlds: Vec<Place>,
}

/// A place for an episode.
struct Place {
    episode: Episode,
    is_lost: bool,
}

impl Worlds {
    /// So many worlds in which the robot has settled, each with a task as of seed 0 until it
    /// [begins](Self::begin) with another.
    ///
    /// # Errors
    /// No worlds, or more than [`MOST_WORLDS`]; settings that don't fit the model; a robot that blows up
    /// while it settles.
    pub fn new(
        experiment: Experiment,
        morphology: Morphology,
        n_worlds: usize,
    ) -> anyhow::Result<Self> {
        ensure!(
            (1..=MOST_WORLDS).contains(&n_worlds),
            "the number of worlds must be from 1 to {MOST_WORLDS}, got {n_worlds}"
        );
        let mut solver = Solver::lockstep()?;
        let mut first = Episode::new(&experiment, &morphology, 0)?;
        while first.is_settling() {
            first.rest()?;
            first.simulate(&mut solver).context("while the robot settled")?;
            first.settle()?;
        }
        let settled = first.body.save()?;
        let mut worlds = Self { experiment, morphology, solver, settled, worlds: Vec::new() };
        for _ in 0..n_worlds {
            let place = Place { episode: worlds.episode(0)?, is_lost: false };
            worlds.worlds.push(place);
        }
        Ok(worlds)
    }

    /// One that begins.
    fn episode(&self, seed: u64) -> anyhow::Result<Episode> {
        Episode::settled(&self.experiment, &self.morphology, seed, &self.settled)
    }

    /// A world begins anew where the robot has settled. What its task draws is of the seed.
    ///
    /// # Errors
    /// A world that there isn't.
    pub fn begin(&mut self, world: usize, seed: u64) -> anyhow::Result<()> {
        self.check(world)?;
        self.worlds[world] = Place { episode: self.episode(seed)?, is_lost: false };
        Ok(())
    }

    /// A control step of all worlds that get targets, `[n_actuators]` within -1 to 1; the others stay
    /// as they are. What each did is told in their order, with xi as at the start of training.
    ///
    /// # Errors
    /// Another number of worlds; targets that aren't; a world that blew up before. No world has moved
    /// then. An error of the solver's own leaves the worlds between two steps: they should begin anew.
    pub fn step(&mut self, targets: &[Option<&[f64]>]) -> anyhow::Result<Vec<Option<Stepped>>> {
        let n_worlds = self.worlds.len();
        ensure!(
            targets.len() == n_worlds,
            "targets for {n_worlds} worlds expected, got those of {}",
            targets.len()
        );
        for (world, (place, targets)) in self.worlds.iter_mut().zip(targets).enumerate() {
            let Some(targets) = targets else { continue };
            ensure!(
                !place.is_lost,
                "world {world} blew up: it must begin anew before it's stepped"
            );
            place.episode.aim(targets).with_context(|| format!("world {world}"))?;
        }
        let moves = |(_, targets): &(&mut Place, &Option<_>)| targets.is_some();
        let mut moved: Vec<_> = self.worlds.iter_mut().zip(targets).filter(moves).collect();
        let mut episodes: Vec<_> = moved.iter_mut().map(|(place, _)| &mut place.episode).collect();
        let mut results = simulate(&mut episodes, &mut self.solver).into_iter();
        let all = self.worlds.iter_mut().zip(targets);
        all.map(|(place, targets)| match targets {
            Some(_) => results.next().map(|result| place.after(result)).transpose(),
            None => Ok(None),
        })
        .collect()
    }

    /// The number of worlds.
    #[must_use]
    pub fn n_worlds(&self) -> usize {
        self.worlds.len()
    }

    /// The robot in them.
    #[must_use]
    pub fn morphology(&self) -> &Morphology {
        &self.morphology
    }

    /// What they are worlds of.
    #[must_use]
    pub fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// What lives in a world, to look at.
    ///
    /// # Errors
    /// A world that there isn't.
    pub fn look(&self, world: usize) -> anyhow::Result<&Episode> {
        self.check(world)?;
        Ok(&self.worlds[world].episode)
    }

    fn check(&self, world: usize) -> anyhow::Result<()> {
        let n_worlds = self.worlds.len();
        ensure!(world < n_worlds, "worlds are counted from 0 to {}, got {world}", n_worlds - 1);
        Ok(())
    }
}

impl Place {
    /// What its physics came to.
    fn after(&mut self, result: Result<(), svenja::Error>) -> anyhow::Result<Stepped> {
        use svenja::Error::{BlewUp, World};
        let evaluated = match result {
            Ok(()) => self.episode.evaluate(0),
            Err(error @ (BlewUp { .. } | World(bullet::Error::BlewUp { .. }))) => Err(error.into()),
            Err(error) => {
                self.is_lost = true;
                bail!(error)
            }
        };
        Ok(evaluated.map_or_else(
            |error| {
                self.is_lost = true;
                Stepped::BlewUp(error.to_string())
            },
            Stepped::Did,
        ))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use config::Document;
    use reward::Terms;

    use super::*;

    fn settings(model: &str, more: &str) -> (Experiment, Morphology) {
        let path = format!("{}/../../models/{model}.toml", env!("CARGO_MANIFEST_DIR"));
        let morphology = Morphology::open(Path::new(&path)).unwrap();
        let text = format!("model = 'm'\n{more}");
        (Document::parse("x", &text).unwrap().read(Experiment::read).unwrap(), morphology)
    }

    /// Round numbers that jump about, other ones in each world.
    fn targets(n: usize, world: u64, step: u64) -> Vec<f64> {
        (0..n as u64).map(|i| ((i * 7 + world * 5 + step * 3) % 9) as f64 / 4.0 - 1.0).collect()
    }

    type Life = Vec<([f64; Terms::NAMES.len()], Vec<f64>)>;

    /// As a rollout lives it, settling included, with Bullet's own solver.
    fn alone((experiment, morphology): &(Experiment, Morphology), world: u64, steps: u64) -> Life {
        let mut episode = Episode::new(experiment, morphology, world).unwrap();
        let mut solver = Solver::bullet();
        while episode.is_settling() {
            episode.rest().unwrap();
            episode.simulate(&mut solver).unwrap();
            episode.settle().unwrap();
        }
        let n = morphology.actuators().len();
        let mut step = |step| {
            episode.aim(&targets(n, world, step)).unwrap();
            episode.simulate(&mut solver).unwrap();
            let did = episode.evaluate(0).unwrap();
            (did.terms.as_array(), episode.readings().values.clone())
        };
        (0..steps).map(&mut step).collect()
    }

    fn step_all(worlds: &mut Worlds, lives: &mut [Life], step: u64, rests: Option<usize>) {
        let n = worlds.morphology().actuators().len();
        let own: Vec<_> = (0..lives.len() as u64).map(|world| targets(n, world, step)).collect();
        let given: Vec<_> = own.iter().map(|it| Some(it.as_slice())).collect();
        let given = given.into_iter().enumerate().map(|(i, it)| it.filter(|_| rests != Some(i)));
        let results = worlds.step(&given.collect::<Vec<_>>()).unwrap();
        for (world, result) in results.into_iter().enumerate() {
            assert_eq!(result.is_none(), rests == Some(world));
            let Some(Stepped::Did(did)) = result else { continue };
            let readings = worlds.look(world).unwrap().readings().values.clone();
            lives[world].push((did.terms.as_array(), readings));
        }
    }

    /// Of a task that draws, and of one that measures work; whatever happened in the worlds before.
    #[test]
    fn each_world_has_the_bits_of_an_episode_alone() {
        for (model, more) in [
            ("svenja", ""),
            ("quadruped", "reward.extrinsic.kind = 'reach'\ncontrol.settle_steps = 0"),
            ("worm", "reward.extrinsic.kind = 'efficient_locomotion'"),
        ] {
            let settings = settings(model, more);
            let mut worlds = Worlds::new(settings.0.clone(), settings.1.clone(), 3).unwrap();
            step_all(&mut worlds, &mut vec![Vec::new(); 3], 5, None);
            for world in 0..3 {
                worlds.begin(world, world as u64).unwrap();
            }
            let mut lives: Vec<Life> = vec![Vec::new(); 3];
            (0..4).for_each(|step| step_all(&mut worlds, &mut lives, step, None));
            // The second one is elsewhere in its life from here on.
            worlds.begin(1, 1).unwrap();
            lives[1].clear();
            step_all(&mut worlds, &mut lives, 0, None);
            lives[0].pop();
            lives[2].pop();
            for (world, life) in lives.iter().enumerate() {
                let steps = if world == 1 { 1 } else { 4 };
                assert_eq!(*life, alone(&settings, world as u64, steps), "{model}, world {world}");
            }
        }
    }

    #[test]
    fn a_world_without_targets_stays_as_it_is() {
        let settings = settings("worm", "");
        let mut worlds = Worlds::new(settings.0.clone(), settings.1.clone(), 2).unwrap();
        let mut lives: Vec<Life> = vec![Vec::new(); 2];
        step_all(&mut worlds, &mut lives, 0, None);
        let before = worlds.look(0).unwrap().readings().clone();
        step_all(&mut worlds, &mut lives, 7, Some(0));
        assert_eq!(*worlds.look(0).unwrap().readings(), before);
        step_all(&mut worlds, &mut lives, 1, None);
        assert_eq!(lives[0].iter().map(|it| it.0).collect::<Vec<_>>(), {
            let alone = alone(&settings, 0, 2);
            alone.iter().map(|it| it.0).collect::<Vec<_>>()
        });
    }

    #[test]
    fn what_does_not_fit_is_refused_and_nothing_moves() {
        let (experiment, morphology) = settings("worm", "");
        let refused = |n| Worlds::new(experiment.clone(), morphology.clone(), n).err().unwrap();
        for n in [0, MOST_WORLDS + 1] {
            let expected = format!("the number of worlds must be from 1 to 4096, got {n}");
            assert_eq!(refused(n).to_string(), expected);
        }
        let mut worlds = Worlds::new(experiment.clone(), morphology.clone(), 2).unwrap();
        let n = morphology.actuators().len();
        let before = worlds.look(0).unwrap().state().clone();
        let (good, bad) = (vec![0.5; n], vec![f64::NAN; n]);
        let mut said =
            |targets: &[Option<&[f64]>]| format!("{:#}", worlds.step(targets).unwrap_err());
        assert_eq!(said(&[None]), "targets for 2 worlds expected, got those of 1");
        let nan = said(&[Some(&good), Some(&bad)]);
        assert_eq!(nan, "world 1: actuate: targets[0] must be from -1 to 1, got NaN");
        assert!(said(&[Some(&good[1..]), None]).starts_with("world 0: actuate: targets must be"));
        assert_eq!(*worlds.look(0).unwrap().state(), before);
        assert!(worlds.begin(2, 1).is_err() && worlds.look(2).is_err());
    }
}
