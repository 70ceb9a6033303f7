"""Tables of explicit Runge-Kutta pairs, in one shape so that one stepper serves them all.

Row k of `STAGES[pair]` gives stage k from the rates of the stages before it. Row `STAGE_COUNT[pair] - 1` is the result,
so that stage is the first of the next step; those after it serve the continuous extension alone. `ERRORS[pair]` are one or
two combinations of the stages that estimate the error, `DENSE[pair]` those of the continuous extension.
"""

import numpy as np

from ...steppers import RK32, STEPPERS

PAIRS = (STEPPERS["rk54"], STEPPERS["rk853"], RK32)
N_STAGE = max(pair.stage_rows for pair in PAIRS)
N_DENSE = max(pair.dense_rows for pair in PAIRS)

# Dormand, Prince, J. Comp. Appl. Math. 6 (1980) 19-26
NODES_54 = [0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1]
STAGES_54 = [
    [],
    [1 / 5],
    [3 / 40, 9 / 40],
    [44 / 45, -56 / 15, 32 / 9],
    [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
    [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
    [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
]
ERRORS_54 = [[71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40]]

# of order 4: HNW I, section II.6 and its code DOPRI5 (docs/theory.md, sources)
DENSE_54 = [
    [
        -12715105075 / 11282082432,
        0,
        87487479700 / 32700410799,
        -10690763975 / 1880347072,
        701980252875 / 199316789632,
        -1453857185 / 822651844,
        69997945 / 29380423,
    ]
]

# Dormand and Prince's 8(5,3) with the error estimators of Hairer, Norsett, Wanner, Solving Ordinary Differential
# Equations I (1993), section II.10 and its code DOP853
NODES_853 = [
    0.0,
    0.05260015195876773,
    0.0789002279381516,
    0.1183503419072274,
    0.2816496580927726,
    0.3333333333333333,
    0.25,
    0.3076923076923077,
    0.6512820512820513,
    0.6,
    0.8571428571428571,
    1.0,
    1.0,
    0.1,
    0.2,
    0.7777777777777778,
]
STAGES_853 = [
    [],
    [
        0.05260015195876773,
    ],
    [
        0.0197250569845379,
        0.0591751709536137,
    ],
    [
        0.02958758547680685,
        0,
        0.08876275643042054,
    ],
    [
        0.2413651341592667,
        0,
        -0.8845494793282861,
        0.924834003261792,
    ],
    [
        0.037037037037037035,
        0,
        0,
        0.17082860872947386,
        0.12546768756682242,
    ],
    [
        0.037109375,
        0,
        0,
        0.17025221101954405,
        0.06021653898045596,
        -0.017578125,
    ],
    [
        0.03709200011850479,
        0,
        0,
        0.17038392571223998,
        0.10726203044637328,
        -0.015319437748624402,
        0.008273789163814023,
    ],
    [
        0.6241109587160757,
        0,
        0,
        -3.3608926294469414,
        -0.868219346841726,
        27.59209969944671,
        20.154067550477894,
        -43.48988418106996,
    ],
    [
        0.47766253643826434,
        0,
        0,
        -2.4881146199716677,
        -0.590290826836843,
        21.230051448181193,
        15.279233632882423,
        -33.28821096898486,
        -0.020331201708508627,
    ],
    [
        -0.9371424300859873,
        0,
        0,
        5.186372428844064,
        1.0914373489967295,
        -8.149787010746927,
        -18.52006565999696,
        22.739487099350505,
        2.4936055526796523,
        -3.0467644718982196,
    ],
    [
        2.273310147516538,
        0,
        0,
        -10.53449546673725,
        -2.0008720582248625,
        -17.9589318631188,
        27.94888452941996,
        -2.8589982771350235,
        -8.87285693353063,
        12.360567175794303,
        0.6433927460157636,
    ],
    [
        0.054293734116568765,
        0,
        0,
        0,
        0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        0.3111643669578199,
        -0.1521609496625161,
        0.20136540080403034,
        0.04471061572777259,
    ],
    [
        0.056167502283047954,
        0,
        0,
        0,
        0,
        0,
        0.25350021021662483,
        -0.2462390374708025,
        -0.12419142326381637,
        0.15329179827876568,
        0.00820105229563469,
        0.007567897660545699,
        -0.008298,
    ],
    [
        0.03183464816350214,
        0,
        0,
        0,
        0,
        0.028300909672366776,
        0.053541988307438566,
        -0.05492374857139099,
        0,
        0,
        -0.00010834732869724932,
        0.0003825710908356584,
        -0.00034046500868740456,
        0.1413124436746325,
    ],
    [
        -0.42889630158379194,
        0,
        0,
        0,
        0,
        -4.697621415361164,
        7.683421196062599,
        4.06898981839711,
        0.3567271874552811,
        0,
        0,
        0,
        -0.0013990241651590145,
        2.9475147891527724,
        -9.15095847217987,
    ],
]
ERRORS_853 = [
    [
        0.01312004499419488,
        0,
        0,
        0,
        0,
        -1.2251564463762044,
        -0.4957589496572502,
        1.6643771824549864,
        -0.35032884874997366,
        0.3341791187130175,
        0.08192320648511571,
        -0.022355307863886294,
        0,
    ],
    [
        -0.18980075407240762,
        0,
        0,
        0,
        0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        -0.4226823213237919,
        -0.1521609496625161,
        0.20136540080403034,
        0.02265179219836082,
        0,
    ],
]
DENSE_853 = [
    [
        -8.428938276109013,
        0,
        0,
        0,
        0,
        0.5667149535193777,
        -3.0689499459498917,
        2.38466765651207,
        2.117034582445028,
        -0.871391583777973,
        2.2404374302607883,
        0.6315787787694688,
        -0.08899033645133331,
        18.148505520854727,
        -9.194632392478356,
        -4.436036387594894,
    ],
    [
        10.427508642579134,
        0,
        0,
        0,
        0,
        242.28349177525817,
        165.20045171727028,
        -374.5467547226902,
        -22.113666853125306,
        7.733432668472264,
        -30.674084731089398,
        -9.332130526430229,
        15.697238121770845,
        -31.139403219565178,
        -9.35292435884448,
        35.81684148639408,
    ],
    [
        19.985053242002433,
        0,
        0,
        0,
        0,
        -387.0373087493518,
        -189.17813819516758,
        527.8081592054236,
        -11.57390253995963,
        6.8812326946963,
        -1.0006050966910838,
        0.7777137798053443,
        -2.778205752353508,
        -60.19669523126412,
        84.32040550667716,
        11.99229113618279,
    ],
    [
        -25.69393346270375,
        0,
        0,
        0,
        0,
        -154.18974869023643,
        -231.5293791760455,
        357.6391179106141,
        93.40532418362432,
        -37.45832313645163,
        104.0996495089623,
        29.8402934266605,
        -43.53345659001114,
        96.32455395918828,
        -39.17726167561544,
        -149.72683625798564,
    ],
]

# Bogacki, Shampine, Appl. Math. Lett. 2 (1989) 321-325; its continuous extension is the cubic through both ends
NODES_32 = [0, 1 / 2, 3 / 4, 1]
STAGES_32 = [[], [1 / 2], [0, 3 / 4], [2 / 9, 1 / 3, 4 / 9]]
ERRORS_32 = [[-5 / 72, 1 / 12, 1 / 9, -1 / 8]]


def _padded(rows, shape):
    """Rows of unequal length in an array of zeros."""
    array = np.zeros(shape)

    for k, row in enumerate(rows):
        array[k, : len(row)] = row

    return array


# the pairs' numbers are their places in what follows
assert [pair.number for pair in PAIRS] == [0, 1, 2]

STAGE_COUNT = np.array([7, 13, 4])  # of a step
STAGE_TOTAL = np.array([pair.stage_rows for pair in PAIRS])  # and of its continuous extension
DENSE_COUNT = np.array([pair.dense_rows for pair in PAIRS])  # coefficients of that
ORDER = np.array([pair.order for pair in PAIRS])
NODES = _padded([NODES_54, NODES_853, NODES_32], (3, N_STAGE))
STAGES = np.array([_padded(rows, (N_STAGE, N_STAGE)) for rows in (STAGES_54, STAGES_853, STAGES_32)])
ERRORS = np.array([_padded(rows, (2, N_STAGE)) for rows in (ERRORS_54, ERRORS_853, ERRORS_32)])
DENSE = np.array([_padded(rows, (N_DENSE - 3, N_STAGE)) for rows in (DENSE_54, DENSE_853, [])])


def _gaps(pair, weights):
    """Combinations of the stages (len(weights), N_STAGE): how far the continuous extension of a pair misses its last states.

    Stage i's rate was found at the state x + h sum_j a_ij k_j; the extension, which has that rate there, goes through another.
    """
    unit = np.eye(N_STAGE)
    end = STAGE_COUNT[pair] - 1
    change = STAGES[pair, end]
    terms = [change, unit[0] - change, 2.0 * change - unit[0] - unit[end], *DENSE[pair]]
    gaps = np.zeros((len(weights), N_STAGE))

    for row, weight in enumerate(weights):
        stage = STAGE_TOTAL[pair] - len(weights) + row
        theta = NODES[pair, stage]
        value = np.zeros(N_STAGE)

        for k in range(DENSE_COUNT[pair] - 1, -1, -1):
            value = (value + terms[k]) * (theta if k % 2 == 0 else 1.0 - theta)

        gaps[row] = weight * (value - STAGES[pair, stage])

    return gaps


# where an extension has stages that the step's error estimate does not see: weighed so that an error in one of these rates
# counts at least about as much as it does in the extension
GAP_COUNT = np.array([0, 2, 0])
GAPS = _gaps(1, (47.0, 0.2))


def _noise(errors):
    """What a pair's estimate makes of independent errors of the rates, all of one size."""
    fine, coarse = np.sqrt((errors**2).sum(axis=1))
    return fine**2 / np.sqrt(fine**2 + 0.01 * coarse**2)


NOISE = np.array([_noise(errors) for errors in ERRORS])
GAP_NOISE = np.array([0.0, np.sqrt((GAPS**2).sum()), 0.0])  # and that of its continuous extension

# from where on h |lambda| is at the border of stability (the same codes); inf: the last two stages do not tell
STABLE = np.array([3.25, 6.1, np.inf])
