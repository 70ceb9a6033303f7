/* Derivatives of a line of operations as a graph: its nodes are the operations that are kept, an edge leads
   to a node from one that it is made of, and has a slope. Rates of all nodes follow from seeds along the
   edges, several at once; against them the derivatives of what is seeded by all nodes do. */
#ifndef MBDFMI_GRAPH_H
#define MBDFMI_GRAPH_H

#include "resource.h"

/* Seeds at once. */
#define GRAPH_LANES 16

typedef struct Graph Graph;

/* Along the edges, from what is seeded to all that is made of it; or against them. */
typedef enum { BY_SEEDS, BY_RESULTS, N_WAY } Way;

/* NULL when there is no memory. */
Graph *graph_create(const Resource *r);

void graph_free(Graph *g);

/* The slopes, from the partial derivatives of each operation by its operands (graph_operands), two each. */
void graph_weigh(Graph *g, const double partial[]);

/* The operands that an operation has derivatives by, two at most; returns how many. */
int graph_operands(const Operation *o, int32_t operand[2]);

/* The node of an operation: results, leaves, what is compared, and what several need; else -1. */
int32_t graph_node(const Graph *g, int64_t operation);

/* How many edges lead to a node. */
int64_t graph_n_sources(const Graph *g, int32_t node);

/* Where the only edge comes from that leads to a node; -1 where there are none or several. Its slope. */
int32_t graph_only_source(const Graph *g, int32_t node);
double graph_only_slope(const Graph *g, int32_t node);

/* Nothing has a seed. */
void graph_rest(Graph *g);

void graph_add_seed(Graph *g, int32_t node, int lane, double seed);

void graph_sweep(Graph *g, Way way);

double graph_rate(const Graph *g, int32_t node, int lane);

/* All lanes of a node; NULL: all are 0. */
const double *graph_rates(const Graph *g, int32_t node);

#endif
