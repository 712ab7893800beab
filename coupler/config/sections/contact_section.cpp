#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "contract/number_text.hpp"

namespace copepod::coupler {

ContactCase read_contact(Reader contact) {
  constexpr double least_restitution = 0.05;  // less would need more damping than substeps resolve
  ContactCase result;
  result.restitution = contact.number("restitution", Range::positive, result.restitution);
  if (result.restitution < least_restitution || result.restitution > 1.0) {
    contact.reject("restitution", "is " + rounded_text(result.restitution) +
                                      " (the velocity after an impact over that before). Use a number between 0.05 "
                                      "and 1.");
  }
  result.friction = contact.number("friction", Range::not_negative, result.friction);
  const Value* stiffness = contact.raw("stiffness_N_per_m");
  if (stiffness != nullptr && stiffness->text != "auto")
    result.stiffness_N_per_m = contact.number("stiffness_N_per_m", Range::positive);
  return result;
}

nlohmann::ordered_json resolved_contact(const ContactCase& contact) {
  nlohmann::ordered_json section{{"restitution", contact.restitution}, {"friction", contact.friction}};
  section["stiffness_N_per_m"] = "auto";
  if (contact.stiffness_N_per_m) section["stiffness_N_per_m"] = *contact.stiffness_N_per_m;
  return section;
}

}  // namespace copepod::coupler
