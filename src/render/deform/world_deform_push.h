// Structs that the shaders that deform meshes per world share with the host (world_deformer.h).
//
// Times: slot 0 of 1 is the current frame; slots 0, 1 and 2 of 3 are the previous, the current and the next frame.
#ifndef LATELIGHT_WORLD_DEFORM_PUSH_H
#define LATELIGHT_WORLD_DEFORM_PUSH_H

#include "render/gpu_scene/world_inputs_push.h"
#include "shared/lang.h"

SH_BEGIN

// Returns the time of a slot: 0, 1 or 2 is the current, previous or next frame, as in the arrays of a call.
SH_FUNC uint timeOfSlot(uint slot, uint slots) {
  return slots == 1u || slot == 1u ? 0u : slot == 0u ? 1u : 2u;
}

// A joint of a skinned mesh that worlds deform.
struct PosedJoint {
  mat4x3 inverseBind;  // affine, as glTF requires
  uint listed;         // among the joints that the caller's arrays describe, or kNowhere
  uint first, count;   // joints of its mesh
};

struct JointJob {
  WorldNumbers given[3];  // transforms of the listed joints, by time: current, previous, next frame
  uint64_t joints;        // PosedJoint[joints]: those of all meshes, mesh by mesh
  uint64_t origins;       // double[joints][3]: Skin::origin
  uint64_t scene;         // the scene's joint matrices, as `palettes` of one world
  uint64_t palettes;      // results: mat4x3[worlds][meshes][slots][joints of the mesh]
  uint64_t status;        // uint[worlds]: kWorld* bits; 0: the host has checked the arrays
  uint worlds, jointCount, listed, slots;
};

// A mesh with vertices that the caller's arrays describe.
struct VertexJob {
  WorldNumbers given[3];   // positions in object space, 3 numbers each, by time: current, previous, next frame
  uint64_t fans;           // uint[vertices + 1]: VertexFans::first
  uint64_t fanTriangles;   // FanTriangle[]
  uint64_t indices;        // uint[]
  uint64_t attributes;     // VertexAttributes[vertices] at rest
  uint64_t outPositions;   // VertexPosition[worlds][slots][vertices]
  uint64_t outAttributes;  // VertexAttributes[worlds][vertices]
  vec3 origin;             // vertexOrigin()
  uint worlds, vertices, slots;
  uint first, total;  // index of the mesh's first vertex in a world of the arrays, and their vertices per world
};

struct DeviceFanTriangle {  // scene::FanTriangle
  uint triangle;
  float alongB, alongC;
};

// A sphere that contains the vertices that one joint moves, at rest.
struct DeviceJointSphere {  // scene::JointSphere
  uint joint;
  vec3 center;
  float radius;
  float weight;
};

// A mesh that worlds deform. Strides are in bytes per world.
struct DeformedMesh {
  uint64_t positions, previousPositions, nextPositions, attributes;  // of the first world
  uint64_t positionStride, attributeStride;
  uint64_t spheres;  // DeviceJointSphere[sphereCount]; skinned meshes only
  uint64_t palette;  // mat4x3[] of the current frame in the first world; skinned meshes only
  uint64_t paletteStride;
  uint64_t indices;  // uint[3 * triangles]; meshes with given vertices only
  uint mesh;         // index of the scene's mesh
  uint sphereCount;  // 0: a mesh with given vertices
  uint mirroredAtRest;
  uint firstVertex, vertices, triangles;  // firstVertex: as VertexJob::first
  float moved;                            // maximum distance by which morph targets move a vertex
  float longestEdge;                      // at rest
};

// The bounds of a deformed mesh in a world, in object space.
struct DeformedBounds {
  vec3 low;
  float longestEdge;
  vec3 high;
  uint turnedOver;  // 1: the joints reverse the winding of the triangles, compared with the mesh at rest
};
SH_CONST uint kDeformedBoundsBytes = 32u;

struct BoundJob {
  WorldNumbers vertices[3];  // as VertexJob::given
  uint64_t parts;            // DeformedMesh[meshes]
  uint64_t meshes;           // Mesh[]; from firstDeformed on, results: [worlds][meshes]
  uint64_t bounds;           // results: DeformedBounds[worlds][meshes]
  uint64_t status;           // as JointJob::status
  uint worlds, partCount, firstDeformed, total;
};

struct WorldDeformPush {
  uint64_t job;  // JointJob, VertexJob or BoundJob
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::DeformedBounds) == latelight::shared::kDeformedBoundsBytes);
#endif

#endif
