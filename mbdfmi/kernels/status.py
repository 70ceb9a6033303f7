"""Status of a kernel: 0, or a code and the place (a body or joint) where it happened.

A status is code + 256 * place; `place` indexes `Model.places`, which the outputs follow.

What is no failure but must be told (a start that was moved, the motion became stiff) is a *notice*: a kernel calls
`tell(d, status(CODE, place), a, b)` and gives the code a text in MESSAGES, in which `%s` stands for the name of the place and
each `%g` for the next of the numbers a, b. Whoever calls the kernels tells and clears them after `initialise` and after every
step: `Instance.notices` and `Results.notices` in process, a warning (at the start) or an event (later) in the log of an FMU.
`prepare` clears those that nobody asked for. Told before a failure, they belong to its message. What is known without a
kernel is told by `scene/notices.py` (of what is written) or `Builder.notice` (of what the compiler did with it).
"""

from .language import inlined

MOST_NOTICES = 16  # that are kept for the next to ask; more are only counted

OK = 0
NOT_FINITE = 1
STEP_TOO_SMALL = 2
SINGULAR_INERTIA = 3
BAD_MASS = 4
BAD_START_ORIENTATION = 5
BAD_SOLVER_SETTING = 6
BAD_INERTIA = 7
LOOP_OPEN = 8
NO_STAGES = 9

# no failures: told in the log
STIFF = 10
NOT_STIFF = 11

# settings of the solver, and its work
BAD_TOLERANCE = 40
BAD_ABSOLUTE_TOLERANCE = 41
BAD_MAX_EVALUATIONS = 42
TOO_MUCH_WORK = 43
BAD_STEP = 44
BAD_ROTOR = 45
TOUCHES_ALONG = 46
BAD_EFFORT = 47
BAD_SEA = 50
BEYOND_END = 51
UNDER_BED = 52
COUPLING_OPEN = 48
COUPLING_OFF = 49
SINGULAR_START = 30
LOOP_SIZE = 31
LOOP_ALONG = 32
LOOP_ALONG_Z = 33
LOOP_HELP = 34
START_MOVED = 35
START_TURNED = 36
BEYOND_STOP = 37
GAP_TAKEN = 38
BODY_STUCK = 39

# among steppers: another method must go on
CHANGE_METHOD = 12
CHANGE_PAIR = 17

OUTPUT_NOT_FINITE = 13
BAD_PARAMETER = 14

# no failure: told in the log as a warning
CONTRADICTION = 15

# likewise as an event
NOT_ATTAINED = 16
NOT_KNOWN = 18

MESSAGES = {
    NOT_FINITE: "the motion is no longer finite; check inputs and parameters for huge values",
    STEP_TOO_SMALL: "the inner step became too small to go on; the motion is singular or too stiff for this "
    "integrator",
    SINGULAR_INERTIA: "the inertia about the joint of %s is zero or negative: some mass or inertia it carries "
    "must be positive, or what closes its loop, couples or drives it must determine how it moves",
    BAD_MASS: "the mass of %s is negative",
    BAD_START_ORIENTATION: "the start orientation of %s has Euler parameters of zero length",
    BAD_SOLVER_SETTING: "solver.step is not positive",
    BAD_TOLERANCE: "solver.tolerance must be from 1e-14 to 0.1",
    BAD_ABSOLUTE_TOLERANCE: "solver.absolute_tolerance must be from 1e-14 to 0.1",
    BAD_MAX_EVALUATIONS: "solver.max_evaluations must be at least 1",
    BAD_STEP: "the communication step is negative or no number",
    TOO_MUCH_WORK: "the step costs more than solver.max_evaluations allows: the motion is too fast for a step so long; look for "
    "huge values of inputs and parameters, take shorter steps, or raise solver.max_evaluations",
    NO_STAGES: "the implicit stages of a step were not found: the motion is stiff, or passes a singular position, or the step "
    'is too long; make solver.step smaller, or take integrator = "auto"',
    STIFF: "the motion is stiff: the implicit method goes on from here",
    NOT_STIFF: "the implicit method no longer pays: the explicit method goes on from here",
    CONTRADICTION: "the motion commanded for %s contradicts itself: the speed is not that at which the position changes, or the "
    "acceleration not that of the speed; give what belongs together, or list in its input only what is given, as in "
    'input = ["position"]',
    NOT_ATTAINED: "the motion passes a singular position, where the accelerations are not known as well as solver.tolerance = %g asks: "
    "there the tolerance is %g",
    NOT_KNOWN: "the accelerations are not known as well as solver.tolerance = %g asks, for rounding: where that is so, as here, "
    "the tolerance is %g",
    LOOP_OPEN: "the loop cannot be closed at %s",
    OUTPUT_NOT_FINITE: "%s is not finite; check inputs and parameters for huge values",
    BAD_PARAMETER: "the mass or inertia of %s is not finite; check its parameters for huge values",
    BAD_ROTOR: "the rotor that turns with the joint of %s needs an inertia that is not negative, and finite numbers",
    BAD_EFFORT: "a spring, damper, stop, friction or line that acts on %s has a constant that is negative or no number, or a speed of its "
    "friction is not positive",
    BAD_SEA: "sea.hs, sea.height must not be negative, sea.tp, sea.period must be positive, sea.seed must be a whole number from 0 to "
    "4294967295, and sea.direction one that the coefficients of the bodies have waves of",
    TOUCHES_ALONG: "the surfaces of %s touch in more than a point: the first one is as hollow there as the second one is round, or "
    "hollower, or the second one is a wheel that lies flat",
    SINGULAR_START: "the loop cannot be closed at %s though it stands open by rounding only: the position is singular; start a "
    "little way off",
    COUPLING_OPEN: "%s cannot be kept together with what else holds its joints",
    COUPLING_OFF: "%s stays off by %g (m or rad)",
    LOOP_SIZE: "the ends at %s stay %g m apart and turned by %g rad against each other",
    LOOP_ALONG: "the second end at %s is off by %g m along x, %g m along y",
    LOOP_ALONG_Z: "and by %g m along z of the inertial frame",
    LOOP_HELP: "a start nearer to where it closes may help: %s",
    START_MOVED: "%s at the start is given as %g, but taken as %g: loops, couplings, contacts or drivers leave it nothing else",
    START_TURNED: "%s at the start is turned by %g deg from the given one: loops, couplings, contacts or drivers leave it nothing else",
    BEYOND_STOP: "%s starts at %g, beyond its stop at %g",
    BEYOND_END: "%s has come beyond the end of its curve or surface (s = %g, that is at %g): from there it goes on straight, and what "
    "is held to its frame stops turning at once, which takes energy or adds some; let the points reach as far as the way does",
    UNDER_BED: "%s comes down to z = %g m, and the sea's bed is at %g m: nothing carries it there, and the run goes on so; a line lies on a bed "
    "where its first end is on it, or as high as that with bed = true",
    GAP_TAKEN: "%s does not quite close: its ends stay %g m apart and turned by %g rad against each other, and the run goes on so",
    BODY_STUCK: "%s cannot move: its joints leave it 0 degrees of freedom",
    BAD_INERTIA: "the inertia of %s has a negative principal moment",
}

# texts that a file carries only of a model that has some of these
ONLY_WITH = {BEYOND_END: "n_end_frame", UNDER_BED: "n_low"}


@inlined
def status(code, place):
    """Status of a failure `code` at `place`."""
    return code + 256 * place


@inlined
def tell(d, told, a, b):
    """Adds a notice: a status, and two numbers for its text."""
    # a state from outside may hold any number here
    if 0.0 <= d.notices[0] < MOST_NOTICES:
        k = int(d.notices[0])
        d.notice[3 * k] = told
        d.notice[3 * k + 1] = a
        d.notice[3 * k + 2] = b

    d.notices[0] += 1.0
