//! How the parts hang together: one tree, whose root is free or held by the world.

use super::{Bodies, Checker, Joints, described};

impl Checker<'_> {
    /// Every body but one is the child of exactly one joint, and all hang on that one.
    pub(super) fn tree(&mut self, joints: &Joints<'_>, bodies: &Bodies<'_>) {
        let mut joint_above: Vec<Option<usize>> = vec![None; bodies.len()];
        for (i, (file, joint)) in joints.iter().enumerate() {
            let above = &mut joint_above[joint.child];
            let Some(other) = *above else {
                *above = Some(i);
                continue;
            };
            let message = format!(
                "{}: child must have no other parent, but '{}' is the child of '{}' too",
                described("joint", &joint.name, &file.name.value),
                bodies[joint.child].1.name,
                joints[other].1.name
            );
            self.complain(&file.child.place, message);
        }
        let hangs = |joint: &Option<usize>| joint.is_some_and(|it| joints[it].1.parent.is_some());
        let mut free = bodies.iter().zip(&joint_above).filter(|(_, joint)| !hangs(joint));
        if let Some(((_, root), _)) = free.next() {
            for ((file, body), joint) in free {
                let (joint, but) = match joint {
                    None => ("a joint", "are"),
                    Some(_) => ("a joint to another body", "are: one tree on one root"),
                };
                let message = format!(
                    "{} must be the child of {joint}, as all bodies but one ('{}') {but}",
                    described("body", &body.name, &file.name.value),
                    root.name
                );
                self.complain(&file.name.place, message);
            }
        }
        self.cycles(joints, bodies, &joint_above);
    }

    /// Going up from a body ends at a root; a way that comes to a body again goes round.
    fn cycles(&mut self, joints: &Joints<'_>, bodies: &Bodies<'_>, joint_above: &[Option<usize>]) {
        let mut known = vec![false; bodies.len()];
        for start in 0..bodies.len() {
            let mut way = vec![start];
            let mut here = start;
            while let (false, Some(joint)) = (known[here], joint_above[here])
                && let Some(parent) = joints[joint].1.parent
            {
                here = parent;
                if way.contains(&here) {
                    let (file, joint) = &joints[joint];
                    let message = format!(
                        "{}: parent must not hang on the child, as '{}' does on '{}': a cycle",
                        described("joint", &joint.name, &file.name.value),
                        bodies[parent].1.name,
                        bodies[joint.child].1.name
                    );
                    self.complain(&file.parent.place, message);
                    break;
                }
                way.push(here);
            }
            way.into_iter().for_each(|body| known[body] = true);
        }
    }
}
