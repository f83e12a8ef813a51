# Unity builds: about eight sources of a folder are compiled together. Their headers are then read only once, which more
# than halves the build time. Groups depend only on the names of sources, so a new file does not move others.
# -DLATELIGHT_UNITY=OFF compiles each source separately.
option(LATELIGHT_UNITY "Compile sources in groups" ON)
function(latelight_unity target)
  if(NOT LATELIGHT_UNITY)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # GCC treats the sources of a group as headers, whose types in unnamed namespaces it warns about.
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-subobject-linkage>)
  set(folders)
  foreach(source IN LISTS ARGN)
    file(STRINGS ${source} library REGEX "^#define [A-Z_]+_IMPLEMENTATION" LIMIT_COUNT 1)
    if(library)
      continue()  # the source instantiates a header-only library by macros
    endif()
    get_filename_component(folder ${source} DIRECTORY)
    # Relative to the project: with the checkout's absolute path in a group's name, the compiler cache would miss in
    # other checkouts.
    file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${folder})
    string(MAKE_C_IDENTIFIER "${folder}" folder)
    list(APPEND folders ${folder})
    list(APPEND in_${folder} ${source})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(folder IN LISTS folders)
    list(LENGTH in_${folder} count)
    set(groups 1)
    while(count GREATER 12)
      math(EXPR groups "${groups} * 2")
      math(EXPR count "(${count} + 1) / 2")
    endwhile()
    foreach(source IN LISTS in_${folder})
      get_filename_component(name ${source} NAME)
      string(MD5 hash ${name})
      string(SUBSTRING ${hash} 0 4 hash)
      math(EXPR group "0x${hash} % ${groups}")
      set_property(SOURCE ${source} PROPERTY UNITY_GROUP "${folder}_${group}")
    endforeach()
  endforeach()
endfunction()

# latelight_module(name USES modules... LIBRARIES libraries...): compiles src/<name>/**.cpp to the static library
# latelight_<name>.
function(latelight_module name)
  cmake_parse_arguments(M "" "" "USES;LIBRARIES" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  add_library(latelight_${name} STATIC ${sources})
  latelight_unity(latelight_${name} ${sources})
  target_include_directories(latelight_${name} PUBLIC
    ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src ${LATELIGHT_GENERATED})
  target_link_libraries(latelight_${name} PUBLIC glm::glm fmt::fmt ${M_LIBRARIES})
  if(name STREQUAL base)
    target_precompile_headers(latelight_base PRIVATE ${PROJECT_SOURCE_DIR}/cmake/precompiled.h)
  else()
    target_precompile_headers(latelight_${name} REUSE_FROM latelight_base)
  endif()
  foreach(other IN LISTS M_USES)
    target_link_libraries(latelight_${name} PUBLIC latelight_${other})
  endforeach()
  add_dependencies(latelight_${name} latelight_registry)
  set_property(GLOBAL APPEND PROPERTY LATELIGHT_MODULES latelight_${name})
endfunction()

# latelight_text(generated path): generates a file's text as a C++ string literal, to be included.
function(latelight_text generated path)
  set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${path})
  file(READ ${PROJECT_SOURCE_DIR}/${path} text)
  latelight_generate(${generated} "R\"text(${text})text\"\n")
endfunction()

# latelight_page(generated folder): generates the files of a web page, {"name", "text"} each, as C++ string literals to
# be included.
function(latelight_page generated folder)
  file(GLOB files RELATIVE ${PROJECT_SOURCE_DIR}/${folder} CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${folder}/*)
  set(list "")
  foreach(file IN LISTS files)
    latelight_text(${folder}/${file}.inc ${folder}/${file})
    string(APPEND list "{\"${file}\",\n#include \"${folder}/${file}.inc\"\n},\n")
  endforeach()
  latelight_generate(${generated} "${list}")
endfunction()
