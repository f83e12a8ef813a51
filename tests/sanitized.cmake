# Tests that need neither a device nor shaders run once more with the address and undefined-behavior sanitizers: among
# them are those of all readers and writers of scene and image files. Only the modules are compiled again. The objects of
# the tests are those of the tests without sanitizers, which take most of a compiler's time; `./dev test asan` compiles
# everything with sanitizers.
if(NOT CMAKE_BUILD_TYPE STREQUAL Release)
  return()
endif()

set(sanitized_modules base scene scene_textures scene_environment scene_gltf scene_builtin scene_mesh_files scene_load
  output export)
set_property(SOURCE ${PROJECT_SOURCE_DIR}/src/base/version.cpp APPEND PROPERTY
  COMPILE_DEFINITIONS LATELIGHT_VERSION="${PROJECT_VERSION}")
set(sanitized_objects)
foreach(module IN LISTS sanitized_modules)
  set(target sanitized_${module})
  get_target_property(sources latelight_${module} SOURCES)
  list(FILTER sources INCLUDE REGEX "[.]cpp$")
  add_library(${target} OBJECT EXCLUDE_FROM_ALL ${sources})
  latelight_unity(${target} ${sources})
  target_link_libraries(${target} PRIVATE latelight_${module})
  target_include_directories(${target} PRIVATE $<TARGET_PROPERTY:latelight_${module},INCLUDE_DIRECTORIES>)
  target_compile_definitions(${target} PRIVATE $<TARGET_PROPERTY:latelight_${module},COMPILE_DEFINITIONS>)
  target_compile_options(${target} PRIVATE -O1 -g1 ${sanitizers})
  if(module STREQUAL base)
    target_precompile_headers(${target} PRIVATE ${PROJECT_SOURCE_DIR}/cmake/precompiled.h)
  else()
    target_precompile_headers(${target} REUSE_FROM sanitized_base)
  endif()
  list(APPEND sanitized_objects $<TARGET_OBJECTS:${target}>)
endforeach()

# Objects of modules come first: of functions in headers, which several objects contain, the linker keeps the first one.
get_property(host_tests GLOBAL PROPERTY latelight_host_tests)
foreach(test IN LISTS host_tests)
  set(target test_${test}_sanitized)
  add_executable(${target} ${sanitized_objects} $<TARGET_OBJECTS:test_${test}>)
  set_target_properties(${target} PROPERTIES LINKER_LANGUAGE CXX)
  # What the modules themselves are linked with: nothing is left that their own libraries would define.
  target_link_libraries(${target} PRIVATE $<TARGET_PROPERTY:test_${test},LINK_LIBRARIES> latelight_scene_load latelight_export)
  target_link_options(${target} PRIVATE -fsanitize=address,undefined)
  add_test(NAME ${test}_sanitized COMMAND ${in_part} 4 $<TARGET_FILE:${target}> --gtest_brief=0)
  set_tests_properties(${test}_sanitized PROPERTIES LABELS sanitizers TIMEOUT ${time_limit})
endforeach()
# Left out: what integrates over environments and builds halls for minutes, and reads no files.
set_tests_properties(scene_sanitized PROPERTIES
  ENVIRONMENT GTEST_FILTER=-*SunsBeyond*:*LevelsAre*:*SunOfOnePixel*:*DiscLights*:*Resizing*:Hall.*)
