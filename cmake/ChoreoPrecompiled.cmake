# Precompiled headers. Of the time that a file takes to compile two thirds go into the headers of the standard library,
# OpenCV, fmt and GoogleTest: they are read once for the libraries and once for the tests. Nothing of our own is among
# them, and no file may rely on them: the preset dev goes without.
option(CHOREO_PCH "Precompile the headers of other people that most files include" ON)

set(choreo_common_headers
  <algorithm> <array> <atomic> <chrono> <cmath> <condition_variable> <cstdint> <deque> <filesystem> <fstream>
  <functional> <map> <memory> <mutex> <numeric> <optional> <random> <set> <span> <stop_token> <string> <string_view>
  <thread> <utility> <variant> <vector> <fmt/format.h> <opencv2/core.hpp> <opencv2/imgproc.hpp>)

file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/precompiled/library.cpp CONTENT "")
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/precompiled/program.cpp CONTENT "int main() { return 0; }\n")

# What the libraries share; called when the packages were found.
function(choreo_precompile_for_libraries)
  add_library(choreo_library_headers STATIC EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/precompiled/library.cpp)
  target_link_libraries(choreo_library_headers PRIVATE fmt::fmt OpenCVParts::imgproc choreo_settings)
  if(CHOREO_PCH)
    target_precompile_headers(choreo_library_headers PRIVATE ${choreo_common_headers})
  endif()
endfunction()

# choreo_precompile_for_programs(NAME [LIBS libs...] [OPTIONS options...] HEADERS headers...)
# What programs that are compiled with the same options share: the common headers and some of their own.
function(choreo_precompile_for_programs name)
  cmake_parse_arguments(ARG "" "" "LIBS;OPTIONS;HEADERS" ${ARGN})
  add_executable(${name} EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/precompiled/program.cpp)
  target_link_libraries(${name} PRIVATE fmt::fmt OpenCVParts::imgproc ${ARG_LIBS} choreo_settings)
  target_compile_options(${name} PRIVATE ${ARG_OPTIONS})
  if(CHOREO_PCH)
    target_precompile_headers(${name} PRIVATE ${choreo_common_headers} ${ARG_HEADERS})
  endif()
endfunction()

# choreo_reuse_precompiled(TARGET FROM)
function(choreo_reuse_precompiled name from)
  if(CHOREO_PCH)
    target_precompile_headers(${name} REUSE_FROM ${from})
  endif()
endfunction()
