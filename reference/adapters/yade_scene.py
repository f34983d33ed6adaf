"""Runs in YADE, for yade.py: a task as JSON comes in, states and the processor time of the steps [s] go out."""

import json
import math
import sys
import time

from yade import *  # noqa: F403

task = json.loads(open(sys.argv[1]).read())


def material(kn, ks, cn, cs, mu):
    # Of two materials the pair has k1 k2/(k1 + k2), and the smaller friction.
    return O.materials.append(ViscElMat(kn=kn, ks=ks, cn=cn, cs=cs, frictionAngle=math.atan(mu), density=1))  # noqa: F405


kinds = {name: material(*numbers) for name, numbers in task["materials"].items()}
walls = []
for wall in task["walls"]:
    ax, ay, bx, by = wall["ends"]
    turn = Quaternion((0, 0, 1), math.atan2(by - ay, bx - ax))  # noqa: F405
    half = math.hypot(bx - ax, by - ay) / 2
    shape = utils.box(((ax + bx) / 2, (ay + by) / 2, 0), (half, 1e-9, 1), orientation=turn, fixed=True, material=material(*wall["material"]))  # noqa: F405
    walls.append(O.bodies.append(shape))  # noqa: F405
ids, drags = [], []
for body in task["bodies"]:
    x, y, theta, vx, vy, w = body["start"]
    spheres = [utils.sphere((x + dx, y + dy, 0), radius, material=kinds[kind]) for dx, dy, radius, kind, _ in body["disks"]]  # noqa: F405
    for sphere, disk in zip(spheres, body["disks"]):
        sphere.state.mass = body["mass"] * disk[4]
    if len(spheres) == 1:
        number = O.bodies.append(spheres[0])  # noqa: F405
        # nu of Stokes' drag 6 pi nu r v that is m lambda v
        if body["along"]:
            drags.append(LinearDragEngine(nu=body["mass"] * body["along"] / (6 * math.pi * body["disks"][0][2]), ids=[number]))  # noqa: F405
    else:
        number, _ = O.bodies.appendClumped(spheres, discretization=0)  # noqa: F405
    state = O.bodies[number].state  # noqa: F405
    state.pos, state.vel, state.angVel = (x, y, 0), (vx, vy, 0), (0, 0, w)
    state.mass, state.inertia, state.angMom = body["mass"], (body["inertia"],) * 3, (0, 0, body["inertia"] * w)
    state.blockedDOFs = "zXY"
    if any(body["force"]):
        O.forces.setPermF(number, (*body["force"], 0))  # noqa: F405
    if body["torque"]:
        O.forces.setPermT(number, (0, 0, body["torque"]))  # noqa: F405
    ids.append(number)
O.engines = [  # noqa: F405
    ForceResetter(),  # noqa: F405
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()]),  # noqa: F405
    InteractionLoop(  # noqa: F405
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()],  # noqa: F405
        [Ip2_ViscElMat_ViscElMat_ViscElPhys()],  # noqa: F405
        [Law2_ScGeom_ViscElPhys_Basic()],  # noqa: F405
    ),
    *drags,
    NewtonIntegrator(damping=0, exactAsphericalRot=False),  # noqa: F405
]
O.dt = task["dt"]  # noqa: F405
before = time.process_time()
O.run(task["steps"], True)  # noqa: F405
cost = time.process_time() - before
states = []
for number, body in zip(ids, task["bodies"]):
    state = O.bodies[number].state  # noqa: F405
    parts = [number] if len(body["disks"]) == 1 else list(O.bodies[number].shape.members)  # noqa: F405
    pressed = sum(i.phys.normalForce.norm() for part in parts for i in O.bodies[part].intrs() if i.isReal and ({i.id1, i.id2} & set(walls)))  # noqa: F405
    states.append({"x": state.pos[0], "y": state.pos[1], "vx": state.vel[0], "vy": state.vel[1], "omega": state.angVel[2], "wall": pressed})
with open(task["found"], "w") as file:
    json.dump({"bodies": states, "cost": cost}, file)
