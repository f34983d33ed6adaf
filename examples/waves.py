"""Looks for waves in a packed square of people who stand: do they move together, to and fro, or in circles?

    cargo build --release
    pip install './python[examples]'
    python examples/waves.py [--models NAME ...] [--densities N ...] [--number N] [--until S] [--plot FILE.png] [--film FILE.mp4]

Nobody wants to go anywhere. Each person is agitated by a small force of its own: x and y are Ornstein-Uhlenbeck processes with a
standard deviation of FORCE and a correlation time of one second. The square has walls. Its cells, CELL wide, have a mean velocity V
of the n people who begin there. What counts was written down before the runs:

    together   order = n <V²>/<v²> is above 4. It is 1 if everybody moves for themselves, and n if all move alike. Of a given
               correlation of two people it is larger in denser crowds; the correlation, (order - 1)/(n - 1), is printed, too.
    to and fro the autocorrelation of V, averaged over cells, falls below -0.3 within a quarter of the time. The period is the lag of
               the greatest maximum after that.
    in circles chirality is above 0.5: the mean over cells of the greatest <V(t) x V(t + lag)>, by the variance of V. It is 1 on a
               circle, about 0.3 by chance.

Models (docs/balance.md): none; pendulum, with the defaults; two-level, with the defaults, of which a single person stands stably;
and two-level, slow legs, of which nobody stands still alone. Measured beside it: thousands at a festival begin to turn together
above 4 per m², with a period of 18 s (Gu, Guiselin, Bain, Zuriguel, Bartolo, Nature 638 (2025) 112).
"""

import argparse
import pathlib
import tempfile

import numpy as np
from lemons_fmu import CommandError, Crowd, Drive, SimulationError
from validation import lemons

FORCE = 30.0  # N
CORRELATION = 1.0  # s
SAMPLED = 0.25  # s, between two values of a force
STEP = 0.02  # s, communication step
FIRST = 15.0  # s, dropped
CELL = 1.8  # m
MODELS = {
    "none": "",
    "pendulum": 'balance = "pendulum"\n',
    "two-level": 'balance = "two-level"\n',
    "two-level, slow legs": 'balance = "two-level"\n[two-level]\nspeed = 1.0\nlegs_speed = 1.2\nlegs_rate = 1.0\nbalanced = 0.12\n',
}


def agitation(number, until, seed):
    """Returns the forces on everybody."""
    random = np.random.default_rng(seed)
    times = np.arange(0, until + SAMPLED, SAMPLED)
    kept = np.exp(-SAMPLED / CORRELATION)
    force = random.normal(size=(len(times), number, 3)) * FORCE
    force[1:] *= np.sqrt(1 - kept**2)
    for before, now in zip(force, force[1:]):
        now += kept * before
    force[:, :, 2] = 0
    return Drive({k: (times, force[:, k]) for k in range(number)}, at="middle")


def cells(run, side):
    """Returns times from 0 [s], V as complex numbers (time, cell), the people of each cell, and <v²> [m²/s²]."""
    first = np.searchsorted(run.times, FIRST - 1e-9)
    velocity = run.velocities[first:, :, 0] + 1j * run.velocities[first:, :, 1]
    count = max(1, int(side / CELL))
    place = np.clip((run.poses[first, :, :2] * (count / side)).astype(int), 0, count - 1) @ [1, count]
    there, sizes = np.unique(place, return_counts=True)
    mean = np.stack([velocity[:, place == cell].mean(axis=1) for cell in there], axis=1)
    return run.times[first:] - run.times[first], mean, sizes, (np.abs(velocity) ** 2).mean()


def correlation(mean):
    """Returns the autocorrelation of each cell, for lags of up to half of the time."""
    length = len(mean)
    spectrum = np.abs(np.fft.fft(mean - mean.mean(axis=0), 2 * length, axis=0)) ** 2
    return np.fft.ifft(spectrum, axis=0)[: length // 2] / np.arange(length, length - length // 2, -1)[:, None]


def measures(run, side):
    """Returns order, least autocorrelation, period [s] or nan, chirality, correlation of two people; lags [s], autocorrelation."""
    times, mean, sizes, square = cells(run, side)
    each = correlation(mean)
    lags, all = times[: len(each)], each.mean(axis=1).real
    all = all / all[0]
    quarter = len(all) // 2
    least = np.argmin(all[:quarter])
    waves = all[least] < -0.3
    period = lags[least + np.argmax(all[least:])] if waves else np.nan
    order = (np.abs(mean) ** 2 * sizes).mean() / square
    chirality = np.abs(each.imag / each[0].real).max(axis=0).mean()
    return (order, all[least], period, chirality, (order - 1) / max(1e-9, sizes.mean() - 1)), lags, all


def simulate(model, density, arguments, place):
    """Returns a run and the side of the square [m]."""
    side = round(np.sqrt(arguments.number / density), 3)
    trial = place / "trial"
    options = ["--material", arguments.material] if arguments.material else []
    lemons("crowd", "--number", arguments.number, "--box", f"{side}x{side}", "--seed", arguments.seed, "-o", trial, "--force", *options)
    decision = False
    if MODELS[model]:
        decision = place / "legs.toml"
        decision.write_text(MODELS[model])
    with Crowd(trial, decision=decision) as crowd:
        run = crowd.run(agitation(arguments.number, arguments.until, arguments.seed), until=arguments.until, step=STEP)
    return run, side


def plot(path, results):
    """Draws autocorrelations of each model, and order, period and chirality against the density."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    models = list(dict.fromkeys(model for model, *_ in results))
    figure = plt.figure(figsize=(11, 7), layout="constrained")
    upper, lower = figure.subfigures(2, 1)
    densities = sorted({density for _, density, *_ in results})
    shade = dict(zip(densities, plt.get_cmap("viridis")(np.linspace(0.9, 0, len(densities)))))
    for panel, model in zip(np.atleast_1d(upper.subplots(1, len(models), sharey=True)), models):
        for _, density, _, lags, all in (one for one in results if one[0] == model):
            panel.plot(lags, all, color=shade[density], label=f"{density:g} per m²")
        panel.axhline(-0.3, color="0.5", linestyle=":", linewidth=1)
        panel.set(title=model, xlabel="lag / s", xlim=(0, 20))
    upper.axes[0].set_ylabel("autocorrelation of V")
    upper.axes[0].legend(frameon=False, fontsize="small")
    names = ["order n<V²>/<v²>", None, "period / s", "chirality"]
    for panel, k in zip(lower.subplots(1, 3), (0, 2, 3)):
        for model in models:
            own = [(density, numbers[k]) for name, density, numbers, *_ in results if name == model]
            panel.plot(*zip(*own), "o-", label=model)
        panel.set(xlabel="people per m²", ylabel=names[k], ylim=(0, None))
        if k != 2:
            panel.axhline({0: 4, 3: 0.5}[k], color="0.5", linestyle=":", linewidth=1)
    lower.axes[0].legend(frameon=False, fontsize="small")
    for panel in [*upper.axes, *lower.axes]:
        panel.spines[["top", "right"]].set_visible(False)
        panel.grid(alpha=0.25)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", nargs="+", choices=MODELS, default=list(MODELS), metavar="NAME", help="default all")
    parser.add_argument("--densities", nargs="+", type=float, default=[2, 3, 4, 5, 6, 7, 8], metavar="N", help="people per m²; default 2 to 8")
    parser.add_argument("--number", type=int, default=1000, metavar="N", help="number of people; default 1000")
    parser.add_argument("--until", type=float, default=75.0, metavar="S", help="length of the runs; default 75")
    parser.add_argument("--material", metavar="NAME", help="of the people, as of lemons crowd")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the crowd and of the forces; default 1")
    parser.add_argument("--plot", default="waves.png", metavar="FILE.png", help="default waves.png")
    parser.add_argument("--film", metavar="FILE.mp4", help="film of the last run, ten times as fast")
    arguments = parser.parse_args()
    if arguments.number < 10 or arguments.until < 2 * FIRST or min(arguments.densities) <= 0:
        parser.error(f"--number must be at least 10, --until {2 * FIRST:g}, and densities above 0")
    results = []
    print(f"{'model':22} {'per m²':>6} {'order':>6} {'alike':>6} {'least':>6} {'period':>7} {'chirality':>9}   together, to and fro, in circles")
    with tempfile.TemporaryDirectory() as place:
        place = pathlib.Path(place)
        try:
            for model in arguments.models:
                for density in arguments.densities:
                    run, side = simulate(model, density, arguments, place)
                    numbers, lags, all = measures(run, side)
                    order, least, period, chirality, alike = numbers
                    found = ", ".join("yes" if is_so else "no" for is_so in (order > 4, least < -0.3, chirality > 0.5))
                    print(f"{model:22} {density:6.2f} {order:6.1f} {alike:6.2f} {least:6.2f} {period:7.1f} {chirality:9.2f}   {found}", flush=True)
                    results.append((model, density, numbers, lags, all))
            plot(arguments.plot, results)
            if arguments.film:
                table = run.frame()
                kept = np.isin(table.t, run.times[::10])
                table[kept].to_csv(place / "run.csv", index=False)
                lemons("movie", place / "run.csv", "--trial", place / "trial", "--fill", "lean", "--speed-up", 10, "-o", arguments.film)
        except (CommandError, SimulationError, ValueError, OSError) as error:
            raise SystemExit(str(error))


if __name__ == "__main__":
    main()
