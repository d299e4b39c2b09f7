//! What a reward is told of the robot, once.

/// The robot: its readings, positions first and then contacts, and its bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RobotLayout {
    /// The number of joint positions.
    pub n_positions: usize,
    /// Contacts, of two states each.
    pub n_contacts: usize,
    /// Bins of a position.
    pub n_bins: u64,
    /// The model's groups, its legs.
    pub groups: Vec<Group>,
    /// Pairs of positions whose joints are next to each other: the one moves the body that the other is
    /// fixed to. Bodies that are fixed together count as one. Each pair is there once.
    pub neighbours: Vec<[usize; 2]>,
    /// The bodies' names, in the model's order.
    pub bodies: Vec<String>,
    /// Which of the bodies has the heading axis.
    pub heading_body: usize,
    /// The model's own factor for metres in a control step.
    pub locomotion_scale: f64,
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

impl RobotLayout {
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
