#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the records of one instance in one world: Instance at each time, and RasterInstance. The host's counterparts
// are GpuWorlds::update() and RasterInstances.
#include "render/visibility/compute/place_worlds.glsl"
#include "render/visibility/compute/raster_push.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer InstancesOut { Instance v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer RasterTemplates { RasterInstance v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer RasterOut { RasterInstance v[]; };

// Offsets in Material, in words.
const uint kBaseColorWord = 0u, kEmissiveWord = 4u, kMetallicWord = 7u, kRoughnessWord = 8u, kFlagsWord = 17u;

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer WordsOut { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer BasesRef { DerivableMaterial v[]; };

// Returns the record with the transform. The translation is a float and the remainder of the double.
Instance placed(WorldJob job, Instance record, dmat4 toWorld, vec3 vertexOrigin) {
  dvec3 moved = transformed(toWorld, dvec3(vertexOrigin)).xyz;
  dvec3 translation = difference(moved, columnsAt(job.matrices, kDeviceOrigin)[0].xyz);
  record.objectToWorld = mat4x3(vec3(toWorld[0].xyz), vec3(toWorld[1].xyz), vec3(toWorld[2].xyz), vec3(translation));
  record.translationLow = vec3(difference(translation, widened(record.objectToWorld[3])));
  return record;
}

// The bounding sphere, which grows by the error that rounding its center can cause.
vec4 boundsOf(WorldJob job, WorldTemplate t, dmat4 toWorld) {
  dvec3 low = dvec3(t.low), high = dvec3(t.high), extent = 0.5lf * (high - low);
  double radius = 0.0lf;
  for (uint i = 0u; i < 4u; ++i) {
    dvec3 corner = extent;
    if (i < 3u) corner[i] = -corner[i];
    dvec3 along = toWorld[0].xyz * corner.x + toWorld[1].xyz * corner.y + toWorld[2].xyz * corner.z;
    radius = max(radius, sqrt(dotOf(along, along)));
  }
  dvec3 middle = (low + high) * 0.5lf;
  dvec3 center = toWorld[0].xyz * middle.x + toWorld[1].xyz * middle.y + toWorld[2].xyz * middle.z + toWorld[3].xyz;
  center -= columnsAt(job.matrices, kDeviceOrigin)[0].xyz;
  const double kRounding = 1e-6lf, kCenterRounding = 2e-7lf;
  dvec3 size = abs(center);
  return vec4(vec3(center), float((1.0lf + kRounding) * radius + kCenterRounding * (size.x + size.y + size.z)));
}

// Triangles of this size need more precision than floats have (isVast() of instances.cpp).
bool isVast(float longestEdge, dmat4 toWorld) {
  double squared = dotOf(toWorld[0].xyz, toWorld[0].xyz) + dotOf(toWorld[1].xyz, toWorld[1].xyz);
  squared += dotOf(toWorld[2].xyz, toWorld[2].xyz);
  return double(longestEdge) * sqrt(squared / 3.0lf) >= 1024.0lf;
}

// x: upper bound of the scale of lengths; y: 1 if angles are preserved.
vec2 stretchOf(mat4x3 m) {
  float xx = dot(m[0], m[0]), yy = dot(m[1], m[1]), zz = dot(m[2], m[2]);
  float longest = max(max(xx, yy), zz), sum = xx + yy + zz;
  float skew = max(max(abs(dot(m[0], m[1])), abs(dot(m[1], m[2]))), abs(dot(m[2], m[0])));
  const float kRounding = 1e-4;
  bool similar = 3.0 * longest - sum <= kRounding * longest && skew <= kRounding * longest;
  return vec2((1.0 + kRounding) * sqrt(similar ? longest : sum), similar ? 1.0 : 0.0);
}

uint drawFlags(uint instanceFlags, uint materialFlags, bool similar) {
  uint flags = 0u;
  bool blended = translucent(materialFlags);
  if ((materialFlags & kMaterialDoubleSided) != 0u) flags |= kDrawDoubleSided;
  if ((instanceFlags & kInstanceClockwise) != 0u) flags |= kDrawClockwise;
  if (blended || (materialFlags & kMaterialMasked) != 0u) flags |= kDrawMasked;
  if (blended) flags |= kDrawBlended;
  if ((materialFlags & kMaterialLayered) != 0u) flags |= kDrawLayered;
  if (similar) flags |= kDrawSimilar;
  if ((instanceFlags & kInstanceVast) != 0u) flags |= kDrawVast;
  return flags;
}

// Writes the factors of a row of `count` numbers, if the call gives them.
void writeFactors(uint64_t to, uint word, WorldNumbers given, uint row, uint count) {
  if (given.address == 0ul) return;
  for (uint i = 0u; i < count; ++i) WordsOut(to).v[word + i] = floatBitsToUint(float(numberAt(given, row * count + i)));
}

// Writes the material of a listed instance: the scene's with the world's factors. Returns its flags.
uint writeMaterial(WorldJob job, uint base, uint index, uint row, bool invalid) {
  UintRef from = UintRef(job.materials + uint64_t(base) * kMaterialBytes);
  uint64_t to = job.materials + uint64_t(index) * kMaterialBytes;
  for (uint i = 0u; i < kMaterialBytes / 4u; ++i) WordsOut(to).v[i] = from.v[i];
  uint flags = from.v[kFlagsWord];
  if (invalid) return flags;
  writeFactors(to, kBaseColorWord, job.baseColor, row, 4u);
  writeFactors(to, kEmissiveWord, job.emissive, row, 3u);
  writeFactors(to, kMetallicWord, job.metallic, row, 1u);
  writeFactors(to, kRoughnessWord, job.roughness, row, 1u);
  if (job.baseColor.address == 0ul) return flags;
  // As GpuMaterials: a blended material that is opaque everywhere counts as opaque.
  DerivableMaterial derivable = BasesRef(job.bases).v[base];
  bool opaque = derivable.opaqueTextures != 0u && float(numberAt(job.baseColor, row * 4u + 3u)) >= 1.0;
  flags = opaque ? derivable.flags & ~kMaterialBlended : derivable.flags;
  WordsOut(to).v[kFlagsWord] = flags;
  return flags;
}

// A wrong choice, which check_worlds.comp reports, has no effect.
uint chosenMaterial(WorldJob job, uint world, WorldTemplate t) {
  double choice = numberAt(job.materialChoice, world * job.listed + t.place);
  bool isIndex = choice >= 0.0lf && choice < double(job.paletteSize);
  return isIndex ? UintRef(job.palette).v[uint(choice)] : t.material;
}

void main() {
  WorldJob job = JobRef(push.job).v;
  uint world = elementIndex() / job.instanceCount, i = elementIndex() % job.instanceCount;
  if (world >= job.worlds) return;
  WorldTemplate t = templateOf(job, world, i);
  bool invalid = isInvalid(job, world);
  dmat4 toWorld = invalid ? dmat4(1.0) : worldTransform(job, world, i, 0u);
  bool mirrored = determinantOf(toWorld) < 0.0lf, turnedOver = (t.state & kTemplateTurnedOver) != 0u;
  Instance record;
  record.mesh = t.mesh;
  record.material = t.material;
  if (t.place != kNowhere && job.choices != 0ul) record.material = UintRef(job.choices).v[world * job.listed + t.place];
  if (t.place != kNowhere && job.palette != 0ul) record.material = chosenMaterial(job, world, t);
  uint materialFlags = UintRef(job.materials + uint64_t(record.material) * kMaterialBytes).v[kFlagsWord];
  if (t.place != kNowhere && job.firstDerived != kNowhere) {
    uint base = record.material, row = world * job.listed + t.place;
    record.material = job.firstDerived + row;
    materialFlags = writeMaterial(job, base, record.material, row, invalid);
  }
  record.id = t.id;
  record.part = t.part;
  record.flags = t.flags | (mirrored ? kInstanceMirrored : 0u) | (mirrored != turnedOver ? kInstanceClockwise : 0u);
  if (!invalid && isVast(t.longestEdge, toWorld)) {
    record.flags |= kInstanceVast;
    report(job, world, kWorldVast);
  }
  bool shown = !invalid && (t.state & kTemplateHidden) == 0u && exists(job, world, t.place);
  if (!shown) record.flags |= kInstanceAbsent;
  record = placed(job, record, toWorld, t.vertexOrigin);
  InstancesOut(job.instances[0]).v[elementIndex()] = record;
  for (uint time = 1u; time < job.instanceTimes; ++time) {
    dmat4 moved = invalid ? toWorld : worldTransform(job, world, i, time);
    InstancesOut(job.instances[time]).v[elementIndex()] = placed(job, record, moved, t.vertexOrigin);
  }
  if (t.draw == kNowhere) return;
  RasterInstance raster = RasterTemplates(job.rasterTemplates).v[t.draw];
  vec4 bounds = boundsOf(job, t, toWorld);
  vec2 stretch = stretchOf(record.objectToWorld);
  raster.center = bounds.xyz;
  raster.radius = shown ? bounds.w : uintBitsToFloat(0xff800000u);  // minus infinity
  raster.stretch = stretch.x;
  if (t.deformed != kNowhere) {
    raster.mesh = t.mesh;
    raster.clusters = 0ul;  // their bounds are those of the scene's mesh
  }
  raster.flags = drawFlags(record.flags, materialFlags, stretch.y != 0.0);
  RasterOut(job.raster).v[world * job.draws + t.draw] = raster;
}
