// A driver library as NVIDIA's is where libraries that it opens later are missing: it loads, and has no functions.
extern "C" void* vk_icdGetInstanceProcAddr(void*, const char*) {
  return nullptr;
}
