#include "base/program_symbols.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

extern "C" [[gnu::visibility("hidden")]] const char __ehdr_start;  // a linker symbol: the file's load address

namespace latelight {

template <typename T>
std::span<const T> ProgramSymbols::part(uint64_t offset, uint64_t bytes) const {
  if (offset > file_.size() || bytes > file_.size() - offset) return {};
  return {reinterpret_cast<const T*>(file_.data() + offset), bytes / sizeof(T)};
}

ProgramSymbols::ProgramSymbols() {
  const int fd = open("/proc/self/exe", O_RDONLY | O_CLOEXEC);
  if (fd < 0) return;
  struct stat status {};
  const auto size = fstat(fd, &status) == 0 ? static_cast<size_t>(status.st_size) : 0;
  void* const mapped = size > 0 ? mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0) : MAP_FAILED;
  close(fd);
  if (mapped == MAP_FAILED) return;
  file_ = {static_cast<const std::byte*>(mapped), size};
  const auto header = part<Elf64_Ehdr>(0, sizeof(Elf64_Ehdr));
  if (header.empty()) return;
  // In a position-independent program, symbols are relative to its beginning.
  if (header[0].e_type == ET_DYN) origin_ = reinterpret_cast<uintptr_t>(&__ehdr_start);
  const auto sections = part<Elf64_Shdr>(header[0].e_shoff, header[0].e_shnum * sizeof(Elf64_Shdr));
  for (const Elf64_Shdr& section : sections) {
    if (section.sh_type != SHT_SYMTAB || section.sh_link >= sections.size()) continue;
    const Elf64_Shdr& strings = sections[section.sh_link];
    symbols_ = part<Elf64_Sym>(section.sh_offset, section.sh_size);
    names_ = part<char>(strings.sh_offset, strings.sh_size);
  }
}

ProgramSymbols::~ProgramSymbols() {
  if (!file_.empty()) munmap(const_cast<std::byte*>(file_.data()), file_.size());
}

const char* ProgramSymbols::find(const void* address) const {
  const uintptr_t at = reinterpret_cast<uintptr_t>(address) - origin_;
  for (const Elf64_Sym& symbol : symbols_)
    if (ELF64_ST_TYPE(symbol.st_info) == STT_FUNC && at >= symbol.st_value && at - symbol.st_value < symbol.st_size &&
        symbol.st_name < names_.size())
      return &names_[symbol.st_name];
  return nullptr;
}

}  // namespace latelight
