#pragma once

#include "contract/fluid_setup.hpp"

namespace copepod::fluid {

/// Calls archive(value) for every value of the setup, in a fixed order: the one description for packing,
/// unpacking and digests.
template <class Archive, class Setup>
void describe_physics(Archive& archive, Setup& setup) {
  archive(setup.kind);
  archive(setup.step_s);
  archive(setup.cell_size_m);
  archive(setup.density_kg_per_m3);
  archive(setup.kinematic_viscosity_m2_per_s);
  archive(setup.domain_cells);
  for (auto& boundary : setup.boundaries) {
    archive(boundary.kind);
    archive(boundary.velocity_m_per_s);
    archive(boundary.pressure_Pa);
  }
  archive(setup.no_slip_plane);
  archive(setup.symmetry_planes);
  archive(setup.body_force_N_per_m3);
  archive(setup.collision);
  archive(setup.moving_boundary);
  archive(setup.refill);
  archive(setup.precision);
  for (auto& shape : setup.bodies) {
    archive(shape.kind);
    archive(shape.radius_m);
    archive(shape.length_m);
  }
}

/// What is written beside the results.
template <class Archive, class Setup>
void describe_output(Archive& archive, Setup& setup) {
  auto& fields = setup.fields;
  archive(fields.directory);
  archive(fields.every_steps);
  archive(fields.mean_start);
  archive(fields.mean_stop);
  archive(fields.mean_every_steps);
  archive(setup.trace_directory);
}

}  // namespace copepod::fluid
