#version 460
#extension GL_GOOGLE_include_directive : require
// Writes a key per triangle: the index of its mesh, and the Morton code of its box's center, in a grid of cubes over
// the mesh.
#include "render/rays/build/build.glsl"

layout(local_size_x = kBuildGroup) in;

// Returns the last mesh whose first triangle is at most `triangle`.
uint meshOf(BvhBuild build, uint triangle) {
  uint low = 0u, high = build.meshCount;
  while (high - low > 1u) {
    uint middle = (low + high) / 2u;
    if (BuildMeshesRef(build.meshes).v[middle].first <= triangle) low = middle;
    else high = middle;
  }
  return low;
}

// Inserts two zeros before each of kCodeAxisBits bits.
uint64_t spread(uint value) {
  uint64_t x = value;
  x = (x | x << 16) & 0xff0000ffUL;
  x = (x | x << 8) & 0xf00f00f00fUL;
  x = (x | x << 4) & 0xc30c30c30c3UL;
  return (x | x << 2) & 0x249249249249UL;
}

void main() {
  uint item = workgroup() * kBuildGroup + invocation();
  BvhBuild build = BvhBuildRef(push.build).v;
  if (item >= build.count) return;
  uint index = meshOf(build, item);
  BuildMesh mesh = BuildMeshesRef(build.meshes).v[index];
  BuildBox box = triangleBox(mesh, item - mesh.first);
  vec3 cell = clamp((0.5 * box.low + 0.5 * box.high - mesh.low) * mesh.scale, vec3(0.0),
                    vec3(float((1u << kCodeAxisBits) - 1u)));
  uint64_t code = spread(uint(cell.x)) << 2 | spread(uint(cell.y)) << 1 | spread(uint(cell.z));
  KeysRef(build.keys[0]).v[item] = uint64_t(index) << 3u * kCodeAxisBits | code;
  BuildWordsRef(build.items[0]).v[item] = item;
}
