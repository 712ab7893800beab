# Runs after every commit and change of a source, so that the revision in provenance.json is that of the sources and not
# of the last configure; the file is only touched when its content changes.
execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE REVISION OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT REVISION)
  set(REVISION unknown)
endif()
configure_file(${SOURCE_DIR}/coupler/run/build_info.cpp.in ${OUTPUT} @ONLY)

# What the revision depends on.
execute_process(COMMAND git -C ${SOURCE_DIR} rev-parse --path-format=absolute --git-path logs/HEAD
  OUTPUT_VARIABLE commits OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
execute_process(COMMAND git -C ${SOURCE_DIR} ls-files
    CMakeLists.txt cmake proto fluid_service body_service coupler in_process
  OUTPUT_VARIABLE sources OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
string(REPLACE "\n" "\n${SOURCE_DIR}/" sources "\n${sources}")
string(REPLACE " " "\\ " dependencies "${OUTPUT}:\n${commits}${sources}")
string(REPLACE "\n" " \\\n" dependencies "${dependencies}")
file(WRITE ${OUTPUT}.d "${dependencies}\n")
