#include "contract/words.hpp"

#include <gtest/gtest.h>

namespace copepod {
namespace {

TEST(NearestWord, IsTheWordThatWasMeant) {
  EXPECT_EQ(nearest_word("radius", {"mass_kg", "radius_m"}), "radius_m");
  EXPECT_EQ(nearest_word("mass_g", {"mass_kg", "radius_m"}), "mass_kg");
  EXPECT_EQ(nearest_word("length_um", {"length_m", "mass_kg"}), "length_m");
  EXPECT_EQ(nearest_word("spheroid", {"sphere", "capsule"}), "");
  EXPECT_EQ(nearest_word("colour", {"mass_kg", "radius_m"}), "");
}

TEST(Words, NameTheContractsEnumerators) {
  EXPECT_STREQ(name_of(boundary_names, BoundaryKind::free_slip), "free_slip");
  EXPECT_STREQ(name_of(plane_names, -1), "none");
}

}  // namespace
}  // namespace copepod
