// A library for LD_PRELOAD that lets one call of a program fail: LATELIGHT_FAULT is the kind of call and its number,
// counted from 1 in main(), such as "write 3". At exit, the number of calls of that kind is written to the file
// LATELIGHT_FAULT_COUNT, so that a test knows where a sweep ends.
//
// Kinds: "new" is an allocation by the program's own code, not by a library that it loads, because drivers end the
// process without memory. "new N SIZE" counts only those of SIZE bytes. The others are system calls on files below the
// folder LATELIGHT_FAULT_FOLDER.
//
// A program that loads Latelight as a library, such as Python, calls latelight_fault() instead, as often as it likes.
//
// "every N SIZE" sweeps the allocations of SIZE bytes, or all for 0, of a program that has one thread: at every Nth
// one, a child process continues without the memory and without output while the program waits for it. The numbers of
// the allocations whose child was ended by a signal follow the number of calls in the file LATELIGHT_FAULT_COUNT.
#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string_view>

namespace {

enum class Kind { None, New, Open, Read, Write, Close, Rename, Stat, Every };

constexpr size_t kMaxListed = 100;

struct Fault {
  Kind kind = Kind::None;
  uint64_t number = 0;
  uint64_t size = 0;  // of the allocations that count, in bytes; 0: any
  const char* folder = nullptr;
  const char* object = nullptr;  // of the library whose allocations count, the end of its path; null: the program
  uintptr_t begin = 0, end = 0;  // its code
  std::atomic<bool> isInMain = false;
  std::atomic<uint64_t> calls = 0;
  pid_t process = 0;
  uint64_t signals[kMaxListed] = {};  // numbers of allocations after which a signal ended the child
  size_t signalCount = 0;
};
Fault fault;

Kind kindNamed(std::string_view name) {
  constexpr std::string_view kNames[] = {"", "new", "open", "read", "write", "close", "rename", "stat", "every"};
  for (int i = 1; i < 9; ++i)
    if (name == kNames[i]) return Kind(i);
  return Kind::None;
}

int findCode(dl_phdr_info* info, size_t, void*) {
  if (fault.object && !std::string_view(info->dlpi_name).ends_with(fault.object)) return 0;
  for (int i = 0; i < info->dlpi_phnum; ++i)
    if (info->dlpi_phdr[i].p_type == PT_LOAD && (info->dlpi_phdr[i].p_flags & PF_X)) {
      fault.begin = info->dlpi_addr + info->dlpi_phdr[i].p_vaddr;
      fault.end = fault.begin + info->dlpi_phdr[i].p_memsz;
    }
  return 1;  // the first object is the program
}

void startFault(const char* text) {
  const char* space = std::strchr(text, ' ');
  if (!space) return;
  fault.begin = fault.end = 0;
  dl_iterate_phdr(findCode, nullptr);
  char* end = nullptr;
  fault.number = std::strtoull(space, &end, 10);
  fault.size = std::strtoull(end, nullptr, 10);
  fault.calls = 0;
  fault.kind = kindNamed({text, size_t(space - text)});
}

using Main = int(int, char**, char**);
Main* mainOfProgram = nullptr;

int runMain(int count, char** arguments, char** environment) {
  fault.isInMain = true;
  const int code = mainOfProgram(count, arguments, environment);
  fault.isInMain = false;
  return code;
}

__attribute__((constructor)) void begin() {
  fault.folder = std::getenv("LATELIGHT_FAULT_FOLDER");
  fault.process = getpid();
  if (const char* text = std::getenv("LATELIGHT_FAULT")) startFault(text);
}

__attribute__((destructor)) void finish() {
  const char* path = std::getenv("LATELIGHT_FAULT_COUNT");
  if (!path || fault.kind == Kind::None || getpid() != fault.process) return;
  fault.kind = Kind::None;
  if (std::FILE* file = std::fopen(path, "w")) {
    std::fprintf(file, "%llu\n", static_cast<unsigned long long>(fault.calls.load()));
    for (size_t i = 0; i < fault.signalCount; ++i)
      std::fprintf(file, "%llu\n", static_cast<unsigned long long>(fault.signals[i]));
    std::fclose(file);
  }
}

bool isBelow(const char* path) {
  if (!fault.folder) return false;
  char absolute[PATH_MAX];
  if (path[0] != '/') {
    if (!getcwd(absolute, sizeof absolute)) return false;
    path = absolute;  // all relative paths of a test are below its working directory
  }
  return std::strncmp(path, fault.folder, std::strlen(fault.folder)) == 0;
}

bool isBelow(int fd) {
  char link[64], path[PATH_MAX];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t size = readlink(link, path, sizeof path - 1);
  if (size < 0) return false;
  path[size] = 0;
  return path[0] == '/' && isBelow(path);
}

bool fails(Kind kind) {
  return fault.isInMain && ++fault.calls == fault.number && fault.kind == kind;
}

template <typename Where>
bool fails(Kind kind, Where where, int error) {
  if (fault.kind != kind || !isBelow(where) || !fails(kind)) return false;
  errno = error;
  return true;
}

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

// Starts a child for every Nth allocation. Returns true in the child, whose allocation fails.
bool failsInChild() {
  const uint64_t number = ++fault.calls;
  if (number % fault.number != 0) return false;
  const pid_t child = fork();
  if (child == 0) {
    fault.kind = Kind::None;
    const int nowhere = next<int (*)(const char*, int, ...)>("open")("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    return true;
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) && fault.signalCount < kMaxListed) fault.signals[fault.signalCount++] = number;
  return false;
}

void* allocate(size_t size, size_t alignment, const void* caller) {
  const auto at = reinterpret_cast<uintptr_t>(caller);
  const bool isOwn = fault.isInMain && at >= fault.begin && at < fault.end;
  const bool counts = isOwn && (fault.size == 0 || fault.size == size);
  if (counts && fault.kind == Kind::New && fails(Kind::New)) return nullptr;
  if (counts && fault.kind == Kind::Every && failsInChild()) return nullptr;
  if (size == 0) size = 1;
  return alignment ? aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment) : std::malloc(size);
}

void* allocateOrThrow(size_t size, size_t alignment, const void* caller) {
  void* memory = allocate(size, alignment, caller);
  if (!memory) throw std::bad_alloc();
  return memory;
}

}  // namespace

#define CALLER __builtin_return_address(0)

void* operator new(size_t size) {
  return allocateOrThrow(size, 0, CALLER);
}
void* operator new[](size_t size) {
  return allocateOrThrow(size, 0, CALLER);
}
void* operator new(size_t size, std::align_val_t a) {
  return allocateOrThrow(size, size_t(a), CALLER);
}
void* operator new[](size_t size, std::align_val_t a) {
  return allocateOrThrow(size, size_t(a), CALLER);
}
void* operator new(size_t size, const std::nothrow_t&) noexcept {
  return allocate(size, 0, CALLER);
}
void* operator new[](size_t size, const std::nothrow_t&) noexcept {
  return allocate(size, 0, CALLER);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, size_t, std::align_val_t) noexcept {
  std::free(memory);
}

extern "C" {

// Lets a call fail as LATELIGHT_FAULT does. The calls are counted from 1 on, and allocations are those by the library
// whose path ends in `object`, which remains in memory. Returns how many calls of the fault before there were.
__attribute__((visibility("default"))) uint64_t latelight_fault(const char* text, const char* object) {
  fault.kind = Kind::None;
  const uint64_t calls = fault.calls;
  fault.object = object;
  startFault(text);
  return calls;
}

int __libc_start_main(Main* program, int count, char** arguments, void (*init)(), void (*fini)(), void (*rtld)(),
                      void* stack) {
  mainOfProgram = program;
  return next<int (*)(Main*, int, char**, void (*)(), void (*)(), void (*)(), void*)>("__libc_start_main")(
      runMain, count, arguments, init, fini, rtld, stack);
}

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(more, mode_t) : 0;
  va_end(more);
  if (fails(Kind::Open, path, (flags & O_CREAT) ? ENOSPC : EMFILE)) return -1;
  return next<int (*)(const char*, int, ...)>("open")(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(more, mode_t) : 0;
  va_end(more);
  if (fails(Kind::Open, path, (flags & O_CREAT) ? ENOSPC : EMFILE)) return -1;
  return next<int (*)(const char*, int, ...)>("open64")(path, flags, mode);
}
int openat(int folder, const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(more, mode_t) : 0;
  va_end(more);
  if (fault.kind == Kind::Open && (folder == AT_FDCWD ? isBelow(path) : isBelow(folder)) && fails(Kind::Open)) {
    errno = EMFILE;
    return -1;
  }
  return next<int (*)(int, const char*, int, ...)>("openat")(folder, path, flags, mode);
}
ssize_t read(int fd, void* to, size_t size) {
  if (fails(Kind::Read, fd, EIO)) return -1;
  return next<ssize_t (*)(int, void*, size_t)>("read")(fd, to, size);
}
ssize_t write(int fd, const void* from, size_t size) {
  if (fails(Kind::Write, fd, ENOSPC)) return -1;
  return next<ssize_t (*)(int, const void*, size_t)>("write")(fd, from, size);
}
int close(int fd) {
  const bool failed = fails(Kind::Close, fd, EIO);  // as on Linux, the descriptor is closed anyway
  const int result = next<int (*)(int)>("close")(fd);
  if (!failed) return result;
  errno = EIO;
  return -1;
}
int rename(const char* from, const char* to) {
  if (fails(Kind::Rename, from, EIO)) return -1;
  return next<int (*)(const char*, const char*)>("rename")(from, to);
}
int fstat(int fd, struct stat* status) {
  if (fails(Kind::Stat, fd, EIO)) return -1;
  return next<int (*)(int, struct stat*)>("fstat")(fd, status);
}

}  // extern "C"
