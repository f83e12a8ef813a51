# latelight_module(name USES modules... LIBRARIES libraries...): src/<name>/**.cpp as the static library latelight_<name>.
function(latelight_module name)
  cmake_parse_arguments(M "" "" "USES;LIBRARIES" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  add_library(latelight_${name} STATIC ${sources})
  target_include_directories(latelight_${name} PUBLIC
    ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src ${LATELIGHT_GENERATED})
  target_link_libraries(latelight_${name} PUBLIC glm::glm fmt::fmt ${M_LIBRARIES})
  foreach(other IN LISTS M_USES)
    target_link_libraries(latelight_${name} PUBLIC latelight_${other})
  endforeach()
  add_dependencies(latelight_${name} latelight_registry)
  set_property(GLOBAL APPEND PROPERTY LATELIGHT_MODULES latelight_${name})
endfunction()
