/* The Jacobian by columns: derivatives of all outputs, or of all rates, by one known. Each is found when
   it is first asked for, and kept until the instance changes. */
#ifndef MBDFMI_COLUMNS_H
#define MBDFMI_COLUMNS_H

#include "instance.h"

/* Unknowns: outputs; rates of the states; what stands in the state and follows from parameters, of which
   nothing is kept. */
typedef enum { OUTPUTS, RATES, N_PART, PREPARED = N_PART, N_PART_ALL } Part;

/* The column of a known, by places in y or x', for reading until the instance changes; NULL, and
   `result` says why. */
const double *columns_get(Instance *c, uint32_t known, Part part, Status *result);

/* Whether columns_get would give it at once. */
bool columns_has(const Instance *c, uint32_t known, Part part);

/* Adds to sum[] the derivatives of a part along `seed`, from evaluations along it alone. How often that
   was done since the instance changed is counted in *columns_asked. */
Status columns_add_along(Instance *c, const uint32_t known[], size_t n, const double seed[],
                         Part part, double sum[]);

size_t *columns_asked(Instance *c);

/* The number of a part's unknowns. */
size_t columns_height(const Instance *c, Part part);

void columns_free(Instance *c);

#endif
