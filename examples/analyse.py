"""Draws maps of the density and the speed of a crowd, with PedPy.

    python examples/analyse.py run.sqlite [maps.png] [--from 0] [--until 5] [--cell 0.2]

`lemons export trajectories.csv run.sqlite --to jupedsim --trial TRIAL` makes such a run.sqlite. PedPy: pip install pedpy.

Both maps are means over time on square cells. Density: people per square metre; each person is spread evenly over the Voronoi cell
around it, up to a distance of 1 m. Speed: that of the people whose Voronoi cells were there; white where there were none.
"""

import argparse
import sys
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pedpy
import shapely
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

REACH = 1.0  # [m] radius of a Voronoi cell
WINDOW = 0.2  # [s] the speed follows from the positions this long before and after

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("run", metavar="run.sqlite", type=Path, help="made by `lemons export --to jupedsim`")
parser.add_argument("maps", metavar="maps.png", nargs="?", default="maps.png", help="output file; default maps.png")
parser.add_argument("--from", dest="first", type=float, default=0.0, help="seconds after the first frame")
parser.add_argument("--until", type=float, default=np.inf, help="seconds after the first frame; default: all")
parser.add_argument("--cell", type=float, default=0.2, help="side of a cell in metres")
arguments = parser.parse_args()
if not arguments.cell > 0:
    parser.error("--cell must be positive")
try:
    everything = pedpy.load_trajectory_from_jupedsim_sqlite(trajectory_file=arguments.run)
    area = pedpy.load_walkable_area_from_jupedsim_sqlite(trajectory_file=arguments.run)
except (pedpy.errors.PedPyError, OSError) as error:
    sys.exit(f"{arguments.run}: {error}")

rate = everything.frame_rate
times = (everything.data.frame - everything.data.frame.min()) / rate
chosen = everything.data[(times >= arguments.first - 1e-9) & (times <= arguments.until + 1e-9)]
if chosen.frame.nunique() < 2:
    sys.exit(f"{arguments.run}: fewer than two frames from --from {arguments.first} s to --until {arguments.until} s")
run = pedpy.TrajectoryData(chosen.drop(columns="point").reset_index(drop=True), rate)

speeds = pedpy.compute_individual_speed(
    traj_data=run,
    frame_step=max(1, round(WINDOW * rate)),
    speed_calculation=pedpy.SpeedCalculation.BORDER_SINGLE_SIDED,
)
cells, rows, columns = pedpy.get_grid_cells(walkable_area=area, grid_size=arguments.cell)
near = shapely.STRtree(cells)


def profiles(frames):
    """Sums over some frames, for each cell: density, speed and covered area [m²]."""
    some = run.data[run.data.frame.isin(frames)].drop(columns="point").reset_index(drop=True)
    voronoi = pedpy.compute_individual_voronoi_polygons(
        traj_data=pedpy.TrajectoryData(some, rate), walkable_area=area, cut_off=pedpy.Cutoff(radius=REACH, quad_segments=8)
    )
    people = voronoi.merge(speeds).sort_values("frame", ignore_index=True)
    # PedPy would intersect every cell with the polygon of every person. Nearly all are apart: minutes instead of seconds.
    person, cell = near.query(people.polygon, predicate="intersects")
    shares = np.zeros((len(cells), len(people)))
    shares[cell, person] = shapely.area(shapely.intersection(cells[cell], people.polygon.to_numpy()[person]))
    profile = {"data": people, "walkable_area": area, "grid_size": arguments.cell, "grid_intersections_area": shares}
    densities = pedpy.compute_density_profile(density_method=pedpy.DensityMethod.VORONOI, **profile)
    fast = pedpy.compute_speed_profile(speed_method=pedpy.SpeedMethod.VORONOI, **profile)
    return np.array([np.sum(densities, axis=0), np.sum(fast, axis=0), shares.sum(axis=1).reshape(rows, columns)])


frames = run.data.frame.unique()
block = max(1, int(4e6 / (len(cells) * run.number_pedestrians)))  # frames at once: 32 MB of shares
sums, told = np.zeros((3, rows, columns)), time.monotonic()
for k in range(0, len(frames), block):
    sums += profiles(frames[k : k + block])
    # A terminal shows one line that is updated; elsewhere a new one is written every ten seconds.
    if sys.stderr.isatty() or time.monotonic() > told + 10:
        told = time.monotonic()
        end = "\r" if sys.stderr.isatty() and k + block < len(frames) else "\n"
        print(f"{min(k + block, len(frames))} of {len(frames)} frames", end=end, file=sys.stderr, flush=True)
# PedPy divides by whole cells. At a wall only the part inside counts, and for the speed only the covered part.
inside = shapely.area(shapely.intersection(cells, area.polygon)).reshape(rows, columns) / arguments.cell**2
densities, fast, covered = sums / len(frames)
covered /= arguments.cell**2
with np.errstate(invalid="ignore", divide="ignore"):
    density = np.where(covered > 1e-6, densities / inside, np.nan)
    speed = np.where(covered > 1e-6, fast / covered, np.nan)

left, _, _, top = area.bounds
extent = (left, left + columns * arguments.cell, top - rows * arguments.cell, top)
wide = columns > rows
width, height = (8.0, 8.0 * rows / columns) if wide else (6.0 * columns / rows, 6.0)
size = (width + 1.5, 2 * height + 2.0) if wide else (2 * width + 3.0, height + 1.5)
figure, both = plt.subplots(2 if wide else 1, 1 if wide else 2, figsize=size, layout="constrained", sharex=True, sharey=True)
rings = [area.polygon.exterior, *area.polygon.interiors]
outline = Outline.make_compound_path(*(Outline(np.asarray(ring.coords), closed=True) for ring in rings))
for axes, name, values, colours in [
    (both[0], "density [people/m²]", density, "viridis"),
    (both[1], "speed [m/s]", speed, "plasma"),
]:
    image = axes.imshow(values, extent=extent, cmap=colours, vmin=0, interpolation="nearest")
    # Cells at the edge extend beyond it; the area of people does not.
    image.set_clip_path(PathPatch(outline, transform=axes.transData))
    axes.add_patch(PathPatch(outline, fill=False, lw=1.5, color="0.15", clip_on=False))
    axes.set(ylabel="y [m]", aspect="equal")
    axes.tick_params(length=0)
    figure.colorbar(image, ax=axes, pad=0.02)
    axes.set_title(f"mean {name}", loc="left", fontsize="medium")
    axes.spines[:].set_visible(False)
for axes in both[-1:] if wide else both:
    axes.set_xlabel("x [m]")
first, last = (run.data.frame.min() - everything.data.frame.min()) / rate, (run.data.frame.max() - everything.data.frame.min()) / rate
figure.suptitle(f"{run.number_pedestrians} people, {first:g} to {last:g} s", x=0.01, ha="left")
figure.savefig(arguments.maps, dpi=150)
print(f"{arguments.maps}: {run.number_pedestrians} people, {chosen.frame.nunique()} frames, {rate:g} per second")
print(f"density of a cell  at most {np.nanmax(density):.2f} per m² in the mean")
print(f"speed of a person  at most {speeds.speed.max():.2f} m/s, {speeds.speed.mean():.2f} m/s in the mean")
