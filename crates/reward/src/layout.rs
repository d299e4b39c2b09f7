//! What a reward is told: which readings there are, and what a control step did.

/// The readings of a robot: positions first, then contacts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SensorLayout {
    /// The number of joint positions.
    pub n_positions: usize,
    /// Contacts, of two states each.
    pub n_contacts: usize,
    /// Bins of a position.
    pub n_bins: u64,
    /// The model's groups, its legs.
    pub groups: Vec<Group>,
}

/// Readings that belong together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The group's name in the model.
    pub name: String,
    /// Indices among the positions.
    pub positions: Vec<usize>,
    /// Indices among the contacts.
    pub contacts: Vec<usize>,
}

impl SensorLayout {
    /// Length of a reading.
    #[must_use]
    pub fn n_sensors(&self) -> usize {
        self.n_positions + self.n_contacts
    }

    /// States of each sensor: `[n_sensors]`.
    #[must_use]
    pub fn radices(&self) -> Vec<u64> {
        let mut radices = vec![self.n_bins; self.n_positions];
        radices.resize(self.n_sensors(), 2);
        radices
    }
}

/// What a control step did.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// The reading after it: each sensor's bin, `[n_sensors]`.
    pub bins: &'a [u64],
    /// How far the centre of gravity went along the heading, in m.
    pub advance_m: f64,
    /// How far the heading turned to the left, in rad.
    pub heading_change_rad: f64,
    /// Parts that had better not touch anything, and do.
    pub penalised_contacts: usize,
}
