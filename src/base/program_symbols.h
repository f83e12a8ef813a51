// The names of the program's functions by their addresses, for a backtrace. Dynamic symbols, which glibc looks up, are
// not enough: the program's own functions are hidden.
#pragma once

#include <elf.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace latelight {

// The symbol table in the program's file, mapped. All of it is safe in a signal handler. A stripped program has none.
class ProgramSymbols {
 public:
  ProgramSymbols();
  ~ProgramSymbols();
  ProgramSymbols(const ProgramSymbols&) = delete;
  ProgramSymbols& operator=(const ProgramSymbols&) = delete;

  // The mangled name of the function around an address, or null.
  const char* find(const void* address) const;

 private:
  template <typename T>
  std::span<const T> part(uint64_t offset, uint64_t bytes) const;  // of the file; empty where it ends before

  std::span<const std::byte> file_;
  uintptr_t origin_ = 0;  // of the symbols' addresses
  std::span<const Elf64_Sym> symbols_;
  std::span<const char> names_;
};

}  // namespace latelight
