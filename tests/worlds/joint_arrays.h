// Arrays of joints for worlds.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "render/deform/deformer.h"
#include "scene/scene.h"

namespace latelight::test {

// The scene's poses at the times of worlds, as arrays of joints: the current, previous and next frame.
struct JointArrays {
  std::vector<double> numbers[3];
  void add(const scene::Scene& scene, const std::vector<std::string>& joints, const render::Poses& poses) {
    const scene::Pose* all[] = {&poses.current, &poses.previous, &poses.next};
    for (size_t time = 0; time < 3; ++time)
      for (const std::string& joint : joints) {
        size_t node = 0;
        while (scene.nodes[node].path != joint) ++node;
        const glm::dmat4 rows = glm::transpose(all[time]->world[scene.rig.sceneNodes[node]]);
        for (int i = 0; i < 16; ++i) numbers[time].push_back(rows[i / 4][i % 4]);
      }
  }
};

}  // namespace latelight::test
