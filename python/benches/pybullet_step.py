"""What a physics step costs in PyBullet, beside ours: steps of a world per second, in turns.

    make bench-pybullet                           # installs PyPI's pybullet, and runs
    python pybullet_step.py MODEL.toml [WORLDS]

PyBullet has no spring joints of six axes, so its robot is approximate: the same bodies, masses, ranges, limits
of torque and ground in a URDF, with Bullet's inertia of the same shapes, and hips of two hinges with a gram
between them. It's loaded as PyBullet loads robots, as one multibody, with position motors, and stepped at 100 Hz
with a new random command every 10 steps. Ours has Bullet's joints as the lab has them and 200 iterations of the
solver; PyBullet is measured with as many, and with the 50 that it comes with. Both run on one core, by turns, since
machines have modes: ratios count. Seconds are of processor time, so that what else runs takes none of them. Ours
include all of `VectorEnv.step`: readings, rewards and NumPy.
"""

import math
import os
import statistics
import sys
import tempfile
import time
import tomllib
from xml.sax.saxutils import quoteattr

import numpy as np
import pybullet

import itarl
from halves import parts

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
STEPS = 10  # physics steps in a control step
TURNS = 7
SECONDS = 1.0


def turned_about_z(vector, degrees):
    x, y, z = vector
    a, b, angle = (math.radians(it) for it in degrees)
    if a or b:
        sys.exit("joints' frames that are turned about x or y aren't covered here: use Svenja")
    return [x * math.cos(angle) - y * math.sin(angle), x * math.sin(angle) + y * math.cos(angle), z]


def numbers(values):
    return quoteattr(" ".join(f"{value:.9g}" for value in values))


def collision(shape, at):
    """A shape of a link whose origin is `at` from the body's centre. A capsule of URDF lies along z."""
    if shape["kind"] == "box":
        size = [2 * it for it in shape["half_extents_m"]]
        geometry, centre, rpy = f"<box size={numbers(size)}/>", np.zeros(3), (0, 0, 0)
    else:
        start, end = np.array(shape["from_m"]), np.array(shape["to_m"])
        way, centre = end - start, (start + end) / 2
        length = np.linalg.norm(way)
        x, y, z = way / length
        rpy = (0, math.atan2(math.hypot(x, y), z), math.atan2(y, x))
        geometry = f'<capsule radius="{shape["radius_m"]}" length="{length:.9g}"/>'
    origin = f"<origin xyz={numbers(centre + at)} rpy={numbers(rpy)}/>"
    return f"<collision>{origin}<geometry>{geometry}</geometry></collision>"


def link(name, body, at):
    """A body; Bullet makes its inertia of its shape."""
    inertial = (
        f'<inertial><origin xyz={numbers(at)}/><mass value="{body["mass_kg"]}"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    )
    contact = f'<contact><lateral_friction value="{body.get("friction", 1.0)}"/></contact>'
    return f"<link name={quoteattr(name)}>{contact}{inertial}{collision(body['shape'], at)}</link>"


def urdf(model):
    """The robot as PyBullet can have it."""
    bodies = {part["name"]: part for part, _ in parts(model, "body")}
    joints = list(parts(model, "joint"))
    children = {joint["child"] for joint, _ in joints}
    (root,) = (name for name in bodies if name not in children)
    at = {root: np.zeros(3)}  # from a link's origin to the body's centre
    made = [link(root, bodies[root], at[root])]
    while joints:
        joint, mirrored = next(it for it in joints if it[0]["parent"] in at)
        joints.remove((joint, mirrored))
        parent, child = joint["parent"], joint["child"]
        anchor = at[parent] + joint["anchor_m"]
        offset = np.subtract(bodies[child]["position_m"], bodies[parent]["position_m"])
        at[child] = offset - np.array(joint["anchor_m"])
        axes = sorted(joint.get("axes", []), key=lambda axis: axis["about"], reverse=True)
        before, place = parent, anchor
        for i, axis in enumerate(axes):
            is_last = i == len(axes) - 1
            after = child if is_last else f"{joint['name']} between"
            if not is_last:
                made.append(
                    f'<link name={quoteattr(after)}><inertial><mass value="0.001"/><inertia ixx="1e-6" ixy="0" '
                    'ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/></inertial></link>'
                )
            direction = np.array(turned_about_z(AXES[axis["about"]], joint.get("frame_deg", [0, 0, 0])))
            direction = direction * [1, -1, -1] if mirrored else direction
            low, high = np.radians(axis["range_deg"])
            servo = model["servo"][axis["servo"]]
            made.append(
                f"<joint name={quoteattr(joint['name'] + '/' + axis['about'])} type=\"revolute\">"
                f"<parent link={quoteattr(before)}/><child link={quoteattr(after)}/>"
                f"<origin xyz={numbers(place)}/><axis xyz={numbers(direction)}/>"
                f'<limit lower="{low:.9g}" upper="{high:.9g}" effort="{servo["torque_limit_nm"]}" '
                f'velocity="{servo["speed_limit_rad_s"]}"/></joint>'
            )
            before, place = after, np.zeros(3)
        if not axes:
            made.append(
                f"<joint name={quoteattr(joint['name'])} type=\"fixed\"><parent link={quoteattr(parent)}/>"
                f"<child link={quoteattr(child)}/><origin xyz={numbers(anchor)}/></joint>"
            )
        made.append(link(child, bodies[child], at[child]))
    # PyBullet breaks lines that are longer than 8192 characters, wherever that is.
    return "\n".join([f"<robot name={quoteattr(model['name'])}>", *made, "</robot>"])


class Theirs:
    """The robot in PyBullet, which settles first."""

    def __init__(self, model, iterations):
        self.client = pybullet.connect(pybullet.DIRECT)
        here = {"physicsClientId": self.client}
        pybullet.setGravity(0, 0, -9.81, **here)
        pybullet.setPhysicsEngineParameter(fixedTimeStep=0.01, numSolverIterations=iterations, **here)
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, **here)
        pybullet.createMultiBody(0, plane, **here)
        start = np.add(model["start"]["position_m"], next(parts(model, "body"))[0]["position_m"])
        with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
            file.write(urdf(model))
            file.flush()
            self.robot = pybullet.loadURDF(file.name, start.tolist(), **here)
        joints = [pybullet.getJointInfo(self.robot, i, **here) for i in range(pybullet.getNumJoints(self.robot, **here))]
        joints = [joint for joint in joints if joint[2] == pybullet.JOINT_REVOLUTE]
        self.joints = [joint[0] for joint in joints]
        self.low, self.high = np.array([joint[8:10] for joint in joints]).T
        self.forces = [joint[10] for joint in joints]
        self.speeds = [joint[11] for joint in joints]
        self.random = np.random.default_rng(1)
        self.command((self.low + self.high) / 2)
        for _ in range(200):
            pybullet.stepSimulation(**here)
        self.height = pybullet.getBasePositionAndOrientation(self.robot, **here)[0][2]

    def command(self, targets):
        pybullet.setJointMotorControlArray(
            self.robot,
            self.joints,
            pybullet.POSITION_CONTROL,
            targetPositions=targets.tolist(),
            forces=self.forces,
            physicsClientId=self.client,
        )

    def rate(self):
        """Steps a second of one world."""
        steps, began = 0, time.process_time()
        while time.process_time() - began < SECONDS:
            self.command(np.where(self.random.random(len(self.joints)) < 0.5, self.low, self.high))
            for _ in range(STEPS):
                pybullet.stepSimulation(physicsClientId=self.client)
            steps += STEPS
        return steps / (time.process_time() - began)


class Ours:
    """Robots in lanes, settled."""

    def __init__(self, model_file, n_worlds):
        self.envs = itarl.VectorEnv(model_file, num_envs=n_worlds)
        self.envs.reset(seed=1)
        self.random = np.random.default_rng(1)

    def rate(self):
        """Steps a second of all worlds together."""
        shape, steps, began = self.envs.action_space.shape, 0, time.process_time()
        while time.process_time() - began < SECONDS:
            self.envs.step(np.where(self.random.random(shape) < 0.5, -1.0, 1.0))
            steps += STEPS * self.envs.num_envs
        return steps / (time.process_time() - began)


def main():
    model_file = sys.argv[1]
    n_worlds = int(sys.argv[2]) if len(sys.argv) > 2 else 16
    with open(model_file, "rb") as file:
        model = tomllib.load(file)
    ours = Ours(model_file, n_worlds)
    theirs = {iterations: Theirs(model, iterations) for iterations in (200, 50)}
    for iterations, it in theirs.items():
        print(
            f"{model['name']} in PyBullet, {iterations} iterations: {len(it.joints)} motors, settled with its middle at "
            f"{it.height:.2f} m"
        )
    ratios = {iterations: [] for iterations in theirs}
    for _ in range(TURNS):
        rates = {iterations: it.rate() for iterations, it in theirs.items()}
        our_rate = ours.rate()
        for iterations, rate in rates.items():
            ratios[iterations].append(our_rate / rate)
        said = ", ".join(f"{rate:8.0f} with {iterations}" for iterations, rate in rates.items())
        print(f"  steps a second: {n_worlds} worlds of ours {our_rate:8.0f}; PyBullet's {said}")
    print(f"with {os.cpu_count()} cores, on which {os.getloadavg()[0]:.1f} processes were at work")
    for iterations, each in ratios.items():
        print(f"ours makes {statistics.median(each):.1f} times PyBullet's with {iterations} iterations")


main()
