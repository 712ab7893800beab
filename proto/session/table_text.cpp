#include "session/table_text.hpp"

#include <sstream>
#include <vector>

#include "contract/features.hpp"
#include "session/transition_table.hpp"

namespace copepod::session {

namespace {

constexpr std::array kRoles = {Role::fluid, Role::body};
constexpr std::array kStates = {State::connected, State::greeted,  State::configured,
                                State::ready,     State::stepping, State::checkpointing,
                                State::done,      State::failed,   State::orphaned};

std::vector<std::string> role_names(const Transition& transition) {
  std::vector<std::string> names;
  for (const Role role : kRoles) {
    if ((transition.roles & only(role)) != 0) names.emplace_back(name_of(role));
  }
  return names;
}

std::vector<std::string> state_names(const Transition& transition) {
  std::vector<std::string> names;
  for (const State state : kStates) {
    if ((transition.from & in(state)) != 0) names.emplace_back(name_of(state));
  }
  return names;
}

std::string joined(const std::vector<std::string>& words, const char* quote) {
  std::ostringstream text;
  const char* separator = "";
  for (const std::string& word : words) {
    text << separator << quote << word << quote;
    separator = ", ";
  }
  return text.str();
}

std::string field(const char* name, std::string_view value) {
  std::ostringstream text;
  text << '"' << name << "\": \"" << value << '"';
  return text.str();
}

}  // namespace

std::string table_as_markdown() {
  std::ostringstream text;
  text << "| role | in state | on | does | replies | then |\n|---|---|---|---|---|---|\n";
  for (const Transition& transition : kTransitions) {
    const Trigger& trigger = transition.trigger;
    const char* quote = trigger.is_local() ? "*" : "`";
    text << "| " << (transition.roles == any_role ? "both" : joined(role_names(transition), ""));
    text << " | " << (transition.from == while_running ? "any before the end" : joined(state_names(transition), ""));
    text << " | " << quote << (trigger.is_local() ? name_of(trigger.local) : name_of(trigger.message)) << quote;
    text << " | " << (transition.work == Work::none ? "" : name_of(transition.work)) << " | ";
    if (transition.reply != MessageKind::none) text << "`" << name_of(transition.reply) << "`";
    text << " | " << (transition.stays ? "same" : name_of(transition.to)) << " |\n";
  }
  return text.str();
}

std::string table_as_json() {
  std::ostringstream text;
  const char* separator = "[\n";
  for (const Transition& transition : kTransitions) {
    const Trigger& trigger = transition.trigger;
    text << separator << R"(  {"roles": [)" << joined(role_names(transition), "\"");
    text << R"(], "from": [)" << joined(state_names(transition), "\"") << "], ";
    text << (trigger.is_local() ? field("event", name_of(trigger.local)) : field("message", name_of(trigger.message)));
    if (!transition.stays) text << ", " << field("to", name_of(transition.to));
    text << ", " << field("work", name_of(transition.work));
    if (transition.reply != MessageKind::none) text << ", " << field("reply", name_of(transition.reply));
    text << "}";
    separator = ",\n";
  }
  text << "\n]\n";
  return text.str();
}

std::string features_as_markdown() {
  std::ostringstream text;
  text << "| feature | kind | meaning |\n|---|---|---|\n";
  for (const Feature& feature : known_features())
    text << "| `" << feature.name << "` | " << name_of(feature.kind) << " | " << feature.meaning << " |\n";
  return text.str();
}

std::string features_as_json() {
  std::ostringstream text;
  const char* separator = "[\n";
  for (const Feature& feature : known_features()) {
    text << separator << "  {" << field("name", feature.name) << ", " << field("kind", copepod::name_of(feature.kind))
         << ", " << field("meaning", feature.meaning) << "}";
    separator = ",\n";
  }
  text << "\n]\n";
  return text.str();
}

}  // namespace copepod::session
