#include <gtest/gtest.h>

#include "conversion/codec.hpp"
#include "conversion/limits.hpp"
#include "copepod/v1/setup.pb.h"
#include "samples.hpp"

namespace copepod::conversion {
namespace {

/// Every field of the message differs from what a message without fields would give.
void expect_every_field_set(const google::protobuf::Message& message) {
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const auto& field = *message.GetDescriptor()->field(i);
    EXPECT_TRUE(field.is_repeated() ? message.GetReflection()->FieldSize(message, &field) > 0
                                    : message.GetReflection()->HasField(message, &field))
        << field.full_name();
  }
}

TEST(SetupBytes, HoldEveryFieldAndReadBackToTheSameBytes) {
  FluidSetup fluid = sample_fluid_setup();
  fluid.trace_directory = "/trace";
  fluid.obstacles = {{"rock", sample_shape(), {1e-6, 2e-6, 1.0 / 3}, {0, 0.6, 0, 0.8}}};
  v1::FluidSetup fluid_wire;
  ASSERT_TRUE(fluid_wire.ParseFromString(to_bytes(fluid)));
  expect_every_field_set(fluid_wire);
  EXPECT_EQ(to_bytes(fluid_setup_from_bytes(to_bytes(fluid))), to_bytes(fluid));
  BodySetup body = sample_body_setup();
  body.threads = 3;
  body.bodies[1].shape = sample_shape();
  body.bodies[1].inertia_kg_m2 = {2e-25, 2.1e-25, 2.2e-25, 1e-26, 2e-26, 1.0 / 3};
  body.trace_directory = "/trace";
  v1::BodySetup body_wire;
  ASSERT_TRUE(body_wire.ParseFromString(to_bytes(body)));
  expect_every_field_set(body_wire);
  EXPECT_EQ(to_bytes(body_setup_from_bytes(to_bytes(body))), to_bytes(body));
}

TEST(SetupBytes, OfAnotherMessageAreRefused) {
  EXPECT_THROW(fluid_setup_from_bytes("not a setup"), MalformedMessage);
  EXPECT_THROW(fluid_setup_from_bytes(""), MalformedMessage);
  EXPECT_THROW(body_setup_from_bytes(to_bytes(sample_fluid_setup())), MalformedMessage);
}

}  // namespace
}  // namespace copepod::conversion
