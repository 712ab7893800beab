#pragma once

#include "config/yaml/document.hpp"  // declares parse_yaml and to_yaml
