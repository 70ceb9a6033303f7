"""A scene's own code: the kernels run on symbolic scalars, and what they did is written out
(docs/specialise.md).

plain       the kernels as plain Python functions that compute with symbols
graph       operations, each once; what folds away
record      a run of a kernel on symbols: what it reads, what it writes, on what the branches that it took
depend searches    the few loops that end by values: each is one operation, and a C function of its own
derivatives of a graph, forward and reverse
c99, python, symbolic   a graph written out
functions   x' = f(t, x, u, p), outputs and their derivatives of a scene, to be called
equations   the same to be read
"""
