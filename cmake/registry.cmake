# Registries: one file per G-buffer layout, normal encoding or type of light, one folder per lighting technique. The
# build lists the folders and generates the files that the code includes; no other code names the entries.
set(LATELIGHT_GENERATED ${PROJECT_BINARY_DIR}/generated)

# latelight_list(out glob directories?): returns the names, without extension, of the folders or headers that match.
function(latelight_list out glob directories)
  file(GLOB entries CONFIGURE_DEPENDS LIST_DIRECTORIES true ${PROJECT_SOURCE_DIR}/${glob})
  set(names)
  foreach(entry IN LISTS entries)
    if((directories AND IS_DIRECTORY ${entry}) OR (NOT directories AND entry MATCHES "\\.h$"))
      get_filename_component(name ${entry} NAME_WE)
      list(APPEND names ${name})
    endif()
  endforeach()
  list(SORT names)
  set(${out} ${names} PARENT_SCOPE)
endfunction()

# Rewrites a generated file only when its text changes.
function(latelight_generate path text)
  file(CONFIGURE OUTPUT ${LATELIGHT_GENERATED}/${path} CONTENT "${text}" @ONLY)
endfunction()

# latelight_numbered(out names...): returns X(name, number) for each.
function(latelight_numbered out)
  set(table "")
  set(index 0)
  foreach(name IN LISTS ARGN)
    string(APPEND table " X(${name}, ${index})")
    math(EXPR index "${index} + 1")
  endforeach()
  set(${out} "${table}" PARENT_SCOPE)
endfunction()

latelight_list(LATELIGHT_LAYOUTS src/shared/gbuffer/* FALSE)
# Layouts without targets, whose shaders differ by more than the targets that they read and write.
set(LATELIGHT_LAYOUTS_WITH_TARGETS)
set(LATELIGHT_LAYOUTS_WITHOUT_TARGETS)
foreach(name IN LISTS LATELIGHT_LAYOUTS)
  set(source ${PROJECT_SOURCE_DIR}/src/shared/gbuffer/${name}.h)
  set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
  file(STRINGS ${source} without REGEX "define GBUFFER_NO_TARGETS")
  if(without)
    list(APPEND LATELIGHT_LAYOUTS_WITHOUT_TARGETS ${name})
  else()
    list(APPEND LATELIGHT_LAYOUTS_WITH_TARGETS ${name})
  endif()
endforeach()
latelight_list(LATELIGHT_NORMALS src/shared/normal/* FALSE)
latelight_list(LATELIGHT_LIGHTS src/shared/light/* FALSE)
latelight_list(LATELIGHT_LIGHTING src/render/lighting/* TRUE)

# generated/normals.h (GLSL and C++): every encoding, numbered in alphabetical order, and the switch over them.
set(includes "")
set(constants "")
set(channels "")
set(hemisphere "")
set(encode "")
set(decode "")
set(index 0)
foreach(name IN LISTS LATELIGHT_NORMALS)
  string(APPEND includes "#include \"shared/normal/${name}.h\"\n")
  string(APPEND constants "SH_CONST uint kNormal_${name} = ${index}u;\n")
  string(APPEND channels "  if (encoding == ${index}u) return kNormalChannels_${name};\n")
  string(APPEND hemisphere "  if (encoding == ${index}u) return kNormalHemisphere_${name} != 0u;\n")
  string(APPEND encode "  if (encoding == ${index}u) return encodeNormal_${name}(n, levels);\n")
  string(APPEND decode "  if (encoding == ${index}u) return decodeNormal_${name}(e, levels);\n")
  math(EXPR index "${index} + 1")
endforeach()
latelight_numbered(table ${LATELIGHT_NORMALS})
latelight_generate(normals.h "// Written by cmake/registry.cmake from the files in src/shared/normal.
#ifndef LATELIGHT_GENERATED_NORMALS_H
#define LATELIGHT_GENERATED_NORMALS_H
${includes}
SH_BEGIN
${constants}
// Channels the encoding stores: 2 or 3.
SH_FUNC uint normalChannels(uint encoding) {
${channels}  return 0u;
}
// Whether only normals with z >= 0 come back.
SH_FUNC bool normalHemisphereOnly(uint encoding) {
${hemisphere}  return false;
}
// Channels in [0, 1] of a unit normal; `levels` is 2^bits - 1 of each channel, 0 for float channels.
SH_FUNC vec3 encodeNormal(uint encoding, vec3 n, vec3 levels) {
${encode}  return vec3(0.0f, 0.0f, 0.0f);
}
// Unit normal of stored channels.
SH_FUNC vec3 decodeNormal(uint encoding, vec3 e, vec3 levels) {
${decode}  return vec3(0.0f, 0.0f, 1.0f);
}
SH_END
#define LATELIGHT_NORMALS(X)${table}
#endif
")

# generated/light_types.h (GLSL and C++): every type of light, numbered in alphabetical order (shared/light.h).
set(includes "")
set(constants "")
set(directional "")
set(cone "")
set(area "")
set(distribution "")
set(index 0)
foreach(name IN LISTS LATELIGHT_LIGHTS)
  string(SUBSTRING ${name} 0 1 first)
  string(SUBSTRING ${name} 1 -1 rest)
  string(TOUPPER ${first} first)
  string(APPEND includes "#include \"shared/light/${name}.h\"\n")
  string(APPEND constants "SH_CONST uint kLight${first}${rest} = ${index}u;\n")
  string(APPEND directional " ||\n         (type == ${index}u && kLightReach_${name} == kReachEverywhere)")
  string(APPEND cone " ||\n         (type == ${index}u && kLightReach_${name} == kReachCone)")
  string(APPEND area " ||\n         (type == ${index}u && kLightReach_${name} == kReachArea)")
  set(source ${PROJECT_SOURCE_DIR}/src/shared/light/${name}.h)
  set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
  file(STRINGS ${source} shape REGEX "lightDistribution_${name}")
  if(shape)
    string(APPEND distribution "  if (light.type == ${index}u) return lightDistribution_${name}(light, toLight);\n")
  endif()
  math(EXPR index "${index} + 1")
endforeach()
latelight_numbered(table ${LATELIGHT_LIGHTS})
latelight_generate(light_types.h "// Written by cmake/registry.cmake from the files in src/shared/light.
#ifndef LATELIGHT_GENERATED_LIGHT_TYPES_H
#define LATELIGHT_GENERATED_LIGHT_TYPES_H
${includes}
SH_BEGIN
${constants}SH_CONST uint kLightTypes = ${index}u;
// Whether it reaches everywhere, and has a direction and no place.
SH_FUNC bool lightIsDirectional(uint type) {
  return false${directional};
}
// Whether it reaches what is in its cone alone.
SH_FUNC bool lightHasCone(uint type) {
  return false${cone};
}
// Whether it is a shape that emits light.
SH_FUNC bool lightIsArea(uint type) {
  return false${area};
}
// Its intensity in a direction, as a factor. `toLight`: unit, from where it shines on.
SH_FUNC float lightDistribution(Light light, vec3 toLight) {
${distribution}  return 1.0f;
}
SH_END
#define LATELIGHT_LIGHTS(X)${table}
#endif
")

# Generated files for the layouts:
#   layout/<name>/gbuffer_layout.h  the layout that a shader is compiled for (glslang does not support #include MACRO)
#   layouts.inc                     LAYOUT(name) for each layout
#   layout/<name>/layout.cpp        the layout's entry in the registry
set(layouts "")
set(LATELIGHT_LAYOUT_SOURCES)
foreach(name IN LISTS LATELIGHT_LAYOUTS)
  latelight_generate(layout/${name}/gbuffer_layout.h "#include \"shared/gbuffer/${name}.h\"\n")
  latelight_generate(layout/${name}/layout.cpp
    "#define LATELIGHT_LAYOUT ${name}\n#include \"shared/gbuffer/${name}.h\"\n#include \"render/gbuffer/layout_registration.h\"\n")
  list(APPEND LATELIGHT_LAYOUT_SOURCES ${LATELIGHT_GENERATED}/layout/${name}/layout.cpp)
  string(APPEND layouts "LAYOUT(${name})\n")
endforeach()
latelight_generate(layouts.inc "${layouts}")

# generated/lighting.inc: TECHNIQUE(folder) for each lighting technique.
set(techniques "")
foreach(name IN LISTS LATELIGHT_LIGHTING)
  string(APPEND techniques "TECHNIQUE(${name})\n")
endforeach()
latelight_generate(lighting.inc "${techniques}")

add_custom_target(latelight_registry)
