#version 460
#extension GL_GOOGLE_include_directive : require
// Fits shadow maps to a view and its world, one invocation per view: the cascades of directional lights, and the sizes
// and depths of the maps of point and spot lights, with everything that the raster and lookups read of them
// (place_shadows_push.h). Lights may have other positions and directions in each world (place_lights.comp). It computes
// in doubles, with the operations of the host in the same order, so that the maps have the same bytes as those of
// fitCascades(), chooseShadowCasters() and planShadows(), where the method is described. Floats are divided as doubles,
// because devices may round divisions of floats otherwise.
#include "render/glsl/common.glsl"
#include "render/glsl/float_rounding.glsl"
#include "render/gpu_scene/light_template_push.h"
#include "render/shadow/page_push.h"
#include "render/shadow/place_shadows_push.h"
#include "render/visibility/compute/raster_push.h"

layout(local_size_x = kPlaceShadowsGroup) in;
layout(push_constant, scalar) uniform Push { PlaceShadowsPush push; };

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer JobRef { PlacedShadowJob v; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TemplatesRef { MapTemplate v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LocalsRef { LocalCaster v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer GroupsRef { PlacedMaps v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer CastersRef { PlacedCaster v[]; };
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

double sumOf(double a, double b) {
  precise double sum = a + b;
  return sum;
}
dvec3 sumOf(dvec3 a, dvec3 b) {
  precise dvec3 sum = a + b;
  return sum;
}

float quotient(float a, float b) { return float(widened(a) / widened(b)); }

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
  double center = double(depthOf(view.worldToView, scene.center)), radius = widened(scene.radius);
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

dvec3 unit(dvec3 v) {
  double reciprocal = 1.0lf / sqrt(dotOf(v, v));
  precise dvec3 scaled = v * reciprocal;
  return scaled;
}

dvec3 crossOf(dvec3 a, dvec3 b) {
  precise double x = a.y * b.z - b.y * a.z;
  precise double y = a.z * b.x - b.z * a.x;
  precise double z = a.x * b.y - b.x * a.y;
  return dvec3(x, y, z);
}

// As axesAlong() of the host.
Axes axesAlong(dvec3 away) {
  dvec3 other = abs(away.z) < 0.9lf ? dvec3(0.0lf, 0.0lf, 1.0lf) : dvec3(0.0lf, 1.0lf, 0.0lf);
  dvec3 right = unit(crossOf(away, other));
  return Axes(right, away, crossOf(right, away));
}

// The view of a map of a light that is at `origin`, as viewOf() of the host.
View placedView(View view, Axes axes, dvec3 origin) {
  dvec3 rows[3] = dvec3[3](axes.right, axes.away, axes.up);
  view.eye = vec3(origin);
  for (uint row = 0u; row < 3u; ++row) {
    for (uint column = 0u; column < 3u; ++column) {
      view.worldToView[column][row] = float(rows[row][column]);
      view.viewToWorld[row][column] = float(rows[row][column]);
    }
    view.worldToView[3][row] = float(-dotOf(rows[row], origin));
  }
  view.viewToWorld[3] = view.eye;
  return view;
}

// A light in a world.
struct Caster {
  vec3 position, direction;  // only if job.casters is not 0
  uint column;               // of job.table, or kEmitsNothing
};

// `caster`: among the directional lights and then the local ones.
Caster casterOf(PlacedShadowJob job, uint world, uint caster) {
  if (job.casters == 0ul) return Caster(vec3(0.0), vec3(0.0), caster);
  PlacedCaster placed = CastersRef(job.casters).v[world * (job.sunCount + job.localCount) + caster];
  return Caster(placed.position, placed.direction, placed.column);
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
  double halfWidth = widened(sphere.radius) * double(size) / (double(size) - kMarginTexels);
  double texel = 2.0lf * halfWidth / double(size);
  dvec3 center = widened(sphere.center);
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

// The depths of a map in meters, from its projection.
vec2 depthsOf(Projection p) {
  float range = quotient(0.5, p.A), near = times(-2.0 * p.B, range);
  return vec2(near, near + range);
}

// With reversed depth, as the raster expects.
Projection reversed(Projection p) {
  vec2 d = depthsOf(p);
  if (p.kind == kPerspective) return Projection(p.H, p.V, 0.0, max(d.x, times(1e-6, d.y)), p.X, p.Z, p.kind);
  return Projection(p.H, p.V, quotient(-1.0, d.y - d.x), quotient(d.y, d.y - d.x), p.X, p.Z, p.kind);
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

// Writes a map of a group: `view` is the view that looks it up, `own` that of the map, without reversed depth, and
// `far` its farthest depth in meters or 0 if it is orthographic.
void writeMap(PlacedShadowJob job, PlacedMaps group, uint view, uint map, View own, ShadowMap m, float unit,
              float far) {
  uint place = map - group.first, inLayer = place % (group.across * group.across);
  uint batch = map - place % group.mapsAtOnce, row = group.firstRow + place * group.rows;
  m.corner = uvec2(inLayer % group.across, inLayer / group.across) * group.size;
  m.layer = group.firstLayer + place / (group.across * group.across);
  MapsOut(job.maps).v[map] = m;
  TargetsOut(job.targets).v[map] = ShadowTarget(m.corner.x, m.corner.y, m.layer, own.projection.A, own.projection.B,
                                                unit, far, row, 1u);
  own.projection = reversed(own.projection);
  ViewsOut(job.mapViews).v[map] = own;
  FrameConstants frame = FramesIn(job.frames).v[view];
  frame.views = job.mapViews + uint64_t(batch) * uint64_t(kViewBytes);
  frame.previousViews = frame.nextViews = frame.views;
  frame.viewCount = group.mapsAtOnce;
  FramesOut(job.mapFrames).v[map] = frame;
}

// `within`: the sphere of everything that matters to the map.
void writePages(PlacedShadowJob job, PlacedMaps group, uint map, vec4 within, bool used) {
  uint row = group.firstRow + (map - group.first) * group.rows;
  WithinOut(job.within).v[map] = RasterMap(within, row, 1u);
  for (uint i = 0u; i < group.rows; ++i)
    WordsOut(job.pages).v[row + i] = used ? ~0u >> (32u - group.rows) : 0u;
}

const float kEverywhere = 1e18;  // its square is finite

void placeSun(PlacedShadowJob job, uint index, uint sun, Caster caster, Bounds bounds, uint cascades,
              Sphere spheres[kMaxCascades]) {
  PlacedMaps group = GroupsRef(job.groups).v[0];
  MapTemplate t = TemplatesRef(job.suns).v[sun];
  Axes axes = axesOf(job, sun);
  if (job.casters != 0ul) {
    axes = axesAlong(unit(dvec3(caster.direction)));
    t.view = placedView(t.view, axes, dvec3(0.0lf));
    t.map.away = vec4(vec3(axes.away), float(-dotOf(axes.away, dvec3(0.0lf))));
  }
  uint first = (index * job.sunCount + sun) * kMaxCascades;
  if (caster.column == kEmitsNothing)
    cascades = 0u;
  else
    TableOut(job.table).v[index * (job.sunCount + job.localCount) + caster.column] = LightShadow(first, cascades, 0u);
  for (uint i = 0u; i < kMaxCascades; ++i) {
    // Nothing draws the map of an unused cascade or looks it up.
    Sphere sphere = i < cascades ? spheres[i] : Sphere(vec3(0.0), 1.0);
    MapFrame f = frameOfCascade(axes, sphere, bounds, group.size);
    View own = t.view;
    own.projection = projectionOf(f);
    ShadowMap m = mapOf(t.map, axes, f, group.size);
    writeMap(job, group, index, first + i, own, m, times(m.texel, m.depthScale), 0.0);
    writePages(job, group, first + i, vec4(vec3(0.0), kEverywhere), i < cascades);
  }
}

// --- maps of local lights --------------------------------------------------------------------------------------------

float lengthOf(vec3 v) {
  precise float squared = v.x * v.x + v.y * v.y + v.z * v.z;
  return float(sqrt(double(squared)));  // correctly rounded
}

// As Frustum::touches().
bool touches(View view, Sphere sphere) {
  mat4x3 m = view.worldToView;
  vec3 p = sphere.center;
  precise vec3 c = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3] * 1.0;
  Projection projection = view.projection;
  bool perspective = projection.kind == kPerspective, inside = !(perspective && c.y < -sphere.radius);
  for (uint i = 0u; i < 4u; ++i) {
    float side = (i & 1u) == 0u ? 1.0 : -1.0, offset = times(side, i < 2u ? projection.X : projection.Z);
    float scale = times(side, i < 2u ? projection.H : projection.V);
    vec3 normal = i < 2u ? vec3(scale, 0.0, 0.0) : vec3(0.0, 0.0, scale);
    float constant = perspective ? 0.0 : 1.0 + offset;
    if (perspective) normal.y = 1.0 + offset;
    float size = lengthOf(normal);
    normal = vec3(quotient(normal.x, size), quotient(normal.y, size), quotient(normal.z, size));
    precise float distance = normal.x * c.x + normal.y * c.y + normal.z * c.z + quotient(constant, size);
    inside = inside && distance >= -sphere.radius;
  }
  return inside;
}

// Returns the index of the size of a light's maps in a view, as sizeOf() of the host. Sizes are rounded by ratio.
uint sizeOf(PlacedShadowJob job, LocalCaster light, View view, Bounds bounds) {
  dvec3 extent = bounds.high - bounds.low;
  double reach = widened(min(light.radius, float(2.0lf * (sqrt(dotOf(extent, extent)) * 0.5lf))));
  precise vec3 offset = light.position - view.eye;
  double distance = max(widened(lengthOf(offset)), 0.5lf * reach);
  double pixels = times(times(reach, double(view.projection.V)), double(view.size.y));
  if (view.projection.kind == kPerspective) pixels = pixels / distance;
  if (light.maps == 6u) pixels = 0.5lf * pixels;
  const double kRootOfTwo = 1.414213562373095048802lf;
  uint size = 0u;
  double least = double(kMinPlacedTile) * kRootOfTwo;
  for (; size + 1u < job.sizes && pixels >= least; ++size) least = 2.0lf * least;
  return size;
}

// Returns the nearest and the farthest depth of a light's maps, as localFrame() of the host.
dvec2 depthsOf(LocalCaster light, Bounds bounds) {
  dvec3 origin = dvec3(light.position);
  double farthest = -1e300lf;
  for (uint corner = 0u; corner < 8u; ++corner) {
    dvec3 offset = cornerOf(bounds, corner) - origin;
    farthest = max(farthest, sqrt(dotOf(offset, offset)));
  }
  double far = times(1.001lf, min(double(light.radius), farthest)) + 1e-6lf;
  double rounding = times(1e-5lf, max(max(abs(origin.x), abs(origin.y)), abs(origin.z)));
  return dvec2(min(max(double(light.size), min(rounding, times(1e-4lf, far))), 0.5lf * far), far);
}

dvec3 cubeAxis(uint face) {
  dvec3 axis = dvec3(0.0lf);
  axis[face / 2u] = (face & 1u) == 0u ? 1.0lf : -1.0lf;
  return axis;
}

// Moves a map to where the light is in a world, as viewOf() and mapOf() of the host. `tangent`: of half its angle.
MapTemplate placedMap(MapTemplate t, Axes axes, dvec3 origin, double tangent, uint size) {
  const double kMarginTexels = 8.0lf;  // on both sides
  double halfWidth = times(tangent, double(size)) / (double(size) - kMarginTexels);
  double middle = 0.5lf * double(size), h = middle / halfWidth;
  double right = dotOf(axes.right, origin), away = dotOf(axes.away, origin), up = dotOf(axes.up, origin);
  t.view = placedView(t.view, axes, origin);
  t.map.across = vec4(vec3(sumOf(axes.right * h, axes.away * middle)), float(-sumOf(right * h, away * middle)));
  t.map.down = vec4(vec3(sumOf(axes.away * middle, axes.up * -h)), float(-sumOf(away * middle, up * -h)));
  t.map.away = vec4(vec3(axes.away), float(-away));
  return t;
}

void placeLocal(PlacedShadowJob job, uint index, uint number, Caster caster, View view, Bounds bounds, bool any) {
  LocalCaster light = LocalsRef(job.locals).v[number];
  if (job.casters != 0ul) light.position = caster.position;
  bool emits = caster.column != kEmitsNothing;
  bool used = any && emits && touches(view, Sphere(light.position, light.radius));
  uint chosen = sizeOf(job, light, view, bounds);
  dvec2 depths = depthsOf(light, bounds);
  double range = depths.y - depths.x;
  vec4 within = vec4(light.position, min(light.radius, kEverywhere));
  for (uint size = 0u; size < job.sizes; ++size) {
    // lavapipe executes the bodies once more after the last size and face, and with Mesa 26, it also loads then.
    uint known = min(size, job.sizes - 1u);
    PlacedMaps group = GroupsRef(job.groups).v[1u + known];
    uint first = group.first + index * job.localMaps + light.firstMap;
    if (emits && size == chosen)
      TableOut(job.table).v[index * (job.sunCount + job.localCount) + caster.column] =
          LightShadow(first, used ? light.maps : 0u, 0u);
    for (uint face = 0u; face < light.maps; ++face) {
      uint map = min(light.firstMap + face, job.localMaps - 1u);
      MapTemplate t = TemplatesRef(job.faces).v[known * job.localMaps + map];
      if (job.casters != 0ul) {
        Axes axes = axesAlong(light.maps == 1u ? unit(dvec3(caster.direction)) : cubeAxis(face));
        t = placedMap(t, axes, dvec3(light.position), DoublesRef(job.tangents).v[number], group.size);
      }
      t.view.projection.A = float(0.5lf / range);
      t.view.projection.B = float(-0.5lf * depths.x / range);
      t.map.depthScale = float(1.0lf / range);
      t.map.depthOffset = float(-depths.x / range);
      float unit = float(times(widened(times(t.map.texel, t.map.depthScale)), depths.y));
      writeMap(job, group, index, first + face, t.view, t.map, unit, depthsOf(t.view.projection).y);
      writePages(job, group, first + face, within, used && size == chosen);
    }
  }
}

void main() {
  PlacedShadowJob job = JobRef(push.job).v;
  uint index = gl_GlobalInvocationID.x;
  if (index >= job.viewCount) return;
  uint world = (job.firstView + index) / job.viewsPerWorld, camera = (job.firstView + index) % job.viewsPerWorld;
  DoublesRef corners = DoublesRef(job.bounds + uint64_t(world) * 48ul);
  dvec3 low = dvec3(corners.v[0], corners.v[1], corners.v[2]), high = dvec3(corners.v[3], corners.v[4], corners.v[5]);
  Bounds bounds = Bounds(low, high);
  View view = ViewsIn(job.views).v[index];
  Sphere spheres[kMaxCascades];
  bool any = bounds.low.x <= bounds.high.x;
  uint cascades = any ? fitCascades(job, view, camera, bounds, spheres) : 0u;
  if (!any) bounds = Bounds(dvec3(-1.0lf), dvec3(1.0lf));  // no map is used
  for (uint sun = 0u; sun < job.sunCount; ++sun)
    placeSun(job, index, sun, casterOf(job, world, sun), bounds, cascades, spheres);
  for (uint local = 0u; local < job.localCount; ++local)
    placeLocal(job, index, local, casterOf(job, world, job.sunCount + local), view, bounds, any);
}
