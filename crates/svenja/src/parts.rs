//! What names of groups, of joints and of axes stand for: the axes that are sensed and driven.

use std::collections::BTreeMap;

use crate::{
    AxisId, JointAxis,
    check::{Groups, Joints},
};

/// What sensors and actuators are named by.
pub(crate) struct Parts<'a> {
    joints: &'a Joints<'a>,
    /// Of every group, joint and axis, by name.
    pub(crate) axes: BTreeMap<String, Vec<AxisId>>,
}

impl<'a> Parts<'a> {
    pub(crate) fn new(joints: &'a Joints<'a>, groups: &Groups<'_>) -> Self {
        let mut parts = Self { joints, axes: BTreeMap::new() };
        for id in parts.all_axes() {
            parts.axes.insert(parts.name(id), vec![id]);
        }
        for (i, (_, joint)) in joints.iter().enumerate() {
            parts.axes.insert(joint.name.clone(), parts.axes_of_joint(i).collect());
        }
        for (_, group) in groups {
            let axes = group.joints.iter().flat_map(|&joint| parts.axes_of_joint(joint)).collect();
            parts.axes.insert(group.name.clone(), axes);
        }
        parts
    }

    pub(crate) fn axis(&self, id: AxisId) -> &JointAxis {
        &self.joints[id.joint].1.axes[id.axis]
    }

    pub(crate) fn name(&self, id: AxisId) -> String {
        format!("{}/{}", self.joints[id.joint].1.name, self.axis(id).name)
    }

    fn axes_of_joint(&self, joint: usize) -> impl Iterator<Item = AxisId> + use<> {
        (0..self.joints[joint].1.axes.len()).map(move |axis| AxisId { joint, axis })
    }

    pub(crate) fn all_axes(&self) -> Vec<AxisId> {
        (0..self.joints.len()).flat_map(|joint| self.axes_of_joint(joint)).collect()
    }
}
