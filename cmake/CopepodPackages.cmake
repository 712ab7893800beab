# What an installation has, and Debian packages of it: cmake --build build --target packages, then build/packages/*.deb.
# Parts: programs (package copepod), kit (libcopepod-dev), python (python3-copepod).

set(private ${CMAKE_INSTALL_LIBEXECDIR}/copepod)
set(modules lib/python3/dist-packages)  # of Debian's Python, whatever the prefix
set(docs ${CMAKE_INSTALL_DATADIR}/doc)
set(pages ${CMAKE_BINARY_DIR}/pages)  # made when packages are

foreach(program IN ITEMS coupler fluid_service body_service in_process_run bullet_body_service mujoco_body_service)
  if(TARGET ${program})
    list(APPEND programs ${program})
  endif()
endforeach()
install(TARGETS ${programs} DESTINATION ${private} COMPONENT programs)
install(TARGETS copepod LIBRARY COMPONENT programs NAMELINK_COMPONENT kit)
install(CODE "file(MAKE_DIRECTORY \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${private})
  file(CREATE_LINK ../../${CMAKE_INSTALL_LIBDIR}/libcopepod.so.${PROJECT_VERSION_MAJOR}
    \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${private}/libcopepod.so SYMBOLIC)" COMPONENT programs)
install(PROGRAMS deploy/copepod DESTINATION bin COMPONENT programs)
install(DIRECTORY configs DESTINATION ${CMAKE_INSTALL_DATADIR}/copepod COMPONENT programs)
install(DIRECTORY examples/python DESTINATION ${CMAKE_INSTALL_DATADIR}/copepod/examples COMPONENT programs)
install(DIRECTORY docs/ DESTINATION ${docs}/copepod COMPONENT programs FILES_MATCHING REGEX "docs/[^/]*\\.(md|svg|png)$")
install(DIRECTORY ${pages}/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT programs OPTIONAL)

install(FILES in_process/copepod.h in_process/copepod_component.h TYPE INCLUDE COMPONENT kit)
configure_file(cmake/copepod.pc.in copepod.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/copepod.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT kit)

install(DIRECTORY deploy/ proto/python/ python/ DESTINATION ${modules} COMPONENT python
  FILES_MATCHING REGEX "\\.(py|html|css|js|md|toml)$|/py.typed$" PATTERN __pycache__ EXCLUDE PATTERN container EXCLUDE
  PATTERN slurm EXCLUDE)
install(DIRECTORY ${CMAKE_BINARY_DIR}/python/copepod DESTINATION ${modules} COMPONENT python
  FILES_MATCHING REGEX "\\.(py|json)$" PATTERN __pycache__ EXCLUDE)
file(WRITE ${CMAKE_BINARY_DIR}/METADATA "Metadata-Version: 2.1\nName: copepod\nVersion: ${PROJECT_VERSION}\n")
install(FILES ${CMAKE_BINARY_DIR}/METADATA DESTINATION ${modules}/copepod-${PROJECT_VERSION}.dist-info COMPONENT python)

# Dependencies that no program shows are those that the command installs for a checkout.
set(lists "from copepod_run import packages as p; print(*map(', '.join, (p.RUN, p.KIT, p.PYTHON)), sep=';', end='')")
execute_process(COMMAND /usr/bin/python3 -B -c "${lists}" OUTPUT_VARIABLE lists COMMAND_ERROR_IS_FATAL ANY
  WORKING_DIRECTORY ${CMAKE_SOURCE_DIR}/deploy)
list(GET lists 0 run)
list(GET lists 1 kit)
list(GET lists 2 python)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME copepod)
set(CPACK_PACKAGE_CONTACT "The Copepod developers <developers@copepod.example>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_COMPONENTS_ALL programs kit python)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)

set(same "(= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME copepod)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/cmake/debian/triggers)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS "python3-copepod ${same}, python3-argcomplete, ${run}")
set(CPACK_COMPONENT_PROGRAMS_DESCRIPTION "couples fluid solvers and rigid bodies
A lattice Boltzmann fluid, rigid bodies and a coupler run as services that
exchange motions and loads; each can be replaced by another solver.")
set(CPACK_DEBIAN_KIT_PACKAGE_NAME libcopepod-dev)
set(CPACK_DEBIAN_KIT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_KIT_PACKAGE_DEPENDS "copepod ${same}, ${kit}")
set(CPACK_DEBIAN_KIT_PACKAGE_SUGGESTS libopenmpi-dev)  # copepod::fluid_program
set(CPACK_COMPONENT_KIT_DESCRIPTION "component kit and C interface of Copepod
Turns a solver into a component of Copepod (CMake: find_package(copepod)),
and steps whole simulations from C (pkg-config: copepod).")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-copepod)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3, ${run}, ${python}")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "copepod ${same}")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "cases, runs and results of Copepod from Python
The package copepod, the component kit for solvers in Python, conformance and
recording tools, and the modules of the command.")
foreach(script IN ITEMS postinst prerm)  # keeps compiled modules, and removes them
  list(APPEND CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/cmake/debian/${script})
endforeach()
foreach(part IN ITEMS PROGRAMS KIT PYTHON)
  string(TOLOWER ${part} component)
  set(folder ${docs}/${CPACK_DEBIAN_${part}_PACKAGE_NAME})
  install(FILES LICENSE DESTINATION ${folder} RENAME copyright COMPONENT ${component})
  install(FILES ${CMAKE_BINARY_DIR}/changelog.gz DESTINATION ${folder} COMPONENT ${component} OPTIONAL)
endforeach()
include(CPack)

add_custom_target(packages DEPENDS ${programs} copepod copepod_python VERBATIM WORKING_DIRECTORY ${CMAKE_SOURCE_DIR}
  COMMAND ${CMAKE_SOURCE_DIR}/cmake/debian/pages ${pages}
  COMMAND sh -c "gzip -9nc CHANGELOG.md >${CMAKE_BINARY_DIR}/changelog.gz"
  COMMAND ${CMAKE_CPACK_COMMAND} --config ${CMAKE_BINARY_DIR}/CPackConfig.cmake)
