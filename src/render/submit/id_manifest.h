// The id manifest of a scene: every id that a picture of it may contain, and the ancestors of their nodes.
#pragma once

#include "output/id_manifest.h"
#include "scene/scene.h"

namespace latelight::render {

output::IdManifest idManifest(const scene::Scene& scene);

}  // namespace latelight::render
