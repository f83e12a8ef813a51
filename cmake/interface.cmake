# The public functions alone, with debug information, from which `./dev abi` reads the library's interface. The library
# itself has none. What these functions call is left undefined, so nothing else is compiled.
get_target_property(sources latelight_api SOURCES)
add_library(latelight_interface SHARED EXCLUDE_FROM_ALL ${sources} ${PROJECT_SOURCE_DIR}/src/base/error.cpp
  ${PROJECT_SOURCE_DIR}/src/base/memory.cpp ${PROJECT_SOURCE_DIR}/src/base/version.cpp)
latelight_unity(latelight_interface ${sources})
add_dependencies(latelight_interface latelight_registry)
foreach(property INCLUDE_DIRECTORIES COMPILE_DEFINITIONS)
  set_property(TARGET latelight_interface APPEND PROPERTY ${property} $<TARGET_PROPERTY:latelight_api,${property}>)
endforeach()
target_include_directories(latelight_interface SYSTEM PRIVATE
  $<TARGET_PROPERTY:latelight_api,INTERFACE_SYSTEM_INCLUDE_DIRECTORIES>)
target_compile_options(latelight_interface PRIVATE -O0 -g)
target_link_options(latelight_interface PRIVATE LINKER:--version-script=${exports} LINKER:--unresolved-symbols=ignore-all)
set_target_properties(latelight_interface PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/interface)
