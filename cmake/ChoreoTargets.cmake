# How every target of this project is made: language, warnings, sanitizers, and one library a folder.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)

option(CHOREO_FUZZ "Build the fuzzers (target fuzzers); needs clang" OFF)
option(CHOREO_WERROR "Warnings are errors" OFF)
set(CHOREO_SANITIZE "" CACHE STRING "Sanitizers for everything built here, such as address,undefined or thread")

find_program(CCACHE ccache)
if(CCACHE)
  # Depend mode trusts the compiler's own list of headers and skips the preprocessor. Paths below the checkout are made
  # relative and the working directory is left out of the hash, so that another checkout elsewhere finds everything.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_DEPEND=1 CCACHE_SLOPPINESS=pch_defines,time_macros
    CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${CCACHE})
endif()

add_library(choreo_settings INTERFACE)
target_compile_options(choreo_settings INTERFACE
  -pthread  # Everywhere, since precompiled headers are refused where it defines other macros.
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-qual -Wimplicit-fallthrough
  # False alarms of g++ 12 about std::string (GCC bug 105651), some only where its header is precompiled.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<BOOL:${CHOREO_PCH}>>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>
  # Sums of products must be the same on every machine and at every optimisation level.
  -ffp-contract=off
  $<$<BOOL:${CHOREO_WERROR}>:-Werror>)
if(CHOREO_SANITIZE)
  target_compile_definitions(choreo_settings INTERFACE CHOREO_SANITIZED)
  target_compile_options(choreo_settings INTERFACE -fsanitize=${CHOREO_SANITIZE} -fno-omit-frame-pointer)
  if(NOT CHOREO_SANITIZE STREQUAL "thread")
    target_compile_options(choreo_settings INTERFACE -fno-sanitize-recover=all)
  endif()
  target_link_options(choreo_settings INTERFACE -fsanitize=${CHOREO_SANITIZE})
endif()

if(CHOREO_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "CHOREO_FUZZ needs clang: cmake --preset asan")
  endif()
  # Everything is watched, so that the fuzzers see which way their input went.
  target_compile_options(choreo_settings INTERFACE -fsanitize=fuzzer-no-link)
endif()

# choreo_library(NAME [PUBLIC libs...] [PRIVATE libs...] SOURCES ... [HEADERS ...])
# Makes the static library choreo_NAME of the calling folder, known as choreoscope::NAME, with its sources one by one.
function(choreo_library name)
  cmake_parse_arguments(ARG "" "" "PUBLIC;PRIVATE;SOURCES;HEADERS" ${ARGN})
  add_library(choreo_${name} STATIC ${ARG_SOURCES} ${ARG_HEADERS})
  add_library(choreoscope::${name} ALIAS choreo_${name})
  set_target_properties(choreo_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(choreo_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/choreoscope>)
  target_compile_features(choreo_${name} PUBLIC cxx_std_20)
  target_link_libraries(choreo_${name} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE} $<BUILD_INTERFACE:choreo_settings>)
  choreo_reuse_precompiled(choreo_${name} choreo_library_headers)
endfunction()

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

# choreo_test(NAME [ALONE] [LABELS label] [TIMEOUT seconds] [LIBRARIES_FROM folder] [LIBS libs...] SOURCES ...)
# Makes a GoogleTest program whose cases CTest runs one by one; ALONE, where they watch the real clock, with nothing
# beside them. Shared libraries that lie in LIBRARIES_FROM stand in for those of the system. The label is unit unless
# said otherwise. The target unit_tests builds these programs but the end-to-end ones, and threaded_tests those of the
# label unit_threaded, which are what the thread sanitizer is for.
add_custom_target(unit_tests)
add_custom_target(threaded_tests)
function(choreo_test name)
  cmake_parse_arguments(ARG "ALONE" "TIMEOUT;LIBRARIES_FROM" "LABELS;LIBS;SOURCES" ${ARGN})
  if(NOT ARG_LABELS)
    set(ARG_LABELS unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(${name} PRIVATE ${ARG_LIBS} GTest::gmock GTest::gtest_main choreo_settings)
  target_compile_options(${name} PRIVATE ${choreo_test_optimisation})
  if(ARG_LIBS)  # Of a test by itself the precompiled headers are not known.
    choreo_reuse_precompiled(${name} choreo_test_headers)
  endif()
  if(CHOREO_SANITIZE STREQUAL "thread")
    target_sources(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support/one_worker.cpp)
    target_link_libraries(${name} PRIVATE TBB::tbb OpenCVParts::core)
  endif()
  if(NOT ARG_LABELS MATCHES end_to_end)
    add_dependencies(unit_tests ${name})
  endif()
  if(ARG_LABELS MATCHES threaded)
    add_dependencies(threaded_tests ${name})
  endif()
  set(replaced)
  if(ARG_LIBRARIES_FROM)
    set(replaced ENVIRONMENT_MODIFICATION "LD_LIBRARY_PATH=path_list_prepend:${ARG_LIBRARIES_FROM}")
  endif()
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${ARG_TIMEOUT} RUN_SERIAL ${ARG_ALONE} ${choreo_test_environment} ${replaced})
endfunction()
