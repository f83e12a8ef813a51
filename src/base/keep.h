// Lists of objects that are kept for reuse.
#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace latelight {

// Adds an object to a list. If there is no memory for a longer list, the object is destroyed instead: destructors
// return objects, also after memory ran out.
template <typename T>
void keepForReuse(std::vector<std::unique_ptr<T>>& list, std::unique_ptr<T> object) noexcept {
  try {
    list.push_back(std::move(object));
  } catch (const std::bad_alloc&) {
  }
}

}  // namespace latelight
