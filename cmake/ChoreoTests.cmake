# How tests are made: what runs in which build, and what the sanitizers are told.
#
# Each test program says where it is worth running:
#
#   unit             with AddressSanitizer and UndefinedBehaviorSanitizer (preset asan): all but the end-to-end tests
#   threaded         with ThreadSanitizer as well (preset tsan): what has threads of its own
#   kernel           in the release build as well: what is optimised otherwise there
#   end_to_end       in the release build alone: runs of the program that users run
#   architecture     there alone, too: what includes what
#   measure          there alone, but not with --quick: how good the results are on performers and recordings
#   long             script/test --long: the same cases once more over all seeds
#   v4l2             in the machine with the kernel's camera, with the sanitizers of asan
#
# and the targets unit_tests, threaded_tests, quick_tests, release_tests (with these of quick_tests) and long_tests build the
# programs of these.

include(GoogleTest)

# What the sanitizers are told, so that nobody has to remember it.
set(choreo_test_environment)
if(CHOREO_SANITIZE STREQUAL "thread")
  # OpenCV, FFmpeg and TBB are not instrumented: what they synchronise among themselves cannot be seen. Of TBB the tests
  # take one worker (tests/support/one_worker.cpp); the threads of the pipeline are all there.
  set(choreo_test_environment ENVIRONMENT "TSAN_OPTIONS=ignore_noninstrumented_modules=1")
elseif(CHOREO_SANITIZE MATCHES "address")
  # Leaks are looked for by default.
  set(choreo_test_environment ENVIRONMENT
    "LSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/cmake/leaks.supp:print_suppressions=0")
endif()

# The work is the libraries' and the program's; tests are better compiled soon.
set(choreo_test_optimisation -O1)
if(CHOREO_SANITIZE)
  set(choreo_test_optimisation -O0)
endif()

add_custom_target(unit_tests)
add_custom_target(threaded_tests)
add_custom_target(quick_tests)
add_custom_target(release_tests)
add_dependencies(release_tests quick_tests)
add_custom_target(long_tests)

# choreo_test_program(NAME [OPTIMISED] [LIBS libs...] SOURCES ...)
# Makes a GoogleTest program without a CTest entry. OPTIMISED: with sanitizers, too. For what computes much with Eigen: of its
# templates the linker takes the test's copies, not the library's.
function(choreo_test_program name)
  cmake_parse_arguments(ARG "OPTIMISED" "" "LIBS;SOURCES" ${ARGN})
  set(optimisation ${choreo_test_optimisation})
  if(ARG_OPTIMISED)
    set(optimisation -O1)
  endif()
  add_executable(${name})
  choreo_sources(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(${name} PRIVATE ${ARG_LIBS} GTest::gmock GTest::gtest_main choreo_settings)
  target_compile_options(${name} PRIVATE ${optimisation})
  if(CHOREO_SANITIZE STREQUAL "thread")
    target_sources(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support/one_worker.cpp)
    target_link_libraries(${name} PRIVATE TBB::tbb OpenCVParts::core)
  endif()
endfunction()

# choreo_test(NAME [ALONE] [EACH] [LONG] [OPTIMISED] [LABELS labels...] [TIMEOUT seconds] [SHARDS n] [LIBRARIES_FROM folder] [LIBS libs...] SOURCES ...)
# Makes a GoogleTest program and one CTest entry, or SHARDS of them that share its cases; a failure names its case. EACH:
# an entry for every case, where a process can run but one.
# ALONE: with nothing beside it, where it watches the real clock. LONG: in the long lane, too, where it does more (see
# support/long_lane.hpp). Shared libraries that lie in LIBRARIES_FROM stand in for
# those of the system. The label is unit unless said otherwise.
function(choreo_test name)
  cmake_parse_arguments(ARG "ALONE;EACH;LONG;OPTIMISED" "TIMEOUT;SHARDS;LIBRARIES_FROM" "LABELS;LIBS;SOURCES" ${ARGN})
  if(NOT ARG_LABELS)
    set(ARG_LABELS unit)
  endif()
  foreach(label IN LISTS ARG_LABELS)
    if(NOT label MATCHES "^(unit|threaded|kernel|end_to_end|architecture|measure)$")
      message(FATAL_ERROR "${name} has the label ${label}, which runs nowhere: see cmake/ChoreoTests.cmake")
    endif()
  endforeach()
  if(CMAKE_CURRENT_SOURCE_DIR MATCHES "end_to_end$" AND ARG_LABELS MATCHES "unit")
    message(FATAL_ERROR "${name} is no unit test: give it LABELS end_to_end or measure")
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 600)  # A guard against hanging, on a loaded machine, too.
  endif()
  if(NOT ARG_SHARDS)
    set(ARG_SHARDS 1)
  endif()
  set(optimised)
  if(ARG_OPTIMISED)
    set(optimised OPTIMISED)
  endif()
  choreo_test_program(${name} ${optimised} LIBS ${ARG_LIBS} SOURCES ${ARG_SOURCES})
  if(ARG_LABELS MATCHES "unit")
    add_dependencies(unit_tests ${name})
  endif()
  if(ARG_LABELS MATCHES "threaded")
    add_dependencies(threaded_tests ${name})
  endif()
  if(ARG_LABELS MATCHES "kernel|end_to_end|architecture")
    add_dependencies(quick_tests ${name})
  elseif(ARG_LABELS MATCHES "measure")
    add_dependencies(release_tests ${name})
  endif()
  if(ARG_LONG)
    add_dependencies(long_tests ${name})
  endif()
  set(replaced)
  if(ARG_LIBRARIES_FROM)
    set(replaced "LD_LIBRARY_PATH=path_list_prepend:${ARG_LIBRARIES_FROM}")
  endif()
  list(JOIN ARG_LABELS "_" labels)
  set(properties LABELS ${labels} TIMEOUT ${ARG_TIMEOUT} RUN_SERIAL ${ARG_ALONE} ${choreo_test_environment})
  if(ARG_EACH)
    gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES ${properties} ENVIRONMENT_MODIFICATION "${replaced}")
    return()
  endif()
  math(EXPR last "${ARG_SHARDS} - 1")
  foreach(shard RANGE ${last})
    set(test ${name})
    if(ARG_SHARDS GREATER 1)
      math(EXPR number "${shard} + 1")
      set(test ${name}.${number}_of_${ARG_SHARDS})
    endif()
    # Of what went well one line is enough.
    add_test(NAME ${test} COMMAND ${name} --gtest_brief=1)
    set_tests_properties(${test} PROPERTIES ${properties})
    set(modification "GTEST_TOTAL_SHARDS=set:${ARG_SHARDS}" "GTEST_SHARD_INDEX=set:${shard}" ${replaced})
    set_property(TEST ${test} PROPERTY ENVIRONMENT_MODIFICATION "${modification}")
    if(ARG_LONG)
      add_test(NAME ${test}.long COMMAND ${name})
      set_tests_properties(${test}.long PROPERTIES LABELS long TIMEOUT 3600)
      set_property(TEST ${test}.long PROPERTY ENVIRONMENT_MODIFICATION "${modification}" CHOREO_LONG=set:1)
    endif()
  endforeach()
endfunction()
