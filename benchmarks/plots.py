"""The pictures of the report, by matplotlib where it is installed."""

import numpy as np

from .contests import front_of

PANEL = (4.2, 3.3)  # inches
COLUMNS = 3

# ours in blues and greens, a filled mark; peers in warm colours, dashed, an open mark
OUR_STYLES = (
    ("#08519c", "o"), ("#4292c6", "s"), ("#006d5b", "D"), ("#5e3c99", "^"),
    ("#41ab5d", "v"), ("#00c2c7", "P"), ("#252525", "X"), ("#8c96c6", "*"),
)  # fmt: skip
PEER_STYLES = (("#d7301f", "o"), ("#fd8d3c", "s"), ("#8c510a", "D"), ("#dd1c77", "^"), ("#7f7f7f", "*"))


def error_figure(report):
    """Error of the state against CPU time, a panel for each problem: the front of each contestant's settings
    as a line, its other settings as dots.
    """
    from matplotlib.figure import Figure

    n_rows = -(-len(report.problems) // COLUMNS)
    n_columns = min(COLUMNS, len(report.problems))
    figure = Figure(figsize=(PANEL[0] * n_columns, PANEL[1] * n_rows + 0.9), layout="constrained")
    axes = figure.subplots(n_rows, n_columns, squeeze=False)
    styles = _styles(report)
    drawn = {}

    for ax, problem in zip(axes.flat, report.problems):
        for name, points in problem["results"].items():
            shown = [point for point in points if point["cpu_s"]]

            if not shown:
                continue

            color, mark = styles[name]
            ours = report.contestants[name]["kind"] == "ours"
            front = np.array([(p["cpu_s"], p["error"]) for p in front_of(shown)]).T
            every = np.array([(p["cpu_s"], p["error"]) for p in shown]).T
            front[1], every[1] = np.maximum(front[1], 1e-16), np.maximum(every[1], 1e-16)
            ax.plot(1e3 * every[0], every[1], ".", color=color, markersize=3, alpha=0.4)
            (line,) = ax.plot(
                1e3 * front[0], front[1], color=color, marker=mark, markersize=4.5,
                linestyle="-" if ours else "--", markerfacecolor=color if ours else "white", label=name,
            )  # fmt: skip
            drawn.setdefault(name, line)

        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_title(problem["title"], fontsize=9)
        ax.axhline(1e-8, color="grey", linewidth=0.8, linestyle=":")
        ax.set_ylim(1e-15, 10)
        ax.grid(alpha=0.25)
        ax.tick_params(labelsize=8)

    for ax in list(axes.flat)[len(report.problems) :]:
        ax.set_axis_off()

    for ax in axes[:, 0]:
        ax.set_ylabel("error of the state", fontsize=8)

    for ax in axes[-1]:
        ax.set_xlabel("CPU time, ms", fontsize=8)

    order = [name for name in report.contestants if name in drawn]
    figure.legend(
        [drawn[name] for name in order], order, loc="outside lower center", ncols=min(6, len(order))
    )
    return figure


def _styles(report):
    ours = [name for name, contestant in report.contestants.items() if contestant["kind"] == "ours"]
    peers = [name for name in report.contestants if name not in ours]
    styles = {name: OUR_STYLES[k % len(OUR_STYLES)] for k, name in enumerate(ours)}
    return styles | {name: PEER_STYLES[k % len(PEER_STYLES)] for k, name in enumerate(peers)}


def evaluation_figure(report):
    """Time of an evaluation of the accelerations against the number of bodies, a panel for each mechanism."""
    from matplotlib.figure import Figure

    mechanisms = {row["mechanism"]: None for row in report.rows}
    figure = Figure(figsize=(5.5 * len(mechanisms), 4.5), layout="constrained")
    axes = figure.subplots(1, len(mechanisms), sharey=True, squeeze=False)[0]

    for ax, mechanism in zip(axes, mechanisms):
        rows = [row for row in report.rows if row["mechanism"] == mechanism]
        bodies = [row["bodies"] for row in rows]

        for name in report.contestants:
            measured = [(row["bodies"], 1e6 * row["seconds"][name]) for row in rows if name in row["seconds"]]
            ax.loglog(*zip(*measured), "o-", label=name, markersize=4)

        ax.set(title=f"{mechanism} of revolute joints", xlabel="bodies")
        ax.set_xticks(bodies, bodies, minor=False)
        ax.minorticks_off()
        ax.grid(alpha=0.3)

    axes[0].set_ylabel("µs for the accelerations")
    axes[0].legend()
    return figure
