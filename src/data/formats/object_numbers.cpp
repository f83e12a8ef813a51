#include "data/formats/object_numbers.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "data/formats/names.h"

namespace latelight::data {

static_assert(std::endian::native == std::endian::little, "the low bytes of a number are the first ones");

ObjectNumbers::ObjectNumbers(const output::IdManifest& ids, const Categories& categories)
    : categories_(categories.all({})) {
  struct Listed {
    std::string node, category;
    uint32_t id;
  };
  std::vector<Listed> objects;
  for (const output::IdEntry& entry : ids.ids)
    if (!entry.parts.empty()) objects.push_back({nameOf(entry), categories.of(entry.id, ids), entry.id});
  std::ranges::sort(objects, {}, [](const Listed& object) { return std::tie(object.node, object.id); });
  if (categories_.empty()) {
    for (const Listed& object : objects)
      if (!object.category.empty()) categories_.push_back(object.category);
    std::ranges::sort(categories_);
    const auto repeated = std::ranges::unique(categories_);
    categories_.erase(repeated.begin(), repeated.end());
  }
  std::unordered_map<std::string, uint32_t> numberOf{{"", 0}};
  for (const std::string& category : categories_) numberOf.emplace(category, numberOf.size());
  for (Listed& object : objects) {
    const auto instance = static_cast<uint32_t>(numbers_.size() + 1);
    numbers_[object.id] = {instance, numberOf.at(object.category), std::move(object.node)};
  }
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
    numbers_ = std::make_shared<ObjectNumbers>(ids_ ? *ids_ : output::IdManifest(), categories);
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
