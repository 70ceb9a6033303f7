"""What can be said of a model beyond a run: its freedoms and reactions, the efforts that a motion needs."""
