#include "graph.h"

#include <stdlib.h>
#include <string.h>

#include "kernels.h"

/* What leads from a node to another through an operand of an operation; several may be of one edge. */
typedef struct {
    int32_t source, op, edge, operand;
} Strand;

/* The edges of each node one way: where they begin, the nodes at their other ends, and which they are. */
typedef struct {
    int64_t *begins; /* n + 1 */
    int32_t *other, *edge;
} Edges;

/* Of an operation that one other alone needs no rate is kept: its strands are those of that one, and its
   gain is the derivative of the kept one that it leads to. */
struct Graph {
    const Resource *r;
    int32_t *node;   /* of each operation; -1 of what is not kept */
    int32_t *user;   /* who needs it, of what is not kept; -1 of what is */
    int32_t *needed; /* as which of the partial derivatives: 2 user + operand */
    double *gain;    /* 1 of what is kept */

    Strand *strand; /* in the order of the nodes that they lead to */
    double *slope;  /* of each edge */
    Edges edges[N_WAY];
    int64_t n, n_strands, n_edges;

    double (*rate)[GRAPH_LANES];
    bool *moves; /* whether any of a node's rates is not 0 */
    bool *has_seed;
    int32_t *seeded;
    int64_t n_seeded;
};

int graph_operands(const Operation *o, int32_t operand[2])
{
    operand[0] = o->a;
    operand[1] = o->b;

    switch (o->op) {
        case TAPE_SELECT:
            operand[0] = o->b;
            operand[1] = o->c;
            return 2;
        case TAPE_ADD:
        case TAPE_SUBTRACT:
        case TAPE_MULTIPLY:
        case TAPE_DIVIDE:
        case TAPE_MINIMUM:
        case TAPE_MAXIMUM:
        case TAPE_ATAN2:
        case TAPE_POW:      return 2;
        case TAPE_CONSTANT:
        case TAPE_LEAF:
        case TAPE_LOAD:
        case TAPE_INTERVAL:
        case TAPE_NOT:
        case TAPE_ISFINITE:
        case TAPE_LESS:
        case TAPE_NOT_MORE:
        case TAPE_EQUAL:
        case TAPE_UNEQUAL:
        case TAPE_WHOLE:
        case TAPE_FLOOR:
        case TAPE_STILL:
        case TAPE_SOLVE:
        case TAPE_FOUND:    return 0;
        default:            return 1;
    }
}

void graph_free(Graph *g)
{
    if (!g) return;
    free(g->node);
    free(g->user);
    free(g->needed);
    free(g->gain);
    free(g->strand);
    free(g->slope);
    for (int way = 0; way < N_WAY; way++) {
        free(g->edges[way].begins);
        free(g->edges[way].other);
        free(g->edges[way].edge);
    }
    free(g->rate);
    free(g->moves);
    free(g->has_seed);
    free(g->seeded);
    free(g);
}

/* What there is of each operation. */
static bool allocate(Graph *g, size_t n)
{
    g->node = malloc(n * sizeof *g->node);
    g->user = malloc(n * sizeof *g->user);
    g->needed = malloc(n * sizeof *g->needed);
    g->gain = malloc(n * sizeof *g->gain);
    g->strand = malloc(2 * n * sizeof *g->strand);
    return g->node && g->user && g->needed && g->gain && g->strand;
}

/* What there is of each node. */
static bool allocate_nodes(Graph *g)
{
    size_t n = (size_t)g->n + 1;
    bool complete = true;

    for (int way = 0; way < N_WAY; way++) {
        g->edges[way].begins = calloc(n, sizeof *g->edges[way].begins);
        complete = complete && g->edges[way].begins;
    }
    g->rate = malloc(n * sizeof *g->rate);
    g->moves = calloc(n, sizeof *g->moves);
    g->has_seed = calloc(n, sizeof *g->has_seed);
    g->seeded = malloc(n * sizeof *g->seeded);
    return complete && g->rate && g->moves && g->has_seed && g->seeded;
}

static bool allocate_edges(Graph *g)
{
    size_t n = (size_t)g->n_edges + 1;
    bool complete = true;

    for (int way = 0; way < N_WAY; way++) {
        g->edges[way].other = malloc(n * sizeof *g->edges[way].other);
        g->edges[way].edge = malloc(n * sizeof *g->edges[way].edge);
        complete = complete && g->edges[way].other && g->edges[way].edge;
    }
    g->slope = malloc(n * sizeof *g->slope);
    return complete && g->slope;
}

/* Which operations are kept: results, what is asked for by its own, and what several need or nobody. */
static void choose_nodes(Graph *g)
{
    enum { NOBODY = -2, KEPT = -1 };
    const Resource *r = g->r;

    for (int64_t k = 0; k < r->n.operations; k++) {
        const Operation *o = &r->operations[k];
        int32_t operand[2];
        int n = graph_operands(o, operand);
        bool compares = o->op == TAPE_EQUAL || o->op == TAPE_UNEQUAL;
        bool apart = compares || o->op == TAPE_LED || o->op == TAPE_SELECT;
        bool is_kept = apart || o->op == TAPE_CONSTANT || o->op == TAPE_LEAF;

        g->user[k] = is_kept ? KEPT : NOBODY;
        for (int i = 0; i < (compares ? 2 : n); i++) {
            int32_t *user = &g->user[operand[i]];
            *user = apart || *user != NOBODY ? KEPT : (int32_t)k;
            g->needed[operand[i]] = (int32_t)(2 * k + i);
        }
    }
    for (int64_t i = 0; i < r->n.results; i++) g->user[r->results[i]] = KEPT;
    for (int64_t k = 0; k < r->n.operations; k++) {
        if (g->user[k] == NOBODY) g->user[k] = KEPT;
        g->node[k] = g->user[k] < 0 ? (int32_t)g->n++ : -1;
    }
}

/* From how often each node is met, to where what is its own ends; returns how many in all. Placed from
   the last to the first, they end up where what is its own begins. */
static int64_t add_up(int64_t count[], int64_t n)
{
    int64_t sum = 0;

    for (int64_t k = 0; k < n; k++) count[k] = sum += count[k];
    return count[n] = sum;
}

/* The strands of all operations, by the nodes that they lead to; false when there is no memory. */
static bool lay_strands(Graph *g)
{
    const Resource *r = g->r;
    int32_t *root = malloc(((size_t)r->n.operations + 1) * sizeof *root);
    int64_t *begins = g->edges[BY_SEEDS].begins;

    if (!root) return false;
    for (int64_t k = r->n.operations - 1; k >= 0; k--)
        root[k] = g->user[k] < 0 ? g->node[k] : root[g->user[k]];

    for (int pass = 0; pass < 2; pass++) {
        for (int64_t k = r->n.operations - 1; k >= 0; k--) {
            int32_t operand[2];

            for (int i = graph_operands(&r->operations[k], operand) - 1; i >= 0; i--) {
                int32_t source = g->node[operand[i]];
                bool is_constant = r->operations[operand[i]].op == TAPE_CONSTANT;

                if (source < 0 || is_constant) continue;
                if (pass == 0)
                    begins[root[k]]++;
                else
                    g->strand[--begins[root[k]]] = (Strand){source, (int32_t)k, 0, i};
            }
        }
        if (pass == 0) g->n_strands = add_up(begins, g->n);
    }
    free(root);
    return true;
}

/* Strands between the same two nodes are one edge; false when there is no memory. */
static bool join(Graph *g)
{
    int64_t *begins = g->edges[BY_SEEDS].begins, begin = 0;
    int32_t *last = malloc(((size_t)g->n + 1) * sizeof *last); /* edge from each node */

    if (!last) return false;
    for (int64_t k = 0; k < g->n; k++) last[k] = -1;
    for (int64_t k = 0; k < g->n; k++) {
        int64_t first = g->n_edges;

        for (int64_t i = begin; i < begins[k + 1]; i++) {
            Strand *s = &g->strand[i];
            if (last[s->source] < first) last[s->source] = (int32_t)g->n_edges++;
            s->edge = last[s->source];
        }
        begin = begins[k + 1];
        begins[k] = first;
    }
    begins[g->n] = g->n_edges;
    free(last);
    return true;
}

/* The edges of each node both ways. */
static void list_edges(Graph *g)
{
    Edges *forward = &g->edges[BY_SEEDS], *backward = &g->edges[BY_RESULTS];

    for (int64_t i = 0; i < g->n_strands; i++) {
        int32_t edge = g->strand[i].edge;
        forward->other[edge] = g->strand[i].source;
        forward->edge[edge] = edge;
    }
    for (int64_t i = 0; i < g->n_edges; i++) backward->begins[forward->other[i]]++;
    add_up(backward->begins, g->n);
    for (int64_t k = g->n - 1; k >= 0; k--)
        for (int64_t i = forward->begins[k + 1] - 1; i >= forward->begins[k]; i--) {
            int64_t place = --backward->begins[forward->other[i]];
            backward->other[place] = (int32_t)k;
            backward->edge[place] = (int32_t)i;
        }
}

Graph *graph_create(const Resource *r)
{
    Graph *g = calloc(1, sizeof *g);

    if (!g) return NULL;
    g->r = r;
    if (allocate(g, (size_t)r->n.operations + 1)) {
        choose_nodes(g);
        if (allocate_nodes(g) && lay_strands(g) && join(g) && allocate_edges(g)) {
            list_edges(g);
            return g;
        }
    }
    graph_free(g);
    return NULL;
}

void graph_weigh(Graph *g, const double partial[])
{
    for (int64_t k = g->r->n.operations - 1; k >= 0; k--)
        g->gain[k] = g->user[k] < 0 ? 1 : g->gain[g->user[k]] * partial[g->needed[k]];
    memset(g->slope, 0, (size_t)g->n_edges * sizeof *g->slope);
    for (int64_t i = 0; i < g->n_strands; i++) {
        const Strand *s = &g->strand[i];
        g->slope[s->edge] += g->gain[s->op] * partial[2 * (int64_t)s->op + s->operand];
    }
}

int32_t graph_node(const Graph *g, int64_t operation)
{
    return g->node[operation];
}

int64_t graph_n_sources(const Graph *g, int32_t node)
{
    const int64_t *begins = g->edges[BY_SEEDS].begins;

    return begins[node + 1] - begins[node];
}

int32_t graph_only_source(const Graph *g, int32_t node)
{
    const Edges *edges = &g->edges[BY_SEEDS];

    return graph_n_sources(g, node) == 1 ? edges->other[edges->begins[node]] : -1;
}

double graph_only_slope(const Graph *g, int32_t node)
{
    return g->slope[g->edges[BY_SEEDS].begins[node]];
}

/* ---- rates ---- */

void graph_rest(Graph *g)
{
    for (int64_t i = 0; i < g->n_seeded; i++) g->has_seed[g->seeded[i]] = false;
    g->n_seeded = 0;
}

void graph_add_seed(Graph *g, int32_t node, int lane, double seed)
{
    if (!g->has_seed[node]) {
        g->has_seed[node] = true;
        g->seeded[g->n_seeded++] = node;
        memset(g->rate[node], 0, sizeof *g->rate);
    }
    g->rate[node][lane] += seed;
}

/* Adds a part of a rate to another. */
static void add(double *restrict to, double slope, const double *restrict rate)
{
    for (int i = 0; i < GRAPH_LANES; i++) to[i] += slope * rate[i];
}

/* The rate of a node: its seed, and what comes by its edges. What is not moved is not looked at, so that
   no infinite slope meets a 0. */
static void follow(Graph *g, const Edges *edges, int64_t k)
{
    double rate[GRAPH_LANES] = {0};
    bool moves = g->has_seed[k];

    if (moves) memcpy(rate, g->rate[k], sizeof rate);
    for (int64_t i = edges->begins[k]; i < edges->begins[k + 1]; i++) {
        int32_t other = edges->other[i];
        double slope = g->slope[edges->edge[i]];
        if (!g->moves[other] || slope == 0) continue;
        moves = true;
        add(rate, slope, g->rate[other]);
    }
    g->moves[k] = moves;
    if (moves) memcpy(g->rate[k], rate, sizeof rate);
}

void graph_sweep(Graph *g, Way way)
{
    for (int64_t i = 0; i < g->n; i++)
        follow(g, &g->edges[way], way == BY_SEEDS ? i : g->n - 1 - i);
}

double graph_rate(const Graph *g, int32_t node, int lane)
{
    return g->moves[node] ? g->rate[node][lane] : 0;
}

const double *graph_rates(const Graph *g, int32_t node)
{
    return g->moves[node] ? g->rate[node] : NULL;
}
