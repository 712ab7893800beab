#pragma once

#include <functional>
#include <memory>
#include <ostream>

#include "config/sections/case.hpp"
#include "contract/errors.hpp"
#include "run/command_line.hpp"
#include "run/components.hpp"
#include "run/signals.hpp"

namespace copepod::coupler {

/// @param signals  of the run; outlives the components
using MakeComponents =
    std::function<std::unique_ptr<Components>(const Options&, const ServicesCase&, const RunSignals& signals)>;

/// The coupler program: plans or runs a case and turns whatever happens into events and an exit code.
/// @param out   plan, or events of the run, one JSON object per line
/// @param err   one line per error
/// @return exit code of the process
int run_program(int argc, const char* const* argv, std::ostream& out, std::ostream& err,
                const MakeComponents& make_components);

}  // namespace copepod::coupler
