# Rules for `cmake --install`: the program, the library with its headers, and the package that find_package(latelight)
# reads.
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
# Documentation that the program generates: its manual page, and completions in the folders where shells search for
# them.
set(said ${PROJECT_BINARY_DIR}/said)
function(latelight_said file folder)
  add_custom_command(OUTPUT ${said}/${file} COMMAND ${CMAKE_COMMAND} -E make_directory ${said}
    COMMAND latelight_program ${ARGN} > ${said}/${file} DEPENDS latelight_program VERBATIM)
  set_property(GLOBAL APPEND PROPERTY LATELIGHT_SAID ${said}/${file})
  install(FILES ${said}/${file} DESTINATION ${folder} COMPONENT program)
endfunction()
latelight_said(latelight.1 ${CMAKE_INSTALL_MANDIR}/man1 man)
latelight_said(latelight ${CMAKE_INSTALL_DATADIR}/bash-completion/completions completions bash)
latelight_said(_latelight ${CMAKE_INSTALL_DATADIR}/zsh/site-functions completions zsh)
latelight_said(latelight.fish ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d completions fish)
get_property(all_said GLOBAL PROPERTY LATELIGHT_SAID)
add_custom_target(latelight_said ALL DEPENDS ${all_said})

install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
