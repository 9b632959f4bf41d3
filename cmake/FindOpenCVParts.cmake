# Finds single OpenCV modules where OpenCVConfig.cmake is absent: Debian ships it only with libopencv-dev, which pulls
# in 247 MB, while libopencv-core-dev and its kind need a quarter of that.
# Components: core, imgproc, ...; makes the imported targets OpenCVParts::core and so on.

find_path(OpenCVParts_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
if(OpenCVParts_INCLUDE_DIR AND EXISTS ${OpenCVParts_INCLUDE_DIR}/opencv2/core/version.hpp)
  file(STRINGS ${OpenCVParts_INCLUDE_DIR}/opencv2/core/version.hpp _lines REGEX "#define CV_VERSION_(MAJOR|MINOR|REVISION) ")
  string(REGEX REPLACE "[^0-9;]" "" _numbers "${_lines}")
  list(JOIN _numbers "." OpenCVParts_VERSION)
endif()
foreach(_part IN LISTS OpenCVParts_FIND_COMPONENTS)
  find_library(OpenCVParts_${_part}_LIBRARY opencv_${_part})
  if(OpenCVParts_${_part}_LIBRARY)
    set(OpenCVParts_${_part}_FOUND TRUE)
  endif()
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCVParts REQUIRED_VARS OpenCVParts_INCLUDE_DIR
  VERSION_VAR OpenCVParts_VERSION HANDLE_COMPONENTS)

foreach(_part IN LISTS OpenCVParts_FIND_COMPONENTS)
  if(OpenCVParts_FOUND AND NOT TARGET OpenCVParts::${_part})
    add_library(OpenCVParts::${_part} UNKNOWN IMPORTED)
    set_target_properties(OpenCVParts::${_part} PROPERTIES
      IMPORTED_LOCATION ${OpenCVParts_${_part}_LIBRARY}
      INTERFACE_INCLUDE_DIRECTORIES ${OpenCVParts_INCLUDE_DIR})
    if(NOT _part STREQUAL core)
      set_property(TARGET OpenCVParts::${_part} PROPERTY INTERFACE_LINK_LIBRARIES OpenCVParts::core)
    endif()
  endif()
endforeach()
mark_as_advanced(OpenCVParts_INCLUDE_DIR)
