// Converts labels to the classes of latelight.labels.
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <vector>

namespace latelight::python {

nanobind::object labelsOf(Labels&& labels);
// Accepts a list of latelight.labels.Keypoint, or of paths of nodes.
std::vector<Keypoint> keypointsOf(nanobind::handle value, std::string_view name);
nanobind::object keypointLabelsOf(const std::vector<Keypoint>& keypoints, const std::vector<KeypointLabel>& labels);
// The labels of all worlds, which have the same number of cameras each.
nanobind::object worldLabelsOf(std::vector<Labels>&& labels, size_t cameras);
nanobind::object worldKeypointLabelsOf(const std::vector<Keypoint>& keypoints,
                                       const std::vector<std::vector<KeypointLabel>>& labels, size_t cameras);
nanobind::object correspondenceOf(Correspondence&& correspondence);
nanobind::object worldCorrespondenceOf(std::vector<Correspondence>&& correspondences, size_t cameras);

}  // namespace latelight::python
