// Rays through the scene: closest hit and any hit, shared by all shaders that trace rays. A ray visits the BVH over the
// instances and, below it, the BVHs of their meshes (shared/rays.h). It goes to the nearer child first and keeps the
// other on a stack (Aila and Laine 2009, Understanding the Efficiency of Ray Traversal on GPUs).
//
// The vertices of a mesh are transformed to the space of the ray, whose origin is 0 and whose z axis is the ray. There,
// an edge's sign is computed from its two vertices only, so that two triangles with a common edge agree on it and no
// ray passes between them (Woop, Benthin and Wald 2013, Watertight Ray/Triangle Intersection, JCGT 2(1)). Vertices are
// relative to the ray's origin before they are rounded, so hits near the origin are as precise as the raster's,
// wherever the scene lies. Boxes are widened by the rounding of the transforms, and their tests by that of the tests
// (Ize 2013, Robust BVH Ray Traversal, JCGT 2(2)).
//
// Include after common.glsl.
#ifndef LATELIGHT_RAYS_GLSL
#define LATELIGHT_RAYS_GLSL
#include "render/glsl/texels.glsl"
#include "render/visibility/vast_triangle.glsl"
#include "shared/rays.h"
#include "load/RayEmitter.glsl"
#include "load/RayInstance.glsl"
#include "load/RayNode.glsl"
#include "load/RayScene.glsl"

struct Ray {
  vec3 origin, originLow;  // the device's world space, as a pair of floats
  vec3 direction;          // unit; the ray hits nothing if it is not
  float near, far;         // meters
};

struct RayHit {
  float distance;  // meters; infinite: the ray hits nothing, and the members below are not set
  uint instance;   // index in FrameConstants::instances
  uint triangle;   // index in the mesh
  uvec3 corners;   // its vertices
  vec3 weights;    // barycentric coordinates
  bool front;      // the ray hits the front face
};

RayEmitter sceneEmitter(RayScene scene, uint index) {
  return loadRayEmitter(scene.emitters + uint64_t(index) * kRayEmitterBytes);
}

#define kRayInfinity uintBitsToFloat(0x7f800000u)
bool isHit(RayHit hit) { return hit.distance < kRayInfinity; }

// Shaders may define RAY_ALPHA_TESTS as false for scenes without masked and blended materials.
#ifndef RAY_ALPHA_TESTS
#define RAY_ALPHA_TESTS true
#endif

const uint kRayStackEnd = 0xfffffffeu;  // on the stack, below the nodes of a mesh: return to the instances

// --- boxes -----------------------------------------------------------------------------------------------------------

// A ray in the space of a BVH, as the slab test needs it. The distance to a plane is its coordinate times `inverse`,
// plus `toLow` or `toHigh`.
struct RaySlabs {
  vec3 toLow, toHigh;  // the negative origin, moved by the slack of the boxes, times `inverse`
  vec3 inverse;        // 1 / direction, finite
};

// The slack exceeds 16 roundings of the origin, which covers those of the products. It also covers the replacement of
// components that are small relative to the largest one.
RaySlabs raySlabs(vec3 origin, vec3 direction, vec3 slack) {
  vec3 size = abs(direction), least = vec3(max(1e-12 * max(size.x, max(size.y, size.z)), 1e-30));
  vec3 inverse = 1.0 / mix(direction, least, lessThan(size, least));
  return RaySlabs(-(origin + slack) * inverse, -(origin - slack) * inverse, inverse);
}

// Returns the distance at which the ray enters the box, or infinity if it misses the box.
float enterBox(RaySlabs ray, vec3 low, vec3 high, float near, float far) {
  vec3 a = low * ray.inverse + ray.toLow, b = high * ray.inverse + ray.toHigh;
  vec3 first = min(a, b), last = max(a, b);
  const float kGrow = 1.0 + 8.0 * 5.960464e-8;
  float enter = max(max(first.x, first.y), max(first.z, near));
  float leave = min(min(last.x, last.y), min(last.z, far)) * kGrow;
  return enter <= leave ? enter : kRayInfinity;
}

// --- instances -------------------------------------------------------------------------------------------------------

// The instance whose mesh a ray visits.
struct RayMesh {
  uint index;       // in FrameConstants::instances
  uint material;
  uint flags;       // kRay*
  uint group;
  uint64_t nodes, triangles, positions;
  mat3 toRay;       // from object space to the ray's axes
  vec3 offset;      // the origin of object space, in the ray's axes
  RaySlabs slabs;
};

// Returns an orthonormal right-handed frame whose third axis is the unit direction.
mat3 rayAxes(vec3 direction) {
  vec3 other = abs(direction.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
  vec3 right = normalize(cross(other, direction));
  return mat3(right, cross(direction, right), direction);
}

// Return the addresses of a mesh's streams. GPUs load nothing else of it.
uvec4 meshWords(FrameConstants frame, uint mesh, uint i) {
  return sceneWordsAt(frame.meshes + uint64_t(mesh) * kMeshBytes, i);
}
uint64_t meshPositions(FrameConstants frame, uint mesh) {
  uint64_t address;
  if (kTexelLoads != 0u) address = packUint2x32(meshWords(frame, mesh, 0u).xy);
  else address = MeshRef(frame.meshes).v[mesh].positions;
  return address;
}
uint64_t meshAttributes(FrameConstants frame, uint mesh) {
  uint64_t address;
  if (kTexelLoads != 0u) address = packUint2x32(meshWords(frame, mesh, 0u).zw);
  else address = MeshRef(frame.meshes).v[mesh].attributes;
  return address;
}
uint64_t meshExtras(FrameConstants frame, uint mesh) {
  uint64_t address;
  if (kTexelLoads != 0u) address = packUint2x32(meshWords(frame, mesh, 1u).xy);
  else address = MeshRef(frame.meshes).v[mesh].extras;
  return address;
}

RayMesh enterInstance(FrameConstants frame, RayScene scene, uint index, Ray ray, mat3 axes) {
  RayInstance placed = loadRayInstance(scene.instances + uint64_t(index) * kRayInstanceBytes);
  vec4 x = placed.rows[0], y = placed.rows[1], z = placed.rows[2];
  Instance instance = frameInstance(frame, placed.instance);
  precise vec3 offset = (instance.objectToWorld[3] - ray.origin) + (instance.translationLow - ray.originLow);
  mat3 toAxes = transpose(axes);
  RayMesh mesh;
  mesh.index = placed.instance;
  mesh.material = instance.material;
  mesh.flags = placed.flags;
  mesh.group = instance.flags >> kInstanceGroupShift;
  mesh.nodes = placed.nodes;
  mesh.triangles = placed.triangles;
  mesh.positions = meshPositions(frame, instance.mesh);
  mesh.toRay = toAxes * mat3(instance.objectToWorld);
  mesh.offset = toAxes * offset;
  vec3 origin = -vec3(dot(x.xyz, offset), dot(y.xyz, offset), dot(z.xyz, offset));
  vec3 direction = vec3(dot(x.xyz, ray.direction), dot(y.xyz, ray.direction), dot(z.xyz, ray.direction));
  mesh.slabs = raySlabs(origin, direction, vec3(x.w, y.w, z.w) * (length(offset) + placed.reach));
  return mesh;
}

// --- triangles -------------------------------------------------------------------------------------------------------

float rayEdge(vec2 a, vec2 b) {
  precise float area = a.x * b.y - a.y * b.x;
  return area;
}

// The same with exact products.
float exactRayEdge(vec2 a, vec2 b) {
  Exact3 products = exactProduct(vec3(a, 0.0), vec3(b.yx, 0.0));
  precise float area = (products.hi.x - products.hi.y) + (products.lo.x - products.lo.y);
  return area;
}

// Barycentric coordinates of the ray in a triangle that it hits. The area of a sliver is less than the rounding of the
// products that it is the difference of.
vec3 rayWeights(vec3 areas, vec2 a, vec2 b, vec2 c) {
  vec2 extent = max(abs(a), max(abs(b), abs(c)));
  float size = max(extent.x, extent.y);
  if (abs(areas.x + areas.y + areas.z) < 1e-4 * size * size) {
    vec3 exactly = vec3(exactRayEdge(b, c), exactRayEdge(c, a), exactRayEdge(a, b));
    if (exactly.x + exactly.y + exactly.z != 0.0) areas = clamp(exactly / (exactly.x + exactly.y + exactly.z), 0.0, 1.0);
  }
  return areas / (areas.x + areas.y + areas.z);
}

TextureTransform textureTransform(uint64_t material, uint slot) {
  TextureTransform t;
  uint at = kMaterialTransformsAt + kTransformWords * slot;
  if (kTexelLoads == 0u)
    t = MaterialRef(material).v.transforms[slot];
  else
    t = TextureTransform(sceneVec3At(material, at), sceneVec3At(material, at + 3u), sceneWordAt(material, at + 6u));
  return t;
}

// The alpha of a surface as the raster's alpha test reads it, from level 0 of the texture.
float rayAlpha(FrameConstants frame, uint materialIndex, uint instanceIndex, uvec3 corners, vec3 weights) {
  uint64_t material = frame.materials + uint64_t(materialIndex) * kMaterialBytes;
  Instance instance = frameInstance(frame, instanceIndex);
  uint64_t attributes = meshAttributes(frame, instance.mesh), extras = meshExtras(frame, instance.mesh);
  vec4 uv = vec4(0.0);
  precise float alpha = uintBitsToFloat(sceneWordAt(material, 3u));
  for (int i = 0; i < 3; ++i) uv.xy += weights[i] * attributesAt(attributes, corners[i]).uv0;
  if ((instance.flags & kInstanceExtras) != 0u) {
    float color = 0.0;
    for (int i = 0; i < 3; ++i) {
      VertexExtra extra = ExtraRef(extras).v[corners[i]];
      uv.zw += weights[i] * extra.uv1;
      color += weights[i] * extra.color.a;
    }
    alpha *= color;
  }
  if ((sceneWordAt(material, kMaterialTexturesAt) & (1u << kTextureBaseColor)) != 0u) {
    TextureTransform t = textureTransform(material, kTextureBaseColor);
    vec3 at = vec3(t.uvSet == 0u ? uv.xy : uv.zw, 1.0);
    TextureRecord texture = textureAt(frame.textures, sceneWordAt(material, kMaterialImagesAt + kTextureBaseColor));
    alpha *= filteredLevel(texture, levelOf(texture, 0u), vec2(dot(t.row0, at), dot(t.row1, at)),
                           (texture.flags & kTextureMagnifyNearest) != 0u).a;
  }
  return alpha;
}

// As masked() of material.glsl.
bool rayPasses(uint64_t material, float alpha) {
  float cutoff = sceneFloatsAt(material, 2u).w;
  uint flags = sceneWordAt(material, kMaterialFlagsAt);
  return (flags & kMaterialMasked) != 0u ? alpha < cutoff : alpha <= 0.0;
}

// Returns true if a hit precedes another one: the nearer one, and at equal distances the last one by instance and then
// by triangle. Shaders that define RAY_ORDER(instance) order the instances themselves.
#ifdef RAY_ORDER
bool precedes(float distance, uint instance, uint triangle, RayHit other) {
  bool first = distance < other.distance;
  if (distance == other.distance)
    first = instance == other.instance ? triangle > other.triangle : RAY_ORDER(instance) > RAY_ORDER(other.instance);
  return first;
}
#else
bool precedes(float distance, uint instance, uint triangle, RayHit other) {
  bool last = instance > other.instance || (instance == other.instance && triangle > other.triangle);
  return distance < other.distance || (distance == other.distance && last);
}
#endif

void visitTriangle(FrameConstants frame, RayMesh mesh, uint index, Ray ray, uint what, inout RayHit hit) {
  uvec4 triangle = sceneWordsAt(mesh.triangles, index);
  vec3 a = mesh.toRay * positionAt(mesh.positions, triangle.x) + mesh.offset;
  vec3 b = mesh.toRay * positionAt(mesh.positions, triangle.y) + mesh.offset;
  vec3 c = mesh.toRay * positionAt(mesh.positions, triangle.z) + mesh.offset;
  vec3 areas = vec3(rayEdge(b.xy, c.xy), rayEdge(c.xy, a.xy), rayEdge(a.xy, b.xy));
  bool inside = all(greaterThanEqual(areas, vec3(0.0))) || all(lessThanEqual(areas, vec3(0.0)));
  float area = areas.x + areas.y + areas.z;
  // Counter-clockwise triangles have a negative area, because the ray's third axis points away from its origin.
  bool front = (area < 0.0) != ((mesh.flags & kRayClockwise) != 0u);
  bool visible = front || (mesh.flags & kRayDoubleSided) != 0u || (what & kRayTwoSided) != 0u;
  if (inside && area != 0.0 && visible) {
    vec3 weights = rayWeights(areas, a.xy, b.xy, c.xy);
    float distance = dot(weights, vec3(a.z, b.z, c.z));
    bool hits = distance >= ray.near && distance <= ray.far && precedes(distance, mesh.index, triangle.w, hit);
    uint64_t material = frame.materials + uint64_t(mesh.material) * kMaterialBytes;
    if (hits && RAY_ALPHA_TESTS && (mesh.flags & kRayAlphaConstant) != 0u)
      hits = !rayPasses(material, sceneFloatsAt(material, 0u).w);
    if (hits && RAY_ALPHA_TESTS && (mesh.flags & kRayAlphaTested) != 0u)
      hits = !rayPasses(material, rayAlpha(frame, mesh.material, mesh.index, triangle.xyz, weights));
    if (hits) hit = RayHit(distance, mesh.index, triangle.w, triangle.xyz, weights, front);
  }
}

// --- traversal -------------------------------------------------------------------------------------------------------

// lavapipe silently ends all loops of a subgroup after 65535 iterations in total. Shaders that may reach this many
// define RAY_COUNTS_WORK as a condition, and end their own loops before. `rayWork` estimates the number of iterations
// so far, of the lane that was active the longest: between nested spheres, loops ended when it was 41,000.
#ifdef RAY_COUNTS_WORK
uint rayWork = 0u;
const uint kMaxRayWork = 30000u;  // the rest is for the last ray
bool rayWorkIsDone() {
  if (!RAY_COUNTS_WORK) return false;
  rayWork = subgroupMax(rayWork);
  return rayWork > kMaxRayWork;
}
// `steps`: of the lane, in one iteration of the loop over nodes and leaves.
void countRayWork(inout uint work, uint steps) {
  const uint kLoops = 8u;  // that are there without a step
  if (RAY_COUNTS_WORK) work += subgroupMax(steps) + kLoops;
}
void endRayWork(uint work) {
  if (RAY_COUNTS_WORK) rayWork += subgroupMax(work);
}
#else
void countRayWork(inout uint work, uint steps) {}
void endRayWork(uint work) {}
#endif

// Returns the index of an element that a lane loads. lavapipe also fetches texels for lanes that wait, and computes
// with what it finds there. Integers read as floats are denormal numbers, which take a hundred times as long, so these
// lanes load element 0.
uint presentIndex(bool present, uint index) {
  if (kTexelLoads != 0u) index = present ? index : 0u;
  return index;
}

RayHit noHit() { return RayHit(kRayInfinity, 0u, 0u, uvec3(0u), vec3(0.0), false); }

bool isUsable(Ray ray) {
  return abs(dot(ray.direction, ray.direction) - 1.0) < 1e-3 && all(lessThan(abs(ray.origin), vec3(3.0e37))) &&
         ray.near <= ray.far;
}

// Returns true if the ray does not hit the instance. `what`: kRay* above.
bool skips(RayMesh mesh, uint what) {
  bool translucent = (mesh.flags & kRayTranslucent) != 0u && (what & kRayAnySurface) == 0u;
  return translucent || (what >> kRayGroupShift != 0u && what >> kRayGroupShift != mesh.group);
}

// `what`: kRay* above. Loops change nothing for lanes that have ended them (lane_loops.glsl).
RayHit traceRay(FrameConstants frame, Ray ray, uint what) {
  // If any hit ends the ray, none is kept from leaf to leaf, so that its registers are free.
  bool any = (what & kRayStopAtFirst) != 0u, stops = false;
  RayHit hit = noHit();
  RayScene scene = loadRayScene(frame.rayScene);
  mat3 axes = rayAxes(ray.direction);
  float extent = abs(ray.origin.x) + abs(ray.origin.y) + abs(ray.origin.z);
  RaySlabs world = raySlabs(ray.origin, ray.direction, vec3(extent * 9.5367432e-7));
  RaySlabs slabs = world;
  uint64_t nodes = scene.nodes;
  RayMesh mesh;
  if (kTexelLoads != 0u) mesh = RayMesh(0u, 0u, 0u, 0u, 0ul, 0ul, 0ul, mat3(0.0), vec3(0.0), world);
  mesh.flags = 0u;
  bool inMesh = false;
  uint stack[kRayStack];
  uint top = 1u;
  stack[0] = kRayNone;
  uint current = scene.instanceCount != 0u && isUsable(ray) ? 0u : kRayNone, work = 0u;
  do {
    uint steps = 0u;
    bool descends = (current & kRayLeaf) == 0u;
    do {
      if (kCpuDevice == 0u && !descends) break;  // on a GPU, the branch below would cost more
      if (descends) {
        ++steps;
        RayNode node = loadRayNode(nodes + uint64_t(presentIndex(descends, current)) * kRayNodeBytes);
        float far = min(hit.distance, ray.far);
        float toA = enterBox(slabs, node.lowA, node.highA, ray.near, far);
        float toB = node.b == kRayNone ? kRayInfinity : enterBox(slabs, node.lowB, node.highB, ray.near, far);
        bool both = toA < kRayInfinity && toB < kRayInfinity;
        if (both) stack[top] = toA <= toB ? node.b : node.a;
        if (!both && toA == toB) current = stack[top - 1u];  // both are infinite
        else current = toA <= toB ? node.a : node.b;
        top += both ? 1u : (toA == toB ? ~0u : 0u);
        descends = (current & kRayLeaf) == 0u;
      }
    } while (kCpuDevice == 0u || lanesGoOn(descends));
    if (current == kRayStackEnd) {
      inMesh = false;
      nodes = scene.nodes;
      slabs = world;
      current = stack[--top];
    }
    bool enters = !inMesh && current < kRayStackEnd && (current & kRayLeaf) != 0u;
    bool tests = inMesh && current < kRayStackEnd && (current & kRayLeaf) != 0u;
    if (enters) {
      mesh = enterInstance(frame, scene, presentIndex(enters, current & kRayFirstMask), ray, axes);
      inMesh = !skips(mesh, what);
      if (inMesh) {
        stack[top++] = kRayStackEnd;
        nodes = mesh.nodes;
        slabs = mesh.slabs;
      }
      current = inMesh ? 0u : stack[--top];
    }
    if (tests) {
      uint first = presentIndex(tests, current & kRayFirstMask), count = (current >> kRayCountShift & 7u) + 1u;
      steps += 8u * count;  // loops of visitTriangle()
      uint i = first;
      do {
        if (kCpuDevice == 0u || i < first + count) {
          RayHit found = hit;
          visitTriangle(frame, mesh, i, ray, what, found);
          if (any) stops = stops || isHit(found);
          else hit = found;
        }
      } while (lanesGoOn(++i < first + count));
      current = stops ? kRayNone : stack[--top];
    }
    countRayWork(work, steps);
  } while (lanesGoOn(current != kRayNone));
  endRayWork(work);
  if (stops) hit.distance = 0.0;
  return hit;
}

// Returns true if something that is neither blended nor transmissive lies on the ray. Both sides of surfaces block
// rays, as in shadow maps.
bool isBlocked(FrameConstants frame, Ray ray) {
  return isHit(traceRay(frame, ray, kRayTwoSided | kRayStopAtFirst));
}

#endif
