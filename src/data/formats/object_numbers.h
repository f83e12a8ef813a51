// Small numbers for the objects and categories of a scene, for formats whose images cannot hold 32-bit ids.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "data/formats/categories.h"
#include "data/frame.h"

namespace latelight::data {

struct ObjectNumber {
  uint32_t instance = 0;  // from 1, in the order of the paths of all objects
  uint32_t category = 0;  // from 1, in the order of ObjectNumbers::categories(); 0: none
  std::string node;       // the object's path
};

// The numbers are the same in all frames of a scene, whichever objects its variations show.
class ObjectNumbers {
 public:
  // `ids`: of a frame. `all`: of all variations of its scene. Objects and categories that only `ids` has follow.
  ObjectNumbers(const output::IdManifest& ids, const output::IdManifest& all, const Categories& categories);

  // Returns null if no object has the id, such as 0, the background.
  const ObjectNumber* find(uint32_t id) const;
  uint32_t instances() const { return instances_; }  // of the whole scene
  // In the order of the option's rules, or the sorted names of the scene's categories if there are no rules.
  const std::vector<std::string>& categories() const { return categories_; }

  // Return the number of each pixel's object, 0 for the background.
  std::vector<uint32_t> instancesOf(const output::AovImage& ids) const;
  std::vector<uint32_t> categoriesOf(const output::AovImage& ids) const;

 private:
  uint32_t instances_ = 0;
  std::unordered_map<uint32_t, ObjectNumber> numbers_;  // of the frame's objects, by id
  std::vector<std::string> categories_;
};

// Numbers the objects of frames, and caches the numbers of the last scene. Thread-safe.
class NumberedScenes {
 public:
  std::shared_ptr<const ObjectNumbers> of(const DataFrame& frame, const Categories& categories);

 private:
  std::mutex mutex_;
  std::shared_ptr<const output::IdManifest> ids_;
  std::shared_ptr<const ObjectNumbers> numbers_;
};

// Returns the bytes per number, 1, 2 or 4, that hold numbers up to `largest`.
uint32_t bytesForNumbers(uint32_t largest);
// Returns the low bytes of each number, little-endian.
std::vector<std::byte> packNumbers(const std::vector<uint32_t>& numbers, uint32_t bytesEach);

}  // namespace latelight::data
