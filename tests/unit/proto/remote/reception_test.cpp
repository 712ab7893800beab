#include "remote/reception.hpp"

#include <gtest/gtest.h>

#include "contract/errors.hpp"

namespace copepod::remote {
namespace {

/// Keeps what is sent, to whom.
class Door : public transport::Router {
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

class Visitor {
 public:
  Visitor(session::Lane lane, std::string identity) : identity_(std::move(identity)) {
    session::Hello hello;
    hello.lane = lane;
    hello.session_token = "token";
    bytes_ = encoder_.encode(session::Header{}, hello);
    peer_ = lane == session::Lane::data ? "data" : "control";
  }

  [[nodiscard]] transport::Frame knock() const { return {peer_, identity_, bytes_}; }

 private:
  std::string peer_, identity_;
  conversion::Encoder encoder_;
  transport::Bytes bytes_;
};

/// The Hellos of the two lanes come in any order; the component reads its Refusal on the data lane.
TEST(Reception, EndsTheRunOnlyAfterTheRefusalOnTheDataLane) {
  Door door;
  Parties parties;
  Reception reception(door, parties, "token");
  EXPECT_NO_THROW(reception.handle(Visitor(session::Lane::control, "body").knock(), 0));
  EXPECT_THROW(reception.handle(Visitor(session::Lane::data, "body").knock(), 0), Refused);
  const std::vector<std::pair<std::string, session::MessageKind>> expected = {
      {"control", session::MessageKind::refusal}, {"data", session::MessageKind::refusal}};
  EXPECT_EQ(door.answers, expected);
}

TEST(Reception, AdmitsAComponentOnceBothLanesHaveAsked) {
  Door door;
  Parties parties;
  Reception reception(door, parties, "token");
  reception.handle(Visitor(session::Lane::control, "fluid").knock(), 0);
  EXPECT_FALSE(parties.of(session::Role::fluid).is_complete());
  reception.handle(Visitor(session::Lane::data, "fluid").knock(), 0);
  EXPECT_TRUE(parties.of(session::Role::fluid).is_complete());
}

}  // namespace
}  // namespace copepod::remote
