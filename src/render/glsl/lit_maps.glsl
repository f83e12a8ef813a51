// The maps that every lit shader binds, together in set 0: after the G-buffer where the shader reads one
// (gbuffer_read.glsl comes first), else from binding 0 on. render/frame/lit_maps.h is their other side. The environment's:
// prefiltered specular (octahedral, one mip a roughness level, each with its own border), diffuse, the split-sum table,
// and the table of lobes. Then the shadow atlas and ambient occlusion, which are only ever fetched from.
#ifndef LATELIGHT_LIT_MAPS_GLSL
#define LATELIGHT_LIT_MAPS_GLSL
#include "render/glsl/setup.glsl"

#ifdef GBUFFER_BINDINGS
#define LIT_MAPS_BINDING GBUFFER_BINDINGS
#else
#define LIT_MAPS_BINDING 0
#endif
#define AFTER_LIT_MAPS (LIT_MAPS_BINDING + 6)  // the first binding after them

layout(set = 0, binding = LIT_MAPS_BINDING) uniform sampler2D environmentSpecular;
layout(set = 0, binding = LIT_MAPS_BINDING + 1) uniform sampler2D environmentDiffuse;
layout(set = 0, binding = LIT_MAPS_BINDING + 2) uniform sampler2D reflectanceTable;
layout(set = 0, binding = LIT_MAPS_BINDING + 3) uniform sampler2D lobeTable;
layout(set = 0, binding = LIT_MAPS_BINDING + 4) uniform sampler2DArray shadowAtlas;
layout(set = 0, binding = LIT_MAPS_BINDING + 5) uniform sampler2DArray ambientOcclusion;

// The share of the hemisphere over a pixel of a view that nothing near hides.
float visibleHemisphere(ivec3 place) {
  if (kAmbientOcclusion == 0u) return 1.0;
  return texelFetch(ambientOcclusion, place, 0).r;
}

#endif
