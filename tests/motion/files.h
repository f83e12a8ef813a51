// Small glTF files with moving objects.
#pragma once

#include "scene/gltf_builder.h"

namespace latelight::render::test {

// A box that rotates about Y by a quarter turn in one second and moves along X and towards the viewer, linearly, in
// front of a static square of 2 x `half` meters, `away` meters behind the origin.
scene::test::GltfBuilder movingBox(float away = 4, float half = 5);
// A square with one morph target that bends it; its weight increases from 0 to 1 in one second along a cubic spline.
scene::test::GltfBuilder morphingSquare();
// A strip along Y with two joints, of which the upper one rotates about X by a quarter turn in one second. Eight
// influences per vertex; sets 0 and 1 both apply.
scene::test::GltfBuilder bendingStrip();

}  // namespace latelight::render::test
