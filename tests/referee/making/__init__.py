"""What a random scene is made of, each a file: frames, shapes, kinds of joints, mechanism, bodies, motions, forces, what is told."""
