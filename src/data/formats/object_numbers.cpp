#include "data/formats/object_numbers.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <set>
#include <tuple>

#include "data/formats/names.h"

namespace latelight::data {

static_assert(std::endian::native == std::endian::little, "the low bytes of a number are the first ones");

namespace {

struct Listed {
  std::string node, category;
  uint32_t id;
};

// Returns the objects of a manifest in the order of their paths.
std::vector<Listed> objectsOf(const output::IdManifest& ids, const Categories& categories) {
  std::vector<Listed> objects;
  for (const output::IdEntry& entry : ids.ids)
    if (!entry.parts.empty()) objects.push_back({nameOf(entry), categories.of(entry.id, ids), entry.id});
  std::ranges::sort(objects, {}, [](const Listed& object) { return std::tie(object.node, object.id); });
  return objects;
}

std::set<std::string> categoryNames(const std::vector<Listed>& objects) {
  std::set<std::string> names;
  for (const Listed& object : objects)
    if (!object.category.empty()) names.insert(object.category);
  return names;
}

}  // namespace

ObjectNumbers::ObjectNumbers(const output::IdManifest& ids, const output::IdManifest& all, const Categories& categories)
    : categories_(categories.all(SetEntries{})) {
  const bool hasRules = !categories_.empty();
  std::unordered_map<std::string, uint32_t> instanceOf, categoryOf{{"", 0}};
  for (const std::string& category : categories_) categoryOf.emplace(category, categoryOf.size());
  std::vector<Listed> objects;
  for (const output::IdManifest* manifest : {&all, &ids}) {
    objects = objectsOf(*manifest, categories);
    for (const Listed& object : objects) instanceOf.emplace(object.node, instanceOf.size() + 1);
    if (hasRules) continue;
    for (const std::string& category : categoryNames(objects))
      if (categoryOf.emplace(category, categoryOf.size()).second) categories_.push_back(category);
  }
  instances_ = static_cast<uint32_t>(instanceOf.size());
  for (Listed& object : objects)
    numbers_[object.id] = {instanceOf.at(object.node), categoryOf.at(object.category), std::move(object.node)};
}

const ObjectNumber* ObjectNumbers::find(uint32_t id) const {
  const auto found = numbers_.find(id);
  return found == numbers_.end() ? nullptr : &found->second;
}

namespace {

// Neighboring pixels mostly show the same object.
template <typename Number>
std::vector<uint32_t> numbersOf(const std::vector<uint32_t>& ids, const Number& number) {
  std::vector<uint32_t> numbers(ids.size());
  for (size_t i = 0; i < ids.size(); ++i) numbers[i] = i > 0 && ids[i] == ids[i - 1] ? numbers[i - 1] : number(ids[i]);
  return numbers;
}

}  // namespace

std::vector<uint32_t> ObjectNumbers::instancesOf(const output::AovImage& ids) const {
  return numbersOf(ids.ids, [&](uint32_t id) {
    const ObjectNumber* object = find(id);
    return object ? object->instance : 0;
  });
}

std::vector<uint32_t> ObjectNumbers::categoriesOf(const output::AovImage& ids) const {
  return numbersOf(ids.ids, [&](uint32_t id) {
    const ObjectNumber* object = find(id);
    return object ? object->category : 0;
  });
}

std::shared_ptr<const ObjectNumbers> NumberedScenes::of(const DataFrame& frame, const Categories& categories) {
  const std::lock_guard lock(mutex_);
  if (!numbers_ || ids_ != frame.metadata.ids) {
    ids_ = frame.metadata.ids;
    const output::IdManifest none;
    const output::IdManifest& ids = ids_ ? *ids_ : none;
    numbers_ = std::make_shared<ObjectNumbers>(ids, frame.idsOfAll ? *frame.idsOfAll : ids, categories);
  }
  return numbers_;
}

uint32_t bytesForNumbers(uint32_t largest) {
  return largest <= 0xff ? 1 : largest <= 0xffff ? 2 : 4;
}

std::vector<std::byte> packNumbers(const std::vector<uint32_t>& numbers, uint32_t bytesEach) {
  std::vector<std::byte> bytes(numbers.size() * bytesEach);
  for (size_t i = 0; i < numbers.size(); ++i) std::memcpy(&bytes[i * bytesEach], &numbers[i], bytesEach);
  return bytes;
}

}  // namespace latelight::data
