"""What only the paper's cases need in a report: families of designs, hydrodynamic radii, resonance in vacuum."""
