#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, multisampled, sample-layers
// Virtual shadow maps, first pass: marks the pages that the surfaces of the G-buffer may look up, for each light that
// reaches them. The marking is conservative: it uses the lookup point and the maximum distance from it at which the
// lookup (shadow.glsl) reads texels. Inputs: the G-buffer, push.lights. Output: push.asked, a bit mask of pages.
#include "render/glsl/common.glsl"
#define GBUFFER_SAMPLED_ONLY
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/lanes.glsl"
#include "render/glsl/pixel_group.glsl"
#include "render/shadow/page_push.h"
#include "shared/light.h"
#include "shared/shadow.h"

layout(push_constant, scalar) uniform Push { PagesRequestedPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PagedLightRef { PagedLight v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer RequestedRef { uint v[]; };

// --- one map --------------------------------------------------------------------------------------------------------

// The maximum distance from the point, in texels, at which the lookup reads: the displacement of the point plus the
// reach of the filter. The point is moved along its normal by at most shadowRadius(), which is 2.1 texels, or 4.3
// texels at the edge of the widest map. kMoved allows a fifth more, because the point may move to where texels are that
// much smaller.
float reachAround(ShadowMap m, ShadowPoint p) {
  const float kMoved = 6.0;
  float reach = shadowReach(kShadowFilter);
  if (kShadowFilter == kShadowFilterPcss) {
    // No blocker is nearer than the near end of the map, so the blocker search at that distance has the widest radius,
    // and no penumbra is wider.
    float near = -m.depthOffset / m.depthScale;
    float search = 1.25 * shadowPenumbra(m, p.away + kMoved * p.width, near) / p.width;
    reach = clamp(search, reach, kShadowWidest * m.size) + 1.0;
  }
  return reach + kMoved;
}

// Marks the pages of the map that the lookup of the point may read.
void request(ShadowMap m, ShadowPoint p) {
  float reach = reachAround(m, p);
  vec2 last = vec2(m.size - 1.0);
  uvec2 low = uvec2(clamp(p.texel - reach, vec2(0.0), last)) / kShadowPage;
  uvec2 high = uvec2(clamp(p.texel + reach, vec2(0.0), last)) / kShadowPage;
  uint span = (~0u >> (31u - (high.x - low.x))) << low.x;
  RequestedRef requested = RequestedRef(push.requested);
  uvec2 cell = m.corner / kShadowCell;
  for (uint row = low.y; row <= high.y; ++row) {
    uint word = (m.layer * push.down + cell.y + row) * push.across + cell.x;
    if ((requested.v[word] & span) != span) atomicOr(requested.v[word], span);
  }
}

// --- one light ------------------------------------------------------------------------------------------------------

// Marks pages of the finest cascade that contains the point. If rounding may decide whether it does, marks pages of the
// next coarser cascade as well.
void requestCascades(FrameConstants frame, LightShadow shadow, vec3 position) {
  float margin = shadowReach(kShadowFilter) + 0.5;
  bool sure = false;
  for (uint i = 0u; i < shadow.maps && !sure; ++i) {
    ShadowMap m = frameShadowMap(frame, shadow.first + i);
    ShadowPoint p = shadowPoint(m, position);
    if (shadowInside(m, p.texel, margin - 1.0)) request(m, p);
    sure = shadowInside(m, p.texel, margin + 1.0);
  }
}

// Marks pages of a spot light's map, or of the cube face that contains the point. If rounding may decide between faces,
// marks pages of each of them.
void requestCubeFaces(FrameConstants frame, LightShadow shadow, vec3 light, vec3 position) {
  vec3 toPoint = position - light, along = abs(toPoint);
  float nearly = 0.999 * max(along.x, max(along.y, along.z));
  for (uint i = 0u; i < shadow.maps; ++i) {
    float onAxis = (i & 1u) == 0u ? toPoint[i >> 1u] : -toPoint[i >> 1u];
    if (shadow.maps == 6u && onAxis < nearly) continue;
    ShadowMap m = frameShadowMap(frame, shadow.first + i);
    ShadowPoint p = shadowPoint(m, position);
    if (p.away > 0.0) request(m, p);
  }
}

// --- one surface ----------------------------------------------------------------------------------------------------

struct LaneLight {
  vec3 position;
  float radius;
  uint type;
  LightShadow shadow;
};

LaneLight lightInView(FrameConstants frame, uint view, uint number) {
  PagedLight paged = PagedLightRef(push.lights).v[number];
  Light light = frameLight(frame, paged.light);
  LightShadow shadow = LightShadowRef(frame.lightShadows).v[view * frame.shadowColumns + paged.column];
  const float kRounding = 1.001;
  return LaneLight(light.position, light.radius * kRounding, light.type, shadow);
}

LaneLight ofLane(LaneLight own, uint lane) {
  return LaneLight(fromLane(own.position, lane), fromLane(own.radius, lane),
                    fromLane(own.type, lane),
                    LightShadow(fromLane(own.shadow.first, lane), fromLane(own.shadow.maps, lane), 0u));
}

// Returns true if the light casts shadows and may reach into the box.
bool reachesInto(LaneLight l, vec3 low, vec3 high) {
  vec3 d = max(max(low - l.position, l.position - high), vec3(0.0));
  return l.shadow.maps != 0u && (lightIsDirectional(l.type) || dot(d, d) < l.radius * l.radius);
}

void requestForLight(FrameConstants frame, LaneLight l, vec3 position) {
  if (lightIsDirectional(l.type))
    requestCascades(frame, l.shadow, position);
  else
    requestCubeFaces(frame, l.shadow, l.position, position);
}

// Marks the pages for a surface's position. The lanes of a subgroup each test one light against the box around all
// positions of the subgroup. Every invocation of the subgroup must call it; `there` is false for those without a
// surface.
void requestAt(FrameConstants frame, uint view, vec3 position, bool there) {
  const float kFar = 3.0e38;
  vec3 low = subgroupMin(there ? position : vec3(kFar)), high = subgroupMax(there ? position : vec3(-kFar));
  for (uint first = 0u; first < push.lightCount; first += lanesPresent) {
    uint number = first + laneRank;
    LaneLight own = lightInView(frame, view, min(number, push.lightCount - 1u));
    uvec4 hits = subgroupBallot(number < push.lightCount && reachesInto(own, low, high));
    if (!anyLane(hits)) continue;
    do {
      LaneLight l = ofLane(own, popLane(hits));
      if (there && reachesInto(l, position, position)) requestForLight(frame, l, position);
    } while (anyLane(hits));
  }
}

#ifdef MULTISAMPLED
void requestAtPixel(FrameConstants frame, View view, ivec3 place, bool inside) {
  uint surfaces = inside ? countSurfaces(pixelSurfaces, place).x : 0u, most = subgroupMax(surfaces);
  for (uint i = 0u; i < most; ++i) {
    bool there = i < surfaces;
    uint samples = there ? surfaceSamples(pixelSurfaces, place, i) : 0u;
    vec3 position = vec3(0.0);
    if (there) position = readSurface(view, place, samples, depthOfSamples(gbufferDepth, place, samples), 1.0).position;
    requestAt(frame, uint(place.z), position, there);
  }
}
#else
void requestAtPixel(FrameConstants frame, View view, ivec3 place, bool inside) {
  float depth = inside ? texelFetch(gbufferDepth, place, 0).r : 0.0;
  vec3 position = vec3(0.0);
  if (depth != 0.0) position = readSurface(view, place, depth, 1.0).position;
  requestAt(frame, uint(place.z), position, depth != 0.0);
}
#endif

void main() {
  ivec3 place = ownPixel();
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  View view = frameView(frame, uint(place.z));
  countLanes();
  requestAtPixel(frame, view, place, all(lessThan(vec2(place.xy), view.size)));
}
