"""What a physics step costs in MuJoCo, beside ours: the robot of a model file, built by MuJoCo's API.

    make bench-mujoco                                # installs PyPI's mujoco, and runs
    python mujoco_step.py MODEL.toml path/to/itarl

Both simulators step the same bodies, joints, ranges and ground at 100 Hz, with a new random command
every 10 steps: MuJoCo one robot, with its own solver as it comes (Newton, which stops once it has
converged) and position actuators; ours with Bullet's 200 iterations and the servo law, as many robots
as there are lanes. Both run on one core, by turns, since machines have modes: the ratio counts.
"""

import math
import re
import statistics
import subprocess
import sys
import time
import tomllib

import mujoco
import numpy as np

from halves import parts

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
STEPS = 10  # physics steps in a control step
TURNS = 5


def turned(vector, degrees):
    """Turned about x, then about the fixed y, then about the fixed z."""
    x, y, z = vector
    a, b, c = (math.radians(angle) for angle in degrees)
    y, z = y * math.cos(a) - z * math.sin(a), y * math.sin(a) + z * math.cos(a)
    x, z = x * math.cos(b) + z * math.sin(b), z * math.cos(b) - x * math.sin(b)
    x, y = x * math.cos(c) - y * math.sin(c), x * math.sin(c) + y * math.cos(c)
    return np.array([x, y, z])


def add_shape(body, part):
    shape = part["shape"]
    geom = body.add_geom(mass=part["mass_kg"], friction=[part.get("friction", 1.0), 0.005, 0.0001])
    # The robot's parts don't collide with each other, only with the ground.
    geom.contype, geom.conaffinity = 2, 1
    if shape["kind"] == "box":
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_BOX, shape["half_extents_m"]
    elif shape["kind"] in ("capsule", "cylinder"):
        geom.type = getattr(mujoco.mjtGeom, f"mjGEOM_{shape['kind'].upper()}")
        geom.fromto = [*shape["from_m"], *shape["to_m"]]
        geom.size = [shape["radius_m"], 0, 0]
    else:
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_SPHERE, [shape["radius_m"], 0, 0]


def build(model):
    spec = mujoco.MjSpec()
    spec.option.timestep = 0.01
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    ground = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    ground.contype, ground.conaffinity = 1, 2
    bodies = {part["name"]: part for part, _ in parts(model, "body")}
    if any(part.get("rotation_deg", [0, 0, 0]) != [0, 0, 0] for part in bodies.values()):
        sys.exit("bodies that are drawn turned aren't covered here: use Svenja")
    joints = list(parts(model, "joint"))
    children = {joint["child"] for joint, _ in joints}
    start = np.array(model["start"]["position_m"])
    made = {}

    def make(name, parent, position):
        made[name] = parent.add_body(name=name, pos=position)
        add_shape(made[name], bodies[name])
        return made[name]

    (root,) = (name for name in bodies if name not in children)
    make(root, spec.worldbody, start + bodies[root]["position_m"]).add_freejoint()
    while joints:
        joint, mirrored = next(it for it in joints if it[0]["parent"] in made)
        joints.remove((joint, mirrored))
        parent, child = bodies[joint["parent"]], bodies[joint["child"]]
        offset = np.subtract(child["position_m"], parent["position_m"])
        body = make(child["name"], made[parent["name"]], offset)
        # A spherical joint turns about z first, then about y, then about x.
        for axis in sorted(joint.get("axes", []), key=lambda axis: axis["about"], reverse=True):
            direction = turned(AXES[axis["about"]], joint.get("frame_deg", [0, 0, 0]))
            direction = direction * [1, -1, -1] if mirrored else direction
            name = f"{joint['name']}/{axis['about']}"
            servo = model["servo"][axis["servo"]]
            low, high = axis["range_deg"]
            body.add_joint(
                name=name,
                type=mujoco.mjtJoint.mjJNT_HINGE,
                pos=np.array(joint["anchor_m"]) - offset,
                axis=direction,
                limited=True,
                range=[low, high],
                damping=1.0,
            )
            actuator = spec.add_actuator(
                name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, ctrlrange=np.radians([low, high])
            )
            actuator.set_to_position(kp=servo["torque_limit_nm"] / 0.05, kv=servo["torque_limit_nm"])
            torque = servo["torque_limit_nm"]
            actuator.forcerange, actuator.forcelimited = [-torque, torque], True
    return spec.compile()


def mujoco_step(model, data, random, seconds):
    """Microseconds a step, random commands for so long."""
    low, high = model.actuator_ctrlrange.T
    steps, began = 0, time.perf_counter()
    while time.perf_counter() - began < seconds:
        data.ctrl = np.where(random.random(model.nu) < 0.5, low, high)
        mujoco.mj_step(model, data, STEPS)
        steps += STEPS
    return 1e6 * (time.perf_counter() - began) / steps


def our_step(itarl, seconds):
    """Microseconds a physics step in lanes, with the servo law, and the name of the instructions."""
    run = [itarl, "bench", "--seconds", str(seconds)]
    text = subprocess.run(run, check=True, capture_output=True, text=True).stdout
    control_step = float(re.search(r"physics\s+([\d.]+) us a control step", text)[1])
    return control_step / STEPS, re.search(r"with .* in lanes \(\w+\)", text)[0]


def main():
    _, model_file, itarl = sys.argv
    with open(model_file, "rb") as file:
        description = tomllib.load(file)
    model = build(description)
    data = mujoco.MjData(model)
    random = np.random.default_rng(1)
    mujoco_step(model, data, random, 0.5)
    print(f"{description['name']} in MuJoCo {mujoco.__version__}: {model.nbody - 1} bodies, {model.nu} actuators")
    turns = []
    for _ in range(TURNS):
        theirs, (ours, how) = mujoco_step(model, data, random, 1.0), our_step(itarl, 2)
        turns.append((theirs, ours))
        print(f"  mj_step {theirs:6.1f} us    our step {ours:6.1f} us {how}    ratio {ours / theirs:.2f}")
    if not np.isfinite(data.qpos).all():
        sys.exit("MuJoCo's robot blew up: its times say nothing")
    print(f"ours takes {statistics.median(ours / theirs for theirs, ours in turns):.2f} of MuJoCo's time")


main()
