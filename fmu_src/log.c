#include "log.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static int category_of(Status status)
{
    switch (status) {
        case STATUS_WARNING: return LOG_STATUS_WARNING;
        case STATUS_DISCARD: return LOG_STATUS_DISCARD;
        case STATUS_ERROR:   return LOG_STATUS_ERROR;
        case STATUS_FATAL:   return LOG_STATUS_FATAL;
        default:             return LOG_EVENTS;
    }
}

Status log_tell(Log *log, Status status, const char *format, ...)
{
    int category = category_of(status);
    bool always = status == STATUS_WARNING || status == STATUS_ERROR || status == STATUS_FATAL;

    if (!log->send || log->is_sending || !(always || log->logged[LOG_ALL] || log->logged[category]))
        return status;

    char text[LONGEST_MESSAGE];
    va_list args;

    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    log->is_sending = true;
    log->send(log, status, CATEGORY_NAMES[category], text);
    log->is_sending = false;
    return status;
}

const char *log_choose(Log *log, bool on, size_t n, const char *const names[])
{
    bool logged[N_CATEGORY] = {false};

    for (size_t i = 0; i < n; i++) {
        const char *name = names[i] ? names[i] : "NULL";
        int k = 0;

        while (k < N_CATEGORY && strcmp(name, CATEGORY_NAMES[k]) != 0) k++;
        if (k == N_CATEGORY) return name;
        logged[k] = on;
    }
    if (n == 0) logged[LOG_ALL] = on;

    memcpy(log->logged, logged, sizeof logged);
    return NULL;
}
