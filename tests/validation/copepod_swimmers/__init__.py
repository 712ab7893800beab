"""Theory of swimmers made of spheres, and figures that compare runs with it (docs/results/swimmers.md)."""
