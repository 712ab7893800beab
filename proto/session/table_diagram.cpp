#include "session/table_diagram.hpp"

#include <sstream>
#include <vector>

#include "session/transition_table.hpp"

namespace copepod::session {

namespace {

/// States that a component passes through before its end, in the order of the enumeration.
constexpr std::array kRunning = {State::connected, State::greeted,  State::configured,
                                 State::ready,     State::stepping, State::checkpointing};

struct Arrow {
  State from;
  State to;
  std::string label;
};

std::string label_of(const Transition& transition) {
  std::ostringstream label;
  const Trigger& trigger = transition.trigger;
  label << (trigger.is_local() ? name_of(trigger.local) : name_of(trigger.message));
  if (transition.reply != MessageKind::none) label << " → " << name_of(transition.reply);
  for (const Role role : {Role::fluid, Role::body}) {
    if (transition.roles == only(role)) label << " (" << name_of(role) << ")";
  }
  return label.str();
}

/// Work that ends in its initial state is not a separate arrow: it is the arrow of the request.
bool is_shown(const Transition& transition) {
  return !(transition.stays && transition.trigger.is_local()) && transition.from != while_running;
}

void add(std::vector<Arrow>& arrows, const Arrow& arrow) {
  for (Arrow& known : arrows) {
    if (known.from != arrow.from || known.to != arrow.to) continue;
    known.label += ", " + arrow.label;
    return;
  }
  arrows.push_back(arrow);
}

std::vector<Arrow> arrows_of_the_table() {
  std::vector<Arrow> arrows;
  for (const State from : kRunning) {
    for (const Transition& transition : kTransitions) {
      if ((transition.from & in(from)) == 0 || !is_shown(transition)) continue;
      add(arrows, {from, next_state(transition, from), label_of(transition)});
    }
  }
  return arrows;
}

}  // namespace

std::string table_as_mermaid() {
  std::ostringstream text;
  text << "```mermaid\nstateDiagram-v2\n  [*] --> connected: Hello\n";
  for (const Arrow& arrow : arrows_of_the_table()) {
    text << "  " << name_of(arrow.from) << " --> " << name_of(arrow.to) << ": " << arrow.label << "\n";
  }
  text << "  state \"any before the end\" as running\n";
  for (const Transition& transition : kTransitions) {
    if (transition.from != while_running) continue;
    text << "  running --> " << name_of(transition.to) << ": " << label_of(transition) << "\n";
  }
  text << "```\n";
  return text.str();
}

}  // namespace copepod::session
