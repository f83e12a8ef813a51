// Scenes of layered materials. Coordinates are those of glTF: +Z points toward the viewer.
#pragma once

#include <glm/gtc/matrix_transform.hpp>

#include "render/support.h"

namespace latelight::render::test {

using glm::vec2;
using glm::vec3;
using glm::vec4;

// One material for each layer that is shaded after the G-buffer, one with all of them, and masked ones.
enum class LayeredKind { Clearcoat, Sheen, Anisotropy, Iridescence, DiffuseTransmission, All, Masked, Count };
scene::Material layeredMaterial(LayeredKind kind);

// A ball of each material in front of a wall, under lights of every type: with ranges, cones and optional shadows.
scene::Scene layeredRoom();
scene::Camera roomCamera();

// A wall of vertical stripes of width `stripe` at z = -`away`, and in front of it a plate of the material at z = 0.
// Nothing is lit: the stripes emit 1 and 0, and the first one to the right of x = 0 is bright.
scene::Scene stripesBehind(const scene::Material& plate, float stripe, float away);
// A transmissive plate without reflection: its index of refraction acts only through the thickness.
scene::Material clearPlate(float thickness);

}  // namespace latelight::render::test
