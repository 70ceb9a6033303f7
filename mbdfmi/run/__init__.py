"""A model runs in process: instance, inputs over time, results."""
