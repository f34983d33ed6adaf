"""Names and units of what is recorded of a crowd: the columns of the table that `lemons run` writes, and the FMU's
variables behind them. A test holds this table to the command's own (tests/columns.csv)."""

from __future__ import annotations

from typing import NamedTuple


class Quantity(NamedTuple):
    """A column of the table that is an output of the FMU."""

    #: The column.
    name: str
    #: The output; for a quantity of an agent, what comes after `agent[i].`.
    variable: str
    #: `None` for a count.
    unit: str | None


#: [s], time of the communication point
TIME = "t"
#: Id of the agent in Agents.xml
ID = "id"

MOTION = (
    Quantity("x", "Position.x", "m"),
    Quantity("y", "Position.y", "m"),
    Quantity("vx", "Velocity.x", "m/s"),
    Quantity("vy", "Velocity.y", "m/s"),
    Quantity("theta", "Theta", "rad"),
    Quantity("omega", "Omega", "rad/s"),
)
CONTACTS = (
    Quantity("agent_contacts", "AgentContacts", None),
    Quantity("wall_contacts", "WallContacts", None),
    Quantity("contacting_agents", "ContactingAgents", None),
)
SQUEEZE = Quantity("normal_force", "NormalForce", "N")
#: Outputs about the last communication step; FMUs of the first versions do not have them.
OF_STEP = (
    Quantity("mean_normal_force", "MeanNormalForce", "N"),
    Quantity("peak_normal_force", "PeakNormalForce", "N"),
    Quantity("peak_overlap", "PeakOverlap", "m"),
)
#: 1 if an agent is there, 0 if it has left. Only tables of runs in which agents may leave have it, before the last two.
ACTIVE = Quantity("active", "Active", None)
#: Of the whole crowd.
TOTALS = (
    Quantity("total_agent_contacts", "AgentContacts", None),
    Quantity("total_wall_contacts", "WallContacts", None),
)
#: The columns after time and Id, in their order.
TABLE = (*MOTION, *CONTACTS, SQUEEZE, *OF_STEP, *TOTALS)

_X, _Y, _VX, _VY, _THETA, _OMEGA = MOTION
#: In the order in which this package holds the real outputs of every FMU: pose, velocity, squeeze.
REALS = (_X, _Y, _THETA, _VX, _VY, _OMEGA, SQUEEZE)

#: What drives an agent: inputs of the FMU [N], [N], [N.m], and columns of a drive file.
INPUTS = ("Fp.x", "Fp.y", "Mp")
