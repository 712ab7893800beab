# Installs the component kit, builds the example fluid against it as a stranger would, and asks it what it can do.
#   cmake -D build=… -D source=… -D work=… -D compiler=… -P external_fluid_test.cmake
file(REMOVE_RECURSE ${work})
file(MAKE_DIRECTORY ${work})

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed: ${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install ${build} --component kit --prefix ${work}/prefix)
run(${CMAKE_COMMAND} -S ${source} -B ${work}/build -DCMAKE_PREFIX_PATH=${work}/prefix -DCMAKE_CXX_COMPILER=${compiler}
  "-DCMAKE_EXE_LINKER_FLAGS=${linker_flags}")
run(${CMAKE_COMMAND} --build ${work}/build)
run(${work}/build/external_fluid --capabilities)
if(NOT output MATCHES "\"name\":\"Uniform stream\"")
  message(FATAL_ERROR "not the capabilities of the example: ${output}")
endif()
file(REMOVE_RECURSE ${work})
