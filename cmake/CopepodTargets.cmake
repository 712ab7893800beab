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

# address includes undefined behaviour, and in the libraries that fuzz targets call what libFuzzer needs. Both need
# clang: use the presets. To compile takes longer than to test: only numerics are optimised, and the checks of each
# single pointer are left out. Of what these find, the address sanitizer sees an access outside of any object.
set(COPEPOD_SANITIZER "" CACHE STRING "Build with a sanitizer: address or thread")
set(sanitizer_address address,undefined)
set(sanitizer_thread thread)
set(sanitizer_left_out null,alignment,object-size,pointer-overflow,vptr)
set(sanitizer_optimised copepod_contract copepod_conversion copepod_body copepod_fluid)
set(sanitizer_fuzzed copepod_contract copepod_conversion copepod_session copepod_coupler copepod_body)
if(COPEPOD_SANITIZER)
  set(sanitizer_flags -fsanitize=${sanitizer_${COPEPOD_SANITIZER}} -fno-sanitize=${sanitizer_left_out}
    -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_compile_options(-O0 ${sanitizer_flags})
  add_link_options(${sanitizer_flags} -fuse-ld=lld)
endif()

option(COPEPOD_COVERAGE "Build with coverage counters for gcovr" OFF)

# What ccache keeps serves every checkout: no object holds the path of its own.
find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=true ${CCACHE})
endif()
add_compile_options(-ffile-prefix-map=${CMAKE_SOURCE_DIR}/=)

function(copepod_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  # Without errno, which nothing reads, rounding and roots are single instructions.
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Werror -ffp-contract=off -fno-math-errno)
  if(COPEPOD_COVERAGE)
    target_compile_options(${target} PRIVATE --coverage -O0)
    target_link_options(${target} PUBLIC --coverage)
  endif()
endfunction()

# Several sources at once, since most of the time goes into the headers that they share. A private name must not be used
# twice in a target, nor in a header that another source uses. The preset `debug` compiles each source alone and so
# finds what a source fails to include.
set(sources_together 8)
if(COPEPOD_SANITIZER)
  set(sources_together 24)
endif()
function(copepod_sources_together target)
  if(NOT CMAKE_BUILD_TYPE STREQUAL "Debug")
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${sources_together})
    target_compile_options(${target} PRIVATE -Wno-shadow  # of a private name of another source
      $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)  # every source is taken for a header
  endif()
endfunction()

# copepod_library(name [COLD] SOURCES a.cpp … LINKS target …): a static library under the rules above. COLD: objects for
# another library. None of their loops is long, so that the time to compile them counts for more; the bits of their
# numbers are the same.
function(copepod_library name)
  cmake_parse_arguments(ARG "COLD" "" "SOURCES;LINKS" ${ARGN})
  if(ARG_COLD)
    add_library(${name} OBJECT ${ARG_SOURCES})
  else()
    add_library(${name} STATIC ${ARG_SOURCES})
  endif()
  copepod_compile_options(${name})
  copepod_sources_together(${name})
  if(ARG_COLD AND CMAKE_BUILD_TYPE STREQUAL "Release")
    target_compile_options(${name} PRIVATE -Og)
    set_target_properties(${name} PROPERTIES UNITY_BUILD_BATCH_SIZE 16)
  endif()
  if(COPEPOD_SANITIZER AND name IN_LIST sanitizer_optimised)
    target_compile_options(${name} PRIVATE -O1 -finline-functions)
  endif()
  if(COPEPOD_SANITIZER STREQUAL address AND name IN_LIST sanitizer_fuzzed)
    target_compile_options(${name} PRIVATE -fsanitize=fuzzer-no-link)
  endif()
  target_link_libraries(${name} PUBLIC ${ARG_LINKS})
endfunction()

# copepod_program(name SOURCES a.cpp … LINKS target …): an executable under the rules above.
function(copepod_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  copepod_compile_options(${name})
  copepod_sources_together(${name})
  target_link_libraries(${name} PRIVATE ${ARG_LINKS})
endfunction()
