# Generates the functions that load shared structs from device memory. For each struct whose size is a multiple of 16
# bytes, load/<Struct>.glsl has
#
#   Struct loadStruct(uint64_t address)
#
# which loads 16 bytes at once (render/glsl/words.glsl says why). Shaders include it after the struct. A struct
# with an array of structs is loaded in this way up to the first of these. The rest, of which shaders use little, is
# loaded member by member, by the buffer reference <Struct>Ref of the shader.
include(${CMAKE_CURRENT_LIST_DIR}/structs.cmake)

# The number of 32-bit words of each type.
foreach(type IN ITEMS float:1 uint:1 uint64_t:2 vec2:2 uvec2:2 vec3:3 uvec3:3 vec4:4 uvec4:4 mat4x3:12)
  string(REGEX MATCH "(.*):(.*)" type ${type})
  set(latelight_words_${CMAKE_MATCH_1} ${CMAKE_MATCH_2})
endforeach()

# latelight_elements(struct prefix out): returns the members of a struct, and of structs in it, in order, each as "type
# place", and "rest" instead of the first one that is loaded by itself and all after it.
function(latelight_elements struct prefix out)
  set(elements "")
  foreach(member IN LISTS structs_${struct})
    string(REPLACE " " ";" member "${member} 1")
    list(GET member 0 type)
    list(GET member 1 name)
    list(GET member 2 length)
    list(LENGTH member described)
    if(DEFINED latelight_words_${type} AND described EQUAL 3)
      list(APPEND elements "${type} ${prefix}${name}")
    elseif(DEFINED latelight_words_${type} AND length MATCHES "^[0-9]+$")
      math(EXPR last "${length} - 1")
      foreach(i RANGE ${last})
        list(APPEND elements "${type} ${prefix}${name}<${i}>")  # brackets would join elements of the list
      endforeach()
    elseif(DEFINED structs_${type} AND described EQUAL 3)
      latelight_elements(${type} "${prefix}${name}." inner)
      list(APPEND elements ${inner})
    else()
      list(APPEND elements rest)
    endif()
    if("rest" IN_LIST elements)
      break()
    endif()
  endforeach()
  set(${out} "${elements}" PARENT_SCOPE)
endfunction()

# latelight_loaded_value(type first out): returns GLSL of a value whose first word is word `first` of the struct.
function(latelight_loaded_value type first out)
  set(components x y z w)
  math(EXPR end "${first} + ${latelight_words_${type}}")
  set(parts "")
  while(first LESS end)
    math(EXPR quad "${first} / 4")
    math(EXPR next "4 * ${quad} + 4")
    set(swizzle "")
    while(first LESS end AND first LESS next)
      math(EXPR component "${first} % 4")
      list(GET components ${component} component)
      string(APPEND swizzle ${component})
      math(EXPR first "${first} + 1")
    endwhile()
    list(APPEND parts "w${quad}.${swizzle}")
  endwhile()
  list(TRANSFORM parts REPLACE "\\.xyzw$" "")
  if(type STREQUAL "uint64_t")
    list(TRANSFORM parts REPLACE "(.+)" "packUint2x32(\\1)")
  elseif(NOT type MATCHES "^u")
    list(TRANSFORM parts REPLACE "(.+)" "uintBitsToFloat(\\1)")
  endif()
  list(LENGTH parts count)
  list(JOIN parts ", " value)
  if(count GREATER 1)
    set(value "${type}(${value})")
  endif()
  set(${out} "${value}" PARENT_SCOPE)
endfunction()

# Structs that are always in memory of the scene, which sceneWordsAt() loads.
set(latelight_scene_structs
  AreaLight Instance Light Material Mesh RayEmitter RayInstance RayNode RayScene TextureRecord VertexAttributes)

# Those of which shaders use few members, so that GPUs load these one by one.
set(latelight_structs_in_part Mesh RayEmitter RayScene)

# latelight_load(header struct): writes load/<struct>.glsl, if its size is a multiple of 16 bytes.
function(latelight_load header struct)
  latelight_elements(${struct} "" elements)
  set(word 0)
  set(statements "")
  foreach(element IN LISTS elements)
    if(element MATCHES "^(.+) (.+)$")
      set(type ${CMAKE_MATCH_1})
      string(REGEX REPLACE "<(.+)>" "[\\1]" place ${CMAKE_MATCH_2})
      if(type STREQUAL "uint64_t")
        math(EXPR word "(${word} + 1) / 2 * 2")
      endif()
      latelight_loaded_value(${type} ${word} value)
      string(APPEND statements "  s.${place} = ${value};\n")
      math(EXPR word "${word} + ${latelight_words_${type}}")
    endif()
  endforeach()
  set(rest "")
  if("rest" IN_LIST elements)
    set(rest " = ${struct}Ref(address).v")
  endif()
  math(EXPR odd "${word} % 4")
  if(word EQUAL 0 OR (odd AND NOT rest))
    return()
  endif()
  set(load wordsAt)
  if(struct IN_LIST latelight_scene_structs)
    set(load sceneWordsAt)
  endif()
  set(loads "")
  math(EXPR last "(${word} - 1) / 4")
  foreach(quad RANGE ${last})
    string(APPEND loads "  uvec4 w${quad} = ${load}(address, ${quad}u);\n")
  endforeach()
  set(reference "")
  set(body "${loads}${statements}")
  if(struct IN_LIST latelight_structs_in_part)
    # No early return, which would leave a loop of one iteration in the code.
    set(reference
      "layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer ${struct}At { ${struct} v; };\n")
    set(body "  if (kTexelLoads == 0u) {\n  s = ${struct}At(address).v;\n  } else {\n${body}  }\n")
  endif()
  latelight_generate(load/${struct}.glsl "// By cmake/loads.cmake from ${header}.
#ifndef LATELIGHT_LOAD_${struct}
#define LATELIGHT_LOAD_${struct}
#include \"render/glsl/words.glsl\"
${reference}${struct} load${struct}(uint64_t address) {
  ${struct} s${rest};
${body}  return s;
}
#endif
")
  set(latelight_loaded_structs ${latelight_loaded_structs} ${struct} PARENT_SCOPE)
endfunction()

# latelight_loaded_structs: all structs that have such a function.
set(latelight_loaded_structs)
latelight_shared_headers(headers)
foreach(header IN LISTS headers)
  latelight_read_structs(${header} structs)
  set(structs_of_${header} "${structs}")
endforeach()
foreach(header IN LISTS headers)
  foreach(struct IN LISTS structs_of_${header})
    latelight_load(${header} ${struct})
  endforeach()
endforeach()
