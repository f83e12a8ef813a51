// Evaluates the visible surface of a pixel from the visibility buffer, for gbuffer_read.glsl with a layout without
// targets.
#ifndef LATELIGHT_SHOWN_SURFACE_GLSL
#define LATELIGHT_SHOWN_SURFACE_GLSL
#include "render/glsl/surface.glsl"
#include "render/visibility/compute/shown_push.h"
#include "render/visibility/compute/surface_point.glsl"
#include "render/visibility/compute/visible.glsl"

uint64_t shownFrame;  // FrameConstants
VisibleSurfacePush shown;

// Call it before visibleSurface().
void bindSurfaces(uint64_t frame, VisibleSurfacePush push) {
  shownFrame = frame;
  shown = push;
#ifndef TEXTURES_BY_INDEX
  textureRecords = FrameRef(frame).v.textures;
#endif
}

// Returns the surface that these covered samples show, at their center on the first sample's triangle.
Surface visibleSurface(View view, ivec3 pixel, uint samples) {
  FrameConstants frame = frameOf(shownFrame, uint(pixel.z));
  uint index = visibleIndex(uvec3(pixel), uvec2(view.size)) + uint(max(findLSB(samples), 0));
  VisibleTriangle t = visibleTriangle(frame, shown.instances, visibleId(VisibleRef(shown.visible).v[index]));
  SurfacePoint p = visiblePoint(frame, view, t, vec2(pixel.xy) + sampleCentroid(samples));
  return evaluateMaterial(frame, frameMaterial(frame, frameInstance(frame, t.draw.instance).material), p);
}

#endif
