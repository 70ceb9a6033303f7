"""Kernels as a program in C99: the statements of the kernels that a scene needs, branches that it never takes
left out.

A trace (`record`) is a straight line of operations, which a stepper, whose loops end by values, is not. Here
the kernels' own text is translated, function by function, with the scene's structure known: counts are
numbers, a loop over nothing and the branch of a joint kind that is not there are gone, and what is called by
no one is not written.

shapes     what an expression is: a number and the whole numbers that it may be, an array, a tuple
types      tuples and tables of numbers as C declares them
expressions, statements   the text of one kernel
layout_c   statements laid out: where variables are declared, what is never read
functions  all kernels that are called, until nothing more becomes known of any
"""
