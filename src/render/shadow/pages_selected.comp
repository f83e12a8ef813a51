#version 460
#extension GL_GOOGLE_include_directive : require
// Virtual shadow maps, second pass: selects the marked pages of each map that have not been drawn yet. One invocation
// processes one row of a map's pages. Inputs: push.maps, push.asked and push.kept, the pages drawn by earlier frames.
// Outputs: push.drawn, the pages to draw, and push.kept, to which they are added.
#include "render/glsl/common.glsl"
#include "render/shadow/page_push.h"

layout(local_size_x = 32, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { PagesSelectedPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PagedMapRef { PagedMap v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PagesRef { uint v[]; };

void main() {
  uint row = gl_GlobalInvocationID.x, number = gl_GlobalInvocationID.y;
  if (number >= push.mapCount) return;
  PagedMap map = PagedMapRef(push.maps).v[number];
  if (row >= map.rows) return;
  uint word = map.first + row * push.across;
  PagesRef kept = PagesRef(push.kept);
  uint requested = map.whole != 0u ? ~0u >> (32u - map.rows) : PagesRef(push.requested).v[word];
  uint has = map.discarded != 0u ? 0u : kept.v[word];
  PagesRef(push.drawn).v[word] = requested & ~has;
  kept.v[word] = has | requested;
}
