#!/usr/bin/env python3
"""Writes ansur.txt from a summary of the US Army ANSUR II survey (2012, public, 4082 men and 1986 women).

    python3 crates/people/data/make_ansur.py ../shared/data/anthropometry/ansur_summary.json > crates/people/data/ansur.txt

Lengths in units of 10 um, masses in g: whole numbers, since the survey counts in mm and 0.1 kg.
"""

import json
import math
import sys

# Measured, not self-reported: reported heights are whole inches, up to 238.8 cm.
MEASURES = {
    "breadth": "bideltoid_breadth_cm",
    "depth": "chest_depth_cm",
    "stature": "stature_measured_cm",
    "mass": "weight_measured_kg",
}


def deviation(quantiles, tail):
    """Standard deviation of values that lie evenly between the quantiles, but in the outermost cells as t^tail."""
    cells = len(quantiles) - 1
    first, second = 0.0, 0.0
    for left, right in zip(quantiles[1:-2], quantiles[2:-1]):
        first += (left + right) / 2
        second += (left * left + left * right + right * right) / 3
    for end, inner in ((quantiles[0], quantiles[1]), (quantiles[-1], quantiles[-2])):
        step = inner - end
        first += end + step / (1 + tail)
        second += end * end + 2 * end * step / (1 + tail) + step * step / (1 + 2 * tail)
    mean = first / cells
    return math.sqrt(second / cells - mean * mean)


def tail_exponent(quantiles, sd):
    """The exponent with which the table has the survey's standard deviation, at most 1."""
    low, high = 0.05, 1.0
    if deviation(quantiles, high) <= sd:
        return high
    if deviation(quantiles, low) >= sd:
        sys.exit("no exponent gives the standard deviation")
    for _ in range(60):
        middle = (low + high) / 2
        if deviation(quantiles, middle) < sd:
            low = middle
        else:
            high = middle
    return low


def main(path):
    with open(path, encoding="utf-8") as file:
        survey = json.load(file)
    print("# US Army ANSUR II (2012), public survey: bideltoid breadth, chest depth, measured stature, measured mass.")
    print("# Made by make_ansur.py. Lengths in 10 um, masses in g; quantiles 0, 0.5 % ... 100 %.")
    print("# Per sex and measure: mean, standard deviation, exponent of the outermost cells; then the quantiles.")
    print("# Spearman's rank correlations in 1e-4, upper triangle: bd bs bm ds dm sm.")
    for sex in ("male", "female"):
        part = survey[sex]
        print(sex, part["n_used"])
        for name, column in MEASURES.items():
            measure = part["measures"][column]
            quantiles = measure["quantile_table_201"]
            tail = tail_exponent(quantiles, measure["sd"])
            mean, sd = (round(measure[key] * 1000) for key in ("mean", "sd"))
            print(name, mean, sd, f"{tail:.4f}")
            numbers = [str(round(value * 1000)) for value in quantiles]
            for start in range(0, len(numbers), 17):
                print(" ".join(numbers[start : start + 17]))
        places = [part["order"].index(column) for column in MEASURES.values()]
        pairs = [(a, b) for a in range(4) for b in range(a + 1, 4)]
        print("spearman", *(round(part["spearman"][places[a]][places[b]] * 1e4) for a, b in pairs))


if __name__ == "__main__":
    main(sys.argv[1])
