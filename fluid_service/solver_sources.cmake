# Sources of the solvers that have a method: lattice Boltzmann (lattice/ to solver/) and Stokes flow.
set(FLUID_SOLVER_SOURCES
  bodies/body_map.cpp
  bodies/boundary_links.cpp
  bodies/momentum_exchange.cpp
  bodies/refill.cpp
  bodies/row_interval.cpp
  boundary/copy_runs.cpp
  boundary/domain.cpp
  boundary/ghost_exchange.cpp
  boundary/origin.cpp
  kernel/stream_collide_avx2.cpp
  kernel/stream_collide_baseline.cpp
  lattice/population_layout.cpp
  solver/field_schedule.cpp
  solver/checkpoint.cpp
  solver/lattice_boltzmann.cpp
  stokes/grand_mobility.cpp
  stokes/plane_images.cpp
  stokes/stokes_flow.cpp)

# One kernel source, one build per instruction set; the fastest that the machine has is chosen at start.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set_source_files_properties(kernel/stream_collide_avx2.cpp PROPERTIES COMPILE_OPTIONS -mavx2)
endif()
