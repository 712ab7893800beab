#include "session/transition_table.hpp"

#include <gtest/gtest.h>

namespace copepod::session {
namespace {

constexpr std::array kRoles = {Role::fluid, Role::body, Role::controller};
constexpr std::array kStates = {State::connected, State::greeted,  State::configured,
                                State::ready,     State::stepping, State::checkpointing,
                                State::done,      State::failed,   State::orphaned};

TEST(TransitionTable, IsUnambiguous) {
  for (const Transition& first : kTransitions) {
    for (const Transition& second : kTransitions) {
      if (&first == &second) continue;
      const bool overlap = (first.roles & second.roles) != 0 && (first.from & second.from) != 0;
      EXPECT_FALSE(overlap && first.trigger == second.trigger) << name_of(first.trigger.message);
    }
  }
}

TEST(TransitionTable, AllowsNothingAfterTheEnd) {
  for (const State end : {State::done, State::failed, State::orphaned}) {
    for (const Transition& transition : kTransitions) EXPECT_EQ(transition.from & in(end), 0) << name_of(end);
  }
}

TEST(TransitionTable, LeadsFromEveryRunningStateToFailedAndOrphaned) {
  for (const Role role : kRoles) {
    for (const State state : kStates) {
      if ((in(state)&while_running) == 0) continue;
      EXPECT_NE(find_transition(role, state, LocalEvent::work_failed), nullptr) << name_of(state);
      EXPECT_NE(find_transition(role, state, LocalEvent::coupler_lost), nullptr) << name_of(state);
    }
  }
}

TEST(TransitionTable, ReachesEveryStateFromConnected) {
  for (const Role role : kRoles) {
    States reached = in(State::connected);
    for (std::size_t round = 0; round < kStates.size(); ++round) {
      for (const Transition& transition : kTransitions) {
        const bool applies = (transition.roles & only(role)) != 0 && (transition.from & reached) != 0;
        if (applies && !transition.stays) reached |= in(transition.to);
      }
    }
    for (const State state : kStates) EXPECT_NE(reached & in(state), 0) << name_of(role) << " " << name_of(state);
  }
}

TEST(TransitionTable, AnswersEveryRequest) {
  for (const Transition& transition : kTransitions) {
    const MessageKind kind = transition.trigger.message;
    const bool is_request =
        !transition.trigger.is_local() && kind != MessageKind::welcome && kind != MessageKind::refusal;
    if (!is_request) continue;
    EXPECT_NE(transition.reply, MessageKind::none) << name_of(kind);
  }
}

}  // namespace
}  // namespace copepod::session
