// The JSON pointers of animatable properties (animated_values.h), for writers.
#pragma once

#include <string>

#include "scene/animated_values.h"

namespace latelight::scene {

// Returns the pointer that findAnimatedValue() resolves to this property.
std::string animatedPointer(AnimatedElements elements, uint32_t property, uint32_t slot);

}  // namespace latelight::scene
