"""Writes the Trial of thirty people in a room whose door leads to a corridor, and their way-points (decision.toml).

    python examples/room_with_door.py resources/Trial_door

The people are the five of the paper's App. C, six times, turned to the door within 40 degrees and shifted by up to
8 cm, with desired speeds of 1.34 m/s on average (standard deviation 0.26 m/s, Weidmann 1993); the random numbers are
seeded. The room is 5 m by 5 m, the door 0.9 m wide, the corridor 2 m.

Friction between people is 0.05. With the 0.4 of the paper's example, people who push on and never give way
mostly form a permanent arch in the door (in 13 of 16 seeded sets of speeds).
"""

import argparse
import random
import xml.etree.ElementTree as ET
from math import atan2, radians
from pathlib import Path

SOURCE = Path(__file__).resolve().parent.parent / "resources" / "Trial_push"
DOOR = (5.0, 2.5)  # m, middle of the door
WALL = "14,1.5 5.2,1.5 5.2,2.05 5,2.05 5,0 0,0 0,5 5,5 5,2.95 5.2,2.95 5.2,3.5 14,3.5"
COLUMNS, ROWS, SPACING = 6, 5, 0.75  # m
FRICTION = "0.05"
DECISION = """\
# Through the door, then along the corridor: `lemons decide --help`.

[[waypoints]]         # the middle of the door
x = 5.1               # m
y = 2.5
radius = 0.4

[[waypoints]]         # beyond the end of the corridor
x = 30.0
y = 2.5

[agents]              # m/s
"""

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("target", metavar="DIR", type=Path, help="directory for the Trial; it is created if necessary")
target = parser.parse_args().target
rng = random.Random(30)
shapes = list(ET.parse(SOURCE / "static/Agents.xml").getroot()) * (COLUMNS * ROWS // 5)
rng.shuffle(shapes)
agents, dynamics = ET.Element("Agents"), ET.Element("Agents")
for i in range(COLUMNS * ROWS):
    agent = ET.SubElement(agents, "Agent", dict(shapes[i].attrib, Id=str(i)))
    agent.extend(shapes[i])
    x = 0.45 + SPACING * (i // ROWS) + rng.uniform(-0.08, 0.08)
    y = 1.0 + SPACING * (i % ROWS) + rng.uniform(-0.08, 0.08)
    theta = atan2(DOOR[1] - y, DOOR[0] - x) + radians(rng.uniform(-40, 40))
    state = ET.SubElement(dynamics, "Agent", Id=str(i))
    ET.SubElement(state, "Kinematics", Position=f"{x:.4f},{y:.4f}", Velocity="0,0", Theta=f"{theta:.4f}", Omega="0")
    ET.SubElement(state, "Dynamics", Fp="0,0", Mp="0")

geometry = ET.Element("Geometry")
ET.SubElement(geometry, "Dimensions", Lx="14", Ly="5")
wall = ET.SubElement(geometry, "Wall", Id="0", MaterialId="concrete")
for corner in WALL.split():
    ET.SubElement(wall, "Corner", Coordinates=corner)

materials = ET.parse(SOURCE / "static/Materials.xml").getroot()
materials.find("Binary/Contact[@Id1='human_naked'][@Id2='human_naked']").set("KineticFriction", FRICTION)

parameters = ET.Element("Parameters")
ET.SubElement(parameters, "Directories", Static="./static/", Dynamic="./dynamic/")
ET.SubElement(parameters, "Times", TimeStep="0.05", TimeStepMechanical="2e-5")


def write(name, root):
    path = target / name
    path.parent.mkdir(parents=True, exist_ok=True)
    ET.indent(root, "    ")
    ET.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
    with path.open("a") as file:
        file.write("\n")


write("Parameters.xml", parameters)
write("static/Agents.xml", agents)
write("static/Geometry.xml", geometry)
write("static/Materials.xml", materials)
write("dynamic/AgentDynamics.xml", dynamics)
speeds = (min(max(rng.gauss(1.34, 0.26), 0.6), 2.0) for _ in agents)
rows = (f"{i} = {{ desired_speed = {speed:.2f} }}\n" for i, speed in enumerate(speeds))
(target / "decision.toml").write_text(DECISION + "".join(rows))
