#pragma once

#include "config/sections/case.hpp"
#include "config/yaml/reader.hpp"

namespace copepod::coupler {

// One function per section of the case; each reads its keys and reports what it cannot use to the reader's
// problems.

FluidCase read_fluid(Reader fluid);
BodyCase read_body_solver(Reader body);
Shape read_shape(Reader& reader);
Swimmer read_swimmer(Reader swimmer);
BodySpecification read_body(Reader body);
NamedSpring read_spring(Reader spring);
NamedForce read_force(Reader force);
OutputCase read_output(Reader output);
ServicesCase read_services(Reader services);

/// Unit vector along the given direction; reports a zero vector.
Eigen::Vector3d read_direction(Reader& reader, const std::string& key, const Eigen::Vector3d& otherwise);

/// Reads the whole case from its root.
Case read_case(Reader top);

}  // namespace copepod::coupler
