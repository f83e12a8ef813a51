// Scenes of layered materials. Coordinates are those of glTF: +Z points toward the viewer.
#pragma once

#include <glm/gtc/matrix_transform.hpp>

#include "render/support.h"

namespace latelight::render::test {

using glm::vec2;
using glm::vec3;
using glm::vec4;

// One material of each layer that is shaded behind the G-buffer, all of them together, and of those cut out by a mask.
enum class LayeredKind { Clearcoat, Sheen, Anisotropy, Iridescence, DiffuseTransmission, All, Masked, Count };
scene::Material layeredMaterial(LayeredKind kind);

// A ball of each kind before a wall, under lights of every type: ranges, cones and, where they are asked for, shadows.
scene::Scene layeredRoom();
scene::Camera roomCamera();

// A wall of upright stripes, `stripe` wide, at z = -`away`, and before it a plate of a material at z = 0. Nothing is
// lit: the stripes emit 1 and 0, the first to the right of x = 0 being bright.
scene::Scene stripesBehind(const scene::Material& plate, float stripe, float away);
// A plate that shows what lies behind it, and reflects nothing: its index of refraction is in the thickness alone.
scene::Material clearPlate(float thickness);

}  // namespace latelight::render::test
