//! Transfer entropy in a sliding window: what one sensor's reading tells about another's next one,
//! beyond what the other's own reading tells.
//!
//! ```text
//! T_{Y->X} = I(X_{t+1} ; Y_t | X_t) = H(X_{t+1}, X_t) + H(X_t, Y_t) - H(X_{t+1}, X_t, Y_t) - H(X_t)
//! ```
//!
//! counted over the newest N <= T' steps (T. Schreiber, *Measuring information transfer*, Physical
//! Review Letters 85, 2000). With n ln n as integers, each entropy is a sum that a step changes in two
//! places, the one that comes and the one that goes; it's exact, and so is that of a recount.

use super::{counted::Counted, readings::Readings};
use crate::{
    error::{Error, check_length, check_room, refused},
    information::{Estimator, Information},
    logs,
};

/// The last steps of some sensors, counted for several links from one sensor to another.
///
/// A reading costs O(1) for each link, and a value too; neither allocates.
///
/// ```
/// use infotheory::{Estimator, TransferWindow};
///
/// // The second sensor does what the first did, a step later.
/// let mut window = TransferWindow::new(100, &[2, 2], &[[0, 1], [1, 0]])?;
/// let leader = |t: u64| (t * t / 7) % 2;
/// for t in 1..=101 {
///     window.push(&[leader(t), leader(t - 1)])?;
/// }
/// let passed = |link| window.transfer_entropy(link, Estimator::PlugIn);
/// assert!(passed(0)? > passed(1)?);
/// # Ok::<(), infotheory::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct TransferWindow {
    /// T'
    steps: usize,
    /// [n_sensors]
    radices: Vec<u64>,
    links: Vec<Link>,
    /// The newest T' + 1.
    readings: Readings,
    /// [T' + 1]: n ln n in units of 2^-53.
    n_ln_n: Vec<i128>,
    /// Of sensors and links.
    hash: u64,
}

/// Counts of y, the source, with x and its next reading x', the target.
#[derive(Clone, Debug)]
struct Link {
    source: usize,
    target: usize,
    /// x
    alone: Plogp,
    /// (x', x)
    next: Plogp,
    /// (x, y)
    both: Plogp,
    /// (x', x, y)
    all: Plogp,
}

/// Counts with their sum of n ln n.
#[derive(Clone, Debug)]
struct Plogp {
    counted: Counted,
    /// In units of 2^-53.
    sum: i128,
}

impl TransferWindow {
    /// An empty window of `steps` steps, 1 to 2^20, on sensors with `radices` states each, for `links`
    /// from a source to a target, two different sensors.
    ///
    /// It takes some 180 T' bytes a link.
    ///
    /// # Errors
    /// [`Error::Argument`] for steps out of range, sensors that aren't there, and no links;
    /// [`Error::Memory`] if there's no room for it, with nothing allocated.
    pub fn new(steps: usize, radices: &[u64], links: &[[usize; 2]]) -> Result<Self, Error> {
        const CALL: &str = "TransferWindow::new";
        if !(1..=1 << 20).contains(&steps) {
            return Err(refused(CALL, "steps", "1 to 1048576", steps));
        }
        if let Some(sensor) = radices.iter().position(|&radix| radix == 0) {
            return Err(refused(CALL, format!("the radix of sensor {sensor}"), "at least 1", 0));
        }
        if links.is_empty() {
            return Err(refused(CALL, "the number of links", "at least 1", 0));
        }
        for (place, &[source, target]) in links.iter().enumerate() {
            if source.max(target) >= radices.len() || source == target {
                let expected = format!("two different sensors below {}", radices.len());
                let value = format!("{source} and {target}");
                return Err(refused(CALL, format!("link {place}"), expected, value));
            }
        }
        let one = [1, 2, 2, 3].map(|width| Counted::bytes(width, steps)).iter().sum::<usize>();
        let rows = Readings::bytes(radices.len(), steps + 1);
        check_room(CALL, one.saturating_mul(links.len()).saturating_add(rows))?;
        let plogp = |width| Plogp { counted: Counted::new(width, steps), sum: 0 };
        let link = |&[source, target]: &[usize; 2]| Link {
            source,
            target,
            alone: plogp(1),
            next: plogp(2),
            both: plogp(2),
            all: plogp(3),
        };
        Ok(Self {
            steps,
            radices: radices.to_vec(),
            links: links.iter().map(link).collect(),
            readings: Readings::new(radices.len(), steps + 1),
            n_ln_n: (0..=steps as u64).map(logs::n_ln_n).collect(),
            hash: super::hash_of(radices, links),
        })
    }

    /// The number of links.
    #[must_use]
    pub fn n_links(&self) -> usize {
        self.links.len()
    }

    /// Steps in the window: none with the first reading, then one more with each, up to T'.
    #[must_use]
    pub fn n_steps(&self) -> usize {
        self.readings.len().saturating_sub(1)
    }

    /// Takes in the next reading: each sensor's symbol, below its radix.
    ///
    /// `reading`: \[n_sensors\]
    ///
    /// # Errors
    /// [`Error::Argument`] for another number of symbols, or one that is too large.
    pub fn push(&mut self, reading: &[u64]) -> Result<(), Error> {
        super::check_reading("TransferWindow::push", reading, &self.radices)?;
        self.slide(reading);
        Ok(())
    }

    /// Transfer entropy along a link, over the window. With [`Estimator::MillerMadow`] less its bias,
    /// as [`transfer_entropy`](crate::transfer_entropy()) has it. 0 as long as there are no steps.
    ///
    /// # Errors
    /// [`Error::Argument`] for a link that isn't there.
    pub fn transfer_entropy(
        &self,
        link: usize,
        estimator: Estimator,
    ) -> Result<Information, Error> {
        let Some(link) = self.links.get(link) else {
            let expected = format!("below {}", self.links.len());
            return Err(refused("TransferWindow::transfer_entropy", "link", expected, link));
        };
        Ok(Information::from_nats(self.nats(link, estimator)))
    }

    /// The mean of [`transfer_entropy`](Self::transfer_entropy) over the links.
    #[must_use]
    pub fn mean_transfer_entropy(&self, estimator: Estimator) -> Information {
        Information::from_nats(self.mean(|link| self.nats(link, estimator)))
    }

    /// The mean over the links of transfer entropy as a share of the greatest that there can be, ln
    /// min(K, T') for the fewer states K of source and target. It's at most 1. A sensor of one state, or
    /// a window of one step, has a share of 0.
    #[must_use]
    pub fn share_of_maximum(&self) -> f64 {
        self.mean(|link| {
            let states = self.radices[link.source].min(self.radices[link.target]);
            let most = logs::nats(i128::from(logs::ln_fixed(states.min(self.steps as u64))), 1);
            if most > 0.0 { self.nats(link, Estimator::PlugIn) / most } else { 0.0 }
        })
    }

    /// Writes the window's state, for [`restore`](Self::restore): four words that say of what shape it
    /// is (T', number of sensors, a hash of sensors and links, number of readings) and the readings,
    /// oldest first.
    pub fn save(&self, words: &mut Vec<u64>) {
        words.clear();
        words.extend(self.shape());
        words.push(self.readings.len() as u64);
        for age in (0..self.readings.len()).rev() {
            words.extend_from_slice(self.readings.row(age));
        }
    }

    /// Takes up a saved state, in a window made with the same arguments. It continues with the same
    /// bits.
    ///
    /// # Errors
    /// [`Error::Argument`] for a state of another window; this one is then as before.
    pub fn restore(&mut self, words: &[u64]) -> Result<(), Error> {
        const CALL: &str = "TransferWindow::restore";
        let Some((header, rows)) = words.split_at_checked(4) else {
            return Err(refused(CALL, "the length of words", "at least 4", words.len()));
        };
        let names = ["steps", "the number of sensors", "the sensors' hash"];
        for ((name, expected), &found) in names.into_iter().zip(self.shape()).zip(header) {
            if found != expected {
                return Err(refused(CALL, name, expected.to_string(), found));
            }
        }
        let n_readings = header[3];
        if n_readings > self.steps as u64 + 1 {
            let expected = format!("at most {}", self.steps + 1);
            return Err(refused(CALL, "the number of readings", expected, n_readings));
        }
        let n_sensors = self.radices.len();
        check_length(CALL, "words", 4 + n_readings as usize * n_sensors, words.len())?;
        for row in rows.chunks_exact(n_sensors) {
            super::check_reading(CALL, row, &self.radices)?;
        }
        self.readings.clear();
        self.links.iter_mut().for_each(Link::clear);
        for row in rows.chunks_exact(n_sensors) {
            self.slide(row);
        }
        Ok(())
    }

    /// Drops the oldest step of a full window, then adds the newest one.
    fn slide(&mut self, reading: &[u64]) {
        if self.readings.len() == self.steps + 1 {
            let (oldest, next) = (self.readings.row(self.steps), self.readings.row(self.steps - 1));
            for link in &mut self.links {
                link.count(oldest, next, |plogp, key| plogp.remove(key, &self.n_ln_n));
            }
        }
        self.readings.push(reading);
        if self.readings.len() > 1 {
            let (newest, next) = (self.readings.row(1), self.readings.row(0));
            for link in &mut self.links {
                link.count(newest, next, |plogp, key| plogp.add(key, &self.n_ln_n));
            }
        }
    }

    fn shape(&self) -> [u64; 3] {
        [self.steps as u64, self.radices.len() as u64, self.hash]
    }

    fn mean(&self, value: impl Fn(&Link) -> f64) -> f64 {
        self.links.iter().map(value).sum::<f64>() / self.links.len() as f64
    }

    fn nats(&self, link: &Link, estimator: Estimator) -> f64 {
        let n = self.n_steps() as u64;
        if n == 0 {
            return 0.0;
        }
        // Each entropy is ln n less its sum over n, and there are as many with either sign.
        let sum = link.all.sum + link.alone.sum - link.next.sum - link.both.sum;
        let plug_in = logs::nats(sum, n).max(0.0);
        match estimator {
            Estimator::PlugIn => plug_in,
            Estimator::MillerMadow => {
                let states = |plogp: &Plogp| plogp.counted.keys.len() as f64;
                let bias = states(&link.next) + states(&link.both)
                    - states(&link.all)
                    - states(&link.alone);
                plug_in + bias / (2.0 * n as f64)
            }
        }
    }
}

impl Link {
    /// A step from one reading to the next, in all four counts.
    fn count(&mut self, now: &[u64], next: &[u64], mut count: impl FnMut(&mut Plogp, &[u64])) {
        let (y, x, x_next) = (now[self.source], now[self.target], next[self.target]);
        count(&mut self.alone, &[x]);
        count(&mut self.next, &[x_next, x]);
        count(&mut self.both, &[x, y]);
        count(&mut self.all, &[x_next, x, y]);
    }

    fn clear(&mut self) {
        for plogp in [&mut self.alone, &mut self.next, &mut self.both, &mut self.all] {
            plogp.counted.clear();
            plogp.sum = 0;
        }
    }
}

impl Plogp {
    fn add(&mut self, key: &[u64], n_ln_n: &[i128]) {
        let (slot, _) = self.counted.add(key);
        let n = self.counted.counts[slot as usize] as usize;
        self.sum += n_ln_n[n] - n_ln_n[n - 1];
    }

    /// Does nothing if the key isn't there.
    fn remove(&mut self, key: &[u64], n_ln_n: &[i128]) {
        let Some(slot) = self.counted.keys.find(key) else { return };
        let n = self.counted.counts[slot as usize] as usize;
        self.counted.remove(slot);
        self.sum += n_ln_n[n - 1] - n_ln_n[n];
    }
}
