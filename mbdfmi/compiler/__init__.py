"""From the parts of a scene to the rows of a model's tables: a module for each kind of part."""
