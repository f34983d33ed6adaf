#!/usr/bin/env python3
"""Writes data/bodies.txt: the mean body of each sex and how its measures follow the four of a person.

Source: US Army ANSUR II (2012), 4081 men and 1986 women, summarised as means, SDs and Spearman ranks of 54
measures in ansur_body_summary.json. A measure y of a person whose four measures are x is taken as the conditional mean
of a multivariate normal: E[y|x] = mean_y + S_yx S_xx^-1 (x - mean_x), with S from the SDs and Pearson's r = 2 sin(pi rho/6).

    python3 crates/people/data/body_measures.py ../shared/data/anthropometry/ansur_body_summary.json > crates/people/data/bodies.txt
"""

import json
import math
import sys

GIVEN = ["bideltoidbreadth", "chestdepth", "stature", "weightkg"]
# src/body3d/measures.rs says what each is.
USED = [
    "acromialheight",
    "axillaheight",
    "chestheight",
    "tenthribheight",
    "waistheightomphalion",
    "buttockheight",
    "crotchheight",
    "kneeheightmidpatella",
    "tibialheight",
    "lateralmalleolusheight",
    "wristheight",
    "tragiontopofhead",
    "acromionradialelength",
    "handlength",
    "biacromialbreadth",
    "chestbreadth",
    "waistbreadth",
    "waistdepth",
    "hipbreadth",
    "buttockdepth",
    "headbreadth",
    "headlength",
    "footlength",
    "footbreadthhorizontal",
    "handbreadth",
    "chestcircumference",
    "waistcircumference",
    "buttockcircumference",
    "headcircumference",
    "neckcircumference",
    "neckcircumferencebase",
    "bicepscircumferenceflexed",
    "forearmcircumferenceflexed",
    "wristcircumference",
    "thighcircumference",
    "lowerthighcircumference",
    "calfcircumference",
    "anklecircumference",
]


def inverse(matrix):
    """Gauss-Jordan with pivots; four by four."""
    n = len(matrix)
    rows = [row[:] + [float(i == j) for j in range(n)] for i, row in enumerate(matrix)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda r: abs(rows[r][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [v / rows[k][k] for v in rows[k]]
        for r in range(n):
            if r != k:
                rows[r] = [a - rows[r][k] * b for a, b in zip(rows[r], rows[k])]
    return [row[n:] for row in rows]


def unit(name):
    """SI per unit of the survey's summary."""
    return 1.0 if name == "weightkg" else 0.01


def table(sex):
    order = sex["order"]

    def covariance(a, b):
        rho = sex["spearman"][order.index(a)][order.index(b)]
        r = 1.0 if a == b else 2 * math.sin(math.pi * rho / 6)
        return r * sex["sd"][a] * unit(a) * sex["sd"][b] * unit(b)

    given = inverse([[covariance(a, b) for b in GIVEN] for a in GIVEN])
    lines = [" ".join(f"{sex['mean'][g] * unit(g):.5f}" for g in GIVEN)]
    for name in USED:
        of = [covariance(name, g) for g in GIVEN]
        slopes = [sum(of[j] * given[j][k] for j in range(4)) for k in range(4)]
        numbers = " ".join(f"{v:.6f}" for v in [sex["mean"][name] * unit(name), *slopes])
        lines.append(f"{name} {numbers}")
    return "\n".join(lines)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        data = json.load(file)
    print("# The mean body of each sex: made by body_measures.py from the US Army ANSUR II survey (2012).")
    print("# male, female: means of bideltoid breadth, chest depth, stature [m] and mass [kg].")
    print("# Then each measure: mean [m] and its slopes with respect to these four.")
    for sex in ["male", "female"]:
        print(sex, table(data[sex]))


main()
