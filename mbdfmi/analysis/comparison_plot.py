"""The picture of a comparison of steppers, by matplotlib."""

from typing import Any

from matplotlib.figure import Figure

COLOURS = {
    "auto": "black",
    "rk54": "tab:blue",
    "rk853": "tab:cyan",
    "radau": "tab:red",
    "rk4": "tab:green",
    "ros2": "tab:orange",
    "gauss": "tab:purple",
}

SMALL: dict[str, Any] = {"fontsize": "x-small", "color": "0.3"}


def figure_of(comparison) -> Figure:
    """Error against CPU time of all runs, a line for each stepper from loose to tight; those that no other
    beats are ringed.
    """
    figure = Figure(figsize=(9, 5.5), layout="constrained")
    ax = figure.subplots()
    ax.set_xscale("log")
    ax.set_yscale("log")
    floor = max(comparison.doubt, 1e-15)
    _draw_runs(ax, comparison, floor)
    _draw_reference(ax, floor)
    ax.set_xlabel("CPU time [ms]")
    ax.set_ylabel("largest error of the outputs, by their sizes")
    what = f"{comparison.until:g} s, communication step {comparison.step:g} s"
    ax.set_title(f"{comparison.title}\n{what}", loc="left", fontsize="medium")
    ax.grid(which="major", alpha=0.4)
    figure.legend(
        loc="outside right upper",
        title="solid: adaptive\ndashed: fixed step",
        fontsize="small",
        title_fontsize="small",
    )
    return figure


def _draw_runs(ax, comparison, floor):
    """Lines of the steppers, rings around what no other beats, a star for the scene's own solver."""
    lines = {}

    for run in comparison.done:
        lines.setdefault(run.setting.integrator, []).append(run)

    for name in COLOURS:
        runs = sorted(lines.get(name, ()), key=lambda run: -run.setting.value)

        if runs:
            style = "s--" if runs[0].setting.key == "step" else "o-"
            x, y = [1e3 * run.cpu for run in runs], [max(run.error, floor) for run in runs]
            ax.plot(x, y, style, color=COLOURS[name], markersize=4, linewidth=1.2, label=name)

    for run in comparison.front:
        place = (1e3 * run.cpu, max(run.error, floor))
        ax.plot(*place, "o", markersize=10, markerfacecolor="none", markeredgecolor="0.4")
        ax.annotate(run.setting.short, place, (6, 5), textcoords="offset points", **SMALL)

    if not comparison.own.reason:
        place = (1e3 * comparison.own.cpu, max(comparison.own.error, floor))
        ax.plot(*place, "*", markersize=13, color="gold", markeredgecolor="black", label="the scene's own")


def _draw_reference(ax, floor):
    """What the reference run does not tell apart."""
    ax.set_ylim(bottom=floor / 5.0)
    ax.axhspan(floor / 5.0, floor, color="0.9", zorder=0)
    ax.text(
        0.99,
        floor,
        "as exact as the reference",
        transform=ax.get_yaxis_transform(),
        ha="right",
        va="top",
        **SMALL,
    )
