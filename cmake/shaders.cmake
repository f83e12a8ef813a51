# Compiles every shader under src/render and src/study to SPIR-V and embeds it, compressed, by its file name. The first
# line after #version and #extension declares a shader's variants:
#   // variants: layout, multisampled
#
#   variant        compiled                                     macro                        suffix          include
#   layout         once per layout with targets                                              @<layout>       (1)
#   visible        with layout: also per layout without targets                              @<layout>       (1)
#   multisampled   again for several samples per pixel          MULTISAMPLED                 +msaa           (2)
#   sample-layers  with multisampled: again for samples in      MULTISAMPLED, SAMPLE_LAYERS  +sample-layers  (2)
#                  array layers
#   coated         again for materials that may have coats      COATED                       +coated         (3)
#   hits           again per entry of LATELIGHT_HITS            RASTER_HIT, HIT_<HIT>        +<hit>          (5)
#   textured       again for bindless textures                  TEXTURES_BY_INDEX            +indexed        (4)
#
#   (1) gbuffer_layout.h, or gbuffer_read.glsl or gbuffer_write.glsl, which include it
#   (2) multisample.glsl or gbuffer_read.glsl
#   (3) blended.glsl or blended_light.glsl (src/render/transparency), which light blended surfaces
#   (4) fragment_point.glsl, surface_fragment.glsl, surface_point.glsl or blended.glsl, which sample materials' textures
#   (5) raster_hit.glsl (src/render/visibility/compute), which stores a pixel that a triangle covers
#
# Each variant multiplies those above it, and suffixes combine: <file>@<layout>+msaa+indexed. A shader that defines
# MULTISAMPLED itself has only that form, and one that defines ONE_SAMPLE has no multisampled form. For layouts without
# targets, a `visible` shader reads surfaces from the visibility buffer (gbuffer_read.glsl): it has no +msaa form there,
# and every form is also compiled as +indexed.
#
# Hits are the ways in which the raster compute stores a covered pixel, except that of opaque triangles, which has no
# suffix. Hits that sample textures are also compiled as +indexed, without a declaration.
set(LATELIGHT_HITS masked blended overdraw lens lens-blended)
set(LATELIGHT_TEXTURED_HITS masked lens lens-blended)

set(LATELIGHT_SPIRV ${PROJECT_BINARY_DIR}/spirv)
# Debug information contains the sources and their paths, so release builds omit it.
set(LATELIGHT_SHADER_DEBUG $<$<NOT:$<CONFIG:Release>>:-g>)
# spirv-opt simplifies the shaders of release builds, function by function. It must not change rounding, and its -O and
# -Os rearrange arithmetic. Then functions are inlined, because lavapipe compiles inlined code five times as fast, which
# saves a third of the time of a small picture. Dead code is removed before the passes whose time grows with the square
# of a function's length. Forms with descriptor indexing, which lavapipe does not support, keep their functions, because
# the driver of an H200 compiles those faster. So do shaders with the line `// functions: kept`, whose functions have so
# many calls that inlining multiplies the shader's size and lavapipe gains nothing.
find_program(SPIRV_OPT spirv-opt REQUIRED)
find_program(ZSTD zstd REQUIRED)
set(LATELIGHT_SPIRV_OPT ${SPIRV_OPT} --target-env=vulkan1.3 --scalar-block-layout
  --merge-return --scalar-replacement=0 --convert-local-access-chains --ssa-rewrite --eliminate-dead-branches
  --cfg-cleanup --eliminate-dead-code-aggressive)
set(LATELIGHT_SPIRV_INLINE
  --inline-entry-points-exhaustive --eliminate-dead-functions --eliminate-local-single-store
  --eliminate-dead-code-aggressive --eliminate-dead-branches --cfg-cleanup
  --private-to-local --scalar-replacement=0 --convert-local-access-chains --eliminate-local-single-block
  --eliminate-local-single-store --ssa-rewrite --eliminate-dead-code-aggressive --vector-dce --eliminate-dead-inserts
  --eliminate-dead-branches --cfg-cleanup --eliminate-dead-code-aggressive)

# generated/constant_ids.glsl: `#define NAME ID` for each specialization constant of the files constants.def. They are
# no GLSL constants, which would be part of every shader's SPIR-V.
function(latelight_constant_ids)
  set(text "")
  foreach(folder IN ITEMS vk render/base study)
    set(source ${PROJECT_SOURCE_DIR}/src/${folder}/constants.def)
    set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
    file(STRINGS ${source} lines REGEX "^[A-Z]+_CONSTANT\\(")
    foreach(line IN LISTS lines)
      if(NOT line MATCHES "^[A-Z]+_CONSTANT\\(([A-Za-z]+, )?(k[A-Za-z]+), ([0-9]+)\\)")
        message(FATAL_ERROR "${source}: \"${line}\" is not KIND_CONSTANT([scope, ]name, id)")
      endif()
      string(APPEND text "#define ${CMAKE_MATCH_2} ${CMAKE_MATCH_3}\n")
    endforeach()
  endforeach()
  latelight_generate(constant_ids.glsl "${text}")
endfunction()

# latelight_compile_shader(source name includes out): returns the file of SPIR-V, in LATELIGHT_SPIRV.
function(latelight_compile_shader source name includes out)
  set(spirv ${LATELIGHT_SPIRV}/${name}.spv)
  set(simplify ${LATELIGHT_SPIRV_OPT})
  file(STRINGS ${source} kept REGEX "^// functions: kept$")
  if(NOT name MATCHES "\\+indexed" AND NOT kept)
    list(APPEND simplify ${LATELIGHT_SPIRV_INLINE})
  endif()
  add_custom_command(
    OUTPUT ${spirv}
    COMMAND ${GLSLANG} --quiet --target-env vulkan1.3 ${LATELIGHT_SHADER_DEBUG} -I${PROJECT_SOURCE_DIR}/src -I${LATELIGHT_GENERATED} ${includes}
            --depfile ${spirv}.d -o ${spirv} ${source}
    COMMAND "$<$<CONFIG:Release>:${simplify};${spirv};-o;${spirv}>"
    COMMAND_EXPAND_LISTS
    MAIN_DEPENDENCY ${source}
    DEPFILE ${spirv}.d
    VERBATIM
    COMMENT "Compiling shader ${name}")
  set(${out} ${spirv} PARENT_SCOPE)
endfunction()

# latelight_embed_shader(spirv symbol out): appends the compressed shader to an assembly file's text, from `symbol` to
# `symbolEnd`. Compression divides the size of the program by three.
function(latelight_embed_shader spirv symbol out)
  add_custom_command(
    OUTPUT ${spirv}.zst
    COMMAND ${ZSTD} -19 --quiet --force ${spirv} -o ${spirv}.zst
    DEPENDS ${spirv}
    VERBATIM
    COMMENT "")
  set(${out} "${${out}}.global ${symbol}, ${symbol}End
.hidden ${symbol}, ${symbol}End
${symbol}:
.incbin \"${spirv}.zst\"
${symbol}End:
" PARENT_SCOPE)
endfunction()

# latelight_declared_variants(source out): returns the variants that a shader declares, checked against its includes.
function(latelight_declared_variants source out)
  get_filename_component(file ${source} NAME)
  file(READ ${source} text)
  set(declared "")
  if(text MATCHES "^(#(version|extension)[^\n]*\n)*// variants: ([^\n]*)\n")
    string(REPLACE ", " ";" declared "${CMAKE_MATCH_3}")
  endif()
  set(used "")
  if(text MATCHES "#include \"(gbuffer_layout\\.h|render/glsl/gbuffer_(read|write)\\.glsl)\"")
    list(APPEND used layout)
  endif()
  if(text MATCHES "#include \"render/glsl/(multisample|gbuffer_read)\\.glsl\"" AND NOT text MATCHES "#define (MULTISAMPLED|ONE_SAMPLE)")
    list(APPEND used multisampled)
  endif()
  if(text MATCHES "#include \"render/(visibility/fragment_point|visibility/surface_fragment|visibility/compute/surface_point|transparency/blended)\\.glsl\"" AND NOT text MATCHES "#define BINDS_TEXTURES")
    list(APPEND used textured)
  endif()
  if(text MATCHES "#include \"render/transparency/blended(_light)?\\.glsl\"")
    list(APPEND used coated)
  endif()
  if(text MATCHES "#include \"render/visibility/compute/raster_hit\\.glsl\"")
    list(APPEND used hits)
  endif()
  list(JOIN used ", " wanted)
  foreach(variant IN LISTS used)
    if(NOT variant IN_LIST declared)
      message(FATAL_ERROR "${file} has an include that differs by ${variant} but does not say so: its first line behind #version and #extension must be \"// variants: ${wanted}\".")
    endif()
  endforeach()
  if("multisampled" IN_LIST used)
    list(APPEND used sample-layers)
  endif()
  if("layout" IN_LIST used)
    list(APPEND used visible)
  endif()
  foreach(variant IN LISTS declared)
    if(NOT variant IN_LIST used)
      message(FATAL_ERROR "${file} declares the variant \"${variant}\", but includes nothing that differs by it.")
    endif()
  endforeach()
  set(${out} ${declared} PARENT_SCOPE)
endfunction()

# latelight_shaders(module): embeds the shaders in that module. generated/shaders.inc lists SHADER(symbol, "name") for
# each.
function(latelight_shaders module)
  latelight_constant_ids()
  file(MAKE_DIRECTORY ${LATELIGHT_SPIRV})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS
    ${PROJECT_SOURCE_DIR}/src/render/*.vert ${PROJECT_SOURCE_DIR}/src/render/*.frag ${PROJECT_SOURCE_DIR}/src/render/*.comp
    ${PROJECT_SOURCE_DIR}/src/study/*.comp)
  set(table "")
  set(assembly ".section .rodata\n")
  set(compiled)
  set(files)
  set(index 0)
  foreach(source IN LISTS sources)
    get_filename_component(file ${source} NAME)
    if(file IN_LIST files)
      message(FATAL_ERROR "Two shaders are called ${file}, and a shader is found by its name: rename ${source}")
    endif()
    list(APPEND files ${file})
    set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
    latelight_declared_variants(${source} declared)
    set(variants "-")
    if("layout" IN_LIST declared)
      set(variants ${LATELIGHT_LAYOUTS_WITH_TARGETS})
    endif()
    set(several "")
    if("multisampled" IN_LIST declared)
      list(TRANSFORM variants APPEND "+msaa" OUTPUT_VARIABLE several)
    endif()
    if("sample-layers" IN_LIST declared)
      list(TRANSFORM variants APPEND "+sample-layers" OUTPUT_VARIABLE sample_layers)
      list(APPEND several ${sample_layers})
    endif()
    list(APPEND variants ${several})
    if("coated" IN_LIST declared)
      list(TRANSFORM variants APPEND "+coated" OUTPUT_VARIABLE coated)
      list(APPEND variants ${coated})
    endif()
    if("hits" IN_LIST declared)
      foreach(hit IN LISTS LATELIGHT_HITS)
        list(APPEND variants "-+${hit}")
      endforeach()
      foreach(hit IN LISTS LATELIGHT_TEXTURED_HITS)
        list(APPEND variants "-+${hit}+indexed")
      endforeach()
    endif()
    if("textured" IN_LIST declared)
      list(TRANSFORM variants APPEND "+indexed" OUTPUT_VARIABLE indexed)
      list(APPEND variants ${indexed})
    endif()
    if("visible" IN_LIST declared)
      set(visible ${LATELIGHT_LAYOUTS_WITHOUT_TARGETS})
      if("sample-layers" IN_LIST declared)
        list(TRANSFORM visible APPEND "+sample-layers" OUTPUT_VARIABLE sample_layers)
        list(APPEND visible ${sample_layers})
      endif()
      list(TRANSFORM visible APPEND "+indexed" OUTPUT_VARIABLE indexed)
      list(APPEND variants ${visible} ${indexed})
    endif()
    foreach(variant IN LISTS variants)
      string(REGEX REPLACE "\\+.*" "" layout ${variant})
      string(REPLACE "@-" "" name ${file}@${variant})
      set(includes "")
      if(NOT layout STREQUAL "-")
        list(APPEND includes -I${LATELIGHT_GENERATED}/layout/${layout})
      endif()
      if(variant MATCHES "\\+msaa")
        list(APPEND includes -DMULTISAMPLED)
      endif()
      if(variant MATCHES "\\+sample-layers")
        list(APPEND includes -DMULTISAMPLED -DSAMPLE_LAYERS)
      endif()
      if(variant MATCHES "\\+coated")
        list(APPEND includes -DCOATED)
      endif()
      foreach(hit IN LISTS LATELIGHT_HITS)
        if(variant MATCHES "\\+${hit}(\\+|$)")
          string(TOUPPER ${hit} macro)
          string(REPLACE "-" "_" macro ${macro})
          list(APPEND includes -DRASTER_HIT -DHIT_${macro})
        endif()
      endforeach()
      if(variant MATCHES "\\+indexed")
        list(APPEND includes -DTEXTURES_BY_INDEX)
      endif()
      latelight_compile_shader(${source} ${name} "${includes}" spirv)
      list(APPEND compiled ${spirv}.zst)
      string(APPEND table "SHADER(latelightShader${index}, \"${name}\")\n")
      latelight_embed_shader(${spirv} latelightShader${index} assembly)
      math(EXPR index "${index} + 1")
    endforeach()
  endforeach()
  string(APPEND assembly ".section .note.GNU-stack,\"\",@progbits\n")
  latelight_generate(shaders.inc "${table}")
  latelight_generate(shaders.S "${assembly}")
  set_source_files_properties(${LATELIGHT_GENERATED}/shaders.S PROPERTIES OBJECT_DEPENDS "${compiled}")
  target_sources(latelight_${module} PRIVATE ${LATELIGHT_GENERATED}/shaders.S)
  add_custom_target(latelight_spirv DEPENDS ${compiled})
endfunction()
