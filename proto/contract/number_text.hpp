#pragma once

#include <string>

namespace copepod {

// Numbers in messages: a person reads four significant digits.
std::string rounded_text(double number);
std::string length_text(double length_m);  ///< with a unit in which it is readable: "1.5 µm"

}  // namespace copepod
