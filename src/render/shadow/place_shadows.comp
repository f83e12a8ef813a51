#version 460
#extension GL_GOOGLE_include_directive : require
// Fits the shadow maps of directional lights to a view, one invocation per view: the cascades, their projections and
// everything that the raster and lookups read of them (place_shadows_push.h). It computes in doubles, with the
// operations of the host in the same order, so that the maps have the same bytes as those of fitCascades() and
// planShadows(), where the method is described. Floats are divided as doubles, because devices may round divisions of
// floats otherwise.
#include "render/glsl/common.glsl"
#include "render/shadow/page_push.h"
#include "render/shadow/place_shadows_push.h"
#include "render/visibility/compute/raster_push.h"

layout(local_size_x = kPlaceShadowsGroup) in;
layout(push_constant, scalar) uniform Push { PlaceShadowsPush push; };

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer JobRef { PlacedShadowJob v; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer SunsRef { SunTemplate v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer DoublesRef { double v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewsIn { View v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer FramesIn { FrameConstants v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer TableOut { LightShadow v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer MapsOut { ShadowMap v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ViewsOut { View v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer FramesOut { FrameConstants v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer TargetsOut { ShadowTarget v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer WithinOut { RasterMap v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer WordsOut { uint v[]; };

struct Sphere {
  vec3 center;
  float radius;
};

struct Bounds {
  dvec3 low, high;
};

// --- arithmetic ------------------------------------------------------------------------------------------------------

// Products that are not contracted with sums. They are functions, because glslang 12 may not end if `precise` numbers
// depend on structs.
float times(float a, float b) {
  precise float product = a * b;
  return product;
}
double times(double a, double b) {
  precise double product = a * b;
  return product;
}

float quotient(float a, float b) { return float(double(a) / double(b)); }

double dotOf(dvec3 a, dvec3 b) {
  precise double sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

// Halves are rounded away from 0.
double rounded(double x) {
  double whole = trunc(x);
  return abs(x - whole) >= 0.5lf ? whole + (x < 0.0lf ? -1.0lf : 1.0lf) : whole;
}

// The k-th quarter of an octave above 1.
double quarterOctave(uint k) {
  const double steps[5] = double[5](1.0lf, 1.189207115002721066717lf, 1.414213562373095048802lf,
                                    1.681792830507429086062lf, 2.0lf);
  return steps[k];
}

// Rounds a positive distance to a quarter of an octave, up or down.
double stepped(double d, bool up) {
  uvec2 bits = unpackDouble2x32(d);
  double octave = packDouble2x32(uvec2(0u, bits.y & 0x7ff00000u));
  double share = packDouble2x32(uvec2(bits.x, (bits.y & 0xfffffu) | 0x3ff00000u));  // from 1 to 2
  uint k = 0u;
  while (k < 4u && (up ? quarterOctave(k) < share : quarterOctave(k + 1u) <= share)) ++k;
  return quarterOctave(k) * octave;
}

// --- cascades --------------------------------------------------------------------------------------------------------

float depthOf(mat4x3 m, vec3 p) {
  precise float y = m[0].y * p.x + m[1].y * p.y + m[2].y * p.z + m[3].y * 1.0;
  return y;
}

double preciseDepthOf(mat4x3 m, dvec3 p) {
  precise double y = double(m[0].y) * p.x + double(m[1].y) * p.y + double(m[2].y) * p.z + double(m[3].y) * 1.0lf;
  return y;
}

vec3 pointOnAxis(mat4x3 m, float depth) {
  precise vec3 point = m[0] * 0.0 + m[1] * depth + m[2] * 0.0 + m[3] * 1.0;
  return point;
}

dvec3 cornerOf(Bounds b, uint corner) {
  return dvec3((corner & 1u) != 0u ? b.high.x : b.low.x, (corner & 2u) != 0u ? b.high.y : b.low.y,
               (corner & 4u) != 0u ? b.high.z : b.low.z);
}

double nearestDepth(View view, Bounds bounds) {
  double nearest = packDouble2x32(uvec2(0u, 0x7ff00000u));
  for (uint corner = 0u; corner < 8u; ++corner)
    nearest = min(nearest, preciseDepthOf(view.worldToView, cornerOf(bounds, corner)));
  return nearest;
}

Sphere sphereOf(Bounds b) {
  dvec3 size = b.high - b.low;
  return Sphere(vec3((b.low + b.high) * 0.5lf), max(float(sqrt(dotOf(size, size)) * 0.5lf), 1e-6));
}

// The sphere around the part of the view between two depths.
Sphere around(View view, double near, double far) {
  Projection p = view.projection;
  double x = (1.0lf + abs(double(p.X))) / double(p.H), z = (1.0lf + abs(double(p.Z))) / double(p.V);
  double k = times(x, x) + times(z, z), center, radius;
  if (p.kind == kOrthographic) {
    center = 0.5lf * (near + far);
    radius = sqrt(times(0.25lf * (far - near), far - near) + k);
  } else {
    center = min(0.5lf * (near + far) * (1.0lf + k), far);
    radius = sqrt(times(far - center, far - center) + times(far * far, k));
  }
  return Sphere(pointOnAxis(view.viewToWorld, float(center)), float(radius));
}

// Returns the number of cascades.
uint fitCascades(PlacedShadowJob job, View view, uint camera, Bounds bounds, out Sphere spheres[kMaxCascades]) {
  Sphere scene = sphereOf(bounds);
  double center = double(depthOf(view.worldToView, scene.center)), radius = double(scene.radius);
  DoublesRef numbers = DoublesRef(job.numbers);
  double near = numbers.v[kMaxCascades + 2u * camera], far = numbers.v[kMaxCascades + 2u * camera + 1u];
  double from = view.projection.kind == kOrthographic ? near : 0.0lf;
  double first = max(nearestDepth(view, bounds) - times(1e-3lf, radius), near) - from;
  double last = min(center + radius, far) - from;
  if (!(last > 0.0lf) || !(last > first)) return 0u;
  double end = stepped(last, true), begin = first > 0.0lf ? stepped(first, false) : 0.0lf;
  uint count = 0u;
  for (uint i = 0u; i < kMaxCascades; ++i) {
    double to = times(end, numbers.v[i]);
    if (to <= begin) continue;
    double start = count == 0u ? begin : max(begin, to / 3.0lf);
    Sphere sphere = around(view, from + start, from + to);
    bool whole = sphere.radius >= scene.radius;
    if (whole) sphere = scene;
    spheres[count++] = sphere;
    if (whole) break;
  }
  return count;
}

// --- maps ------------------------------------------------------------------------------------------------------------

struct Axes {
  dvec3 right, away, up;
};

Axes axesOf(PlacedShadowJob job, uint sun) {
  DoublesRef v = DoublesRef(job.axes + uint64_t(sun) * 72ul);
  return Axes(dvec3(v.v[0], v.v[1], v.v[2]), dvec3(v.v[3], v.v[4], v.v[5]), dvec3(v.v[6], v.v[7], v.v[8]));
}

// The projection of an orthographic map: half of its width, its center across and upward, and its depths, in meters.
struct MapFrame {
  double halfWidth, across, upward, near, far;
};

// A coordinate of the center, rounded to texels.
double snapped(double at, double texel) { return times(rounded(at / texel), texel); }

MapFrame frameOfCascade(Axes axes, Sphere sphere, Bounds bounds, uint size) {
  double low = 1e300lf, high = -1e300lf;
  for (uint corner = 0u; corner < 8u; ++corner) {
    double depth = dotOf(axes.away, cornerOf(bounds, corner));
    low = min(low, depth);
    high = max(high, depth);
  }
  const double kMarginTexels = 8.0lf;  // on both sides
  double halfWidth = double(sphere.radius) * double(size) / (double(size) - kMarginTexels);
  double texel = 2.0lf * halfWidth / double(size);
  dvec3 center = dvec3(sphere.center);
  double margin = times(1e-3lf, high - low) + 1e-6lf;
  return MapFrame(halfWidth, snapped(dotOf(axes.right, center), texel), snapped(dotOf(axes.up, center), texel),
                  low - margin, high + margin);
}

Projection projectionOf(MapFrame f) {
  double range = f.far - f.near;
  float scale = float(1.0lf / f.halfWidth);
  return Projection(scale, scale, float(0.5lf / range), float(-0.5lf * f.near / range), float(-f.across / f.halfWidth),
                    float(-f.upward / f.halfWidth), kOrthographic);
}

// With reversed depth, as the raster expects.
Projection reversed(Projection p) {
  float range = quotient(0.5, p.A), near = times(-2.0 * p.B, range), far = near + range;
  return Projection(p.H, p.V, quotient(-1.0, far - near), quotient(far, far - near), p.X, p.Z, p.kind);
}

ShadowMap mapOf(ShadowMap same, Axes axes, MapFrame f, uint size) {
  double middle = 0.5lf * double(size), h = middle / f.halfWidth, range = f.far - f.near;
  ShadowMap m = same;
  m.across = vec4(vec3(axes.right * h), float(middle - times(f.across, h)));
  m.down = vec4(vec3(axes.up * -h), float(middle + times(f.upward, h)));
  m.depthScale = float(1.0lf / range);
  m.depthOffset = float(-f.near / range);
  m.texel = float(1.0lf / h);
  return m;
}

void writeMap(PlacedShadowJob job, uint view, uint sun, uint map, Axes axes, MapFrame f) {
  SunTemplate t = SunsRef(job.suns).v[sun];
  uint tile = map % (job.across * job.across), batch = map - map % job.mapsAtOnce;
  uvec2 corner = uvec2(tile % job.across, tile / job.across) * job.size;
  uint layer = map / (job.across * job.across);
  Projection p = projectionOf(f);
  ShadowMap m = mapOf(t.map, axes, f, job.size);
  float unit = times(m.texel, m.depthScale);
  m.corner = corner;
  m.layer = layer;
  MapsOut(job.maps).v[map] = m;
  View own = t.view;
  own.projection = reversed(p);
  ViewsOut(job.mapViews).v[map] = own;
  FrameConstants frame = FramesIn(job.frames).v[view];
  frame.views = job.mapViews + uint64_t(batch) * uint64_t(kViewBytes);
  frame.previousViews = frame.nextViews = frame.views;
  frame.viewCount = job.mapsAtOnce;
  FramesOut(job.mapFrames).v[map] = frame;
  TargetsOut(job.targets).v[map] =
      ShadowTarget(corner.x, corner.y, layer, p.A, p.B, unit, 0.0, map * job.rows, 1u);
}

void writePages(PlacedShadowJob job, uint map, bool used) {
  WithinOut(job.within).v[map] = RasterMap(vec4(vec3(0.0), 1e18), map * job.rows, 1u);
  for (uint row = 0u; row < job.rows; ++row)
    WordsOut(job.pages).v[map * job.rows + row] = used ? ~0u >> (32u - job.rows) : 0u;
}

void main() {
  PlacedShadowJob job = JobRef(push.job).v;
  uint index = gl_GlobalInvocationID.x;
  if (index >= job.viewCount) return;
  uint world = (job.firstView + index) / job.viewsPerWorld, camera = (job.firstView + index) % job.viewsPerWorld;
  DoublesRef corners = DoublesRef(job.bounds + uint64_t(world) * 48ul);
  Bounds bounds = Bounds(dvec3(corners.v[0], corners.v[1], corners.v[2]), dvec3(corners.v[3], corners.v[4], corners.v[5]));
  View view = ViewsIn(job.views).v[index];
  Sphere spheres[kMaxCascades];
  uint cascades = bounds.low.x > bounds.high.x ? 0u : fitCascades(job, view, camera, bounds, spheres);
  for (uint sun = 0u; sun < job.sunCount; ++sun) {
    Axes axes = axesOf(job, sun);
    uint first = (index * job.sunCount + sun) * kMaxCascades;
    TableOut(job.table).v[index * job.sunCount + sun] = LightShadow(first, cascades, 0u);
    for (uint i = 0u; i < kMaxCascades; ++i) {
      // Nothing draws the map of an unused cascade or looks it up.
      Sphere sphere = i < cascades ? spheres[i] : Sphere(vec3(0.0), 1.0);
      Bounds some = cascades > 0u ? bounds : Bounds(dvec3(-1.0lf), dvec3(1.0lf));
      writeMap(job, index, sun, first + i, axes, frameOfCascade(axes, sphere, some, job.size));
      writePages(job, first + i, i < cascades);
    }
  }
}
