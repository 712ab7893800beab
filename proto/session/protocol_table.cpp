#include <iostream>
#include <string>

#include <nlohmann/json.hpp>

#include "contract/features.hpp"
#include "session/transition_table.hpp"

namespace {

using namespace copepod;
using namespace copepod::session;
using nlohmann::ordered_json;

ordered_json row_of(const Transition& transition) {
  ordered_json row{{"roles", ordered_json::array()}, {"from", ordered_json::array()}};
  for (const Role role : {Role::fluid, Role::body, Role::controller})
    if ((transition.roles & only(role)) != 0) row["roles"].push_back(name_of(role));
  for (int state = 0; state <= static_cast<int>(State::orphaned); ++state)
    if ((transition.from & in(static_cast<State>(state))) != 0)
      row["from"].push_back(name_of(static_cast<State>(state)));
  const Trigger& trigger = transition.trigger;
  if (trigger.is_local()) {
    row["event"] = name_of(trigger.local);
  } else {
    row["message"] = name_of(trigger.message);
  }
  if (!transition.stays) row["to"] = name_of(transition.to);
  row["work"] = name_of(transition.work);
  if (transition.reply != MessageKind::none) row["reply"] = name_of(transition.reply);
  return row;
}

}  // namespace

/// Prints the transition table as JSON, or with `--features` the features that components may announce.
int main(int argc, char** argv) {
  ordered_json rows = ordered_json::array();
  if (argc == 2 && argv[1] == std::string("--features")) {
    for (const Feature& feature : known_features())
      rows.push_back({{"name", feature.name}, {"kind", copepod::name_of(feature.kind)}, {"meaning", feature.meaning}});
  } else {
    for (const Transition& transition : kTransitions) rows.push_back(row_of(transition));
  }
  std::cout << rows.dump(1) << std::endl;
  return 0;
}
