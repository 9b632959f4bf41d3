# How every target of this project is made: language, warnings, sanitizers, one library a folder, one test a program.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)

option(CHOREO_FUZZ "Build the fuzzers (target fuzzers); needs clang" OFF)
option(CHOREO_UNITY "Compile the sources of a target several at a time" OFF)
option(CHOREO_WERROR "Warnings are errors" OFF)
set(CHOREO_SANITIZE "" CACHE STRING "Sanitizers for everything built here, such as address,undefined or thread")

find_program(CCACHE ccache)
if(CCACHE)
  # Depend mode trusts the compiler's own list of headers and skips the preprocessor. Paths below the checkout are made
  # relative and the working directory is left out of the hash, so that another checkout elsewhere finds everything.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_DEPEND=1 CCACHE_SLOPPINESS=time_macros
    CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${CCACHE})
endif()

add_library(choreo_settings INTERFACE)
target_compile_options(choreo_settings INTERFACE
  -pthread
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-qual -Wimplicit-fallthrough
  # False alarms of g++ 12 about std::string (GCC bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # It takes an included source for a header.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<BOOL:${CHOREO_UNITY}>>:-Wno-subobject-linkage>
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

# choreo_parsers(SOURCES...)
# Of these the fuzzers see which way their input went. Before the library is made.
function(choreo_parsers)
  if(CHOREO_FUZZ)
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS -fsanitize=fuzzer-no-link)
  endif()
endfunction()
if(CHOREO_FUZZ AND NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  message(FATAL_ERROR "CHOREO_FUZZ needs clang: cmake --preset asan")
endif()

# Two thirds of what a file takes to compile are other people's headers: with CHOREO_UNITY eight sources share them. The
# preset dev compiles each by itself, and so tells what a file forgets to include.
#
# choreo_sources(TARGET SOURCES...)
# Adds sources to a target, several to a compilation unit but for those with options of their own (set these before). Not
# CMake's UNITY_BUILD: until 4.1 it writes absolute paths, and the compiler cache would miss in every other checkout.
function(choreo_sources target)
  set(alone)
  set(joined)
  foreach(source IN LISTS ARGN)
    get_source_file_property(options ${source} COMPILE_OPTIONS)
    get_source_file_property(definitions ${source} COMPILE_DEFINITIONS)
    if(CHOREO_UNITY AND NOT options AND NOT definitions)
      list(APPEND joined ${source})
    else()
      list(APPEND alone ${source})
    endif()
  endforeach()
  target_sources(${target} PRIVATE ${alone})
  list(LENGTH joined count)
  math(EXPR units "(${count} + 7) / 8")  # Of equal size: the longest decides when all are done.
  set(number 0)
  foreach(source IN LISTS joined)
    math(EXPR unit "${number} * ${units} / ${count}")
    math(EXPR number "${number} + 1")
    cmake_path(ABSOLUTE_PATH source NORMALIZE)
    cmake_path(RELATIVE_PATH source BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
    string(APPEND text_${unit} "#include \"${source}\"\n")
  endforeach()
  if(joined)
    math(EXPR last "${units} - 1")
    foreach(unit RANGE ${last})
      set(file ${CMAKE_CURRENT_BINARY_DIR}/unity/${target}_${unit}.cpp)
      file(CONFIGURE OUTPUT ${file} CONTENT "${text_${unit}}" @ONLY)
      target_sources(${target} PRIVATE ${file})
    endforeach()
  endif()
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
endfunction()

# choreo_library(NAME [PUBLIC libs...] [PRIVATE libs...] SOURCES ... [HEADERS ...])
# Makes the static library choreo_NAME of the calling folder, known as choreoscope::NAME, with its sources one by one.
function(choreo_library name)
  cmake_parse_arguments(ARG "" "" "PUBLIC;PRIVATE;SOURCES;HEADERS" ${ARGN})
  add_library(choreo_${name} STATIC ${ARG_HEADERS})
  choreo_sources(choreo_${name} ${ARG_SOURCES})
  add_library(choreoscope::${name} ALIAS choreo_${name})
  set_target_properties(choreo_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(choreo_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/choreoscope>)
  target_compile_features(choreo_${name} PUBLIC cxx_std_20)
  target_link_libraries(choreo_${name} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE} $<BUILD_INTERFACE:choreo_settings>)
endfunction()
