// The images that every lighting shader binds in set 0: after the G-buffer if the shader includes gbuffer_read.glsl
// first, else from binding 0. render/frame/lit_maps.h binds them on the host. They are the prefiltered specular
// environments (octahedral, one mip level per roughness, each with its own border), the diffuse environments, the
// split-sum table, the table of lobes, and both environments with floats if the first are halves
// (kEnvironmentTwoTypes), then the shadow atlas and ambient occlusion, which are read without filtering.
#ifndef LATELIGHT_LIT_MAPS_GLSL
#define LATELIGHT_LIT_MAPS_GLSL
#include "render/glsl/setup.glsl"

#ifdef GBUFFER_BINDINGS
#define LIT_MAPS_BINDING GBUFFER_BINDINGS
#else
#define LIT_MAPS_BINDING 0
#endif
#define AFTER_LIT_MAPS (LIT_MAPS_BINDING + 8)  // the first binding after the maps

layout(set = 0, binding = LIT_MAPS_BINDING) uniform sampler2DArray environmentSpecular;
layout(set = 0, binding = LIT_MAPS_BINDING + 1) uniform sampler2DArray environmentDiffuse;
layout(set = 0, binding = LIT_MAPS_BINDING + 2) uniform sampler2D reflectanceTable;
layout(set = 0, binding = LIT_MAPS_BINDING + 3) uniform sampler2D lobeTable;
layout(set = 0, binding = LIT_MAPS_BINDING + 4) uniform sampler2DArray environmentSpecularFloats;
layout(set = 0, binding = LIT_MAPS_BINDING + 5) uniform sampler2DArray environmentDiffuseFloats;
layout(set = 0, binding = LIT_MAPS_BINDING + 6) uniform sampler2DArray shadowAtlas;
layout(set = 0, binding = LIT_MAPS_BINDING + 7) uniform sampler2DArray ambientOcclusion;

// Returns the unoccluded fraction of the hemisphere over a pixel of a view.
float visibleHemisphere(ivec3 place) {
  if (kAmbientOcclusion == 0u) return 1.0;
  return texelFetch(ambientOcclusion, place, 0).r;
}

#endif
