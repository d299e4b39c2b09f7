//! Cells that are stepped together, and what a control step of theirs takes.

use std::time::{Duration, Instant};

use serde::Serialize;

use crate::{
    commands::print_line,
    session::{Session, Solver, control_step},
};

/// Control steps in a row.
const BLOCK: u64 = 10;

/// What a control step of a world takes.
#[derive(Serialize)]
pub(super) struct Speed {
    pub(super) control_steps_per_second: f64,
    pub(super) physics_us: f64,
    pub(super) policy_us: f64,
    pub(super) rest_us: f64,
}

/// Cells that are stepped together, and what that took.
pub(super) struct Batch {
    pub(super) solver: Solver,
    sessions: Vec<Session>,
    /// Control steps of all worlds: those measured, and those with the ones in which they settled.
    pub(super) steps: u64,
    all_steps: u64,
    total: Duration,
    pub(super) physics: Duration,
    policy: Duration,
}

impl Batch {
    pub(super) fn begin(solver: Solver, sessions: Vec<Session>) -> anyhow::Result<Self> {
        let mut batch = Self {
            solver,
            sessions,
            steps: 0,
            all_steps: 0,
            total: Duration::ZERO,
            physics: Duration::ZERO,
            policy: Duration::ZERO,
        };
        while batch.sessions.iter().any(Session::is_settling) {
            batch.step()?;
        }
        Ok(batch)
    }

    fn step(&mut self) -> anyhow::Result<()> {
        let mut sessions: Vec<&mut Session> = self.sessions.iter_mut().collect();
        for result in control_step(&mut sessions, &mut self.solver) {
            result?;
        }
        for session in &mut self.sessions {
            if session.is_to_learn() {
                session.learn()?;
            }
        }
        self.all_steps += self.worlds();
        Ok(())
    }

    fn worlds(&self) -> u64 {
        self.sessions.iter().map(|session| session.worlds() as u64).sum()
    }

    fn policy_time(&self) -> Duration {
        self.sessions.iter().map(Session::policy_time).sum()
    }

    /// A block; seconds for a control step of a world.
    pub(super) fn run(&mut self) -> anyhow::Result<f64> {
        let (start, physics, policy) = (Instant::now(), self.solver.time(), self.policy_time());
        for _ in 0..BLOCK {
            self.step()?;
        }
        let time = start.elapsed();
        let steps = BLOCK * self.worlds();
        self.steps += steps;
        self.total += time;
        self.physics += self.solver.time() - physics;
        self.policy += self.policy_time() - policy;
        Ok(time.as_secs_f64() / steps as f64)
    }

    pub(super) fn rate(&self) -> f64 {
        self.steps as f64 / self.total.as_secs_f64()
    }

    pub(super) fn speed(&self) -> Speed {
        let us = |time: Duration| 1e6 * time.as_secs_f64() / self.steps as f64;
        Speed {
            control_steps_per_second: self.rate(),
            physics_us: us(self.physics),
            policy_us: us(self.policy),
            rest_us: us(self.total - self.physics - self.policy),
        }
    }

    pub(super) fn report(&self, name: &str) -> anyhow::Result<()> {
        print_line(format_args!("{name}:"))?;
        let rest = self.total - self.physics - self.policy;
        for (name, time) in [("physics", self.physics), ("policy", self.policy), ("rest", rest)] {
            let microseconds = 1e6 * time.as_secs_f64() / self.steps as f64;
            let share = 100.0 * time.as_secs_f64() / self.total.as_secs_f64();
            print_line(format_args!(
                "  {name:8} {microseconds:8.1} us a control step, {share:4.1} %"
            ))?;
        }
        Ok(())
    }

    /// Where a physics step goes that is made in lanes, without the servo law.
    pub(super) fn report_parts(&self, physics_steps: f64) -> anyhow::Result<()> {
        let times = self.solver.times();
        let parts = [
            ("begin", times.begin),
            ("pack", times.pack),
            ("sweep", times.sweep),
            ("unpack", times.unpack),
            ("end", times.end),
        ];
        for (name, seconds) in parts {
            let time = 1e6 * seconds / (self.all_steps as f64 * physics_steps);
            print_line(format_args!("    {name:6} {time:8.1} us a physics step"))?;
        }
        Ok(())
    }
}
