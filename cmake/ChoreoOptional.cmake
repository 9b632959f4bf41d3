# Devices whose libraries may be missing: CHOREO_WITH_X is AUTO (built where the library is there), ON or OFF.

# choreo_optional(FREENECT "Kinect v1" libfreenect libfreenect-dev)
# Looks for the pkg-config module. Sets CHOREO_HAS_FREENECT to 1 or 0, CHOREO_SUMMARY_FREENECT to a few words, and makes
# PkgConfig::FREENECT.
macro(choreo_optional name what module package)
  set(CHOREO_WITH_${name} AUTO CACHE STRING "${what}: AUTO, ON or OFF")
  set_property(CACHE CHOREO_WITH_${name} PROPERTY STRINGS AUTO ON OFF)
  set(CHOREO_HAS_${name} 0)
  if(CHOREO_WITH_${name} STREQUAL "OFF")
    set(CHOREO_SUMMARY_${name} "off (CHOREO_WITH_${name})")
  else()
    pkg_check_modules(${name} IMPORTED_TARGET ${module})
    if(${name}_FOUND)
      set(CHOREO_HAS_${name} 1)
      set(CHOREO_SUMMARY_${name} "on (${module} ${${name}_VERSION})")
    elseif(CHOREO_WITH_${name} STREQUAL "ON")
      message(FATAL_ERROR "CHOREO_WITH_${name} is ON, but ${module} is missing: apt-get install ${package}")
    else()
      set(CHOREO_SUMMARY_${name} "off (${module} is missing: apt-get install ${package})")
    endif()
  endif()
endmacro()
