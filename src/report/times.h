// The times of a frame's passes, for each layout and each technique.
#pragma once

#include <string>

#include "report/scene_page.h"

namespace latelight::report {

std::string timesHtml(const Subject& subject);

}  // namespace latelight::report
