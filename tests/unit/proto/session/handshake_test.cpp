#include <gtest/gtest.h>

#include "session/coupler_session.hpp"

namespace copepod::session {
namespace {

Hello hello_with(const VersionRange& versions, const std::string& token = "secret") {
  Hello hello;
  hello.versions = versions;
  hello.session_token = token;
  hello.host = "node7";
  return hello;
}

const HelloExpectation kExpectation{{1, 2, 4}, "secret", false};

TEST(Handshake, AgreesOnTheNewestMinorVersionThatBothSpeak) {
  EXPECT_EQ(judge_hello(hello_with({1, 0, 3}), kExpectation).minor, 3U);
  EXPECT_EQ(judge_hello(hello_with({1, 3, 9}), kExpectation).minor, 4U);
  EXPECT_EQ(judge_hello(hello_with({1, 0, 2}), kExpectation).minor, 2U);
}

TEST(Handshake, RefusesVersionsThatDoNotOverlapAndNamesBoth) {
  const HelloVerdict old = judge_hello(hello_with({1, 0, 1}), kExpectation);
  EXPECT_FALSE(old.accepted());
  EXPECT_FALSE(old.is_stranger);
  EXPECT_EQ(old.reason,
            "The fluid component on node7 was refused (it supports protocol 1.0 to 1.1, the coupler 1.2 to "
            "1.4). Build both "
            "from the same release.");
  EXPECT_NE(judge_hello(hello_with({0, 0, 9}), kExpectation).reason.find("docs/moving_to_a_newer_kit.md"),
            std::string::npos);
  EXPECT_FALSE(judge_hello(hello_with({2, 0, 9}), kExpectation).accepted());
  EXPECT_FALSE(judge_hello(hello_with({1, 5, 9}), kExpectation).accepted());
}

TEST(Handshake, RefusesAnotherToken) {
  for (const std::string& token :
       {std::string(), std::string("secre"), std::string("secret1"), std::string("Secret")}) {
    const HelloVerdict verdict = judge_hello(hello_with({1, 2, 4}, token), kExpectation);
    EXPECT_FALSE(verdict.accepted()) << token;
    EXPECT_TRUE(verdict.is_stranger);
    EXPECT_EQ(verdict.reason.find("protocol"), std::string::npos) << "a stranger learns nothing about us";
  }
}

TEST(Handshake, RefusesASecondComponentOfOneRole) {
  HelloExpectation taken = kExpectation;
  taken.role_taken = true;
  const HelloVerdict verdict = judge_hello(hello_with({1, 2, 4}), taken);
  EXPECT_FALSE(verdict.accepted());
  EXPECT_NE(verdict.reason.find("already takes part"), std::string::npos);
}

}  // namespace
}  // namespace copepod::session
