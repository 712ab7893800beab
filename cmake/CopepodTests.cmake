include(GoogleTest)

# What a build with a sanitizer is for: the tests that it builds and runs (.ci/run).
# The tests left out take about as long as all others, without optimisation, through code that others pass, too.
if(COPEPOD_SANITIZER)
  add_custom_target(sanitized_tests)
  string(JOIN ":" COPEPOD_LONG_RUNS Contacts.LetAHeapComeToRest PlaneImages.AreSurfaceAveragesOfTheGreensFunction
    JointLimit.Keeps* JointLimit.LetsAPendulumWhoseBobItHoldsKeepItsEnergy Joints.StayClosed
    SegmentDistance.AgreesWithASearchForRandomSegments
    Setups/KeyTravel.EveryFieldIsSetByItsKeyAndSurvivesTheResolvedCase/* BulletWorld.LetsNoCapsulePassThroughAWall
    BodyMap.OfBodiesThatCrossEqualsOneMadeFromScratch BodyMap.SlowSphereTakesAndLosesEveryCellInTime
    Signal.IsIntegratedExactlyForEveryKindPeriodLagRampStartAndStop PrescribedBodies.DoNotDriftInManyPeriods
    Lubrication.LetsABodySinkAsItsWeightDemandsHoweverThinTheFilm ResolvedCase.ReadsBackToTheSameCaseBitForBit
    DoubtfulCases.AreNotThoseOfOurConfigs Store.FindsEveryBitThatFlipsInAnyFile
    DrivenJoints.ResumeWithTheSameBitsBetweenContacts Placement.EndsWhereNothingMoreHasRoom
    NearestDistances.AreThoseOfASearchThroughAllPairs SwarmSection.SaysHowManyCouldBePlaced)
endif()

# copepod_test(name LABEL unit [THREADS] SOURCES a_test.cpp … LINKS target …): a GoogleTest program, one ctest entry per
# TEST. THREADS: its tests have several threads; only these programs are built for the thread sanitizer.
function(copepod_test name)
  cmake_parse_arguments(ARG "THREADS" "LABEL;TIMEOUT" "SOURCES;LINKS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 180)
  endif()
  copepod_program(${name} SOURCES ${ARG_SOURCES} LINKS ${ARG_LINKS} GTest::gtest_main)
  if(COPEPOD_SANITIZER STREQUAL thread AND NOT ARG_THREADS)
    return()
  elseif(COPEPOD_SANITIZER)
    target_compile_options(${name} PRIVATE -Wno-unused-result)  # clang: of [[nodiscard]] functions in EXPECT_THROW
    add_dependencies(sanitized_tests ${name})
  endif()
  if(COPEPOD_SANITIZER AND ARG_LABEL STREQUAL unit)  # starting a program takes longer there than most tests
    add_test(NAME ${ARG_LABEL}.${name} COMMAND ${name} --gtest_filter=-${COPEPOD_LONG_RUNS})
    set_tests_properties(${ARG_LABEL}.${name} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT 600)
  else()
    gtest_discover_tests(${name} TEST_PREFIX "${ARG_LABEL}." DISCOVERY_TIMEOUT 60
      PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT})
  endif()
endfunction()

# copepod_mpi_test(name [THREADS] RANKS 1 2 3 SOURCES … LINKS …): one program with its own main, one ctest entry per
# rank count. THREADS: another one with threads as ranks; sanitizers see these only.
function(copepod_mpi_test name)
  cmake_parse_arguments(ARG "THREADS" "TIMEOUT" "RANKS;SOURCES;LINKS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 600)
  endif()
  copepod_program(${name} SOURCES ${ARG_SOURCES} LINKS ${ARG_LINKS} GTest::gtest)
  foreach(ranks IN LISTS ARG_RANKS)
    set(tests)
    if(ARG_THREADS AND ranks GREATER 1)
      list(APPEND tests mpi.${name}.${ranks}_threads)
      add_test(NAME mpi.${name}.${ranks}_threads COMMAND ${name} ${ranks})
    endif()
    if(NOT COPEPOD_SANITIZER)
      list(APPEND tests mpi.${name}.${ranks}_ranks)
      add_test(NAME mpi.${name}.${ranks}_ranks COMMAND ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${ranks}
        --oversubscribe $<TARGET_FILE:${name}>)
    endif()
    set_tests_properties(${tests} PROPERTIES LABELS mpi TIMEOUT ${ARG_TIMEOUT} PROCESSORS ${ranks}
      ENVIRONMENT "OMPI_ALLOW_RUN_AS_ROOT=1;OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1;OMPI_MCA_hwloc_base_binding_policy=none")
  endforeach()
  if(COPEPOD_SANITIZER)
    add_dependencies(sanitized_tests ${name})
  endif()
endfunction()
