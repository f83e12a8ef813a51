// Small glTF files with moving objects.
#pragma once

#include "scene/gltf_builder.h"

namespace latelight::render::test {

// A box that turns about Y by a quarter in a second and moves along X and towards the viewer, linearly; a square behind
// it that stands.
scene::test::GltfBuilder movingBox();
// A square whose one morph target bends it, its weight from 0 to 1 in a second by a cubic spline.
scene::test::GltfBuilder morphingSquare();
// A strip along Y with two joints, of which the upper turns about X by a quarter in a second; eight influences a
// vertex, of which sets 0 and 1 both count.
scene::test::GltfBuilder bendingStrip();

}  // namespace latelight::render::test
