"""What MuJoCo or PyBullet make of a robot's file, a line for each body and each axis.

oracle.py mujoco|pybullet FILE

body NAME MASS CENTRE(3) MOMENTS(3, ascending) FRAME(3)
axis CHILD KIND DIRECTION(3) ANCHOR(3) LOWER UPPER

Positions and directions are in the world, with all joints at 0. An axis without limits has `- -`.
Fields stand between tabs.
"""

import os
import sys
import tempfile
import xml.etree.ElementTree as ElementTree


def say(*fields):
    print(*(repr(float(it)) if not isinstance(it, str) else it for it in fields), sep="\t")


def mujoco_says(path):
    import mujoco

    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    for i in range(1, model.nbody):
        body = model.body(i)
        moments = sorted(model.body_inertia[i])
        say("body", body.name, model.body_mass[i], *data.xipos[i], *moments, *data.xpos[i])
    kinds = {0: "free", 1: "ball", 2: "slides", 3: "turns"}
    for i in range(model.njnt):
        kind = kinds[int(model.jnt_type[i])]
        if kind in ("free", "ball"):
            continue
        limits = ["-", "-"]
        if model.jnt_limited[i]:
            limits = [x - model.qpos0[model.jnt_qposadr[i]] for x in model.jnt_range[i]]
        name = model.body(model.jnt_bodyid[i]).name
        say("axis", name, kind, *data.xaxis[i], *data.xanchor[i], *limits)


def without_shapes(path):
    """Meshes that aren't there keep PyBullet from reading, and it needs none with inertia given."""
    tree = ElementTree.parse(path)
    for link in tree.getroot().iter("link"):
        for kind in ("visual", "collision"):
            for element in link.findall(kind):
                link.remove(element)
    file = tempfile.NamedTemporaryFile("wb", suffix=".urdf", delete=False)
    tree.write(file)
    file.close()
    return file.name


def pybullet_says(path):
    # It says what it thinks on the standard output.
    out = os.dup(1)
    os.dup2(2, 1)
    import pybullet as p

    p.connect(p.DIRECT)
    path = without_shapes(path)
    robot = p.loadURDF(path, flags=p.URDF_USE_INERTIA_FROM_FILE)
    os.unlink(path)
    sys.stdout.flush()
    os.dup2(out, 1)
    world = p.multiplyTransforms
    names = [p.getBodyInfo(robot)[0].decode()]
    # PyBullet reports the base's centre of mass, and puts its frame at the origin.
    dynamics = p.getDynamicsInfo(robot, -1)
    centre, turn = p.getBasePositionAndOrientation(robot)
    own = p.invertTransform(dynamics[3], dynamics[4])
    frame, _ = world(centre, turn, *own)
    say("body", names[0], dynamics[0], *centre, *sorted(dynamics[2]), *frame)
    for i in range(p.getNumJoints(robot)):
        info = p.getJointInfo(robot, i)
        state = p.getLinkState(robot, i, computeForwardKinematics=True)
        dynamics = p.getDynamicsInfo(robot, i)
        name = info[12].decode()
        say("body", name, dynamics[0], *state[0], *sorted(dynamics[2]), *state[4])
        kind = {p.JOINT_REVOLUTE: "turns", p.JOINT_PRISMATIC: "slides"}.get(info[2])
        if kind is None:
            continue
        # The direction is along the principal axes of the link.
        direction, _ = world((0, 0, 0), state[1], info[13], (0, 0, 0, 1))
        limits = [info[8], info[9]] if info[8] < info[9] else ["-", "-"]
        say("axis", name, kind, *direction, *state[4], *limits)


if __name__ == "__main__":
    {"mujoco": mujoco_says, "pybullet": pybullet_says}[sys.argv[1]](sys.argv[2])
