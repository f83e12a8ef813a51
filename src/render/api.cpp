// The public API of include/latelight/latelight.h.
#include <latelight/latelight.h>

namespace latelight {

const char* version() { return LATELIGHT_VERSION; }

}  // namespace latelight
