// Rejects combinations of options that pictures which take time, or have an aperture, do not support.
#pragma once

#include "render/settings/settings.h"

namespace latelight::render {

// Properties of a request that its settings do not state.
struct ExposureUse {
  bool worlds = false;    // it renders worlds
  bool exposes = false;   // its pictures average several frames, with a shutter or an aperture
  bool byRows = false;    // rows are rendered separately
  bool refracts = false;  // and some surface is transmissive
};

// Throws Error(Usage) with the option to leave out.
void checkExposure(const Settings& settings, const ExposureUse& use);

}  // namespace latelight::render
