/* Lists of outputs beside those of the model, evaluated when they are asked for alone: how joints and bodies move, what they
   bear, and what tables are over. A survey is a head of ints and arrays that stand behind the model's own in ints, reals and
   work: with these the kernel of the outputs writes what it lists.

   In the resource file: of each survey its four lengths; of each its ints, the head first; of each number of SURVEY_WATCHED
   how many kinks there are. Then reals: of each survey its own, and the kinks, those of each number in ascending order. */
#ifndef MBDFMI_SURVEY_H
#define MBDFMI_SURVEY_H

#include "instance.h"

/* Takes the surveys of a resource apart; false, and `why`, when they do not fit it. */
bool survey_take(Resource *r, char *why, size_t why_size);

/* What ints, reals and y take beside those of the model are made when they are first needed. */
Status survey_run(Instance *c, Surveyed which);

/* Brings a local up to date, by its index among all numbers of SURVEY_MOTION and SURVEY_EFFORTS. */
Status survey_local(Instance *c, int64_t index);

/* The room in work that the longest needs, and of all of y. */
int64_t survey_work(const Resource *r);
int64_t survey_y(const Resource *r);

/* Where the numbers of a survey are. */
double *survey_numbers(const Instance *c, Surveyed which);

void survey_free(Instance *c);

#endif
