// Converts transforms between the public API, which has rows, and glm, which has columns.
#pragma once

#include <latelight/latelight.h>

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>

namespace latelight {

inline glm::dmat4 matrixOf(const Transform& rows) {
  return glm::transpose(glm::make_mat4(rows.data()));
}

inline Transform rowsOf(const glm::dmat4& matrix) {
  Transform rows;
  const glm::dmat4 transposed = glm::transpose(matrix);
  std::copy_n(glm::value_ptr(transposed), rows.size(), rows.begin());
  return rows;
}

}  // namespace latelight
