"""What a random scene is made of, a file for each: frames, shapes, kinds of joints, mechanism, bodies,
motions, forces, outputs."""
