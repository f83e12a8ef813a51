# Planted shaders whose first lines and includes differ, and what the configure step says of them.
# usage: cmake -DWORK=FOLDER -P run.cmake       (with -DSOURCE=FILE: configures that one shader)
cmake_minimum_required(VERSION 3.24)
include(${CMAKE_CURRENT_LIST_DIR}/../../cmake/shaders.cmake)

if(SOURCE)
  latelight_declared_variants(${SOURCE} declared)
  message(STATUS "variants: [${declared}]")
  return()
endif()

# expect(text sentence): with these lines a shader planted.comp is answered with that sentence.
function(expect text sentence)
  file(WRITE ${WORK}/planted.comp "#version 460\n#extension GL_GOOGLE_include_directive : require\n${text}")
  execute_process(COMMAND ${CMAKE_COMMAND} -DSOURCE=${WORK}/planted.comp -P ${CMAKE_CURRENT_LIST_FILE}
    OUTPUT_VARIABLE said ERROR_VARIABLE said)
  string(REGEX REPLACE "[ \n]+" " " said "${said}")  # messages are wrapped
  string(FIND "${said}" "${sentence}" place)
  if(place EQUAL -1)
    message(FATAL_ERROR "Of\n${text}is said\n${said}\nand not\n${sentence}")
  endif()
endfunction()

set(layout "#include \"gbuffer_layout.h\"\n")
set(samples "#include \"render/glsl/multisample.glsl\"\n")
set(both "#include \"render/glsl/gbuffer_read.glsl\"\n")
set(textures "#include \"render/visibility/fragment_point.glsl\"\n")
set(hits "#include \"render/visibility/compute/raster_hit.glsl\"\n")
set(add "its first line behind #version and #extension must be")

expect("void main() {}\n" "variants: []")
expect("// variants: layout\n${layout}" "variants: [layout]")
expect("// variants: layout, visible\n${layout}" "variants: [layout;visible]")
expect("// variants: visible\nvoid main() {}\n"
  "planted.comp declares the variant \"visible\", but includes nothing that differs by it.")
expect("// variants: multisampled\n${samples}" "variants: [multisampled]")
expect("// variants: layout, multisampled\n${both}" "variants: [layout;multisampled]")
expect("// variants: multisampled, sample-layers\n${samples}" "variants: [multisampled;sample-layers]")
expect("// variants: layout\n#define ONE_SAMPLE\n${both}" "variants: [layout]")
expect("// variants: hits\n${hits}" "variants: [hits]")
expect("// variants: textured\n${textures}" "variants: [textured]")
expect("#define MULTISAMPLED\n${samples}" "variants: []")

expect("${layout}" "planted.comp has an include that differs by layout but does not say so: ${add} \"// variants: layout\".")
expect("// variants: layout\n${both}"
  "planted.comp has an include that differs by multisampled but does not say so: ${add} \"// variants: layout, multisampled\".")
expect("${samples}// variants: multisampled\n" "planted.comp has an include that differs by multisampled but does not say so")
expect("${textures}" "planted.comp has an include that differs by textured but does not say so: ${add} \"// variants: textured\".")
expect("// variants: layout\nvoid main() {}\n"
  "planted.comp declares the variant \"layout\", but includes nothing that differs by it.")
expect("// variants: multisampled\n#define ONE_SAMPLE\n${samples}"
  "planted.comp declares the variant \"multisampled\", but includes nothing that differs by it.")
expect("// variants: layouts\nvoid main() {}\n"
  "planted.comp declares the variant \"layouts\", but includes nothing that differs by it.")
