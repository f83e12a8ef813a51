// The HDF5 library is opened at run time, because linking it would load its 30 dependencies, among them network and
// cipher libraries, at every start of the program.
#include "data/formats/hdf5_file.h"

#include <dlfcn.h>

#include <mutex>

#include "base/error.h"
#include "output/deflate.h"

namespace latelight::data {

namespace {

// HDF5's types and functions as in H5public.h, H5Dpublic.h, H5Fpublic.h, H5Ppublic.h, H5Spublic.h and H5Tpublic.h. They
// are the same from version 1.10.3, the first with H5Dwrite_chunk(), to 2.0.
using hid_t = int64_t;
using hsize_t = unsigned long long;
constexpr hid_t kDefault = 0;
constexpr unsigned kTruncate = 2;
constexpr int kScalar = 0;
constexpr int kLevel = 1;  // what the file states; readers do not need it

struct Library {
  int (*open)() = nullptr;
  int (*version)(unsigned*, unsigned*, unsigned*) = nullptr;
  int (*quiet)(hid_t, void*, void*) = nullptr;
  hid_t (*propertyList)(hid_t) = nullptr;
  int (*inMemory)(hid_t, size_t, int) = nullptr;
  int (*chunk)(hid_t, int, const hsize_t*) = nullptr;
  int (*deflate)(hid_t, unsigned) = nullptr;
  int (*trackTimes)(hid_t, int) = nullptr;
  int (*closeList)(hid_t) = nullptr;
  hid_t (*createFile)(const char*, unsigned, hid_t, hid_t) = nullptr;
  int (*flush)(hid_t, int) = nullptr;
  ssize_t (*image)(hid_t, void*, size_t) = nullptr;
  int (*closeFile)(hid_t) = nullptr;
  hid_t (*space)(int, const hsize_t*, const hsize_t*) = nullptr;
  hid_t (*scalarSpace)(int) = nullptr;
  int (*closeSpace)(hid_t) = nullptr;
  hid_t (*copyType)(hid_t) = nullptr;
  int (*setSize)(hid_t, size_t) = nullptr;
  int (*closeType)(hid_t) = nullptr;
  hid_t (*createSet)(hid_t, const char*, hid_t, hid_t, hid_t, hid_t, hid_t) = nullptr;
  int (*write)(hid_t, hid_t, hid_t, hid_t, hid_t, const void*) = nullptr;
  int (*writeChunk)(hid_t, hid_t, uint32_t, const hsize_t*, size_t, const void*) = nullptr;
  int (*closeSet)(hid_t) = nullptr;
  // Valid after open().
  const hid_t *fileAccess = nullptr, *setCreation = nullptr, *text = nullptr;
  const hid_t* types[4] = {};  // by Hdf5Type

  bool isUsable = false;

  Library() {
    // Debian's names first. The numbers are those of 2.0, 1.14, 1.12 and 1.10.
    for (const char* name :
         {"libhdf5_serial.so.320", "libhdf5_serial.so.310", "libhdf5_serial.so.103", "libhdf5.so.320", "libhdf5.so.310",
          "libhdf5.so.200", "libhdf5.so.103", "libhdf5_serial.so", "libhdf5.so"})
      if ((handle_ = dlopen(name, RTLD_NOW | RTLD_LOCAL))) break;
    isUsable = handle_ && findAll() && open() >= 0 && quiet(kDefault, nullptr, nullptr) >= 0;
  }

 private:
  template <typename T>
  bool find(T& target, const char* name) {
    target = reinterpret_cast<T>(dlsym(handle_, name));
    return target != nullptr;
  }
  bool findAll() {
    return find(open, "H5open") && find(version, "H5get_libversion") && find(quiet, "H5Eset_auto2") &&
           find(propertyList, "H5Pcreate") && find(inMemory, "H5Pset_fapl_core") && find(chunk, "H5Pset_chunk") &&
           find(deflate, "H5Pset_deflate") && find(trackTimes, "H5Pset_obj_track_times") &&
           find(closeList, "H5Pclose") && find(createFile, "H5Fcreate") && find(flush, "H5Fflush") &&
           find(image, "H5Fget_file_image") && find(closeFile, "H5Fclose") && find(space, "H5Screate_simple") &&
           find(scalarSpace, "H5Screate") && find(closeSpace, "H5Sclose") && find(copyType, "H5Tcopy") &&
           find(setSize, "H5Tset_size") && find(closeType, "H5Tclose") && find(createSet, "H5Dcreate2") &&
           find(write, "H5Dwrite") && find(writeChunk, "H5Dwrite_chunk") && find(closeSet, "H5Dclose") &&
           find(fileAccess, "H5P_CLS_FILE_ACCESS_ID_g") && find(setCreation, "H5P_CLS_DATASET_CREATE_ID_g") &&
           find(text, "H5T_C_S1_g") && find(types[0], "H5T_STD_U8LE_g") && find(types[1], "H5T_STD_U16LE_g") &&
           find(types[2], "H5T_STD_U32LE_g") && find(types[3], "H5T_IEEE_F32LE_g");
  }

  void* handle_ = nullptr;
};

// Never destroyed, because the library frees its own state when the process exits.
const Library& library() {
  static const Library& one = *new Library;
  return one;
}

// Debian's library may be called by one thread at a time.
std::mutex& inLibrary() {
  static std::mutex mutex;
  return mutex;
}

void check(bool done, const char* what) {
  if (!done) fail(ExitCode::Internal, "the HDF5 library cannot {}", what);
}

// An identifier that is closed at the end of its scope.
class Id {
 public:
  Id(hid_t id, int (*close)(hid_t), const char* what) : id_(id), close_(close) { check(id >= 0, what); }
  ~Id() { close_(id_); }
  Id(const Id&) = delete;
  Id& operator=(const Id&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  int (*close_)(hid_t);
};

void addText(const Library& hdf5, hid_t file, const std::string& name, const std::vector<std::byte>& text) {
  const Id type(hdf5.copyType(*hdf5.text), hdf5.closeType, "create a type");
  check(hdf5.setSize(type, text.size()) >= 0, "create a type");
  const Id space(hdf5.scalarSpace(kScalar), hdf5.closeSpace, "create a data space");
  const Id list(hdf5.propertyList(*hdf5.setCreation), hdf5.closeList, "create a property list");
  check(hdf5.trackTimes(list, 0) >= 0, "create a property list");
  const Id set(hdf5.createSet(file, name.c_str(), type, space, kDefault, list, kDefault), hdf5.closeSet,
               "create a data set");
  check(hdf5.write(set, type, kDefault, kDefault, kDefault, text.data()) >= 0, "write a data set");
}

// The array is one chunk, whose filter, deflate, has been applied already.
void addArray(const Library& hdf5, hid_t file, const std::string& name, hid_t type, const std::vector<uint64_t>& shape,
              const std::vector<std::byte>& stream) {
  const std::vector<hsize_t> sizes(shape.begin(), shape.end()), origin(shape.size(), 0);
  const auto rank = static_cast<int>(shape.size());
  const Id space(hdf5.space(rank, sizes.data(), nullptr), hdf5.closeSpace, "create a data space");
  const Id list(hdf5.propertyList(*hdf5.setCreation), hdf5.closeList, "create a property list");
  check(hdf5.chunk(list, rank, sizes.data()) >= 0 && hdf5.deflate(list, kLevel) >= 0 && hdf5.trackTimes(list, 0) >= 0,
        "create a property list");
  const Id set(hdf5.createSet(file, name.c_str(), type, space, kDefault, list, kDefault), hdf5.closeSet,
               "create a data set");
  check(hdf5.writeChunk(set, kDefault, 0, origin.data(), stream.size(), stream.data()) >= 0, "write a data set");
}

}  // namespace

void requireHdf5(std::string_view format) {
  const std::lock_guard lock(inLibrary());
  if (!library().isUsable)
    badUsage("the format {} requires HDF5 1.10.3 or newer: install it (Debian's package is hdf5-tools)", format);
}

void Hdf5File::add(const std::string& name, const Hdf5Array& array) {
  const size_t pixelBytes = array.bytes.size() / (array.shape.at(0) * array.shape.at(1));
  sets_.push_back({name, array.type, array.shape, output::deflateZlib(array.bytes, pixelBytes)});
}

void Hdf5File::add(const std::string& name, const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  sets_.push_back({name, Hdf5Type::Uint8, {}, {begin, begin + text.size()}});
}

std::vector<std::byte> Hdf5File::finish() const {
  const std::lock_guard lock(inLibrary());
  const Library& hdf5 = library();
  check(hdf5.isUsable, "be opened");
  const Id access(hdf5.propertyList(*hdf5.fileAccess), hdf5.closeList, "create a property list");
  constexpr size_t kIncrement = 1 << 20;
  check(hdf5.inMemory(access, kIncrement, 0) >= 0, "keep a file in memory");
  // The name is not that of a file, because nothing is written to the disk.
  const Id file(hdf5.createFile("latelight", kTruncate, kDefault, access), hdf5.closeFile, "create a file");
  for (const DataSet& set : sets_)
    set.shape.empty()
        ? addText(hdf5, file, set.name, set.bytes)
        : addArray(hdf5, file, set.name, *hdf5.types[static_cast<size_t>(set.type)], set.shape, set.bytes);
  check(hdf5.flush(file, 0) >= 0, "complete a file");
  const ssize_t size = hdf5.image(file, nullptr, 0);
  check(size > 0, "return a file");
  std::vector<std::byte> bytes(static_cast<size_t>(size));
  check(hdf5.image(file, bytes.data(), bytes.size()) == size, "return a file");
  return bytes;
}

}  // namespace latelight::data
