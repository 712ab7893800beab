# What every target of ours has in common: the language, the warnings, and the arithmetic.
#
# -ffp-contract=off: a fused multiply-add rounds once where two operations round twice, so a compiler that is
# free to choose would give the vector body and the remainder of a loop different bits (design: determinism).

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

option(COPEPOD_SANITIZE "Build with the address and undefined-behaviour sanitizers" OFF)
option(COPEPOD_FUZZ "Build the fuzz targets, with clang and the sanitizers (tests/fuzz/run)" OFF)
option(COPEPOD_COVERAGE "Build with coverage counters for gcovr" OFF)

find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()

function(copepod_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Werror -ffp-contract=off)
  if(COPEPOD_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=address,undefined -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=address,undefined)
  endif()
  if(COPEPOD_FUZZ)
    set(fuzz_flags -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all)
    target_compile_options(${target} PRIVATE ${fuzz_flags} -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC ${fuzz_flags})
  endif()
  if(COPEPOD_COVERAGE)
    target_compile_options(${target} PRIVATE --coverage -O0)
    target_link_options(${target} PUBLIC --coverage)
  endif()
endfunction()

# copepod_library(name SOURCES a.cpp … LINKS target …): a static library under the rules above.
function(copepod_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  copepod_compile_options(${name})
  target_link_libraries(${name} PUBLIC ${ARG_LINKS})
endfunction()

# copepod_program(name SOURCES a.cpp … LINKS target …): an executable under the rules above.
function(copepod_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  copepod_compile_options(${name})
  target_link_libraries(${name} PRIVATE ${ARG_LINKS})
endfunction()
