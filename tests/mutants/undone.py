"""Mendings of silent faults, each undone by one replacement in the package:
the referee has to notice every one.

The numbers are those of the rules that hold since (docs/scene.md tells them): 1 what is read off between
inner steps, 2 turns of angles, 3 starts, 4 loops that do not quite close, 5 what lies between two given
numbers, 6 commanded motion, 7 no endless call, no silent NaN, 8 the same twice, 9 nothing refused without
need, 10 what acts can be seen, 11 added mass of linear theory, 12 files, 13 what is told.
"""

from dataclasses import dataclass

from .operators import Mutant
from .reach import PACKAGE


@dataclass(frozen=True)
class Undone:
    """A mending undone: in `file` (of mbdfmi/) `before`, which is there once, becomes `after`. tests :
    some that notice it."""

    rule: int
    name: str
    file: str
    before: str
    after: str
    tests: str

    def mutant(self) -> Mutant:
        """The package with the mending undone."""
        source = (PACKAGE / self.file).read_text(encoding="utf-8")
        start = source.index(self.before)
        first = source.count("\n", 0, start) + 1
        last = first + self.before.rstrip("\n").count("\n")
        end = start + len(self.before)
        return Mutant(self.file, self.name, "undone", first, start, end, self.after, (first, last), source)


UNDONE = [
    # 1
    Undone(
        1, "nobody looks at the error of what is read off between inner steps", "kernels/steppers/pairs.py",
        "extension, unseen = extension_error(m, d, pair, step, fine)", "extension, unseen = 0.0, False",
        "tests/test_between_steps.py",
    ),
    Undone(
        1, "a kink or a stiff mode that the step's own estimate does not see may spoil what is read off",
        "kernels/steppers/pairs.py",
        "UNSEEN_ALLOWED = 3.0", "UNSEEN_ALLOWED = 1e9", "tests/test_between_steps.py",
    ),
    Undone(
        1, "estimated_error leaves out what is read off", "kernels/steppers/pairs.py",
        "estimate = max(told, extension)", "estimate = told", "tests/test_between_steps.py",
    ),
    # 2
    Undone(
        2, "the turn of an angle outside the tree is that nearest to the last step", "kernels/motion/coordinates.py",
        "d.z_rate[turn(m, t)] = rate(m, d, m.turn_coordinate[t])", "d.z_rate[turn(m, t)] = 0.0",
        "tests/test_turns.py",
    ),
    Undone(
        2, "the turn of a longitude on a sphere, likewise", "kernels/end_frames/on_surfaces.py",
        "d.z_rate[s] = rate[0]", "d.z_rate[s] = rate[0] if at < 0 else 0.0", "tests/test_turns.py",
    ),
    Undone(
        2, "starts beyond a turn, of joints outside the tree", "kernels/dynamics/assembly.py",
        "    rows.start_turns(m, d)\n", "", "tests/test_turns.py",
    ),
    Undone(
        2, "starts beyond a turn, in absolute coordinates", "compiler/absolute.py",
        "float(d.q[m.body_q[i]])", "float(np.arctan2(np.sin(d.q[m.body_q[i]]), np.cos(d.q[m.body_q[i]])))",
        "tests/test_turns.py",
    ),
    # 3
    Undone(
        3, "given positions give way like any others", "kernels/dynamics/start_positions.py",
        "    holding.keep_given(m, d, POSITION)\n", "", "tests/test_starts.py",
    ),
    Undone(
        3, "given speeds give way like any others", "kernels/dynamics/start_velocities.py",
        "    holding.keep_given(m, d, VELOCITY)\n", "", "tests/test_starts.py",
    ),
    Undone(
        3, "a coupling without an offset restricts the start", "kernels/dynamics/assembly.py",
        "d.row_settles[row] = float(m.row_at_start[row])", "d.row_settles[row] = 0.0", "tests/test_starts.py",
    ),
    Undone(
        3, "what follows through couplings is found only nearby", "kernels/dynamics/assembly.py",
        "    spread_couplings(m, d)\n", "", "tests/test_starts.py",
    ),
    Undone(
        3, "the first assembly found is taken, however far", "kernels/dynamics/start_positions.py",
        "    if way < FAR:", "    if result == OK:", "tests/test_starts.py",
    ),
    Undone(
        3, "start values that moved are not told", "kernels/notes.py", "        tell_start(m, d, k)\n",
        "        pass\n", "tests/test_starts.py",
    ),
    Undone(
        3, "a start beyond a stop is not told", "kernels/notes.py", "        tell_stop(m, d, k)\n",
        "        pass\n", "tests/test_starts.py",
    ),
    Undone(
        3, "a body that its joints lock is not told", "kernels/notes.py",
        "            tell(d, status(BODY_STUCK, i), 0.0, 0.0)\n", "            pass\n",
        "tests/test_starts.py",
    ),
    Undone(
        3, "a disk rolls on the upper side of its plane alone", "kernels/dynamics/assembly.py",
        "d.row_side[row] = -1.0 if height < 0.0 else 1.0", "d.row_side[row] = 1.0", "tests/test_starts.py",
    ),
    # 4
    Undone(
        4, "a loop that repeats itself not quite exactly is refused", "kernels/dynamics/start_positions.py",
        "loose = failure == OK and gap <= GAP_TAKEN", "loose = False", "tests/test_loops_not_exact.py",
    ),
    Undone(
        4, "a gap that is left is not told", "kernels/notes.py",
        "                tell(d, status(GAP_TAKEN, m.n_body + c), al.norm(span), turned)\n",
        "                pass\n",
        "tests/test_loops_not_exact.py",
    ),
    Undone(
        4, "a loop that cannot be closed does not say how far it is open", "kernels/notes.py",
        "    tell(d, status(LOOP_SIZE, m.n_body + c), size, turned)\n", "", "tests/test_loops_not_exact.py",
    ),
    Undone(
        4, "a singular start is not told apart", "kernels/notes.py", "if size <= SINGULAR and turned <= SINGULAR:",
        "if False:", "tests/test_loops_not_exact.py",
    ),
    Undone(
        4, "the closing tolerance is no setting", "kernels/dynamics/projection.py",
        "        failure = project_positions(m, d, m.closing_tolerance[0])",
        "        failure = project_positions(m, d, 1e-9)", "tests/test_loops_not_exact.py",
    ),
    # 5
    Undone(
        5, "tables of forces are read by splines", "scene/tables.py",
        "    position: Ascending\n    effort: Numbers\n    interpolation: ForceReading = \"linear\"",
        "    position: Ascending\n    effort: Numbers\n    interpolation: ForceReading = \"cubic\"",
        "tests/test_tables.py tests/test_forces.py",
    ),
    Undone(
        5, "equal neighbours in a table of motion do not stand still", "compiler/interpolation.py",
        "    equal = np.abs(np.diff(y)) <= 4 * np.finfo(float).eps * np.abs(y[1:])\n",
        "    equal = np.zeros(len(y) - 1, bool)\n", "tests/test_tables.py",
    ),
    Undone(
        5, "motions swing out beside jumps", "compiler/interpolation.py",
        "leaves[some] = (above", "leaves[some] = False & (above", "tests/test_tables.py",
    ),
    Undone(
        5, "functions of time are held over the communication step", "run/inputs.py",
        "        b = self.times[k + 1]\n", "        return [(length, self._constant(a))]\n",
        "tests/test_inputs.py",
    ),
    # 6
    Undone(
        6, "input derivatives of a commanded position count beside the speed told", "kernels/motion/commands.py",
        "        d.command_course[k + 1] = v\n",
        "        d.command_course[k + 1] = v + "
        "(d.u_buffer[n + m.command_u[3 * c]] if m.command_u[3 * c] >= 0 else 0.0)\n",
        "tests/test_commands.py",
    ),
    Undone(
        6, "commanded motion is of order 1 in the communication step", "kernels/motion/commands.py",
        "            if told_on:\n                slope, c2, c3 = extrapolation.by_slope(m, d, c, x, slope, H, found, rounding)\n"
        "            else:\n                slope, c2, c3 = extrapolation.by_history(d, c, found)\n",
        "            pass\n",
        "tests/test_commands.py",
    ),
    Undone(
        6, "bodies jump with what the last step was off", "kernels/motion/commands.py",
        "                settle(\n                    m,\n                    d,\n                    i,\n                    position,\n"
        "                    d.command_reached[2 * i + 1] - d.command_course[courses.N_COURSE * i + 1],\n"
        "                    T,\n                )\n",
        "                pass\n", "tests/test_commands.py",
    ),
    Undone(
        6, "the ground jumps with what its last turn was off", "kernels/motion/commands.py",
        "                settle(\n                    m, d, c + 3 + i, phi[i], "
        "rate[i] - d.command_course[courses.N_COURSE * (c + 3 + i) + 1], T\n                )\n",
        "                pass\n", "tests/test_commands.py",
    ),
    Undone(
        6, "commands that contradict each other are not told", "kernels/motion/commands.py",
        "        doubt(m, d, k)\n", "", "tests/test_commands.py",
    ),
    # 7
    Undone(
        7, "the work of a communication step has no bound", "kernels/steppers/control.py",
        "return not d.evaluations[0] < d.evaluation_limit[0]", "return False", "tests/test_bounded_work.py",
    ),
    Undone(
        7, "outputs that are not finite are handed out", "kernels/entry.py",
        "if failure == OK and not math.isfinite(y[k]):", "if False:",
        "tests/test_extremes.py tests/test_told.py",
    ),
    Undone(
        7, "a step backwards is taken", "kernels/entry.py", "if not H >= 0.0:", "if False:",
        "tests/test_bounded_work.py",
    ),
    Undone(
        7, "masses whose sums overflow are taken", "kernels/prepare.py",
        "        if not has_finite_inertia(d, i):", "        if False:",
        "tests/test_extremes.py",
    ),
    Undone(
        7, "a gap that is no number is none", "kernels/math/algebra.py",
        "        if a > size or a != a:", "        if a > size:",
        "tests/test_extremes.py tests/test_told.py",
    ),
    # 8
    Undone(
        8, "setting a parameter to the value it has restarts the solver", "run/instance.py",
        "if self._prepared != self.reals.tobytes():", "if True:",
        "tests/test_told.py tests/test_same_bytes.py",
    ),
    # 9
    Undone(
        9, "an inertia that no body has is refused", "scene/bodies.py",
        "    if moments[0] < -1e-9 * largest:",
        "    if moments[0] < -1e-9 * largest or moments[0] + moments[1] < 0.99 * moments[2]:",
        "tests/test_massless.py tests/test_scene.py tests/test_notices.py",
    ),
    Undone(
        9, "parts without mass that constraints determine are refused", "kernels/dynamics/assembly.py",
        "    forward.lend_inertia(m, d)\n", "", "tests/test_massless.py",
    ),
    Undone(
        9, "the inertia that massless parts are lent stays", "kernels/dynamics/forward.py",
        "return massless.give_back(m, d) if d.lends[0] > 0.0 else OK", "return OK", "tests/test_massless.py",
    ),
    # 10
    Undone(
        10, "the power of a joint leaves out its friction", "kernels/forces/friction.py",
        "            effort -= resistance(m, k, coordinates.rate(m, d, c))\n", "            pass\n",
        "tests/test_powers.py",
    ),
    Undone(
        10, "the ground does not feel the water that moves along with bodies", "kernels/dynamics/inverse.py",
        "    added_mass.add_reactions(m, d)\n", "", "tests/test_powers.py",
    ),
    Undone(
        10, "what is not symmetric in a stiffness is lost to the sum of powers", "kernels/forces/six_by_six.py",
        "+ 0.5 * lost", "", "tests/test_powers.py",
    ),
    Undone(
        10, "an actuated strut's tension leaves out its actuator", "kernels/forces/struts.py",
        "return spring, damper, d.input[m.strut_u[k]] if m.strut_u[k] >= 0 else 0.0",
        "return spring, damper, 0.0",
        "tests/test_powers.py",
    ),
    # 11
    Undone(
        11, "added mass turns with the body unless told otherwise", "scene/forces.py",
        'axes: OneOf("first", "heading", "body") = "first"',
        'axes: OneOf("first", "heading", "body") = "body"',
        "tests/test_added_mass.py",
    ),
    Undone(
        11, "added mass that keeps its axes feels products of velocities", "kernels/forces/added_mass.py",
        "    if m.six_by_six_axes[k] == BODY:\n        # the momenta",
        "    if m.six_by_six_axes[k] != HEADING:\n        # the momenta",
        "tests/test_added_mass.py",
    ),
    Undone(
        11, "added mass that follows the heading has no gyroscopic terms", "kernels/forces/added_mass.py",
        "    if m.six_by_six_axes[k] == HEADING:\n        L, momentum", "    if False:\n        L, momentum",
        "tests/test_added_mass.py",
    ),
    Undone(
        11, "water moves with the inertial frame, not with the ground", "kernels/forces/added_mass.py",
        "return m.six_by_six_adds[k] == 1 and m.marker_body[m.six_by_six_from[k]] > 0", "return False",
        "tests/test_added_mass.py",
    ),
    # 12
    Undone(
        12, "a file that is read is written over", "cli/paths.py", "        if same(path, given):",
        "        if False:", "tests/test_files.py",
    ),
    Undone(
        12, "a link is replaced instead of what it points to", "files.py",
        "target = path if written else Path(os.path.realpath(path))", "target = path", "tests/test_files.py",
    ),
    Undone(
        12, "pipes and devices are replaced by files", "files.py",
        "return not (stat.S_ISREG(kind) or stat.S_ISDIR(kind))", "return False", "tests/test_files.py",
    ),
    Undone(
        12, "a table is written into a file that promises another format", "files.py",
        "    if ending in FORMATS - set(endings):", "    if False:", "tests/test_files.py",
    ),
    # 13
    Undone(
        13, "any tolerance is taken, in a scene", "scene/fields.py",
        "    if not LEAST_TOLERANCE <= number(value) <= LARGEST_TOLERANCE:", "    if number(value) <= 0.0:",
        "tests/test_bounded_work.py tests/test_told.py",
    ),
    Undone(
        13, "any tolerance is taken, as a parameter", "kernels/prepare.py",
        "    if not LEAST_TOLERANCE <= m.tolerance[0] <= LARGEST_TOLERANCE:",
        "    if not m.tolerance[0] > 0.0:",
        "tests/test_bounded_work.py tests/test_told.py",
    ),
    Undone(
        13, "degrees written as radians are not noticed", "scene/notices.py",
        "RULES = (\n    far_angles,\n", "RULES = (\n", "tests/test_told.py",
    ),
    Undone(
        13, "a body in mm among others in m is not noticed", "scene/notices.py",
        "    far_sizes,\n    coarse_tolerance,\n", "    coarse_tolerance,\n",
        "tests/test_told.py",
    ),
    Undone(
        13, "a coarse absolute tolerance is not noticed", "scene/notices.py",
        "    far_sizes,\n    coarse_tolerance,\n", "    far_sizes,\n", "tests/test_told.py",
    ),
    Undone(
        13, "what sticks by friction creeps", "scene/efforts.py", "smoothing_speed: Positive = 3.7e-7",
        "smoothing_speed: Positive = 1e-3", "tests/test_forces.py",
    ),
    Undone(
        13, "names beyond ASCII are unknown in Python", "run/instance.py",
        "known(variable_name(name), by_name, \"parameter\")", "known(name, by_name, \"parameter\")",
        "tests/test_told.py",
    ),
    Undone(
        13, "a file of another kind is read as TOML", "scene/reader.py",
        "    if other := _other_kind(data):", "    if other := None:",
        "tests/test_told.py",
    ),
    Undone(
        13, "a stop is told in rad that was given in degrees", "compiler/joints.py",
        'stop_unit=ENDINGS["_deg"] if in_degrees else 1.0', "stop_unit=1.0",
        "tests/test_told.py tests/test_starts.py",
    ),
    Undone(
        13, "light parts cost constraints their digits", "kernels/dynamics/forward.py",
        "        if d.lightness[0] < multipliers.UNEVEN:", "        if False:", "tests/test_light_parts.py",
    ),
]  # fmt: skip
"""Every kind of mending at least once."""
