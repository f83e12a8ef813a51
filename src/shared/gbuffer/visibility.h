// visibility: no G-buffer. Lighting reads the visible triangle of each pixel from the visibility buffer of the compute
// rasterizer, and evaluates its material on the spot (Burns and Hunt 2013, The Visibility Buffer: A Cache-Friendly
// Approach to Deferred Shading, JCGT 2(2)). Nothing is packed, so no precision is lost: the lit values equal those of
// `exact`.
#ifndef LATELIGHT_SHARED_GBUFFER_VISIBILITY_H
#define LATELIGHT_SHARED_GBUFFER_VISIBILITY_H

#include "shared/gbuffer.h"

#define GBUFFER_NO_TARGETS
#define GBUFFER_DESCRIPTION "no G-buffer: lighting evaluates materials from the visibility buffer's triangles"
#define GBUFFER_FIXED_NORMAL "what the material gives where it is lit"
#define GBUFFER_FIXED_POSITION "where rays meet triangles"
#define GBUFFER_TARGETS(T)

#endif
