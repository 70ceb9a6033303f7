#include "tape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "graph.h"
#include "kernels.h"

/* A result is the rate of another node, by a weight: of one that several edges lead to, its root, or of a
   leaf. */
typedef struct {
    int32_t root, row; /* row: which of the roots that are no leaves; -1 of leaves */
    double weight;
} Result;

struct Tape {
    const Resource *r;
    Graph *graph;
    double *value;            /* of each operation */
    double *partial;          /* two partial derivatives of each (graph_operands) */
    int32_t *leaf, *equality; /* operations of these kinds */
    int64_t n_leaves, n_equalities;
    Result *result;
    int32_t *by_row; /* results, in the order of their rows */
    int32_t *root;   /* of each row */
    int64_t n_rows;
    bool compares; /* whether what is compared depends on states or inputs */
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
        case TAPE_LEAF:
        case TAPE_SOLVE:
        case TAPE_FOUND:    return 0;
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

/* Whether what operation k solves for is there, and finds room: what it takes stands before it, what it
   gives behind it. */
static bool solves_well(const Resource *r, int64_t k)
{
    const Operation *o = &r->operations[k];

    if (o->a < 0 || o->a >= 2 * N_SOLUTION) return false;
    const Solution *solution = &SOLUTIONS[o->a % N_SOLUTION];
    int32_t gives = solution->gives * (o->a < N_SOLUTION ? 1 : solution->takes);

    return is_within(o->b, 1, r->ints[solution->count]) && o->c == solution->takes && o->d == gives
           && k >= o->c && k + o->d < r->n.operations;
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
        case TAPE_SOLVE:    return solves_well(r, k);
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
    graph_free(t->graph);
    free(t->value);
    free(t->partial);
    free(t->leaf);
    free(t->equality);
    free(t->result);
    free(t->by_row);
    free(t->root);
    free(t);
}

static bool allocate(Tape *t, size_t n, size_t n_results)
{
    t->value = calloc(n, sizeof(double));
    t->partial = calloc(2 * n, sizeof(double));
    t->leaf = malloc(n * sizeof(int32_t));
    t->equality = malloc(n * sizeof(int32_t));
    t->result = malloc(n_results * sizeof(Result));
    t->by_row = malloc(n_results * sizeof(int32_t));
    t->root = malloc(n_results * sizeof(int32_t));
    t->graph = graph_create(t->r);
    return t->value && t->partial && t->leaf && t->equality && t->result && t->by_row && t->root
           && t->graph;
}

/* Of a leaf that is a state, or behind these an input, its place among them; else -1. */
static int64_t known_of(const Resource *r, const Operation *leaf)
{
    int64_t n_x = r->ints[COUNT_n_x], in_x = leaf->b - r->ints[AT_x];

    if (leaf->a == LEAF_U) return n_x + leaf->b;
    return leaf->a == LEAF_STATE && in_x >= 0 && in_x < n_x ? in_x : -1;
}

/* Whether what is compared depends on states or inputs; true when there is no memory. */
static bool does_compare(const Tape *t)
{
    const Resource *r = t->r;
    bool *depends = calloc((size_t)r->n.operations + 1, sizeof *depends);
    bool any = !depends;

    for (int64_t k = 0; depends && k < r->n.operations; k++) {
        const Operation *o = &r->operations[k];
        int32_t operand[2];

        for (int i = graph_operands(o, operand) - 1; i >= 0; i--)
            depends[k] = depends[k] || depends[operand[i]];
        if (o->op == TAPE_LEAF) depends[k] = known_of(r, o) >= 0;
        if (o->op == TAPE_EQUAL || o->op == TAPE_UNEQUAL)
            any = any || depends[o->a] || depends[o->b];
    }
    free(depends);
    return any;
}

/* The roots of all results. */
static void find_roots(Tape *t)
{
    const Resource *r = t->r;

    for (int64_t i = 0; i < r->n.results; i++) {
        Result *result = &t->result[i];
        int32_t node = graph_node(t->graph, r->results[i]), source;

        while ((source = graph_only_source(t->graph, node)) >= 0) node = source;
        *result = (Result){node, -1, 1};
        if (graph_n_sources(t->graph, node) == 0) continue;
        for (int32_t k = 0; k < t->n_rows && result->row < 0; k++)
            if (t->root[k] == node) result->row = k;
        if (result->row >= 0) continue;
        result->row = (int32_t)t->n_rows;
        t->root[t->n_rows++] = node;
    }
}

Tape *tape_create(const Resource *r)
{
    Tape *t = calloc(1, sizeof *t);

    if (!t) return NULL;
    t->r = r;
    if (!allocate(t, (size_t)r->n.operations + 1, (size_t)r->n.results + 1)) {
        tape_free(t);
        return NULL;
    }
    for (int64_t k = 0; k < r->n.operations; k++) {
        int32_t op = r->operations[k].op;
        if (op == TAPE_LEAF) t->leaf[t->n_leaves++] = (int32_t)k;
        if (op == TAPE_EQUAL || op == TAPE_UNEQUAL) t->equality[t->n_equalities++] = (int32_t)k;
    }
    t->compares = does_compare(t);
    find_roots(t);
    for (int64_t row = -1, n = 0; row < t->n_rows; row++)
        for (int64_t i = 0; i < r->n.results; i++)
            if (t->result[i].row == row) t->by_row[n++] = (int32_t)i;
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

/* Operation k, which a kernel does: what it takes stands before it, what it gives behind it. */
static void solve(Tape *t, const Instance *c, int64_t k)
{
    const Operation *o = &t->r->operations[k];
    double *value = t->value;
    int64_t status;
    void *excinfo = NULL;

    mbdfmi_solve(&status, &excinfo, M_OF(c), D_OF(c), o->a, o->b, &value[k - o->c], &value[k + 1]);
}

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
        case TAPE_STILL:    return a;
        case TAPE_SOLVE:    solve(t, at->c, k); return 0;
        case TAPE_FOUND:    return t->value[k];
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
        double *partial = &t->partial[2 * k];

        if (o->op == TAPE_SELECT) {
            bool first = t->value[o->a] != 0;
            t->value[k] = t->value[first ? o->b : o->c];
            partial[0] = first;
            partial[1] = !first;
        } else {
            t->value[k] = operate(t, k, &at, &partial[0], &partial[1]);
        }
    }
    for (int64_t k = by_led ? 0 : r->n.led_guards; k < r->n.guards; k++)
        if ((t->value[r->guards[k].operation] != 0) != (r->guards[k].holds != 0)) return false;

    graph_weigh(t->graph, t->partial);
    return true;
}

/* ---- by columns ---- */

void tape_rest(Tape *t)
{
    graph_rest(t->graph);
}

static void move(Tape *t, int64_t leaf, int lane, double seed)
{
    graph_add_seed(t->graph, graph_node(t->graph, t->leaf[leaf]), lane, seed);
}

void tape_move(Tape *t, int buffer, int64_t place, int lane, double seed)
{
    for (int64_t i = 0; i < t->n_leaves; i++) {
        const Operation *o = &t->r->operations[t->leaf[i]];
        if (o->a == buffer && o->b == place) move(t, i, lane, seed);
    }
}

void tape_move_state(Tape *t, const double seed[])
{
    for (int64_t i = 0; i < t->n_leaves; i++) {
        const Operation *o = &t->r->operations[t->leaf[i]];
        if (o->a == LEAF_STATE && seed[o->b] != 0) move(t, i, 0, seed[o->b]);
    }
}

void tape_forward(Tape *t)
{
    graph_sweep(t->graph, BY_SEEDS);
}

static double rate_of(const Tape *t, int32_t operation, int lane)
{
    return graph_rate(t->graph, graph_node(t->graph, operation), lane);
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

/* ---- by rows ---- */

int64_t tape_n_sweeps(const Tape *t)
{
    return t->compares ? INT64_MAX : (t->n_rows + TAPE_LANES - 1) / TAPE_LANES;
}

/* The weights of results at their roots' rates. */
static void weigh(Tape *t)
{
    for (int64_t i = 0; i < t->r->n.results; i++) {
        Result *result = &t->result[i];
        int32_t node = graph_node(t->graph, t->r->results[i]);

        result->weight = 1;
        while (node != result->root) {
            result->weight *= graph_only_slope(t->graph, node);
            node = graph_only_source(t->graph, node);
        }
    }
}

/* Adds to a column what a leaf's rates are of n results, of a sweep from row `first` on. */
static void add_rates(const Tape *t, const int32_t results[], int64_t n, int64_t first,
                      int32_t leaf, double column[])
{
    const double *rates = graph_rates(t->graph, leaf);

    for (int64_t i = 0; rates && i < n; i++) {
        const Result *result = &t->result[results[i]];
        column[results[i]] += result->weight * rates[result->row - first];
    }
}

/* The results of a sweep from row `first` on, and how many. */
static const int32_t *results_of(const Tape *t, int64_t first, int64_t *n)
{
    int64_t begin = 0, end;

    while (begin < t->r->n.results && t->result[t->by_row[begin]].row < first) begin++;
    for (end = begin; end < t->r->n.results; end++)
        if (t->result[t->by_row[end]].row >= first + TAPE_LANES) break;
    *n = end - begin;
    return t->by_row + begin;
}

/* Adds the weights of results that are the rates of a leaf. */
static void add_weights(const Tape *t, int32_t leaf, double column[])
{
    for (int64_t i = 0; i < t->r->n.results; i++) {
        const Result *result = &t->result[t->by_row[i]];
        if (result->row >= 0) break;
        if (result->root == leaf) column[t->by_row[i]] += result->weight;
    }
}

void tape_add_jacobian(Tape *t, double jacobian[])
{
    const Resource *r = t->r;

    weigh(t);
    for (int64_t first = 0; first < t->n_rows; first += TAPE_LANES) {
        int64_t n;
        const int32_t *results = results_of(t, first, &n);

        graph_rest(t->graph);
        for (int64_t k = first; k < t->n_rows && k < first + TAPE_LANES; k++)
            graph_add_seed(t->graph, t->root[k], (int)(k - first), 1);
        graph_sweep(t->graph, BY_RESULTS);
        for (int64_t i = 0; i < t->n_leaves; i++) {
            int64_t known = known_of(r, &r->operations[t->leaf[i]]);
            int32_t leaf = graph_node(t->graph, t->leaf[i]);
            if (known >= 0) add_rates(t, results, n, first, leaf, jacobian + known * r->n.results);
        }
    }
    for (int64_t i = 0; i < t->n_leaves; i++) {
        int64_t known = known_of(r, &r->operations[t->leaf[i]]);
        int32_t leaf = graph_node(t->graph, t->leaf[i]);
        if (known >= 0) add_weights(t, leaf, jacobian + known * r->n.results);
    }
}
