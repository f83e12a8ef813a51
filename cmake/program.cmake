# The program `latelight` and the library `latelight` (public headers in include/latelight, nothing else exported).
find_package(CLI11 REQUIRED)
get_property(modules GLOBAL PROPERTY LATELIGHT_MODULES)

file(GLOB app_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/app/*.cpp)
add_executable(latelight_program ${app_sources})
set_target_properties(latelight_program PROPERTIES OUTPUT_NAME latelight RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
target_link_libraries(latelight_program PRIVATE latelight_render CLI11::CLI11)
target_compile_definitions(latelight_program PRIVATE LATELIGHT_VERSION="${PROJECT_VERSION}")
