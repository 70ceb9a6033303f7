"""Lines of the package broken one at a time, and which of them no test notices:
`python -m tests.mutants --help`.

A mutant is one small change of one place: a sign, an index, a transposed matrix, two arguments swapped, a key
ignored. The places are found in the syntax tree (`operators`) and drawn by a seed (`draw`). Each mutant lives
in a private copy of the package with kernels run as plain Python; the quick tests that reach its place
(`reach`) run against it, the quickest first, until one fails. What no test notices is a survivor: a test is
missing there, or the mutant changes nothing that could be told (`equivalent` argues these one by one), or the
place is dead.

`undone` is a list of mendings, each to be undone by itself: the referee has to notice every one.
"""
