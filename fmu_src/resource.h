/* The model that an instance is made of, read from resources/model.bin.

   The file, little endian:
     char magic[8] "mbdfmi\0\1"; uint32 version 3
     uint32 crc32 and uint64 length of all that follows
     int64 n_ints, n_reals, n_state, n_work, n_u, n_y, n_param, n_places, n_messages, n_notices
     char guid[64]
     int64 ints[n_ints]; double reals[n_reals]; double u_start[n_u]
     int64 param_index[n_param]; int64 param_tunable[n_param]
     unsigned char told[32]: a digest of what modelDescription.xml says of the variables
     NUL-terminated UTF-8: names of the n_u + n_y + n_param variables, n_places places, for each
     of the n_messages messages its code in decimal and its text, n_notices notices

   The GUID is the beginning of the SHA-256 of the first 7 sizes, the numbers and `told`. The kernels
   follow the indices in ints without looking: only what hashes to the GUID that the description has
   reaches them.
*/
#ifndef MBDFMI_RESOURCE_H
#define MBDFMI_RESOURCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define GUID_SIZE 64

typedef struct {
    int64_t n_ints, n_reals, n_state, n_work, n_u, n_y, n_param, n_places, n_messages, n_notices;
    char guid[GUID_SIZE]; /* NUL-padded, and NUL-terminated */

    const int64_t *ints;
    const double *reals;          /* start values of an instance's reals */
    const double *u_start;        /* start values of the inputs */
    const int64_t *param_index;   /* where in reals a parameter is */
    const int64_t *param_tunable; /* 1: may be set during the simulation */

    const char **names; /* of the variables, by value reference */
    const char **places;
    const char **messages; /* 2*n_messages: code, text, code, text ... */
    const char **notices;  /* what to warn of when an instance starts */

    unsigned char *data; /* owns what the pointers above point to */
} Resource;

/* Reads model.bin in the folder that the URI (file:/..., file:///..., percent-encoded) or plain
   path `location` names. On failure nothing is held and `why` explains. */
bool resource_read(Resource *r, const char *location, char *why, size_t why_size);

void resource_free(Resource *r);

/* the text of a status code, or NULL */
const char *resource_message(const Resource *r, int64_t code);

/* the name of the place of a status; the places are followed by the outputs */
const char *resource_place(const Resource *r, int64_t place);

#endif
