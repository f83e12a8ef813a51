// version() of the public API, which the metadata of all modules states.
#include <latelight/latelight.h>

namespace latelight {

const char* version() {
  return LATELIGHT_VERSION;
}

}  // namespace latelight
