"""Measures of `experiments.py`, by PedPy with the same functions for the experiment and for us, at the frame rate of the experiment.

- flow: between a fifth and four fifths of the passages of a line. Last: at the gate from the start on, at exits after the first.
- density and speed: Voronoi, twice a second; speeds over ±1 s. Upstream of exits: the middle 2 m of the corridor.
- v(density): the middle 4 m of the corridor, all frames, classes of 0.25 /m². J(density): density times speed, the middle 3 m.
- single file: the way along the ring is unrolled; speeds over ±0.4 s. Stopped: slower than 0.05 m/s. Overtaking: somebody whose
  predecessor on the ring falls behind.
"""

import math

import numpy as np
import pandas as pd


def passages(traces, line):
    """When people crossed a line for the first time [s], sorted."""
    import pedpy

    _, crossings = pedpy.compute_n_t(traj_data=traces, measurement_line=pedpy.MeasurementLine(line))
    return np.sort(crossings["frame"].to_numpy()) / traces.frame_rate


def steady(times, number):
    """Flow [1/s] between a fifth and four fifths of the passages of so many people, and when that is [s]. Without them: 0."""
    a, b = (round(part * (number - 1)) for part in (0.2, 0.8))
    if len(times) <= b:
        return 0.0, (times[a] if len(times) > a else math.inf, times[-1] if len(times) else 0.0)
    return (b - a) / (times[b] - times[a]), (times[a], times[b])


def voronoi(traces, area, *parts):
    """Of each part (a rectangle, frames): density [1/m²] and speed [m/s] in those of the frames in which somebody is there. Cells are
    made of the people of the part's surroundings: who waits behind an entrance is not among them."""
    import pedpy

    wanted = sorted(set().union(*(frames for _, frames in parts)) & set(traces.data["frame"]))
    near = traces.data["y"].abs() < 6
    chosen = pedpy.TrajectoryData(traces.data[traces.data["frame"].isin(wanted) & near], frame_rate=traces.frame_rate)
    if not len(chosen.data):
        return [np.zeros((0, 2))] * len(parts)
    cells = pedpy.compute_individual_voronoi_polygons(traj_data=chosen, walkable_area=pedpy.WalkableArea(area))
    own, found = speeds_over(traces, 1.0), []
    for part, frames in parts:
        part = pedpy.MeasurementArea(part)
        density, cut = pedpy.compute_voronoi_density(individual_voronoi_data=cells, measurement_area=part)
        speed = pedpy.compute_voronoi_speed(traj_data=chosen, individual_voronoi_intersection=cut, individual_speed=own, measurement_area=part)
        tables = [table.reset_index().set_index("frame")[name] for table, name in ((density, "density"), (speed, "speed"))]
        both = pd.concat(tables, axis=1).reindex(sorted(set(frames) & set(wanted)))
        found.append(both[both["density"] > 0].to_numpy())
    return found


def speeds_over(traces, seconds):
    """Speeds of people over ± so many seconds."""
    import pedpy

    way = pedpy.SpeedCalculation.BORDER_SINGLE_SIDED
    return pedpy.compute_individual_speed(traj_data=traces, frame_step=round(seconds * traces.frame_rate), speed_calculation=way)


def mean(values):
    return float(np.nanmean(values)) if len(values) else math.nan


def every(traces, window=(0.0, math.inf)):
    """Frames twice a second, within a time."""
    last = min(window[1] * traces.frame_rate, traces.data["frame"].max())
    return range(int(min(window[0] * traces.frame_rate, last)), int(last) + 1, round(traces.frame_rate / 2))


def measure_gate(scene, traces):
    from shapely import box

    number, times = traces.data["id"].nunique(), passages(traces, scene.line)
    flow, window = steady(times, number)
    frames = every(traces, window)
    (ahead,) = voronoi(traces, scene.area, (box(-0.4, 0.5, 0.4, 1.3), frames))
    nearest = []
    for _, own in traces.data[traces.data["frame"].isin(frames)].groupby("frame"):
        places = own[["x", "y"]].to_numpy()
        distance = np.hypot(*(places[:, None] - places).transpose(2, 0, 1)) + np.diag(np.full(len(places), math.inf))
        before = (places[:, 1] > 0) & (np.hypot(*places.T) < 1.5)
        nearest += list(distance[before].min(axis=1)) if len(places) > 1 else []
    gaps = np.diff(times) if len(times) == number else np.array([math.inf])
    return {
        **{"flow": flow, "specific": flow / 0.5, "last": times[-1] if len(times) == number else math.inf, "density": mean(ahead[:, 0])},
        **{"speed": mean(ahead[:, 1]), "nearest": mean(nearest), "gap 95 %": np.quantile(gaps, 0.95, method="inverted_cdf"), "greatest gap": gaps.max(), "times": times},
    }


def measure_corridor(scene, traces, wide, out):
    from shapely import box

    number, times = traces.data["id"].nunique(), passages(traces, scene.line)
    flow, window = steady(times, number)
    upstream, points = voronoi(traces, scene.area, (box(0, -1, wide, 1), every(traces, window)), (box(0, -2, wide, 2), every(traces)))
    through = steady(passages(traces, ((0, 0), (wide, 0))), number)[0]
    return {
        **{"specific": flow / out, "last": times[-1] - times[0] if len(times) == number else math.inf, "times": times},
        **{"density": mean(upstream[:, 0]), "speed": mean(upstream[:, 1]), "capacity": through / wide, "points": points},
    }


def measure_counterflow(scene, traces, wide):
    from shapely import box

    (points,) = voronoi(traces, scene.area, (box(0, -1.5, wide, 1.5), every(traces)))
    # Not by passages of the middle: PedPy misses somebody who is on the line to within some micrometres in a frame.
    ends = traces.data.sort_values("frame").groupby("id")["y"].agg(["first", "last"])
    return {
        "points": points * np.column_stack([np.ones(len(points)), points[:, 0]]),
        "stuck": float((ends["first"] * ends["last"] > 0).any()),
    }


def measure_ring(scene, traces):
    """Of the measured people there are pairs of density and speed only."""
    import pedpy

    if isinstance(traces, tuple):
        density, speed = traces
        found = {"headway": float(np.mean(1 / density)), "overtakings": 0.0}
    else:
        radius, last = scene.ring / (2 * math.pi), traces.data["frame"].max()
        table = traces.data.sort_values(["id", "frame"])
        number = table["id"].nunique()
        angles = np.unwrap(np.arctan2(table["y"], table["x"]).to_numpy().reshape(number, -1), axis=1)
        order = np.argsort(angles[:, 0])
        ahead = np.roll(angles[order], -1, axis=0) - angles[order]
        ahead -= 2 * math.pi * np.floor(ahead[:, :1] / (2 * math.pi))
        flat = pd.DataFrame({"id": table["id"], "frame": table["frame"], "x": radius * angles.ravel(), "y": 0.0})
        own = speeds_over(pedpy.TrajectoryData(flat, frame_rate=scene.fps), 0.4)
        speed = own[own["frame"] > last / 4]["speed"].to_numpy()
        found = {"headway": scene.ring / number, "overtakings": float((ahead.min(axis=1) < 0).sum())}
    return {**found, "speed": float(speed.mean()), "spread": float(speed.std()), "stopped": float((speed < 0.05).mean())}
