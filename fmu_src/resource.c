#include "resource.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "crc32.h"
#include "kernels.h"
#include "sha256.h"
#include "survey.h"
#include "tape.h"

#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#endif

#define N_SIZES   (sizeof(Sizes) / sizeof(int64_t))
#define MAX_COUNT (INT64_C(1) << 24) /* of any array: far beyond any model */

/* Bytes of a path that systems commonly take. */
#ifdef _WIN32
#define LONGEST_PATH 259
#else
#define LONGEST_PATH 4095
#endif

#define SHOWN 400 /* of it in messages */

/* The head of the file, as it lies there. */
typedef struct {
    char magic[sizeof RESOURCE_MAGIC - 1];
    uint32_t version, crc;
    uint64_t length;
} Head;

/* What its length and checksum are of begins with this. */
typedef struct {
    int64_t size[N_SIZES];
    char guid[GUID_SIZE];
} Start;

static bool fail(char *why, size_t why_size, const char *format, ...)
{
    va_list args;

    va_start(args, format);
    vsnprintf(why, why_size, format, args);
    va_end(args);
    return false;
}

/* fopen for reading, of a UTF-8 path on every platform */
static FILE *open_file(const char *path)
{
#ifdef _WIN32
    FILE *file = NULL;
    int n = MultiByteToWideChar(CP_UTF8, 0, path, -1, NULL, 0);
    wchar_t *wide = n > 0 ? malloc(n * sizeof *wide) : NULL;

    if (wide && MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, n) > 0) file = _wfopen(wide, L"rb");
    free(wide);
    return file;
#else
    return fopen(path, "rb");
#endif
}

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

static bool starts_with(const char *text, const char *start)
{
    for (; *start; text++, start++)
        if (tolower((unsigned char)*text) != *start) return false;
    return true;
}

static bool is_separator(char c)
{
#ifdef _WIN32
    if (c == '\\') return true;
#endif
    return c == '/';
}

/* The path of the resource file, to be freed; NULL and `why` on failure. */
static char *file_path(const char *location, char *why, size_t why_size)
{
    bool uri = starts_with(location, "file:");
    const char *from = uri ? location + 5 : location;

    if (!uri && strstr(location, "://")) {
        fail(why, why_size, "the resource location '%s' is not a file: URI", location);
        return NULL;
    }

    /* the authority: none, localhost, or (on Windows) the drive that some tools write there, or the
       host of a share */
    if (uri && starts_with(from, "//localhost/"))
        from += 11;
    else if (uri && starts_with(from, "///"))
        from += 2;
#ifdef _WIN32
    else if (uri && starts_with(from, "//") && isalpha((unsigned char)from[2]) && from[3] == ':')
        from += 2;
#else
    else if (uri && starts_with(from, "//")) {
        fail(why, why_size, "the resource location '%s' names another host", location);
        return NULL;
    }
#endif

    char *path = malloc(strlen(from) + sizeof "/" RESOURCE_NAME);
    if (!path) {
        fail(why, why_size, "out of memory");
        return NULL;
    }

    char *to = path;
    while (*from) {
        int high = uri && from[0] == '%' ? hex_digit(from[1]) : -1;
        int low = high >= 0 ? hex_digit(from[2]) : -1;

        if (low == 0 && high == 0) {
            fail(why, why_size, "the resource location '%s' holds a %%00", location);
            free(path);
            return NULL;
        }
        if (low >= 0) {
            *to++ = (char)(16 * high + low);
            from += 3;
        } else
            *to++ = *from++;
    }
    *to = '\0';

#ifdef _WIN32
    /* /C:/folder -> C:/folder */
    if (path[0] == '/' && isalpha((unsigned char)path[1]) && path[2] == ':')
        memmove(path, path + 1, strlen(path));
#endif

    size_t n = strlen(path);
    if (n > 0 && !is_separator(path[n - 1])) path[n++] = '/';
    memcpy(path + n, RESOURCE_NAME, sizeof RESOURCE_NAME);
    return path;
}

/* Takes n strings from *text on; false when the data end before. */
static bool take_strings(const char **strings, int64_t n, const char **text, const char *end)
{
    for (int64_t i = 0; i < n; i++) {
        const char *stop = memchr(*text, '\0', (size_t)(end - *text));
        if (!stop) return false;
        strings[i] = *text;
        *text = stop + 1;
    }
    return true;
}

/* Reads the checked contents of the file into r->data. */
static bool read_data(Resource *r, FILE *file, size_t *length, char *why, size_t why_size)
{
    Head head;

    if (fread(&head, sizeof head, 1, file) != 1) return fail(why, why_size, "it is too short");
    if (memcmp(head.magic, RESOURCE_MAGIC, sizeof head.magic) != 0)
        return fail(why, why_size, "it is not a model of mbdfmi");
    if (head.version != RESOURCE_VERSION)
        return fail(why, why_size, "it has format %u, this library reads format %d",
                    (unsigned)head.version, RESOURCE_VERSION);

    /* the true length, before memory is asked for */
    long size = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    if (size < 0 || (uint64_t)size - sizeof head != head.length)
        return fail(why, why_size, "it has %ld bytes and should have %llu: truncated or damaged",
                    size, (unsigned long long)head.length + sizeof head);
    if (head.length < sizeof(Start)) return fail(why, why_size, "it is too short");

    *length = (size_t)head.length;
    r->data = malloc(*length);
    if (!r->data) return fail(why, why_size, "out of memory for %zu bytes", *length);
    if (fseek(file, sizeof head, SEEK_SET) != 0 || fread(r->data, 1, *length, file) != *length)
        return fail(why, why_size, "it cannot be read to its end");
    if (crc32_of(r->data, *length) != head.crc)
        return fail(why, why_size, "its checksum is wrong: damaged");
    return true;
}

/* Whether the GUID is that of the sizes and the numbers, `size` bytes with what stands behind them. */
static bool is_sealed(const Start *start, const unsigned char *numbers, size_t size)
{
    Sha256 s;
    unsigned char digest[SHA256_SIZE];
    char hex[2 * 16 + 1], guid[GUID_SIZE];

    sha256_start(&s);
    sha256_add(&s, start->size, N_SEALED * sizeof start->size[0]);
    sha256_add(&s, numbers, size);
    sha256_end(&s, digest);
    for (int i = 0; i < 16; i++) snprintf(hex + 2 * i, 3, "%02x", digest[i]);
    snprintf(guid, sizeof guid, "{%.8s-%.4s-%.4s-%.4s-%.12s}", hex, hex + 8, hex + 12, hex + 16,
             hex + 20);
    return strcmp(guid, start->guid) == 0;
}

#ifdef MBDFMI_ONE_SCENE

/* A library of one scene takes no file of another GUID, and this one's numbers were looked at as it was made. */
bool resource_is_arranged(const int64_t head[], const int64_t length[], char *why, size_t why_size)
{
    (void)head;
    (void)length;
    (void)why;
    (void)why_size;
    return true;
}

#else

bool resource_is_arranged(const int64_t head[], const int64_t length[], char *why, size_t why_size)
{
    for (int k = N_COUNT; k < HEADER_LENGTH; k++) {
        const Array *array = &ARRAYS[k - N_COUNT];
        int64_t count = array->count == ONCE ? 1 : head[array->count];
        int64_t room = length[array->buffer], at = head[k];

        if (count < 0 || count > MAX_COUNT || at < 0 || at > room
            || array->width * count > room - at)
            return fail(why, why_size, "its array '%s' lies outside its buffer", array->name);
    }
    return true;
}

#endif

/* Whether all arrays lie in their buffers. */
static bool is_arranged(const Resource *r, char *why, size_t why_size)
{
    const int64_t length[N_BUFFER] = {
        [IN_INTS] = r->n.ints,
        [IN_REALS] = r->n.reals,
        [IN_STATE] = r->n.state,
        [IN_WORK] = r->n.work,
    };

    if (r->n.ints < HEADER_LENGTH || r->ints[COUNT_n_u] != r->n.u || r->ints[COUNT_n_y] != r->n.y)
        return fail(why, why_size, "its sizes do not agree with those of its arrays");

    return resource_is_arranged(r->ints, length, why, why_size);
}

/* Whether all variables lie in their buffers. */
static bool are_variables_good(const Resource *r, char *why, size_t why_size)
{
    const int64_t room[N_KIND] = {
        [VARIABLE_INPUT] = r->n.u,
        [VARIABLE_OUTPUT] = r->n.y,
        [VARIABLE_FIXED] = r->n.reals,
        [VARIABLE_TUNABLE] = r->n.reals,
        [VARIABLE_CONSTANT] = r->n.reals,
        [VARIABLE_STATE] = r->ints[COUNT_n_x],
        [VARIABLE_RATE] = r->ints[COUNT_n_x],
        [VARIABLE_INDICATOR] = 2 * (r->ints[COUNT_n_stop] + r->survey[SURVEY_WATCHED].n_y),
        [VARIABLE_LOCAL] = r->survey[SURVEY_MOTION].n_y + r->survey[SURVEY_EFFORTS].n_y,
    };
    int64_t states = 0, indicators = 0;

    for (int64_t i = 0; i < r->n.variables; i++) {
        const Variable *v = &r->variables[i];

        if (v->kind < 0 || v->kind >= N_KIND)
            return fail(why, why_size, "its variable '%s' is of no kind that is known",
                        r->names[i]);
        if (v->index < 0 || v->index >= room[v->kind])
            return fail(why, why_size, "its variable '%s' lies outside its buffer", r->names[i]);
        if (v->length < 0 || v->length > r->n.variables - i)
            return fail(why, why_size, "its array '%s' lies outside the variables", r->names[i]);
        if (v->kind == VARIABLE_STATE && states > 0 && r->variables[i - 1].kind != VARIABLE_STATE)
            return fail(why, why_size, "its variable '%s' lies outside the states", r->names[i]);
        states += v->kind == VARIABLE_STATE;
        indicators += v->kind == VARIABLE_INDICATOR;
    }
    if (indicators > room[VARIABLE_INDICATOR])
        return fail(why, why_size, "it has more indicators of events than it should");
    return true;
}

/* Takes the start at rest from `data` on; false when it is none. */
static bool take_rest(Resource *r, const unsigned char *data)
{
    r->rest = (const double *)data;
    r->rest_rates = r->rest + r->n.rest;
    if (r->n.rest != 0 && r->n.rest != r->ints[COUNT_n_x]) return false;
    if (r->n.rests > (r->n.rest > 0)) return false;
    for (int64_t i = 0; i < 2 * r->n.rest; i++)
        if (!isfinite(r->rest[i])) return false;
    return true;
}

/* Sets the pointers into r->data, trusting no size in it. */
static bool take_apart(Resource *r, size_t length, char *why, size_t why_size)
{
    Start start;

    memcpy(&start, r->data, sizeof start);
    for (size_t i = 0; i < N_SIZES; i++)
        if (start.size[i] < 0 || start.size[i] > MAX_COUNT)
            return fail(why, why_size, "it has an impossible size");
    if (start.guid[GUID_SIZE - 1] != '\0') return fail(why, why_size, "its GUID is too long");
    memcpy(&r->n, start.size, sizeof r->n);
    memcpy(r->guid, start.guid, GUID_SIZE);

    /* numbers: 8 bytes each; strings: at least their NUL */
    int64_t per_variable = sizeof(Variable) / 8;
    int64_t n_numbers = r->n.ints + r->n.reals + r->n.u + per_variable * r->n.variables
                        + r->n.survey_ints + r->n.survey_reals;
    int64_t n_strings = r->n.variables + r->n.places + 2 * r->n.messages + r->n.notices;
    int64_t room = (int64_t)(length - sizeof start) - SHA256_SIZE;

    room -= tape_size(&r->n) + 16 * r->n.rest;
    if (n_numbers > room / 8 || n_strings > room - 8 * n_numbers)
        return fail(why, why_size, "its sizes do not agree with its length");

    const unsigned char *data = r->data + sizeof start;
    r->ints = (const int64_t *)data;
    r->reals = (const double *)(r->ints + r->n.ints);
    r->u_start = r->reals + r->n.reals;
    r->variables = (const Variable *)(r->u_start + r->n.u);
    r->survey_ints = (const int64_t *)(r->variables + r->n.variables);
    r->survey_reals = (const double *)(r->survey_ints + r->n.survey_ints);

    if (!is_sealed(&start, data, (size_t)(8 * n_numbers + SHA256_SIZE)))
        return fail(why, why_size, "its contents are not those that its GUID was made of");
    if (!is_arranged(r, why, why_size) || !survey_take(r, why, why_size)) return false;

    const unsigned char *tape =
        (const unsigned char *)(r->survey_reals + r->n.survey_reals) + SHA256_SIZE;

    if (!tape_take(r, tape)) return fail(why, why_size, "its tape is damaged");

    if (!take_rest(r, tape + tape_size(&r->n)))
        return fail(why, why_size, "its start at rest is damaged");

    const char *text = (const char *)(r->rest + 2 * r->n.rest);
    const char *end = (const char *)(r->data + length);

    r->names = malloc((size_t)(n_strings + 1) * sizeof *r->names);
    if (!r->names) return fail(why, why_size, "out of memory");
    r->places = r->names + r->n.variables;
    r->messages = r->places + r->n.places;
    r->notices = r->messages + 2 * r->n.messages;
    if (!take_strings(r->names, n_strings, &text, end) || text != end)
        return fail(why, why_size, "its names do not agree with its length");
    return are_variables_good(r, why, why_size);
}

/* A path as messages have it: of one that is too long for them both ends, in whole letters of UTF-8. */
static void shorten(const char *path, char shown[SHOWN + 1])
{
    size_t length = strlen(path), head = SHOWN / 2 - 3, tail = length - SHOWN / 2;

    if (length <= SHOWN) {
        memcpy(shown, path, length + 1);
        return;
    }
    while (head > 0 && ((unsigned char)path[head] & 0xC0) == 0x80) head--;
    while (path[tail] && ((unsigned char)path[tail] & 0xC0) == 0x80) tail++;
    memcpy(shown, path, head);
    memcpy(shown + head, "...", 3);
    memcpy(shown + head + 3, path + tail, length - tail + 1);
}

bool resource_read(Resource *r, const char *location, char *why, size_t why_size)
{
    char reason[256], shown[SHOWN + 1];
    size_t length = 0;
    char *path = file_path(location, why, why_size);
    FILE *file = path ? open_file(path) : NULL;

    memset(r, 0, sizeof *r);
    bool good = file && read_data(r, file, &length, reason, sizeof reason)
                && take_apart(r, length, reason, sizeof reason);

    if (path) shorten(path, shown);
    if (path && !file && strlen(path) > LONGEST_PATH)
        fail(why, why_size,
             "the resource file '%s' cannot be opened: its path is of %zu bytes, and this system "
             "takes "
             "%d; unpack the FMU in a folder nearer to the root",
             shown, strlen(path), LONGEST_PATH);
    else if (path && !file)
        fail(why, why_size, "the resource file '%s' cannot be opened", shown);
    else if (path && !good)
        fail(why, why_size, "the resource file '%s' is refused: %s", shown, reason);

    if (file) fclose(file);
    if (!good) resource_free(r);
    free(path);
    return good;
}

void resource_free(Resource *r)
{
    free(r->names);
    free(r->data);
    memset(r, 0, sizeof *r);
}

const char *resource_message(const Resource *r, int64_t code)
{
    for (int64_t i = 0; i < r->n.messages; i++)
        if (strtoll(r->messages[2 * i], NULL, 10) == code) return r->messages[2 * i + 1];
    return NULL;
}

const char *resource_place(const Resource *r, int64_t place)
{
    if (place >= 0 && place < r->n.places) return r->places[place];
    for (int64_t i = 0; i < r->n.variables; i++)
        if (r->variables[i].kind == VARIABLE_OUTPUT && r->variables[i].index == place - r->n.places)
            return r->names[i];
    return "?";
}
