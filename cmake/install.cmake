# `cmake --install`: the program, the library with its headers, and the package that find_package(latelight) reads.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/latelight)

install(TARGETS latelight_program COMPONENT program)
install(TARGETS latelight_library EXPORT latelightTargets COMPONENT library FILE_SET HEADERS)
install(EXPORT latelightTargets NAMESPACE latelight:: DESTINATION ${package_folder} COMPONENT library)
configure_package_config_file(cmake/latelightConfig.cmake.in latelightConfig.cmake INSTALL_DESTINATION ${package_folder})
# Before 1.0 a minor version may change the API.
write_basic_package_version_file(latelightConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/latelightConfig.cmake ${PROJECT_BINARY_DIR}/latelightConfigVersion.cmake
  DESTINATION ${package_folder} COMPONENT library)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
