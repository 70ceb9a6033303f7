"""Coefficients of floating bodies from files, the memory of waves made of them, and the waves of a sea."""
