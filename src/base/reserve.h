// Capacity that is allocated before a change, so that the change itself cannot fail.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace latelight {

// Allocates what `count` more elements require. Repeated calls cost as little as push_back(), because the capacity at
// least doubles.
template <typename T>
void reserveMore(std::vector<T>& elements, size_t count) {
  const size_t required = elements.size() + count;
  if (required > elements.capacity()) elements.reserve(std::max(required, 2 * elements.capacity()));
}

}  // namespace latelight
