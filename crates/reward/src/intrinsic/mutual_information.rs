//! Mutual information of successive readings.
//!
//! ```text
//! r_MI,t = sum_{s'} p_t(s'|s_{t-1}) ln( p_t(s'|s_{t-1}) / p_t(s') )
//! ```
//!
//! counted over the last T' pairs of readings ([`infotheory::Window`]), for each sensor or group of
//! sensors; the reward is `max` times the mean of r_MI / ln min(K, T') for K states. The mean over
//! time is at most `max`; single values exceed it and aren't clipped.
//!
//! With many states (2 bits, 4 joints: K = 256) the plug-in value of 100 pairs is mostly bias,
//! which is why Miller and Madow's is recorded beside it.

use config::{Rule, Section, count, one_of, within};
use infotheory::{Estimator, Window, WindowSettings, all_sensors, each_sensor};
use serde::Serialize;

use super::{Build, Intrinsic, Value};
use crate::{Error, NOMINAL_MAXIMUM, RobotLayout};

/// Settings of mutual information.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MutualInformationSettings {
    /// Which readings count.
    pub sensors: Sensors,
    /// Which readings are one variable.
    pub group: Grouping,
    /// T', the pairs that are counted.
    pub window: usize,
    /// Control steps from the first reading of a pair to the second.
    pub lag: usize,
    /// Readings that make up the first of a pair.
    pub past: usize,
    /// The greatest mean over time.
    pub max: f64,
}

/// Which readings count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sensors {
    /// The joint positions alone.
    Positions,
    /// Joint positions and contacts.
    All,
}

/// Which readings are one variable, a joint state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Grouping {
    /// The information of each sensor by itself, averaged.
    Sensor,
    /// Those of each of the model's groups, its legs.
    Group,
    /// The joint state of all sensors.
    Body,
}

impl Default for MutualInformationSettings {
    fn default() -> Self {
        let WindowSettings { pairs, lag, past } = WindowSettings::default();
        let (sensors, group) = (Sensors::Positions, Grouping::Sensor);
        Self { sensors, group, window: pairs, lag, past, max: NOMINAL_MAXIMUM }
    }
}

impl MutualInformationSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let default = Self::default();
        let sensors = [("positions", Sensors::Positions), ("all", Sensors::All)];
        let groupings =
            [("sensor", Grouping::Sensor), ("group", Grouping::Group), ("body", Grouping::Body)];
        let sensors = one_of(&sensors)
            .about("which readings count: `\"positions\"` of joints, or `\"all\"`, contacts too");
        let group = one_of(&groupings).about(
            "what is one variable: `\"sensor\"`: each reading; `\"group\"`: the joint state of the \
             readings of each of the model's groups (legs); `\"body\"`: the joint state of all",
        );
        let window = count(2, 1 << 20).about("newest pairs of readings that are counted");
        let lag = count(1, 10_000).about("control steps from the first of a pair to the second");
        let past = count(1, 64).about("readings that make up the first of a pair");
        let max = within(1e-50, 1e50)
            .about("the largest mean over time; single steps exceed it and aren't clipped");
        Some(Self {
            sensors: section.or("sensors", sensors, default.sensors),
            group: section.or("group", group, default.group),
            window: section.or("window", window, default.window),
            lag: section.or("lag", lag, default.lag),
            past: section.or("past", past, default.past),
            max: section.or("max", max, default.max),
        })
    }

    /// The sensors of each variable.
    fn variables(&self, layout: &RobotLayout) -> Result<Vec<Vec<usize>>, Error> {
        let (n_sensors, sensors) = match self.sensors {
            Sensors::Positions => (layout.n_positions, "positions"),
            Sensors::All => (layout.n_sensors(), "all"),
        };
        let no_sensors = |place: String| Error::NoSensors { place, sensors };
        if n_sensors == 0 {
            return Err(no_sensors("the model".into()));
        }
        match self.group {
            Grouping::Sensor => Ok(each_sensor(n_sensors)),
            Grouping::Body => Ok(all_sensors(n_sensors)),
            Grouping::Group if layout.groups.is_empty() => Err(Error::NoGroups),
            Grouping::Group => layout
                .groups
                .iter()
                .map(|group| {
                    let contacts =
                        group.contacts.iter().map(|contact| layout.n_positions + contact);
                    let all = group.positions.iter().copied().chain(contacts);
                    let counted: Vec<_> = all.filter(|&sensor| sensor < n_sensors).collect();
                    match counted.is_empty() {
                        true => Err(no_sensors(format!("group '{}'", group.name))),
                        false => Ok(counted),
                    }
                })
                .collect(),
        }
    }
}

impl Build for MutualInformationSettings {
    fn build(&self, layout: &RobotLayout) -> Result<Box<dyn Intrinsic>, Error> {
        let &Self { window, lag, past, max, .. } = self;
        let settings = WindowSettings { pairs: window, lag, past };
        let window = Window::new(settings, &layout.radices(), &self.variables(layout)?)?;
        Ok(Box::new(MutualInformation { window, max }))
    }

    fn symbol(&self) -> &'static str {
        "R_MI"
    }
}

#[derive(Debug)]
struct MutualInformation {
    window: Window,
    max: f64,
}

impl Intrinsic for MutualInformation {
    fn push(&mut self, bins: &[u64]) -> Result<(), Error> {
        Ok(self.window.push(bins)?)
    }

    fn value(&self) -> Value {
        let nats = |estimator| self.window.mean_specific_surprise(estimator).nats();
        Value {
            nats: nats(Estimator::PlugIn),
            nats_corrected: nats(Estimator::MillerMadow),
            scaled: self.max * self.window.share_of_maximum(Estimator::PlugIn),
        }
    }

    fn save(&self) -> Vec<u64> {
        let mut state = Vec::new();
        self.window.save(&mut state);
        state
    }

    fn restore(&mut self, state: &[u64]) -> Result<(), Error> {
        Ok(self.window.restore(state)?)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::f64::consts::LN_2;

    use super::*;
    use crate::Group;

    /// Two legs of two joints and a foot each.
    fn layout() -> RobotLayout {
        let group = |name: &str, positions: [usize; 2], contact| Group {
            name: name.into(),
            positions: positions.into(),
            contacts: vec![contact],
        };
        let groups = vec![group("left", [0, 2], 1), group("right", [1, 3], 0)];
        RobotLayout { n_positions: 4, n_contacts: 2, n_bins: 2, groups, ..Default::default() }
    }

    fn settings(sensors: Sensors, group: Grouping) -> MutualInformationSettings {
        MutualInformationSettings { sensors, group, ..Default::default() }
    }

    #[test]
    fn variables_are_sensors_groups_or_all() {
        use Grouping::{Body, Group, Sensor};
        use Sensors::{All, Positions};
        let variables = |sensors, group| settings(sensors, group).variables(&layout()).unwrap();
        assert_eq!(variables(Positions, Sensor), [[0], [1], [2], [3]]);
        assert_eq!(variables(All, Sensor), [[0], [1], [2], [3], [4], [5]]);
        assert_eq!(variables(Positions, Group), [[0, 2], [1, 3]]);
        assert_eq!(variables(All, Group), [[0, 2, 5], [1, 3, 4]]);
        assert_eq!(variables(Positions, Body), [[0, 1, 2, 3]]);
        assert_eq!(variables(All, Body), [[0, 1, 2, 3, 4, 5]]);
    }

    #[test]
    fn a_layout_without_what_is_asked_for_is_refused_by_name() {
        let mut layout = layout();
        let message = |layout: &RobotLayout| {
            let settings = settings(Sensors::Positions, Grouping::Group);
            settings.build(layout).unwrap_err().to_string()
        };
        layout.groups[1].positions.clear();
        let expected = "reward.intrinsic must have at least one sensor in group 'right', got none \
                        with sensors = \"positions\"";
        assert_eq!(message(&layout), expected);
        layout.groups.clear();
        assert!(message(&layout).starts_with("reward.intrinsic.group = \"group\" needs a model"));
        layout.n_positions = 0;
        assert!(message(&layout).contains("in the model, got none"));
    }

    /// One position alternates, three stand still: ln 2 / 4 nats, a quarter of the maximum. As one
    /// joint state of 16 states: ln 2 nats, of ln 16 = 4 ln 2 a quarter, too.
    #[test]
    fn an_alternating_sensor_is_worth_ln_2() {
        for (group, nats) in [(Grouping::Sensor, LN_2 / 4.0), (Grouping::Body, LN_2)] {
            let mut intrinsic = settings(Sensors::Positions, group).build(&layout()).unwrap();
            for t in 0..101 {
                intrinsic.push(&[t % 2, 0, 1, 0, t % 2, 1]).unwrap();
            }
            let value = intrinsic.value();
            // A few roundings of numbers below 1.
            assert!((value.nats - nats).abs() < 1e-15, "{value:?}");
            assert!((value.scaled - 0.1 / 4.0).abs() < 1e-16, "{value:?}");
        }
    }
}
