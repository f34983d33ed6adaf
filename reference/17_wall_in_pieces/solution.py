"""The closed form of README.md."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from forms import Flat  # noqa: E402

#: k_n, k_t [N/m], gamma_n, gamma_t [kg/s], mu, with G, E = 1379310.3, 4.0e6 and 7.1e8, 1.7e9 Pa: numbers, so that law.py has no part in it.
LAW = (5001491.609548339, 3551485.7704010373, 1230.0, 1230.0, 0.5)


def solution():
    disk = Flat(80, 1.6, 0.2, LAW, 500.0, 300.0, 0.5).advance(1.0)
    return {"0.x": disk.x, "0.vx": disk.v, "0.theta": disk.theta, "0.omega": disk.omega}
