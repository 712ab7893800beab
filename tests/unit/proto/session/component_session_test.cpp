#include "session/component_session.hpp"

#include <gtest/gtest.h>

#include "transcript.hpp"

namespace copepod::session {
namespace {

#define EXPECT_GOES(role, transcript) EXPECT_EQ(replay(role, transcript), transcript)

// clang-format off

TEST(FluidSession, RunsFromWelcomeToFinished) {
  EXPECT_GOES(Role::fluid, R"(
> Welcome               | greeted       | accept the welcome
> FluidSetup #1 @0      | configured    | make the solver -> Configured
! work done             | configured    | none
> Kinematics #2 @0      | stepping      | compute loads, reply, bulk update -> Loads
! work done             | ready         | none
> Kinematics #3 @1      | stepping      | compute loads, reply, bulk update -> Loads
! work done             | ready         | none
> Save #4 @2            | checkpointing | write the state -> Saved
! work done             | ready         | none
> Summarise #5 @2       | ready         | send the summary -> Summary
! work done             | ready         | none
> Finish #6             | done          | confirm the end -> Finished
)");
}

TEST(BodySession, RunsFromWelcomeToFinished) {
  EXPECT_GOES(Role::body, R"(
> Welcome               | greeted       | accept the welcome
> BodySetup #1 @0       | configured    | make the solver -> Configured
! work done             | configured    | none
> KinematicsRequest #2  | configured    | send the kinematics -> Kinematics
! work done             | configured    | none
> AppliedLoads #3 @0    | stepping      | advance bodies -> Kinematics
! work done             | ready         | none
> AppliedLoads #4 @1    | stepping      | advance bodies -> Kinematics
! work done             | ready         | none
> Finish #5             | done          | confirm the end -> Finished
)");
}

TEST(ControllerSession, IsAskedNowAndThenButNeverBackwards) {
  EXPECT_GOES(Role::controller, R"(
> Welcome               | greeted       | accept the welcome
> ControllerSetup #1 @0 | configured    | make the solver -> Configured
! work done             | configured    | none
> Observation #2 @0     | stepping      | decide the action -> Action
! work done             | ready         | none
> Observation #3 @100   | stepping      | decide the action -> Action
! work done             | ready         | none
> Save #4 @150          | checkpointing | write the state -> Saved
! work done             | ready         | none
> Observation #5 @100   | failed        | refuse: An Observation of step 100 came after that of step 100 (time runs forward). Send them in order.
)");
}

TEST(ComponentSession, ContinuesAtTheStepOfACheckpoint) {
  EXPECT_GOES(Role::fluid, R"(
> Welcome               | greeted       | accept the welcome
> FluidSetup #1 @40     | configured    | make the solver -> Configured
! work done             | configured    | none
> Restore #2 @50        | checkpointing | read the state -> Restored
! work done             | ready         | none
> Kinematics #3 @50     | stepping      | compute loads, reply, bulk update -> Loads
! work done             | ready         | none
> Kinematics #4 @51     | stepping      | compute loads, reply, bulk update -> Loads
)");
}

TEST(ComponentSession, BeginsAnewWithAnotherSetupAtAnEarlierStep) {
  EXPECT_GOES(Role::body, R"(
> Welcome               | greeted       | accept the welcome
> BodySetup #1 @0       | configured    | make the solver -> Configured
! work done             | configured    | none
> BodySetup #2 @0       | configured    | make the solver -> Configured
! work done             | configured    | none
> AppliedLoads #3 @0    | stepping      | advance bodies -> Kinematics
! work done             | ready         | none
> AppliedLoads #4 @1    | stepping      | advance bodies -> Kinematics
! work done             | ready         | none
> BodySetup #5 @1       | configured    | make the solver -> Configured
! work done             | configured    | none
> Restore #6 @1         | checkpointing | read the state -> Restored
! work done             | ready         | none
> AppliedLoads #7 @1    | stepping      | advance bodies -> Kinematics
! work done             | ready         | none
> BodySetup #8 @0       | configured    | make the solver -> Configured
! work done             | configured    | none
> AppliedLoads #9 @0    | stepping      | advance bodies -> Kinematics
)");
}

TEST(ComponentSession, AnswersARepeatedRequestWithTheSameReplyAndNeverStepsTwice) {
  EXPECT_GOES(Role::fluid, R"(
> Welcome               | greeted       | accept the welcome
> FluidSetup #1 @0      | configured    | make the solver -> Configured
! work done             | configured    | none
> FluidSetup #1 @0      | configured    | repeat the reply
> Kinematics #2 @0      | stepping      | compute loads, reply, bulk update -> Loads
! work done             | ready         | none
> Kinematics #2 @0      | ready         | repeat the reply
> Kinematics #2 @0      | ready         | repeat the reply
> FluidSetup #1 @0      | ready         | ignore: request 1 was answered long ago
> Kinematics #3 @1      | stepping      | compute loads, reply, bulk update -> Loads
)");
}

TEST(ComponentSession, RefusesARequestWithoutANumber) {
  EXPECT_GOES(Role::fluid, R"(
> Welcome               | greeted       | accept the welcome
> FluidSetup @0         | failed        | refuse: FluidSetup came without a number (its sequence is 0). Number the requests from 1.
)");
}

TEST(ComponentSession, RefusesWhatItsStateDoesNotAllowAndNamesWhatIsLegal) {
  EXPECT_GOES(Role::fluid, R"(
> Welcome               | greeted       | accept the welcome
> Kinematics #1 @0      | failed        | refuse: Kinematics is not allowed now (a fluid component in state 'greeted' allows FluidSetup, Finish). Send the messages in the order of docs/protocol.md.
)");
}

TEST(ComponentSession, RefusesARequestBeforeTheWelcome) {
  EXPECT_GOES(Role::fluid, R"(
> FluidSetup #1 @0      | connected     | ignore: the Welcome has not come yet
)");
}

TEST(ComponentSession, RefusesTheOtherRolesSetup) {
  EXPECT_GOES(Role::fluid, R"(
> Welcome               | greeted       | accept the welcome
> BodySetup #1 @0       | failed        | refuse: BodySetup is not allowed now (a fluid component in state 'greeted' allows FluidSetup, Finish). Send the messages in the order of docs/protocol.md.
)");
  EXPECT_GOES(Role::body, R"(
> Welcome               | greeted       | accept the welcome
> FluidSetup #1 @0      | failed        | refuse: FluidSetup is not allowed now (a body component in state 'greeted' allows BodySetup, Finish). Send the messages in the order of docs/protocol.md.
)");
}

TEST(ComponentSession, RefusesToRestoreInTheMiddleOfARun) {
  EXPECT_GOES(Role::body, R"(
> Welcome               | greeted       | accept the welcome
> BodySetup #1 @0       | configured    | make the solver -> Configured
! work done             | configured    | none
> AppliedLoads #2 @0    | stepping      | advance bodies -> Kinematics
! work done             | ready         | none
> Restore #3 @0         | failed        | refuse: Restore is not allowed now (a body component in state 'ready' allows BodySetup, KinematicsRequest, AppliedLoads, Save, Summarise, Finish). Send the messages in the order of docs/protocol.md.
)");
}

TEST(ComponentSession, RefusesAStepThatIsNotTheNextOne) {
  EXPECT_GOES(Role::fluid, R"(
> Welcome               | greeted       | accept the welcome
> FluidSetup #1 @0      | configured    | make the solver -> Configured
! work done             | configured    | none
> Kinematics #2 @1      | failed        | refuse: Kinematics of step 1 came where step 0 was due (a step was left out or done twice). Advance step by step.
)");
}

TEST(ComponentSession, RefusesASequenceNumberThatSkipsAhead) {
  EXPECT_GOES(Role::fluid, R"(
> Welcome               | greeted       | accept the welcome
> FluidSetup #2 @0      | failed        | refuse: request 2 came after request 0 (one in between was lost). Send every request until it is answered.
)");
}

TEST(ComponentSession, IgnoresMessagesOfAnotherRunAndASecondWelcome) {
  EXPECT_GOES(Role::fluid, R"(
> Welcome                       | greeted       | accept the welcome
> Welcome                       | greeted       | ignore: the handshake is over
> FluidSetup #1 @0 ~foreign     | greeted       | ignore: message of another session or of an earlier coupler
> FluidSetup #1 @0              | configured    | make the solver -> Configured
)");
}

TEST(ComponentSession, EndsWhenItIsRefused) {
  EXPECT_GOES(Role::fluid, R"(
> Refusal               | failed        | end the process
)");
}

TEST(ComponentSession, ReportsAFailureFromAnyRunningState) {
  EXPECT_GOES(Role::fluid, R"(
> Welcome               | greeted       | accept the welcome
> FluidSetup #1 @0      | configured    | make the solver -> Configured
! work done             | configured    | none
> Kinematics #2 @0      | stepping      | compute loads, reply, bulk update -> Loads
! work failed           | failed        | report the failure -> Failure
! work failed           | failed        | ignore: nothing is left to do
)");
}

TEST(ComponentSession, IsOrphanedFromAnyRunningStateButNotAfterTheEnd) {
  EXPECT_GOES(Role::body, R"(
! coupler lost          | orphaned      | end the process
)");
  EXPECT_GOES(Role::body, R"(
> Welcome               | greeted       | accept the welcome
> Finish #1             | done          | confirm the end -> Finished
! coupler lost          | done          | ignore: nothing is left to do
)");
}

// clang-format on

}  // namespace
}  // namespace copepod::session
