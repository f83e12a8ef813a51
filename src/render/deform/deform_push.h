// Push constants of deform.comp.
#ifndef LATELIGHT_RENDER_DEFORM_PUSH_H
#define LATELIGHT_RENDER_DEFORM_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct DeformPush {
  uint64_t positions;      // VertexPosition[] of the undeformed mesh
  uint64_t attributes;     // VertexAttributes[] of the same
  uint64_t joints;         // uint[]: `influences` per vertex
  uint64_t jointWeights;   // float[]: `influences` per vertex
  uint64_t deltas;         // MorphDelta[targets][vertices]
  uint64_t palette;        // mat4x3[poses][jointCount] of the first world
  uint64_t weights;        // float[poses][targets]; never null: some drivers load from it even if there are no targets
  uint64_t outPositions;   // VertexPosition[worlds][poses][stride]; poses: previous, current, next, or only current
  uint64_t outAttributes;  // VertexAttributes[worlds][vertices], for the current pose only
  uint vertices;
  uint stride;
  uint influences;
  uint jointCount;
  uint targets;
  uint flatNormals;
  uint now;            // the current pose
  uint worlds;         // 1: those of the scene
  uint paletteStride;  // matrices per world
  uint padding;
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::DeformPush) == 112);
#endif

#endif
