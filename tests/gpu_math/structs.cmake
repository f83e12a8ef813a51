# Every struct that C++ and shaders share, parsed from the headers, for layouts.comp and layouts_test.cpp:
#   struct_headers.h: includes the headers
#   structs.inc: STRUCT(type, MEMBER(type, member) ...) for each
# Not the texels of G-buffer layouts, which macros make and no memory holds.
function(latelight_shared_structs folder)
  file(GLOB_RECURSE headers RELATIVE ${PROJECT_SOURCE_DIR}/src CONFIGURE_DEPENDS
    ${PROJECT_SOURCE_DIR}/src/shared/*.h ${PROJECT_SOURCE_DIR}/src/render/*_push.h ${PROJECT_SOURCE_DIR}/src/study/*_push.h)
  list(FILTER headers EXCLUDE REGEX "^shared/gbuffer/")
  set(includes "")
  set(table "")
  foreach(header IN LISTS headers)
    set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY
      CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${header})
    string(APPEND includes "#include \"${header}\"\n")
    file(READ ${PROJECT_SOURCE_DIR}/src/${header} text)
    string(REGEX REPLACE "//[^\n]*" "" text "${text}")
    string(REGEX REPLACE "\\\\\n" "" text "${text}")       # a macro is one line
    string(REGEX REPLACE "\\[[^]]*\\]" "" text "${text}")  # lengths of arrays
    string(REPLACE ";" "@" text "${text}")                  # no list yet
    string(REGEX MATCHALL "\n *struct +[A-Za-z0-9_]+[ \n]*{[^}]*}" structs "${text}")
    string(REGEX MATCHALL "\n *struct [^\n]*" begun "${text}")
    list(LENGTH begun wanted)
    list(LENGTH structs found)
    if(NOT found EQUAL wanted)
      message(FATAL_ERROR "${header} has ${wanted} structs, of which ${found} could be read: write them as the others are.")
    endif()
    foreach(struct IN LISTS structs)
      string(REGEX MATCH "struct +([A-Za-z0-9_]+)[ \n]*{([^}]*)}" struct "${struct}")
      set(type ${CMAKE_MATCH_1})
      string(REPLACE "@" ";" declarations "${CMAKE_MATCH_2}")
      set(members "")
      foreach(declaration IN LISTS declarations)
        string(REGEX REPLACE "^[ \n]*[A-Za-z0-9_]+[ \n]+" "" names "${declaration}")  # without its type
        string(REGEX MATCHALL "[A-Za-z0-9_]+" names "${names}")
        foreach(name IN LISTS names)
          string(APPEND members " MEMBER(${type}, ${name})")
        endforeach()
      endforeach()
      string(APPEND table "STRUCT(${type},${members})\n")
    endforeach()
  endforeach()
  file(CONFIGURE OUTPUT ${folder}/struct_headers.h CONTENT "${includes}" @ONLY)
  file(CONFIGURE OUTPUT ${folder}/structs.inc CONTENT "${table}" @ONLY)
endfunction()
