//! A ring of the last control steps. All its memory is taken when it's made.

use super::{Error, Recording, RecordingLayout};

/// One control step, as it's recorded.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// \[frames_per_step x n_bodies x 7\]: x y z in metres, quaternion x y z w
    pub poses: &'a [f32],
    /// \[n_sensors\]: the readings after the step, within -1 to 1
    pub sensors: &'a [f32],
    /// \[n_actuators\]: the targets that were executed, within -1 to 1
    pub actions: &'a [f32],
    /// \[n_bodies\]: 1 for a body that touches something at the step's end, else 0
    pub contacts: &'a [u8],
    /// \[n_terms\]: the reward's terms
    pub terms: &'a [f64],
}

/// The last control steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    layout: RecordingLayout,
    /// Control steps that it holds at most.
    capacity: usize,
    /// Control steps that were pushed, also those that are overwritten by now.
    n_pushed: u64,
    poses: Lane<f32>,
    sensors: Lane<f32>,
    actions: Lane<f32>,
    contacts: Lane<u8>,
    terms: Lane<f64>,
}

impl Ring {
    /// An empty ring for `capacity` control steps; with 0 it takes steps and keeps none.
    ///
    /// # Errors
    /// If there's no memory for them, and for the copies that are made when they're saved.
    pub fn new(layout: RecordingLayout, capacity: usize) -> Result<Self, Error> {
        const COPIES: usize = 4;
        let too_many = |bytes: usize| {
            let megabytes = bytes as f64 / 1e6;
            let value =
                format!("{capacity}: it takes {megabytes:.0} MB, and there is no memory for them");
            Error::argument("Ring::new", "capacity", "what there is memory for", value)
        };
        let widths = layout.widths().ok_or_else(|| too_many(usize::MAX))?;
        let [poses, sensors, actions, contacts, terms] = widths;
        let widths = [(poses, 4), (sensors, 4), (actions, 4), (contacts, 1), (terms, 8)];
        let step = widths.map(|(width, size)| width.saturating_mul(size));
        let step = step.into_iter().fold(0, usize::saturating_add);
        let bytes = step.saturating_mul(capacity).saturating_mul(1 + COPIES);
        Vec::<u8>::new().try_reserve_exact(bytes).map_err(|_| too_many(bytes))?;
        let too_much = || too_many(bytes);
        Ok(Self {
            capacity,
            n_pushed: 0,
            poses: Lane::new(poses, capacity).ok_or_else(too_much)?,
            sensors: Lane::new(sensors, capacity).ok_or_else(too_much)?,
            actions: Lane::new(actions, capacity).ok_or_else(too_much)?,
            contacts: Lane::new(contacts, capacity).ok_or_else(too_much)?,
            terms: Lane::new(terms, capacity).ok_or_else(too_much)?,
            layout,
        })
    }

    /// Takes in a control step, in the place of the oldest one if it's full. Allocates nothing.
    ///
    /// # Errors
    /// If a slice has another length than the layout says. The ring is then as before.
    pub fn push(&mut self, step: Step<'_>) -> Result<(), Error> {
        self.poses.check("poses", step.poses)?;
        self.sensors.check("sensors", step.sensors)?;
        self.actions.check("actions", step.actions)?;
        self.contacts.check("contacts", step.contacts)?;
        self.terms.check("terms", step.terms)?;
        if let Some(slot) = self.n_pushed.checked_rem(self.capacity as u64) {
            let slot = slot as usize;
            self.poses.put(slot, step.poses);
            self.sensors.put(slot, step.sensors);
            self.actions.put(slot, step.actions);
            self.contacts.put(slot, step.contacts);
            self.terms.put(slot, step.terms);
        }
        self.n_pushed += 1;
        Ok(())
    }

    /// What it holds, the oldest control step first. [`Recording::encode`] makes the bytes of it,
    /// for the checkpoint and for `replay.safetensors`.
    #[must_use]
    pub fn recording(&self) -> Recording {
        let n_steps = self.n_pushed.min(self.capacity as u64) as usize;
        let first_control_step = self.n_pushed - n_steps as u64;
        let first = first_control_step.checked_rem(self.capacity as u64).unwrap_or(0) as usize;
        Recording {
            layout: self.layout.clone(),
            first_control_step,
            n_steps,
            poses: self.poses.in_order(first, n_steps),
            sensors: self.sensors.in_order(first, n_steps),
            actions: self.actions.in_order(first, n_steps),
            contacts: self.contacts.in_order(first, n_steps),
            terms: self.terms.in_order(first, n_steps),
        }
    }

    /// Goes back to a [`Ring::recording`] of a ring with the same layout and capacity, and
    /// continues from it with the same bits.
    ///
    /// # Errors
    /// If it has another layout, or steps that this ring can't have held. The ring is then as
    /// before.
    pub fn restore(&mut self, recording: &Recording) -> Result<(), Error> {
        let refused = |argument: &str, expected: String, value: String| {
            Err(Error::argument("Ring::restore", argument, expected, value))
        };
        if recording.layout != self.layout {
            let [expected, value] = [&self.layout, &recording.layout].map(|it| format!("{it:?}"));
            return refused("the recording's layout", expected, value);
        }
        let n_pushed = recording.first_control_step.checked_add(recording.n_steps as u64);
        let n_held = n_pushed.map(|n| n.min(self.capacity as u64));
        let (Some(n_pushed), true) = (n_pushed, n_held == Some(recording.n_steps as u64)) else {
            let expected = format!("the last {} or all steps", self.capacity);
            let (n, first) = (recording.n_steps, recording.first_control_step);
            return refused("the recording", expected, format!("{n} steps from step {first}"));
        };
        let first = recording.first_control_step.checked_rem(self.capacity as u64).unwrap_or(0);
        let first = first as usize;
        self.n_pushed = n_pushed;
        self.poses.fill(first, &recording.poses);
        self.sensors.fill(first, &recording.sensors);
        self.actions.fill(first, &recording.actions);
        self.contacts.fill(first, &recording.contacts);
        self.terms.fill(first, &recording.terms);
        Ok(())
    }
}

/// One kind of numbers for all control steps.
#[derive(Clone, Debug, PartialEq)]
struct Lane<T> {
    /// Numbers of one control step.
    width: usize,
    /// \[capacity x width\]
    values: Vec<T>,
}

impl<T: Copy + Default> Lane<T> {
    fn new(width: usize, capacity: usize) -> Option<Self> {
        let length = width.checked_mul(capacity)?;
        let mut values = Vec::new();
        values.try_reserve_exact(length).ok()?;
        values.resize(length, T::default());
        Some(Self { width, values })
    }

    fn check(&self, argument: &str, values: &[T]) -> Result<(), Error> {
        if values.len() == self.width {
            return Ok(());
        }
        let argument = format!("the length of {argument}");
        Err(Error::argument("Ring::push", argument, self.width.to_string(), values.len()))
    }

    fn put(&mut self, slot: usize, values: &[T]) {
        self.values[slot * self.width..(slot + 1) * self.width].copy_from_slice(values);
    }

    /// The values of `n_steps` control steps from slot `first` on, around the end.
    fn in_order(&self, first: usize, n_steps: usize) -> Vec<T> {
        let (start, length) = (first * self.width, n_steps * self.width);
        let behind = &self.values[start..self.values.len().min(start + length)];
        [behind, &self.values[..length - behind.len()]].concat()
    }

    /// The inverse of `in_order`; the other slots get zeros, as before the first round.
    fn fill(&mut self, first: usize, values: &[T]) {
        let start = first * self.width;
        let (behind, around) = values.split_at(values.len().min(self.values.len() - start));
        self.values.fill(T::default());
        self.values[start..start + behind.len()].copy_from_slice(behind);
        self.values[..around.len()].copy_from_slice(around);
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::*;

    use super::*;

    fn layout([frames_per_step, bodies, sensors, actuators, terms]: [usize; 5]) -> RecordingLayout {
        let names = |what: &str, n| (0..n).map(|i| format!("{what} {i}")).collect();
        RecordingLayout {
            actuators: names("actuator", actuators),
            bodies: names("body", bodies),
            frames_per_step,
            seconds_per_frame: 0.02,
            sensors: names("sensor", sensors),
            terms: names("term", terms),
        }
    }

    /// Pushes control step number k, with numbers that tell steps and places apart.
    fn push(ring: &mut Ring, k: u64) {
        let widths = ring.layout.widths().unwrap();
        let numbers = |lane: usize| -> Vec<f32> {
            (0..widths[lane]).map(|i| (k * 1000 + i as u64) as f32 + lane as f32 / 8.0).collect()
        };
        let contacts: Vec<_> = (0..widths[3] as u64).map(|i| ((k + i) % 2) as u8).collect();
        let terms: Vec<_> = numbers(4).into_iter().map(f64::from).collect();
        let [poses, sensors, actions] = [0, 1, 2].map(numbers);
        let [poses, sensors, actions] = [&poses[..], &sensors, &actions];
        ring.push(Step { poses, sensors, actions, contacts: &contacts, terms: &terms }).unwrap();
    }

    fn sizes() -> impl Strategy<Value = [usize; 5]> {
        [0..3usize, 0..4, 0..4, 0..4, 0..4]
    }

    #[test]
    fn it_holds_the_last_steps_in_order() {
        let mut ring = Ring::new(layout([1, 1, 2, 0, 1]), 3).unwrap();
        assert_eq!(ring.recording().n_steps, 0);
        (0..2).for_each(|k| push(&mut ring, k));
        let recording = ring.recording();
        assert_eq!((recording.first_control_step, recording.n_steps), (0, 2));
        assert_eq!(recording.sensors, [0.125, 1.125, 1000.125, 1001.125]);
        (2..5).for_each(|k| push(&mut ring, k));
        let recording = ring.recording();
        assert_eq!((recording.first_control_step, recording.n_steps), (2, 3));
        assert_eq!(recording.terms, [2000.5, 3000.5, 4000.5]);
        assert_eq!(recording.contacts, [0, 1, 0]);
    }

    proptest! {
        #[test]
        fn restored_it_continues_with_the_same_bytes(
            sizes in sizes(),
            capacity in 0..6usize,
            before in 0..14u64,
            after in 0..14u64,
        ) {
            let mut through = Ring::new(layout(sizes), capacity).unwrap();
            (0..before).for_each(|k| push(&mut through, k));
            let bytes = through.recording().encode().unwrap();

            let mut resumed = Ring::new(layout(sizes), capacity).unwrap();
            (0..3).for_each(|k| push(&mut resumed, k + 50));
            let recording = Recording::decode(Path::new("replay"), &bytes).unwrap();
            resumed.restore(&recording).unwrap();
            prop_assert_eq!(&resumed, &through);
            for ring in [&mut through, &mut resumed] {
                (before..before + after).for_each(|k| push(ring, k));
            }
            prop_assert_eq!(&resumed, &through);
            let [through, resumed] = [through, resumed].map(|ring| ring.recording().encode().unwrap());
            prop_assert_eq!(through, resumed);
        }
    }

    #[test]
    fn pushing_allocates_nothing() {
        let mut ring = Ring::new(layout([2, 3, 4, 2, 5]), 3).unwrap();
        let (poses, sensors, terms) = ([0.5; 42], [0.5; 4], [0.5; 5]);
        let step = Step {
            poses: &poses,
            sensors: &sensors,
            actions: &sensors[..2],
            contacts: &[1; 3],
            terms: &terms,
        };
        let counted = allocation_counter::measure(|| {
            (0..10).for_each(|_| ring.push(step).unwrap());
        });
        assert_eq!(counted.count_total, 0);
    }

    /// A JSON reader that rounds carelessly gets one in nine of these wrong.
    #[test]
    fn any_time_between_frames_comes_back() {
        for frequency in 1..=500 {
            let seconds_per_frame = 1.0 / f64::from(frequency);
            let layout = RecordingLayout { seconds_per_frame, ..layout([1; 5]) };
            let mut ring = Ring::new(layout, 1).unwrap();
            let bytes = ring.recording().encode().unwrap();
            ring.restore(&Recording::decode(Path::new("replay"), &bytes).unwrap()).unwrap();
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let mut ring = Ring::new(layout([1, 1, 1, 1, 1]), 2).unwrap();
        push(&mut ring, 0);
        let before = ring.clone();
        let one = [0.0];
        let contacts = [0];
        let step = Step {
            poses: &[0.0; 7],
            sensors: &one,
            actions: &one,
            contacts: &contacts,
            terms: &[],
        };
        let error = ring.push(step).unwrap_err().to_string();
        assert_eq!(error, "Ring::push: the length of terms must be 1, got 0");

        let recording = ring.recording();
        let other = Recording { layout: layout([1, 1, 1, 2, 1]), ..recording.clone() };
        assert!(ring.restore(&other).is_err());
        for first_control_step in [1, u64::MAX] {
            let other = Recording { first_control_step, ..recording.clone() };
            let error = ring.restore(&other).unwrap_err().to_string();
            assert!(error.contains("must be the last 2 or all steps, got 1 steps from"), "{error}");
        }
        assert_eq!(ring, before);
        assert!(Ring::new(layout([1, 1, 1, 1, 1]), usize::MAX / 2).is_err());
    }
}
