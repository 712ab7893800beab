#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "remote/link.hpp"

namespace copepod::coupler {
namespace {

/// Keeps what is sent, to whom.
class SentMessages : public transport::Router {
 public:
  bool receive(transport::Frame& /*frame*/, transport::Duration /*wait*/) override { return false; }
  bool send(const std::string& peer, transport::Bytes bytes) override {
    answers.emplace_back(peer, decoder_.parse(bytes));
    return true;
  }
  bool connected(const std::string& /*peer*/) override { return true; }

  std::vector<std::pair<std::string, session::MessageKind>> answers;

 private:
  conversion::Decoder decoder_;
};

class Applicant {
 public:
  Applicant(session::Lane lane, std::string identity, session::Hello hello = {}) : identity_(std::move(identity)) {
    hello.lane = lane;
    hello.session_token = "token";
    bytes_ = encoder_.encode(session::Header{}, hello);
    peer_ = lane == session::Lane::data ? "data" : "control";
  }

  [[nodiscard]] transport::Frame hello() const { return {peer_, identity_, bytes_}; }

 private:
  std::string peer_, identity_;
  conversion::Encoder encoder_;
  transport::Bytes bytes_;
};

/// The Hellos of the two lanes come in any order; the component reads its Refusal on the data lane.
TEST(Handshake, EndsTheRunOnlyAfterTheRefusalOnTheDataLane) {
  SentMessages sent;
  Parties parties({});
  Handshake handshake(sent, parties, "token");
  EXPECT_NO_THROW(handshake.handle(Applicant(session::Lane::control, "body").hello(), 0));
  EXPECT_THROW(handshake.handle(Applicant(session::Lane::data, "body").hello(), 0), Refused);
  const std::vector<std::pair<std::string, session::MessageKind>> expected = {
      {"control", session::MessageKind::refusal}, {"data", session::MessageKind::refusal}};
  EXPECT_EQ(sent.answers, expected);
}

TEST(Handshake, AdmitsAComponentOnceBothLanesHaveAsked) {
  SentMessages sent;
  Parties parties({});
  Handshake handshake(sent, parties, "token");
  handshake.handle(Applicant(session::Lane::control, "fluid").hello(), 0);
  EXPECT_FALSE(parties[0].is_complete());
  handshake.handle(Applicant(session::Lane::data, "fluid").hello(), 0);
  EXPECT_TRUE(parties[0].is_complete());
}

TEST(Handshake, AdmitsTheControllersOfTheCaseByTheirNames) {
  SentMessages sent;
  Parties parties({"pilot", "brake"});
  Handshake handshake(sent, parties, "token");
  const auto hello_of = [](const char* name) {
    session::Hello hello;
    hello.role = session::Role::controller;
    hello.name = name;
    return hello;
  };
  EXPECT_EQ(parties.missing(), "fluid and body and pilot and brake");
  for (const session::Lane lane : {session::Lane::control, session::Lane::data})
    EXPECT_EQ(handshake.handle(Applicant(lane, "brake", hello_of("brake")).hello(), 0), "");
  EXPECT_EQ(parties.missing(), "fluid and body and pilot");
  const std::string refused = handshake.handle(Applicant(session::Lane::data, "", hello_of("pirate")).hello(), 0);
  EXPECT_NE(refused.find("no controller of that name"), std::string::npos) << refused;
  EXPECT_THROW(handshake.handle(Applicant(session::Lane::data, "brake", hello_of("pilot")).hello(), 0), Refused);
}

}  // namespace
}  // namespace copepod::coupler
