#!/usr/bin/env python3
"""Writes growth.txt from the data files of the CDC growth charts of 2000 (United States, public domain).

    python3 crates/people/data/make_growth.py statage.csv wtage.csv > crates/people/data/growth.txt

The files have L, M and S for each month; a row of growth.txt has those of a whole year. How much the medians between
whole years are off is printed to the standard error.
"""

import csv
import sys

HEADER = """\
# CDC growth charts of 2000 (United States, public domain; Kuczmarski and others, 2002): stature and mass of children
# for their age, as the parameters L, M, S of Cole and Green (1992), at whole years. Made by make_growth.py.
# Per sex and year of age: L, M [cm], S of the stature; L, M [kg], S of the mass."""
SEXES = {"1": "male", "2": "female"}
YEARS = range(2, 19)


def read(path):
    """The rows (age in years, L, M, S) of each sex."""
    rows = {sex: [] for sex in SEXES.values()}
    with open(path, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            rows[SEXES[row["Sex"]]].append([float(row["Agemos"]) / 12, *(float(row[key]) for key in "LMS")])
    return rows


def at(rows, age):
    """L, M and S at an age, linear between months."""
    for before, after in zip(rows, rows[1:]):
        if before[0] <= age <= after[0]:
            way = (age - before[0]) / (after[0] - before[0])
            return [a + way * (b - a) for a, b in zip(before[1:], after[1:])]
    sys.exit(f"there is no age {age}")


def main(paths):
    charts = [read(path) for path in paths]
    print(HEADER)
    worst = 0.0
    for sex in SEXES.values():
        print(sex)
        for year in YEARS:
            values = [value for chart in charts for value in at(chart[sex], year)]
            print(year, *(f"{value:.5g}" for value in values))
        for chart in charts:
            for age, _, median, _ in chart[sex]:
                if age < YEARS[-1]:
                    year, way = int(age), age % 1
                    found = (1 - way) * at(chart[sex], year)[1] + way * at(chart[sex], year + 1)[1]
                    worst = max(worst, abs(found / median - 1))
    print(f"largest error of a median between whole years: {100 * worst:.2f} %", file=sys.stderr)


if __name__ == "__main__":
    main(sys.argv[1:])
