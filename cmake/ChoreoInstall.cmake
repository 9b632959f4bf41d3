# What `cmake --install` puts where: the program with its presets, and the mathematics as a library.

include(CMakePackageConfigHelpers)

install(TARGETS choreoscope RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
if(CHOREO_HAS_OPENNI2)
  install(TARGETS choreoscope-openni2 RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR})
endif()
install(DIRECTORY config/presets DESTINATION ${CMAKE_INSTALL_DATADIR}/choreoscope)
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(CHOREO_MATHEMATICS core vision body similarity recognition)
foreach(_part IN LISTS CHOREO_MATHEMATICS)
  install(TARGETS choreo_${_part} EXPORT choreoscopeTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY src/${_part} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/choreoscope FILES_MATCHING PATTERN "*.hpp"
    # Libraries of their own, which the program alone uses.
    PATTERN "src/vision/network" EXCLUDE PATTERN "src/vision/person" EXCLUDE)
endforeach()

set(CHOREO_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/choreoscope)
install(EXPORT choreoscopeTargets NAMESPACE choreoscope:: DESTINATION ${CHOREO_CMAKE_DIR})
configure_package_config_file(cmake/choreoscopeConfig.cmake.in ${PROJECT_BINARY_DIR}/choreoscopeConfig.cmake
  INSTALL_DESTINATION ${CHOREO_CMAKE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/choreoscopeConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/choreoscopeConfig.cmake ${PROJECT_BINARY_DIR}/choreoscopeConfigVersion.cmake
  cmake/FindOpenCVParts.cmake DESTINATION ${CHOREO_CMAKE_DIR})
