"""Motion: poses and velocities of bodies and markers, joint coordinates, what is prescribed."""
