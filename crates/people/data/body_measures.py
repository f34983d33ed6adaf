#!/usr/bin/env python3
"""Writes src/body3d/measures.rs: the mean body of each sex and how its measures follow the four of a person.

Source: US Army ANSUR II (2012), 4081 men and 1986 women, summarised as means, SDs and Spearman ranks of 54
measures in ansur_body_summary.json. A measure y of a person whose four measures are x is taken as the conditional mean
of a multivariate normal: E[y|x] = mean_y + S_yx S_xx^-1 (x - mean_x), with S from the SDs and Pearson's r = 2 sin(pi rho/6).

    python3 crates/people/data/body_measures.py ../shared/data/anthropometry/ansur_body_summary.json > crates/people/src/body3d/measures.rs
"""

import json
import math
import sys

GIVEN = ["bideltoidbreadth", "chestdepth", "stature", "weightkg"]
# In the order of the body: name in the survey, name of the variant, what it is.
USED = [
    ("acromialheight", "AcromialHeight", "height of the bony tip of the shoulder"),
    ("axillaheight", "AxillaHeight", "height of the armpit"),
    ("chestheight", "ChestHeight", "height of the nipples"),
    ("tenthribheight", "TenthRibHeight", "height of the lowest rib"),
    ("waistheightomphalion", "WaistHeight", "height of the navel"),
    ("buttockheight", "ButtockHeight", "height of the most prominent point of the buttocks"),
    ("crotchheight", "CrotchHeight", "height of the crotch"),
    ("kneeheightmidpatella", "KneeHeight", "height of the middle of the kneecap"),
    ("tibialheight", "TibialHeight", "height of the top of the shinbone"),
    ("lateralmalleolusheight", "MalleolusHeight", "height of the outer ankle bone"),
    ("wristheight", "WristHeight", "height of the wrist"),
    ("tragiontopofhead", "TragionToTop", "from the ear's notch up to the top of the head"),
    ("acromionradialelength", "UpperArmLength", "from the shoulder's tip to the elbow"),
    ("handlength", "HandLength", "from the wrist to the fingertip"),
    ("biacromialbreadth", "BiacromialBreadth", "between the tips of the shoulders"),
    ("chestbreadth", "ChestBreadth", "at the nipples"),
    ("waistbreadth", "WaistBreadth", "at the navel"),
    ("waistdepth", "WaistDepth", "at the navel"),
    ("hipbreadth", "HipBreadth", "widest of the hips"),
    ("buttockdepth", "ButtockDepth", "at the buttocks"),
    ("headbreadth", "HeadBreadth", "widest above the ears"),
    ("headlength", "HeadLength", "from the brow to the back of the head"),
    ("footlength", "FootLength", "heel to toe"),
    ("footbreadthhorizontal", "FootBreadth", "widest of the foot"),
    ("handbreadth", "HandBreadth", "across the knuckles"),
    ("chestcircumference", "ChestGirth", "at the nipples"),
    ("waistcircumference", "WaistGirth", "at the navel"),
    ("buttockcircumference", "ButtockGirth", "at the buttocks"),
    ("headcircumference", "HeadGirth", "above the brow"),
    ("neckcircumference", "NeckGirth", "at the larynx"),
    ("neckcircumferencebase", "NeckBaseGirth", "at the root of the neck"),
    ("bicepscircumferenceflexed", "BicepsGirth", "flexed"),
    ("forearmcircumferenceflexed", "ForearmGirth", "flexed"),
    ("wristcircumference", "WristGirth", "at the wrist"),
    ("thighcircumference", "ThighGirth", "just below the buttocks"),
    ("lowerthighcircumference", "LowerThighGirth", "just above the kneecap"),
    ("calfcircumference", "CalfGirth", "widest of the calf"),
    ("anklecircumference", "AnkleGirth", "narrowest above the ankle"),
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
    lines = []
    for name, _, _ in USED:
        of = [covariance(name, g) for g in GIVEN]
        slopes = [sum(of[j] * given[j][k] for j in range(4)) for k in range(4)]
        numbers = ", ".join(f"{v:.6f}" for v in [sex["mean"][name] * unit(name), *slopes])
        lines.append(f"        [{numbers}],")
    means = ", ".join(f"{sex['mean'][g] * unit(g):.5f}" for g in GIVEN)
    return f"MeanBody {{\n    given: [{means}],\n    measures: [\n" + "\n".join(lines) + "\n    ],\n}"


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        data = json.load(file)
    print("//! The mean body of each sex. Generated by data/body_measures.py from the US Army ANSUR II survey (2012).\n")
    print("/// A measure that follows from the four given measures of a person.")
    print("#[derive(Debug, Clone, Copy, PartialEq, Eq)]\npub(super) enum Measure {")
    for name, variant, what in USED:
        print(f"    /// \\[m\\] {what}: `{name}`.\n    {variant},")
    print("}\n")
    print(f"/// Number of variants of [`Measure`].\npub(super) const COUNT: usize = {len(USED)};\n")
    print("/// The survey's names.\n#[cfg(test)]\npub(super) const NAMES: [&str; COUNT] = [")
    for name, _, _ in USED:
        print(f'    "{name}",')
    print("];\n")
    print("/// The mean body of one sex.\npub(super) struct MeanBody {")
    print("    /// \\[m, m, m, kg\\] means of bideltoid breadth, chest depth, stature, mass.\n    pub given: [f64; 4],")
    print("    /// For each measure: mean \\[m\\], then its slopes with respect to the four given ones.\n    pub measures: [[f64; 5]; COUNT],\n}\n")
    for name, what, sex in [("MEN", f"Of {data['male']['n']} men.", "male"), ("WOMEN", f"Of {data['female']['n']} women.", "female")]:
        print(f"/// {what}\n#[rustfmt::skip]\npub(super) const {name}: MeanBody = {table(data[sex])};")


main()
