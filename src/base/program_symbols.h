// Looks up function names of the program by address, for backtraces. The dynamic symbols that glibc looks up are not
// enough, because the program's own functions are hidden.
#pragma once

#include <elf.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace latelight {

// The symbol table of the program's file, mapped into memory. All functions are safe in a signal handler. A stripped
// program has no symbols.
class ProgramSymbols {
 public:
  ProgramSymbols();
  ~ProgramSymbols();
  ProgramSymbols(const ProgramSymbols&) = delete;
  ProgramSymbols& operator=(const ProgramSymbols&) = delete;

  // The mangled name of the function that contains an address, or null.
  const char* find(const void* address) const;

 private:
  template <typename T>
  std::span<const T> part(uint64_t offset, uint64_t bytes) const;  // a part of the file; empty if it exceeds the file

  std::span<const std::byte> file_;
  uintptr_t origin_ = 0;  // address of the symbols' origin
  std::span<const Elf64_Sym> symbols_;
  std::span<const char> names_;
};

}  // namespace latelight
