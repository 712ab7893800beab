# Runs at every build, so that the revision in provenance.json is that of the sources and not of the last configure;
# the file is only touched when its content changes.
execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE REVISION OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT REVISION)
  set(REVISION unknown)
endif()
configure_file(${SOURCE_DIR}/coupler/run/build_info.cpp.in ${OUTPUT} @ONLY)
