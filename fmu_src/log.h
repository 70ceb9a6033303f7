/* What a call comes to, and the log. Nothing here, nor in what stands on it, knows FMI: fmi2.c and fmi3.c
   turn both into what a master of their version expects. */
#ifndef MBDFMI_LOG_H
#define MBDFMI_LOG_H

#include <stdbool.h>
#include <stddef.h>

#include "layout.h" /* the categories */

typedef enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR, STATUS_FATAL } Status;

#define LONGEST_MESSAGE 1024 /* bytes of a text, its NUL included */

typedef struct Log {
    /* hands a text to the master; NULL when nobody listens */
    void (*send)(const struct Log *log, Status status, const char *category, const char *text);
    void (*logger)(void); /* the master's function, of a type that `send` knows */
    void *environment;    /* what the master wants to hear with it */
    char *name;           /* of the instance */
    bool logged[N_CATEGORY];
    bool is_sending; /* a message is with the master, whose logger may call back */
} Log;

/* Sends a text and returns `status`, so that a refusal is one line. Warnings and errors are always
   sent, the rest when its category is switched on. */
Status log_tell(Log *log, Status status, const char *format, ...);

/* Switches categories on or off, all when n is 0; NULL, or the first of the names that is none: then
   nothing has changed. */
const char *log_choose(Log *log, bool on, size_t n, const char *const names[]);

#endif
