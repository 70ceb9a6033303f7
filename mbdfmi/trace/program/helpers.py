"""What C has no word for, as the compiled kernels do it."""

import re

_TEXT = """\
static inline double minimum(double a, double b)
{
    return b < a ? b : a;
}

static inline double maximum(double a, double b)
{
    return b > a ? b : a;
}

static inline int32_t whole_minimum(int32_t a, int32_t b)
{
    return b < a ? b : a;
}

static inline int32_t whole_maximum(int32_t a, int32_t b)
{
    return b > a ? b : a;
}

static inline int32_t whole_size(int32_t a)
{
    return a < 0 ? -a : a;
}

/* a / b, downwards */
static inline int32_t whole_quotient(int32_t a, int32_t b)
{
    return a / b - (a % b != 0 && (a < 0) != (b < 0));
}

/* what is left of that */
static inline int32_t whole_rest(int32_t a, int32_t b)
{
    return a % b + (a % b != 0 && (a < 0) != (b < 0) ? b : 0);
}

static inline double whole_power(double a, int32_t n)
{
    double result = 1.0;

    for (int32_t left = n < 0 ? -n : n; left > 0; left /= 2) {
        if (left % 2) result *= a;
        a *= a;
    }
    return n < 0 ? 1.0 / result : result;
}
"""

HELPERS = {
    re.search(r"(\w+)\(", text)[1]: text.strip()  # type: ignore[index]
    for text in re.split(r"(?<=^\})\n\n", _TEXT, flags=re.MULTILINE)
}
"""Functions in C by name."""
