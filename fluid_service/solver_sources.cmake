# Sources of the lattice Boltzmann solver: lattice/, kernel/, boundary/, bodies/ and solver/.
set(FLUID_SOLVER_SOURCES
  bodies/body_map.cpp
  bodies/boundary_links.cpp
  bodies/momentum_exchange.cpp
  bodies/refill.cpp
  boundary/copy_runs.cpp
  boundary/domain.cpp
  boundary/ghost_exchange.cpp
  kernel/stream_collide_avx2.cpp
  kernel/stream_collide_baseline.cpp
  solver/field_schedule.cpp
  solver/lattice_boltzmann.cpp)
set_source_files_properties(kernel/stream_collide_avx2.cpp PROPERTIES COMPILE_OPTIONS -mavx2)
