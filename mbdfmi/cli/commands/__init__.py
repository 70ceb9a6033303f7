"""The commands, a file for each: `add` makes its part of the parser, `run` does what it says."""
