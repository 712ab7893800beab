#include "session/coupler_session.hpp"

#include <gtest/gtest.h>

namespace copepod::session {
namespace {

CouplerSession greeted_fluid() { return welcomed({}, 4711, 1); }

/// The session after a request and its reply.
CouplerSession after(const CouplerSession& session, MessageKind request, std::int64_t step, MessageKind reply) {
  const Asked asked = ask(session, request, step);
  EXPECT_EQ(asked.problem, "");
  const Heard heard = hear(asked.session, reply, header_of(asked.session));
  EXPECT_EQ(heard.kind, Heard::Kind::reply);
  return heard.session;
}

TEST(CouplerSession, CountsRequestsAndFollowsTheComponentsState) {
  CouplerSession session = greeted_fluid();
  session = after(session, MessageKind::fluid_setup, 0, MessageKind::configured);
  EXPECT_EQ(session.state, State::configured);
  session = after(session, MessageKind::kinematics, 0, MessageKind::loads);
  EXPECT_EQ(session.state, State::ready);
  session = after(session, MessageKind::save, 1, MessageKind::saved);
  EXPECT_EQ(session.state, State::ready);
  session = after(session, MessageKind::finish, 1, MessageKind::finished);
  EXPECT_EQ(session.state, State::done);
  EXPECT_EQ(session.sequence, 4U);
}

TEST(CouplerSession, PutsIdsSequenceAndStepIntoTheHeader) {
  const Asked asked = ask(greeted_fluid(), MessageKind::fluid_setup, 12);
  const Header header = header_of(asked.session);
  EXPECT_EQ(header.session_id, 4711U);
  EXPECT_EQ(header.epoch, 1U);
  EXPECT_EQ(header.sequence, 1U);
  EXPECT_EQ(header.attempt, 0U);
  EXPECT_EQ(header.step, 12);
  EXPECT_EQ(header_of(ask_again(asked.session)).attempt, 1U);
  EXPECT_EQ(header_of(ask_again(asked.session)).sequence, 1U);
}

TEST(CouplerSession, GuardsItsOwnCallOrder) {
  const CouplerSession session = greeted_fluid();
  EXPECT_EQ(ask(session, MessageKind::kinematics, 0).problem,
            "Kinematics cannot be sent to the fluid component (in state 'greeted' it allows FluidSetup, "
            "Finish). Call in "
            "the order of the contract.");
  const Asked asked = ask(session, MessageKind::fluid_setup, 0);
  EXPECT_NE(ask(asked.session, MessageKind::finish, 0).problem.find("too early"), std::string::npos);
  EXPECT_EQ(ask(asked.session, MessageKind::finish, 0).session, asked.session);
}

TEST(CouplerSession, IgnoresRepliesThatComeTwiceLateOrFromElsewhere) {
  const Asked asked = ask(greeted_fluid(), MessageKind::fluid_setup, 0);
  Header header = header_of(asked.session);
  const Heard heard = hear(asked.session, MessageKind::configured, header);
  EXPECT_EQ(hear(heard.session, MessageKind::configured, header).kind, Heard::Kind::stale);
  header.epoch = 99;
  EXPECT_EQ(hear(asked.session, MessageKind::configured, header).kind, Heard::Kind::stale);
}

TEST(CouplerSession, RefusesAReplyWithASequenceNumberThatNoRequestHad) {
  const Asked asked = ask(greeted_fluid(), MessageKind::fluid_setup, 0);
  Header header = header_of(asked.session);
  for (const std::uint64_t sequence : {0, 7}) {
    header.sequence = sequence;
    const Heard heard = hear(asked.session, MessageKind::configured, header);
    EXPECT_EQ(heard.kind, Heard::Kind::refuse);
    EXPECT_EQ(heard.problem, "it sent Configured of step 0 with sequence number " + std::to_string(sequence) +
                                 ", that of the request is 1");
  }
}

TEST(CouplerSession, RefusesTheResultOfAStepUnderTheNumberOfAnOlderRequest) {
  CouplerSession session = after(greeted_fluid(), MessageKind::fluid_setup, 0, MessageKind::configured);
  session = after(session, MessageKind::kinematics, 0, MessageKind::loads);
  session = ask(session, MessageKind::kinematics, 1).session;
  Header header = header_of(session);
  header.sequence = 2;
  EXPECT_EQ(hear(session, MessageKind::loads, header).kind, Heard::Kind::refuse);
  header.step = 0;
  EXPECT_EQ(hear(session, MessageKind::loads, header).kind, Heard::Kind::stale) << "a repeated reply";
}

TEST(CouplerSession, KnowsTheStepThatTheComponentIsWorkingOn) {
  CouplerSession session = after(greeted_fluid(), MessageKind::fluid_setup, 5, MessageKind::configured);
  EXPECT_EQ(session.current_step(), -1);
  session = ask(session, MessageKind::kinematics, 5).session;
  EXPECT_EQ(session.current_step(), 5);
  session = hear(session, MessageKind::loads, header_of(session)).session;
  EXPECT_EQ(session.current_step(), 5) << "the bulk update follows the loads";
  session = after(session, MessageKind::save, 6, MessageKind::saved);
  EXPECT_EQ(session.current_step(), -1);
}

TEST(CouplerSession, TakesAFailureAtAnyTime) {
  Header unasked;
  unasked.session_id = 4711;
  unasked.epoch = 1;
  const Heard heard = hear(greeted_fluid(), MessageKind::failure, unasked);
  EXPECT_EQ(heard.kind, Heard::Kind::failure);
  EXPECT_EQ(heard.session.state, State::failed);
}

TEST(CouplerSession, RefusesAReplyOfTheWrongKind) {
  const Asked asked = ask(greeted_fluid(), MessageKind::fluid_setup, 0);
  const Heard heard = hear(asked.session, MessageKind::loads, header_of(asked.session));
  EXPECT_EQ(heard.kind, Heard::Kind::refuse);
  EXPECT_NE(heard.problem.find("it answered FluidSetup with Loads, Configured was due"), std::string::npos)
      << heard.problem;
}

TEST(CouplerSession, RefusesAReplyOfTheWrongStep) {
  CouplerSession body;
  body.role = Role::body;
  body = after(welcomed(body, 4711, 1), MessageKind::body_setup, 7, MessageKind::configured);
  const Asked asked = ask(body, MessageKind::applied_loads, 7);
  Header header = header_of(asked.session);
  const Heard heard = hear(asked.session, MessageKind::kinematics, header);
  EXPECT_EQ(heard.kind, Heard::Kind::refuse);
  EXPECT_EQ(heard.problem, "it answered AppliedLoads of step 7 with Kinematics of step 7, step 8 was due");
  header.step = 8;
  EXPECT_EQ(hear(asked.session, MessageKind::kinematics, header).kind, Heard::Kind::reply);
}

}  // namespace
}  // namespace copepod::session
