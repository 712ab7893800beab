#include <initializer_list>

#include <gtest/gtest.h>

#include "session/component_session.hpp"

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

TEST(Orphanhood, BeginsAnewWhenTheComponentWasSuspendedItself) {
  const auto looks_at = [](CouplerSigns signs, bool connected, std::initializer_list<double> times_s) {
    for (const double now_s : times_s) signs = on_look(signs, connected, {}, now_s);
    return signs;
  };
  const CouplerSigns signs{100, -1, 100};
  EXPECT_EQ(orphan_reason(looks_at(signs, true, {100.5, 112.5}), {}, 112.5), "") << "12 s of suspension";
  EXPECT_EQ(orphan_reason(looks_at(signs, false, {100.5, 112.5}), {}, 112.5), "");
  EXPECT_NE(orphan_reason(looks_at(signs, false, {100.5, 112.5, 113, 114, 115, 115.6}), {}, 115.6), "");
  CouplerSigns watchful = signs;
  for (double now_s = 100; now_s < 110.3; now_s += 0.1) watchful = on_look(watchful, true, {}, now_s);
  EXPECT_NE(orphan_reason(watchful, {}, 110.2), "");
}

}  // namespace
}  // namespace copepod::session
