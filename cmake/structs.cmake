# The structs that C++ and shaders share, read from their headers: for the functions that load them (cmake/loads.cmake),
# and for the test that compares their layouts in both languages (tests/gpu_math).

# latelight_shared_headers(out): returns the headers with such structs, relative to src. The texels of G-buffer layouts
# are not among them, because macros declare these, and no memory holds them.
function(latelight_shared_headers out)
  file(GLOB_RECURSE headers RELATIVE ${PROJECT_SOURCE_DIR}/src CONFIGURE_DEPENDS
    ${PROJECT_SOURCE_DIR}/src/shared/*.h ${PROJECT_SOURCE_DIR}/src/render/*_push.h ${PROJECT_SOURCE_DIR}/src/study/*_push.h)
  list(FILTER headers EXCLUDE REGEX "^shared/gbuffer/")
  set(${out} ${headers} PARENT_SCOPE)
endfunction()

# latelight_read_structs(header out): returns the names of the header's structs. The variable <out>_<struct> is the list
# of its members, each as "type name" or "type name length" of an array.
function(latelight_read_structs header out)
  set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${header})
  file(READ ${PROJECT_SOURCE_DIR}/src/${header} text)
  string(REGEX REPLACE "//[^\n]*" "" text "${text}")
  string(REGEX REPLACE "\\\\\n" "" text "${text}")                # a macro is one line
  string(REGEX REPLACE "\\[([^]]*)\\]" " \\1" text "${text}")  # brackets would join elements of lists
  string(REPLACE ";" "@" text "${text}")                           # no list yet
  string(REGEX MATCHALL "\n *struct +[A-Za-z0-9_]+[ \n]*{[^}]*}" structs "${text}")
  string(REGEX MATCHALL "\n *struct [^\n]*" begun "${text}")
  list(LENGTH begun wanted)
  list(LENGTH structs found)
  if(NOT found EQUAL wanted)
    message(FATAL_ERROR "${header} has ${wanted} structs, of which ${found} could be read: write them as the others are.")
  endif()
  set(names "")
  foreach(struct IN LISTS structs)
    string(REGEX MATCH "struct +([A-Za-z0-9_]+)[ \n]*{([^}]*)}" struct "${struct}")
    set(name ${CMAKE_MATCH_1})
    string(REPLACE "@" ";" declarations "${CMAKE_MATCH_2}")
    set(members "")
    foreach(declaration IN LISTS declarations)
      string(STRIP "${declaration}" declaration)
      if(declaration MATCHES "^([A-Za-z0-9_]+) +(.+)$")
        set(type ${CMAKE_MATCH_1})
        string(REGEX REPLACE " *, *" ";" declarators "${CMAKE_MATCH_2}")
        list(TRANSFORM declarators PREPEND "${type} ")
        list(APPEND members ${declarators})
      endif()
    endforeach()
    list(APPEND names ${name})
    set(${out}_${name} "${members}" PARENT_SCOPE)
  endforeach()
  set(${out} "${names}" PARENT_SCOPE)
endfunction()
