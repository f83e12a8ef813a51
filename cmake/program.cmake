# Builds the program `latelight` and the library `latelight`, which exports only the public headers in
# include/latelight.
include(CheckCXXCompilerFlag)
find_package(CLI11 REQUIRED)
get_property(modules GLOBAL PROPERTY LATELIGHT_MODULES)
set_property(SOURCE ${PROJECT_SOURCE_DIR}/src/base/version.cpp APPEND PROPERTY
  COMPILE_DEFINITIONS LATELIGHT_VERSION="${PROJECT_VERSION}")

# `latelight render` as an object library, because tests also call it in their own process.
file(GLOB render_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/app/render*.cpp)
list(APPEND render_sources ${PROJECT_SOURCE_DIR}/app/parse.cpp)
add_library(latelight_render_command OBJECT ${render_sources})
latelight_unity(latelight_render_command ${render_sources})
target_precompile_headers(latelight_render_command REUSE_FROM latelight_base)
latelight_uses(latelight_render_command app_render PATHS app USES data)
target_link_libraries(latelight_render_command PUBLIC CLI11::CLI11)

file(GLOB app_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/app/*.cpp)
list(REMOVE_ITEM app_sources ${render_sources})
if(LATELIGHT_VIEWER)
  file(GLOB viewer_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/app/view/*.cpp)
  list(APPEND app_sources ${viewer_sources})
endif()
add_executable(latelight_program ${app_sources})
latelight_unity(latelight_program ${app_sources})
set_target_properties(latelight_program PROPERTIES OUTPUT_NAME latelight RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
latelight_uses(latelight_program app PATHS app USES study report data serve export)
target_link_libraries(latelight_program PUBLIC latelight_render_command)
if(LATELIGHT_VIEWER)
  target_compile_definitions(latelight_program PRIVATE LATELIGHT_VIEWER GLFW_INCLUDE_NONE)
  target_link_libraries(latelight_program PRIVATE glfw PkgConfig::imgui X11::X11)
  set_property(SOURCE ${PROJECT_SOURCE_DIR}/app/view/display.cpp PROPERTY SKIP_UNITY_BUILD_INCLUSION ON)
endif()
# These targets consist mostly of templates from headers; with less optimization they compile in two thirds of the time.
# GCC 13 and later on x86 turn two options off with -O1 that have to be as they were in the precompiled header.
set(less_optimized -O1)
foreach(option munroll-only-small-loops mvzeroupper)
  check_cxx_compiler_flag(-${option} LATELIGHT_HAS_${option})
  if(LATELIGHT_HAS_${option})
    list(APPEND less_optimized -${option})
  endif()
endforeach()
foreach(target latelight_render_command latelight_program latelight_serve)
  target_compile_options(${target} PRIVATE "$<$<CONFIG:Release>:${less_optimized}>")
endforeach()
set_source_files_properties(${PROJECT_SOURCE_DIR}/src/serve/picture.cpp PROPERTIES
  SKIP_UNITY_BUILD_INCLUSION ON COMPILE_OPTIONS $<$<CONFIG:Release>:-O3>)

# The library consists of every module's objects, because no code inside it refers to the API's functions. Linking the
# modules in addition only adds their dependencies. Its target is not named `latelight`, which is the program's name in
# the build folder.
file(GLOB public_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/include/latelight/*.h
  ${PROJECT_SOURCE_DIR}/include/latelight/*.def)
# Modules that only the program uses.
list(REMOVE_ITEM modules latelight_study latelight_report latelight_data latelight_view latelight_serve)
list(TRANSFORM modules REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>" OUTPUT_VARIABLE objects)
set(exports ${PROJECT_SOURCE_DIR}/cmake/exports.map)
add_library(latelight_library SHARED ${objects})
add_library(latelight::latelight ALIAS latelight_library)
set_target_properties(latelight_library PROPERTIES
  OUTPUT_NAME latelight EXPORT_NAME latelight LINKER_LANGUAGE CXX LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}
  VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
  LINK_DEPENDS ${exports})
target_link_libraries(latelight_library PRIVATE ${modules})
target_link_options(latelight_library PRIVATE LINKER:--version-script=${exports})
if(NOT LATELIGHT_SANITIZE)  # the program provides a sanitizer's functions
  target_link_options(latelight_library PRIVATE LINKER:--no-undefined)
endif()
target_sources(latelight_library PUBLIC
  FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR}/include FILES ${public_headers})
target_compile_features(latelight_library PUBLIC cxx_std_20)

include(cmake/interface.cmake)
include(cmake/install.cmake)
