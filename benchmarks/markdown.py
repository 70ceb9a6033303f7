"""The report as a page of Markdown."""

from .contests import AIMS

INTRODUCTION = """# Speed against error

Measured on: {machine}.

With: {versions}.

Written by `python -m benchmarks`; all raw figures stand in [speed_against_error.json](speed_against_error.json). All
contestants run in one process on one core and take turns; the least CPU time of up to seven rounds counts.

**CPU time** is that of the integration alone, from t = 0 over all reference times: reading, compiling and
setting up are not in it. No contestant goes through Python for each step; ours and MuJoCo's, Pinocchio's and
Exudyn's loops are compiled.

**Error** is that of the state: the largest absolute difference of any compared quantity (positions,
velocities, angles, angular velocities) at any reference time from its reference digits, divided by the
largest value of that quantity; differences of angles and Euler parameters are taken as they are. Energy is
not looked at.

Adaptive contestants get five tolerances, 1e-4 to 1e-12 (absolute and relative alike; 1e-6 to 1e-14 for the
body about its middle axis, whose motion makes errors grow), those of fixed step five steps, each a quarter of
the one before. Times at a given error are read off by straight lines in the doubly logarithmic plot, along
the settings that no other beats in both time and error; nothing is extrapolated.
"""


def markdown(report, pictures: list[str]) -> str:
    """The page. pictures : names of those that stand beside it."""
    head = INTRODUCTION.format(
        machine=", ".join(report.machine.values()),
        versions=", ".join(f"{name} {text}" for name, text in report.versions.items()),
    )
    parts = [head]
    parts += [_at(report, aim) for aim in AIMS]
    parts += [_errors(report, pictures), _failures(report)]
    parts += [_evaluation(report, pictures), _fmu(report)] if report.evaluation else []
    parts += [_contestants(report), _problems(report)]
    return "\n\n".join(part.strip() for part in parts if part) + "\n"


def table(headings, rows) -> str:
    """A table; the first column is text, the others are numbers."""
    lines = [headings, ["---"] + ["---:"] * (len(headings) - 1), *rows]
    return "\n".join(f"| {' | '.join(str(cell) for cell in line)} |" for line in lines)


def power(number: float) -> str:
    """1e-8 for 1e-08."""
    return f"{number:.0e}".replace("e-0", "e-")


def figures(number: float, digits: int = 3) -> str:
    """A number with so many significant digits, never as a power."""
    text = f"{number:.{digits}g}"
    return f"{float(text):.0f}" if "e" in text else text


def milliseconds(problem: dict, name: str, seconds: float | None) -> str:
    """A contestant's time; what there is instead when it has none."""
    if seconds:
        return figures(1e3 * seconds)

    return "-" if any(point["cpu_s"] for point in problem["results"][name]) else "x"


def _at(report, aim):
    peers = [name for name, contestant in report.contestants.items() if contestant["kind"] != "ours"]
    rows = []

    for problem in report.problems:
        standing = report.standing(aim, problem["name"])
        ours = standing["ours"]
        ratios = [(standing[group], standing[f"{group}_ratio"]) for group in ("package", "peer", "limit")]
        cells = [milliseconds(problem, name, standing["all"].get(name)) for name in peers]
        rows.append(
            [
                problem["title"],
                f"{figures(1e3 * ours[1])} ({ours[0]})" if ours else "-",
                *cells,
                *(f"{figures(ratio, 2)} ({peer[0]})" if ratio else "-" for peer, ratio in ratios),
            ]
        )

    headings = ["problem", "ours, ms", *(f"{name}, ms" for name in peers)]
    headings += ["best package to ours", "best of all to ours", "limit to ours"]
    ratios = [report.standing(aim, problem["name"])["package_ratio"] for problem in report.problems]
    ratios = [ratio for ratio in ratios if ratio]
    lines = [f"## CPU time for an error of {power(aim)}", "", table(headings, rows), ""]
    lines += [
        "A dash: no setting that was run is so exact. An x: cannot be run, for the reason given below. "
        "Packages are peers that integrate by themselves; around Pinocchio the loop is ours, in C++, and the "
        "steppers are our 8(5,3) pair and Boost's. The limit is what a program for that one mechanism takes, "
        "with equations derived by hand.",
        "",
    ]

    if ratios and aim == AIMS[0]:
        reached = sum(ratio >= 5 for ratio in ratios)
        lines.append(
            f"The goal, five times less CPU time than the best package, is met on {reached} of the "
            f"{len(ratios)} problems in which one reaches this error."
        )

    return "\n".join(lines)


def _errors(report, pictures):
    lines = ["## Error against CPU time", ""]

    if "speed_against_error.png" in pictures:
        lines += [
            "![Error of the state against CPU time](speed_against_error.png)",
            "",
            "Lines: the settings that no other setting of the same contestant beats; dots: the others. "
            "Peers are dashed.",
            "",
        ]

    for problem in report.problems:
        rows = []

        for name, points in problem["results"].items():
            cells = [f"{figures(1e3 * p['cpu_s'])} ms: {p['error']:.1e}" for p in points if p["cpu_s"]]
            rows += [f"- {name}: {'; '.join(cells)}"] if cells else []

        lines += [
            f"<details><summary>{problem['title']}, all settings, from loose to tight</summary>",
            "",
            *rows,
            "",
        ]
        lines += ["</details>", ""]

    return "\n".join(lines)


def _failures(report):
    """What has no figure, with its reason; the same reason is told once."""
    found = {}

    for problem in report.problems:
        for name, points in problem["results"].items():
            for point in points:
                if point["reason"]:
                    found.setdefault((name, problem["title"], point["reason"]), []).append(point["setting"])

    wholly = {}
    rows = []

    for (name, title, reason), settings in found.items():
        points = next(p["results"][name] for p in report.problems if p["title"] == title)

        if not any(point["cpu_s"] for point in points) and len(settings) == len(points):
            wholly.setdefault((name, reason), []).append(title)
        else:
            rows.append(f"- {name}, {title}, {', '.join(settings)}: {reason}")

    lines = [f"- {name}: {'; '.join(titles)}: {reason}" for (name, reason), titles in wholly.items()]
    lines += rows
    lines += [f"- {name}, left out: {why}" for name, why in report.missing.items()]
    return "\n".join(["## What could not be run", "", *(lines or ["Nothing."])])


def _evaluation(report, pictures):
    costs = report.evaluation
    names = list(costs.contestants)
    lines = ["## Cost of an evaluation against the number of bodies", ""]
    lines += ["µs of CPU for the accelerations at one state; a compiled loop, the least of several rounds."]
    lines += ["", "A dash: more bodies than it can take (Pinocchio needs memory in their third power).", ""]

    if "evaluation_cost.png" in pictures:
        lines += ["![Cost of an evaluation](evaluation_cost.png)", ""]

    for mechanism, exponents in costs.exponents.items():
        rows = [
            [row["bodies"], *(_micro(row["seconds"].get(name)) for name in names)]
            for row in costs.rows
            if row["mechanism"] == mechanism
        ]
        rows.append(["growth from 8 bodies on", *(f"n^{exponents[name]:.2f}" for name in names)])
        lines += [table([f"{mechanism}, bodies", *names], rows), ""]

    lines += [f"- {name}: {how}" for name, how in costs.contestants.items()]
    lines.append(
        f"\nLargest relative difference of the accelerations from ours: {costs.largest_difference:.1e}."
    )
    return "\n".join(lines)


def _micro(seconds):
    return figures(1e6 * seconds) if seconds else "-"


def _fmu(report):
    rows = [
        [
            name,
            *(f"{1e6 * row[key]:.2f}" for key in ("in_process", "fmu", "added", "fmpy")),
            f"{row['size'] / 1024:.0f}",
        ]
        for name, row in report.fmu.items()
    ]
    headings = ["scene", "in process, µs", "`fmi2DoStep`, µs", "added, µs", "through fmpy, µs", "FMU, KB"]
    export = report.export
    lines = [
        "## What an FMU adds",
        "",
        "CPU time of a communication step of 1 ms by the default stepper at a tolerance of 1e-6, in compiled "
        "loops. The goal: the wrapper adds 1 µs at most. `driven` is a scene without anything to integrate.",
        "",
        table(headings, rows),
        "",
        f"An export with the kernels compiled takes {export['in_process']['wall_s']:.2g} s from Python.",
    ]

    for name, text in (
        ("warm", "By the command, Python's start in it,"),
        ("cold", "The first, with an empty cache,"),
    ):
        if name in export:
            lines.append(f"{text} {export[name]['wall_s']:.3g} s ({export[name]['cpu_s']:.3g} s of CPU).")

    return "\n".join(lines)


def _contestants(report):
    lines = [f"- **{name}**: {contestant['how']}." for name, contestant in report.contestants.items()]
    return "\n".join(["## Contestants and their settings", "", *lines])


def _problems(report):
    rows = [
        f"- **{problem['title']}** (`{problem['name']}`): {'; '.join(problem['source'])}. Reference: "
        f"{problem['how_obtained']}."
        for problem in report.problems
    ]
    return "\n".join(["## Problems and their reference digits", "", *rows])
