// The files of a correspondence. The format "correspondence" writes them for data sets, and `latelight render
// --correspond` for single pictures.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "labels/correspondence.h"
#include "output/metadata.h"

namespace latelight::data {

// Returns the arrays by name, each as an NPY file.
std::vector<std::pair<std::string, std::vector<std::byte>>> correspondenceArrays(const labels::Correspondence& match);
// Returns an NPZ file with all arrays.
std::vector<std::byte> encodeCorrespondenceNpz(const labels::Correspondence& match);
// Returns an EXR file with all arrays as channels. `metadata` describes the first image; its ids are not written.
std::vector<std::byte> encodeCorrespondenceExr(const labels::Correspondence& match, output::Metadata metadata);

}  // namespace latelight::data
