#include "session/orphanhood.hpp"

#include <gtest/gtest.h>

namespace copepod::session {
namespace {

TEST(Orphanhood, BeginsWhenPingsStayAway) {
  EXPECT_EQ(orphan_reason({100, -1}, {}, 110), "");
  EXPECT_NE(orphan_reason({100, -1}, {}, 110.1).find("silent"), std::string::npos);
}

TEST(Orphanhood, BeginsEarlierWhenTheConnectionIsBroken) {
  EXPECT_EQ(orphan_reason({100, 101}, {}, 103.9), "");
  EXPECT_NE(orphan_reason({100, 101}, {}, 104.1).find("gone"), std::string::npos);
}

}  // namespace
}  // namespace copepod::session
