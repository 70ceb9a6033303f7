"""Steppers: what integrates the state over a communication step."""
