// The surface that a pixel shows, found again in the visibility buffer: what gbuffer_read.glsl reads of a layout
// without targets.
#ifndef LATELIGHT_SHOWN_SURFACE_GLSL
#define LATELIGHT_SHOWN_SURFACE_GLSL
#include "render/glsl/surface.glsl"
#include "render/visibility/compute/shown_push.h"
#include "render/visibility/compute/surface_point.glsl"
#include "render/visibility/compute/visible.glsl"

uint64_t shownFrame;  // FrameConstants
ShownPush shown;

// Before any surface is looked at.
void showSurfaces(uint64_t frame, ShownPush push) {
  shownFrame = frame;
  shown = push;
#ifndef TEXTURES_BY_INDEX
  textureRecords = FrameRef(frame).v.textures;
#endif
}

// Of these samples of a pixel, which show something; in their middle.
Surface shownSurface(View view, ivec3 pixel, uint samples) {
  FrameConstants frame = FrameRef(shownFrame).v;
  uint index = visibleIndex(uvec3(pixel), uvec2(view.size)) + uint(max(findLSB(samples), 0));
  SeenTriangle t = seenTriangle(frame, shown.instances, visibleId(VisibleRef(shown.visible).v[index]));
  SurfacePoint p = seenPoint(frame, view, t, vec2(pixel.xy) + middleOfSamples(samples));
  return evaluateMaterial(frame, frameMaterial(frame, frameInstance(frame, t.rank.instance).material), p);
}

#endif
