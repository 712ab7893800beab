#include "transcript.hpp"

#include <sstream>
#include <stdexcept>

#include "session/component_session.hpp"

namespace copepod::session {

namespace {

MessageKind message_named(const std::string& name) {
  for (const auto& [kind, known] : kMessageNames) {
    if (known == name) return kind;
  }
  throw std::invalid_argument("no message is called " + name);
}

LocalEvent event_named(const std::string& name) {
  for (const LocalEvent event : {LocalEvent::work_done, LocalEvent::work_failed, LocalEvent::coupler_lost}) {
    if (name_of(event) == name) return event;
  }
  throw std::invalid_argument("no event is called " + name);
}

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

std::string told(const Action& action) {
  switch (action.kind) {
    case Action::Kind::repeat_reply:
      return "repeat the reply";
    case Action::Kind::ignore:
      return "ignore: " + action.reason;
    case Action::Kind::refuse:
      return "refuse: " + action.reason;
    case Action::Kind::work:
      break;
  }
  const std::string reply = action.reply == MessageKind::none ? "" : " -> " + std::string(name_of(action.reply));
  return std::string(name_of(action.work)) + reply;
}

constexpr Welcome kWelcome{0, 4711, 1};

Outcome play_message(const ComponentSession& session, const std::string& text) {
  std::istringstream words(text);
  std::string name;
  words >> name;
  Header header;
  header.session_id = kWelcome.session_id;
  header.epoch = kWelcome.epoch;
  for (std::string word; words >> word;) {
    if (word.front() == '#') header.sequence = std::stoull(word.substr(1));
    if (word.front() == '@') header.step = std::stoll(word.substr(1));
    if (word == "~foreign") header.session_id = 1;
  }
  Outcome outcome = on_message(session, message_named(name), header);
  if (outcome.action.work == Work::accept_welcome) outcome.session = welcomed(outcome.session, kWelcome);
  return outcome;
}

}  // namespace

std::string replay(Role role, const std::string& transcript) {
  ComponentSession session;
  session.role = role;
  std::istringstream lines(transcript);
  std::string result = "\n";
  for (std::string line; std::getline(lines, line);) {
    if (trimmed(line).empty()) continue;
    const std::string input = line.substr(0, line.find('|'));
    const std::string text = trimmed(input);
    const std::string what = trimmed(text.substr(1));
    const Outcome outcome = text.front() == '!' ? on_event(session, event_named(what)) : play_message(session, what);
    session = outcome.session;
    std::string state(name_of(session.state));
    state.resize(13, ' ');
    result += input + "| " + state + " | " + told(outcome.action) + "\n";
  }
  return result;
}

}  // namespace copepod::session
