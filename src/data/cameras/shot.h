// A camera on its way into the list of a job: where it is, in doubles, and the rest of it.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "data/cameras/cameras.h"

namespace latelight::data {

struct Shot {
  std::string name;
  glm::dmat4 pose{1};              // OpenCV's camera frame (X right, Y down, Z forward) to the scene file's frame
  scene::Camera optics;            // all but its place
  uint32_t width = 0, height = 0;  // pixels; 0: the job's
  std::optional<SequencePlace> sequence{};
  bool followsScene = false;
};

// Makes the shots of one source a sequence, in their order. Shots whose names lie in different folders belong to
// different sequences: the pictures of several cameras. `seconds`: the time of each shot, or none.
void makeSequence(std::vector<Shot>& shots, const std::vector<double>& seconds = {});

// Up, the front and the right of a scene, in its file's own frame.
struct SceneAxes {
  glm::dvec3 right, up, front;
};
SceneAxes axesOf(const scene::Scene& scene);

// Without an `up`, the scene's; and where that is along the view, away from its front. Throws Error(Usage) that begins
// with `path` where eye and target are the same or `up` is along the view.
glm::dmat4 lookAtPose(const SceneAxes& axes, glm::dvec3 eye, glm::dvec3 target, const glm::dvec3* up,
                      const std::string& path);

// From OpenGL's camera frame (X right, Y up, Z backward) to OpenCV's, or back: both are this.
glm::dmat4 turnedAxes(const glm::dmat4& pose);

// Rotations a little off, as files with few digits have them, become rotations. False where it is far from one, or the
// place is beyond 1e15 m.
bool makeRigid(glm::dmat4& pose);

// A pose from 16 numbers, row by row. Throws Error(Usage) that begins with `path` where it isn't rigid.
glm::dmat4 poseOf(const std::vector<double>& rows, const std::string& path);

JobCamera toJobCamera(const Shot& shot, const scene::Scene& scene);
Shot toShot(const scene::Camera& camera, const scene::Scene& scene);

}  // namespace latelight::data
