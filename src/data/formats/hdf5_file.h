// HDF5 files in memory, written by the HDF5 library if it is installed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace latelight::data {

enum class Hdf5Type : uint8_t { Uint8, Uint16, Uint32, Float32 };

// An array in C order, little-endian. Its first two dimensions are rows and columns.
struct Hdf5Array {
  Hdf5Type type;
  std::vector<uint64_t> shape;
  std::vector<std::byte> bytes;
};

// Throws Error(Usage) that names the package if the HDF5 library is not installed or is older than 1.10.3.
void requireHdf5(std::string_view format);

// Collects data sets and returns the file with them. Equal data sets produce equal bytes with the same version of the
// HDF5 library. Several files may be written concurrently.
class Hdf5File {
 public:
  // Adds an array, compressed like h5py's `compression="gzip"`. Its size must not be 0.
  void add(const std::string& name, const Hdf5Array& array);
  // Adds a string of fixed length, like np.bytes_.
  void add(const std::string& name, const std::string& text);
  // Throws Error(OutOfMemory) or Error(Internal) if the library fails.
  std::vector<std::byte> finish() const;

 private:
  struct DataSet {
    std::string name;
    Hdf5Type type;
    std::vector<uint64_t> shape;   // empty: a string
    std::vector<std::byte> bytes;  // zlib's stream, or the characters of a string
  };
  std::vector<DataSet> sets_;
};

}  // namespace latelight::data
