# Sources of the lattice Boltzmann solver: lattice/, kernel/, boundary/, bodies/ and solver/.
set(FLUID_SOLVER_SOURCES)
