// A shot, the intermediate form of a job's camera, with its pose in doubles. Functions for poses.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "data/cameras/cameras.h"

namespace latelight::data {

struct Shot {
  std::string name;
  glm::dmat4 pose{1};              // OpenCV's camera frame (X right, Y down, Z forward) to the scene file's frame
  scene::Camera optics;            // everything except the pose
  uint32_t width = 0, height = 0;  // in pixels; 0: the job's size
  std::optional<SequencePosition> sequence{};
  CameraExposure exposure{};
  std::optional<uint32_t> sceneCamera{};  // as in JobCamera
  std::string member{};                   // as in JobCamera
};

// Makes the shots of one source a sequence, in their order. Shots whose names are in different folders form different
// sequences, because they are pictures of different cameras. `seconds` are the times of the shots, or empty.
void makeSequence(std::vector<Shot>& shots, const std::vector<double>& seconds = {});

// The directions right, up and front of a scene in its file's own frame.
struct SceneAxes {
  glm::dvec3 right, up, front;
};
SceneAxes axesOf(const scene::Scene& scene);

// Returns the pose of a camera at `eye` that looks at `target`. If `up` is null, it is the scene's up; if that is
// parallel to the view, it is the direction opposite to the scene's front. Throws Error(Usage) whose message begins
// with `path` if eye and target are equal or `up` is parallel to the view.
glm::dmat4 lookAtPose(const SceneAxes& axes, glm::dvec3 eye, glm::dvec3 target, const glm::dvec3* up,
                      const std::string& path);

// Converts a pose from OpenGL's camera frame (X right, Y up, Z backward) to OpenCV's, or back; both are the same
// operation.
glm::dmat4 turnedAxes(const glm::dmat4& pose);

// Makes a nearly rigid transform, such as one from a file with few digits, rigid. Returns false if the transform is not
// nearly rigid or a coordinate of its position is beyond 1e15 m.
bool makeRigid(glm::dmat4& pose);

// Returns a pose from 16 numbers in row order. Throws Error(Usage) whose message begins with `path` if it isn't rigid.
glm::dmat4 poseOf(const std::vector<double>& rows, const std::string& path);

JobCamera toJobCamera(const Shot& shot, const scene::Scene& scene);
Shot toShot(const scene::Camera& camera, const scene::Scene& scene);

}  // namespace latelight::data
