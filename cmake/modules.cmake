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

# --- modules ---------------------------------------------------------------------------------------------------------
#
# A module may include its own folders and those of the modules below it. The build enforces this: a module is compiled
# with an include folder of its own, <build>/include_paths/<module>, in which symbolic links lead to exactly those parts
# of src. Any other include fails with "No such file". Links, and not one folder with headers per module, let every
# include name its file by the path from src.

set(LATELIGHT_INCLUDE_PATHS ${PROJECT_BINARY_DIR}/include_paths)

# latelight_links(folder paths...): makes the folder contain links to these paths of the project, each under its path
# from src (or from the project, for app).
function(latelight_links folder)
  list(REMOVE_DUPLICATES ARGN)
  list(SORT ARGN)
  set(wanted "${PROJECT_SOURCE_DIR}\n${ARGN}\n")
  set(made "")
  if(EXISTS ${folder}.txt)
    file(READ ${folder}.txt made)
  endif()
  if(made STREQUAL wanted)
    return()
  endif()
  file(REMOVE_RECURSE ${folder})
  foreach(path IN LISTS ARGN)
    string(REGEX REPLACE "^src/" "" link ${path})
    get_filename_component(parent ${folder}/${link} DIRECTORY)
    file(MAKE_DIRECTORY ${parent})
    file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${path} ${folder}/${link} SYMBOLIC)
  endforeach()
  file(WRITE ${folder}.txt "${wanted}")
endfunction()

# latelight_uses(target name PATHS paths... USES modules...): links the target with the modules and compiles it with an
# include folder of that name: with these paths of its own, and those of the modules and of all that they use.
function(latelight_uses target name)
  cmake_parse_arguments(U "" "" "PATHS;USES" ${ARGN})
  set(paths ${U_PATHS})
  foreach(other IN LISTS U_USES)
    string(REPLACE / _ other ${other})
    get_property(below GLOBAL PROPERTY LATELIGHT_PATHS_${other})
    if(NOT below)
      message(FATAL_ERROR "${name} uses the module ${other}, which is not declared above it")
    endif()
    list(APPEND paths ${below})
    target_link_libraries(${target} PUBLIC latelight_${other})
  endforeach()
  set_property(GLOBAL PROPERTY LATELIGHT_PATHS_${name} ${paths})
  set(folder ${LATELIGHT_INCLUDE_PATHS}/${name})
  latelight_links(${folder} ${paths})
  target_include_directories(${target} PRIVATE ${folder})
  # Messages, assertions and debuggers name the files in src. (The last map that fits applies.)
  target_compile_options(${target} PRIVATE -ffile-prefix-map=${folder}/=src/)
endfunction()

# latelight_module(name FOLDERS folders... USES modules... LIBRARIES libraries... [OWN_FILES]): compiles the sources in
# these folders of src (by default the one of the module's name) to the static library latelight_<name>, with _ for /.
# OWN_FILES: without subfolders, which are modules of their own.
function(latelight_module path)
  cmake_parse_arguments(M "OWN_FILES" "" "FOLDERS;USES;LIBRARIES" ${ARGN})
  string(REPLACE / _ name ${path})
  if(NOT M_FOLDERS)
    set(M_FOLDERS ${path})
  endif()
  set(sources)
  set(paths)
  foreach(folder IN LISTS M_FOLDERS)
    if(M_OWN_FILES)
      file(GLOB found CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${folder}/*.cpp)
      file(GLOB headers RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${folder}/*.h)
      list(APPEND paths ${headers})
    else()
      file(GLOB_RECURSE found CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${folder}/*.cpp)
      list(APPEND paths src/${folder})
    endif()
    list(APPEND sources ${found})
  endforeach()
  add_library(latelight_${name} STATIC ${sources})
  latelight_unity(latelight_${name} ${sources})
  latelight_uses(latelight_${name} ${name} PATHS ${paths} USES ${M_USES})
  target_include_directories(latelight_${name} PUBLIC ${PROJECT_SOURCE_DIR}/include ${LATELIGHT_GENERATED})
  target_link_libraries(latelight_${name} PUBLIC glm::glm fmt::fmt ${M_LIBRARIES})
  if(name STREQUAL base)
    target_precompile_headers(latelight_base PRIVATE ${PROJECT_SOURCE_DIR}/cmake/precompiled.h)
  else()
    target_precompile_headers(latelight_${name} REUSE_FROM latelight_base)
  endif()
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
