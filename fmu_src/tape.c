#include "tape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

/* A part of the rate of a kept operation: what goes from `source`, kept too, through an operand of `op`. */
typedef struct {
    int32_t source, op;
    bool second;
} Edge;

/* Of an operation that one other alone needs no rate is kept: its edges are those of that one, and its
   gain is the derivative of the kept one that it leads to. */
struct Tape {
    const Resource *r;
    double *value;       /* of each operation */
    double *by_a, *by_b; /* its partial derivatives by a and b */
    double *gain;        /* 1 of what is kept */
    int32_t *user;       /* who needs it, of what is not kept; -1 of what is */
    bool *as_second;     /* as which operand */

    int32_t *kept, *leaf, *equality; /* operations of these kinds */
    int64_t n_kept, n_leaves, n_equalities;
    Edge *edge;
    double *slope;   /* of each edge */
    int64_t *begins; /* where the edges of the i-th kept operation begin; n_kept + 1 */
    double (*rate)[TAPE_LANES];
    bool *moves; /* whether any of its rates is not 0 */
};

int64_t tape_size(const Sizes *n)
{
    int64_t size = 8 * n->constants + (int64_t)sizeof(Operation) * n->operations
                   + (int64_t)sizeof(TapeGuard) * n->guards + 4 * n->results;

    return (size + 7) / 8 * 8;
}

/* ---- reading ---- */

/* How many operands come before the places of an operation. */
static int operands_of(int32_t op)
{
    switch (op) {
        case TAPE_CONSTANT:
        case TAPE_LEAF:     return 0;
        case TAPE_ADD:
        case TAPE_SUBTRACT:
        case TAPE_MULTIPLY:
        case TAPE_DIVIDE:
        case TAPE_MINIMUM:
        case TAPE_MAXIMUM:
        case TAPE_LESS:
        case TAPE_NOT_MORE:
        case TAPE_EQUAL:
        case TAPE_UNEQUAL:
        case TAPE_ATAN2:
        case TAPE_POW:
        case TAPE_COPYSIGN: return 2;
        case TAPE_SELECT:   return 3;
        default:            return 1;
    }
}

/* Whether `length` numbers from `first` on are in `room`. */
static bool is_within(int64_t first, int64_t length, int64_t room)
{
    return first >= 0 && length >= 0 && first + length <= room;
}

/* Whether operation k needs but what stands before it, and what there is. */
static bool is_good(const Resource *r, int64_t k)
{
    const Operation *o = &r->operations[k];
    const int64_t room[N_LEAF_BUFFER] = {
        [LEAF_REALS] = r->n.reals,
        [LEAF_STATE] = r->n.state,
        [LEAF_U] = r->n.u,
    };
    const int32_t operand[3] = {o->a, o->b, o->c};

    if (o->op < 0 || o->op >= N_OPERATION) return false;
    for (int i = 0; i < operands_of(o->op); i++)
        if (operand[i] < 0 || operand[i] >= k) return false;

    switch (o->op) {
        case TAPE_CONSTANT: return is_within(o->a, 1, r->n.constants);
        case TAPE_LED:      return is_within(o->b, 1, r->ints[COUNT_n_x]);
        case TAPE_LOAD:     return is_within(o->b, o->c, r->n.reals);
        case TAPE_INTERVAL: return o->c > 1 && is_within(o->b, o->c, r->n.reals);
        case TAPE_LEAF: return o->a >= 0 && o->a < N_LEAF_BUFFER && is_within(o->b, 1, room[o->a]);
        default:        return true;
    }
}

bool tape_take(Resource *r, const unsigned char *data)
{
    int64_t results = r->n.operations > 0 ? r->ints[COUNT_n_x] + r->n.y : 0;

    r->constants = (const double *)data;
    r->operations = (const Operation *)(r->constants + r->n.constants);
    r->guards = (const TapeGuard *)(r->operations + r->n.operations);
    r->results = (const int32_t *)(r->guards + r->n.guards);

    if (r->n.results != results || r->n.led_guards > r->n.guards) return false;
    for (int64_t k = 0; k < r->n.operations; k++)
        if (!is_good(r, k)) return false;
    for (int64_t k = 0; k < r->n.guards; k++)
        if (!is_within(r->guards[k].operation, 1, r->n.operations)) return false;
    for (int64_t k = 0; k < results; k++)
        if (!is_within(r->results[k], 1, r->n.operations)) return false;
    return true;
}

/* ---- an instance's ---- */

void tape_free(Tape *t)
{
    if (!t) return;
    free(t->value);
    free(t->by_a);
    free(t->by_b);
    free(t->gain);
    free(t->user);
    free(t->as_second);
    free(t->kept);
    free(t->leaf);
    free(t->equality);
    free(t->edge);
    free(t->slope);
    free(t->begins);
    free(t->rate);
    free(t->moves);
    free(t);
}

static bool allocate(Tape *t, size_t n)
{
    t->value = malloc(n * sizeof(double));
    t->by_a = malloc(n * sizeof(double));
    t->by_b = malloc(n * sizeof(double));
    t->gain = malloc(n * sizeof(double));
    t->user = malloc(n * sizeof(int32_t));
    t->as_second = calloc(n, sizeof(bool));
    t->kept = malloc(n * sizeof(int32_t));
    t->leaf = malloc(n * sizeof(int32_t));
    t->equality = malloc(n * sizeof(int32_t));
    t->edge = malloc(2 * n * sizeof(Edge));
    t->slope = malloc(2 * n * sizeof(double));
    t->begins = malloc((n + 1) * sizeof(int64_t));
    t->rate = malloc(n * sizeof *t->rate);
    t->moves = calloc(n, sizeof(bool));
    return t->value && t->by_a && t->by_b && t->gain && t->user && t->as_second && t->kept
           && t->leaf && t->equality && t->edge && t->slope && t->begins && t->rate && t->moves;
}

/* How many operands an operation has a derivative by that is told before it is evaluated. */
static int slopes_of(int32_t op)
{
    switch (op) {
        case TAPE_LED:
        case TAPE_SELECT:
        case TAPE_LOAD:
        case TAPE_INTERVAL:
        case TAPE_NOT:
        case TAPE_ISFINITE:
        case TAPE_LESS:
        case TAPE_NOT_MORE:
        case TAPE_EQUAL:
        case TAPE_UNEQUAL:
        case TAPE_WHOLE:
        case TAPE_FLOOR:    return 0;
        case TAPE_COPYSIGN: return 1;
        default:            return operands_of(op);
    }
}

/* Which operations are kept: results, what is asked for by its own, and what several need or nobody. */
static void choose_kept(Tape *t)
{
    enum { NOBODY = -2, KEPT = -1 };
    const Resource *r = t->r;

    for (int64_t k = 0; k < r->n.operations; k++) {
        const Operation *o = &r->operations[k];
        const int32_t operand[3] = {o->a, o->b, o->c};
        bool apart = o->op == TAPE_LED || o->op == TAPE_SELECT || o->op == TAPE_EQUAL
                     || o->op == TAPE_UNEQUAL;

        t->user[k] =
            operands_of(o->op) == 0 || o->op == TAPE_LED || o->op == TAPE_SELECT ? KEPT : NOBODY;
        for (int i = 0; i < (apart ? operands_of(o->op) : slopes_of(o->op)); i++) {
            int32_t *user = &t->user[operand[i]];
            *user = apart || *user != NOBODY ? KEPT : (int32_t)k;
            t->as_second[operand[i]] = i == 1;
        }
    }
    for (int64_t i = 0; i < r->n.results; i++) t->user[r->results[i]] = KEPT;
    for (int64_t k = 0; k < r->n.operations; k++)
        if (t->user[k] == NOBODY) t->user[k] = KEPT;
}

/* The edges, in the order of the kept operations that they lead to. */
static void join(Tape *t)
{
    const Resource *r = t->r;
    int64_t n = r->n.operations, n_edges = 0;
    int32_t *root = t->kept; /* of each operation, as long as nothing else stands there */
    int64_t *count = t->begins;

    memset(count, 0, (size_t)(n + 1) * sizeof *count);
    for (int64_t k = n - 1; k >= 0; k--) root[k] = t->user[k] < 0 ? (int32_t)k : root[t->user[k]];

    for (int pass = 0; pass < 2; pass++) {
        for (int64_t k = 0; k < n; k++) {
            const Operation *o = &r->operations[k];
            const int32_t operand[2] = {o->a, o->b};

            for (int i = 0; i < slopes_of(o->op); i++) {
                if (t->user[operand[i]] >= 0 || r->operations[operand[i]].op == TAPE_CONSTANT)
                    continue;
                if (pass == 0)
                    count[root[k]]++;
                else
                    t->edge[count[root[k]]++] = (Edge){operand[i], (int32_t)k, i == 1};
            }
        }
        if (pass > 0) break;
        for (int64_t k = 0; k < n; k++) {
            int64_t here = count[k];
            count[k] = n_edges;
            n_edges += here;
        }
    }

    /* each count is now where the edges end; those of operations that are not kept are none */
    int64_t begin = 0;
    for (int64_t k = 0; k < n; k++) {
        int64_t end = count[k];
        if (t->user[k] >= 0) continue;
        t->begins[t->n_kept] = begin;
        t->kept[t->n_kept++] = (int32_t)k;
        begin = end;
    }
    t->begins[t->n_kept] = begin;
}

Tape *tape_create(const Resource *r)
{
    Tape *t = calloc(1, sizeof *t);

    if (!t) return NULL;
    t->r = r;
    if (!allocate(t, (size_t)r->n.operations + 1)) {
        tape_free(t);
        return NULL;
    }
    for (int64_t k = 0; k < r->n.operations; k++) {
        int32_t op = r->operations[k].op;
        if (op == TAPE_LEAF) t->leaf[t->n_leaves++] = (int32_t)k;
        if (op == TAPE_EQUAL || op == TAPE_UNEQUAL) t->equality[t->n_equalities++] = (int32_t)k;
    }
    choose_kept(t);
    join(t);
    return t;
}

/* Of ascending numbers the one left of x, by bisection; the first or last but one beyond the ends. */
static int64_t left_of(const double knot[], int64_t n, double x)
{
    int64_t low = 0, high = n - 1;

    while (high - low > 1) {
        int64_t middle = (low + high) / 2;
        if (x < knot[middle])
            high = middle;
        else
            low = middle;
    }
    return low;
}

static double looked_up(const double numbers[], int64_t n, double place)
{
    return place >= 0 && place < (double)n ? numbers[(int64_t)place] : NAN;
}

static double leaf(const Instance *c, const Operation *o, const double x[])
{
    int64_t in_x = o->b - c->ints[AT_x];

    if (o->a == LEAF_REALS) return c->reals[o->b];
    if (o->a == LEAF_U) return c->u[o->b];
    return in_x >= 0 && in_x < c->ints[COUNT_n_x] ? x[in_x] : c->state[o->b];
}

/* Values at which tape_evaluate looks. */
typedef struct {
    const Instance *c;
    const double *x, *led;
    bool by_led;
} Place;

/* Operation k: its value, and its partial derivatives, 0 of what jumps. */
static double operate(Tape *t, int64_t k, const Place *at, double *by_a, double *by_b)
{
    const Operation *o = &t->r->operations[k];
    int operands = operands_of(o->op);
    double a = operands > 0 ? t->value[o->a] : 0, b = operands > 1 ? t->value[o->b] : 0, y;

    *by_a = *by_b = 0;
    switch (o->op) {
        case TAPE_CONSTANT: return t->r->constants[o->a];
        case TAPE_LEAF:     return leaf(at->c, o, at->x);
        case TAPE_LED:      *by_a = at->by_led; return at->led[o->b];
        case TAPE_LOAD:     return looked_up(at->c->reals + o->b, o->c, a);
        case TAPE_INTERVAL: return (double)(o->d + left_of(at->c->reals + o->b, o->c, a));
        case TAPE_ADD:      *by_a = *by_b = 1; return a + b;
        case TAPE_SUBTRACT:
            *by_a = 1;
            *by_b = -1;
            return a - b;
        case TAPE_MULTIPLY:
            *by_a = b;
            *by_b = a;
            return a * b;
        case TAPE_DIVIDE:
            *by_a = 1 / b;
            *by_b = -(a / b) / b;
            return a / b;
        case TAPE_NEGATE:   *by_a = -1; return -a;
        case TAPE_ABSOLUTE: *by_a = a < 0 ? -1 : 1; return fabs(a);
        case TAPE_MINIMUM:
            *by_b = b < a;
            *by_a = 1 - *by_b;
            return b < a ? b : a;
        case TAPE_MAXIMUM:
            *by_b = b > a;
            *by_a = 1 - *by_b;
            return b > a ? b : a;
        case TAPE_NOT:      return a == 0;
        case TAPE_ISFINITE: return isfinite(a) != 0;
        case TAPE_LESS:     return a < b;
        case TAPE_NOT_MORE: return a <= b;
        case TAPE_EQUAL:    return a == b;
        case TAPE_UNEQUAL:  return a != b;
        case TAPE_REAL:     *by_a = 1; return a;
        case TAPE_WHOLE:    return trunc(a);
        case TAPE_FLOOR:    return floor(a);
        case TAPE_SQRT:
            y = sqrt(a);
            *by_a = 0.5 / y;
            return y;
        case TAPE_SIN: *by_a = cos(a); return sin(a);
        case TAPE_COS: *by_a = -sin(a); return cos(a);
        case TAPE_ATAN2:
            *by_a = b / (a * a + b * b);
            *by_b = -a / (a * a + b * b);
            return atan2(a, b);
        case TAPE_ASIN: *by_a = 1 / sqrt(1 - a * a); return asin(a);
        case TAPE_EXP:
            y = exp(a);
            *by_a = y;
            return y;
        case TAPE_LOG: *by_a = 1 / a; return log(a);
        case TAPE_TANH:
            y = tanh(a);
            *by_a = 1 - y * y;
            return y;
        case TAPE_ASINH: *by_a = 1 / sqrt(1 + a * a); return asinh(a);
        case TAPE_POW:
            y = pow(a, b);
            *by_a = y * b / a;
            *by_b = y * log(a);
            return y;
        case TAPE_COPYSIGN:
            y = copysign(a, b);
            *by_a = signbit(a) == signbit(y) ? 1 : -1;
            return y;
        default: return NAN;
    }
}

bool tape_evaluate(Tape *t, const Instance *c, const double x[], const double led[], bool by_led)
{
    const Resource *r = t->r;
    const Place at = {c, x, led, by_led};

    for (int64_t k = 0; k < r->n.operations; k++) {
        const Operation *o = &r->operations[k];

        if (o->op == TAPE_SELECT)
            t->value[k] = t->value[t->value[o->a] != 0 ? o->b : o->c];
        else
            t->value[k] = operate(t, k, &at, &t->by_a[k], &t->by_b[k]);
    }
    for (int64_t k = by_led ? 0 : r->n.led_guards; k < r->n.guards; k++)
        if ((t->value[r->guards[k].operation] != 0) != (r->guards[k].holds != 0)) return false;

    for (int64_t k = r->n.operations - 1; k >= 0; k--) {
        int32_t user = t->user[k];
        t->gain[k] =
            user < 0 ? 1 : t->gain[user] * (t->as_second[k] ? t->by_b[user] : t->by_a[user]);
    }
    for (int64_t i = 0; i < t->begins[t->n_kept]; i++) {
        const Edge *e = &t->edge[i];
        t->slope[i] = t->gain[e->op] * (e->second ? t->by_b[e->op] : t->by_a[e->op]);
    }
    return true;
}

void tape_rest(Tape *t)
{
    for (int64_t i = 0; i < t->n_leaves; i++) memset(t->rate[t->leaf[i]], 0, sizeof *t->rate);
}

void tape_move(Tape *t, int buffer, int64_t place, int lane, double seed)
{
    for (int64_t i = 0; i < t->n_leaves; i++) {
        const Operation *o = &t->r->operations[t->leaf[i]];
        if (o->a == buffer && o->b == place) t->rate[t->leaf[i]][lane] = seed;
    }
}

void tape_move_state(Tape *t, const double seed[])
{
    for (int64_t i = 0; i < t->n_leaves; i++) {
        const Operation *o = &t->r->operations[t->leaf[i]];
        if (o->a == LEAF_STATE) t->rate[t->leaf[i]][0] += seed[o->b];
    }
}

/* Adds a part of a rate to another. */
static void add(double *restrict to, double slope, const double *restrict rate)
{
    for (int i = 0; i < TAPE_LANES; i++) to[i] += slope * rate[i];
}

/* The rate of the i-th kept operation by its edges. What is not moved is not looked at, so that no infinite
   slope meets a 0. */
static void follow(Tape *t, int64_t i)
{
    double rate[TAPE_LANES] = {0};
    int32_t k = t->kept[i];

    t->moves[k] = false;
    for (int64_t j = t->begins[i]; j < t->begins[i + 1]; j++) {
        int32_t source = t->edge[j].source;
        if (!t->moves[source] || t->slope[j] == 0) continue;
        t->moves[k] = true;
        add(rate, t->slope[j], t->rate[source]);
    }
    if (t->moves[k]) memcpy(t->rate[k], rate, sizeof rate);
}

/* The rate of an operation that is one of others as it is. */
static void copy(Tape *t, int64_t k, int32_t source, bool does)
{
    t->moves[k] = does && t->moves[source];
    if (t->moves[k]) memcpy(t->rate[k], t->rate[source], sizeof t->rate[k]);
}

static bool is_moved(const double rate[TAPE_LANES])
{
    for (int i = 0; i < TAPE_LANES; i++)
        if (rate[i] != 0) return true;
    return false;
}

void tape_forward(Tape *t)
{
    for (int64_t i = 0; i < t->n_kept; i++) {
        int32_t k = t->kept[i];
        const Operation *o = &t->r->operations[k];

        switch (o->op) {
            case TAPE_LEAF:   t->moves[k] = is_moved(t->rate[k]); break;
            case TAPE_LED:    copy(t, k, o->a, t->by_a[k] != 0); break;
            case TAPE_SELECT: copy(t, k, t->value[o->a] != 0 ? o->b : o->c, true); break;
            default:          follow(t, i);
        }
    }
}

static double rate_of(const Tape *t, int32_t k, int lane)
{
    return t->moves[k] ? t->rate[k][lane] : 0;
}

double tape_rate(const Tape *t, int64_t i, int lane)
{
    return rate_of(t, t->r->results[i], lane);
}

bool tape_holds(const Tape *t, int lane)
{
    for (int64_t i = 0; i < t->n_equalities; i++) {
        int64_t k = t->equality[i];
        const Operation *o = &t->r->operations[k];
        bool equal = (t->value[k] != 0) == (o->op == TAPE_EQUAL);

        if (equal && rate_of(t, o->a, lane) != rate_of(t, o->b, lane)) return false;
    }
    return true;
}
