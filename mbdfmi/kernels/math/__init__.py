"""Mathematics of the kernels: tuples, tables, small linear systems."""
