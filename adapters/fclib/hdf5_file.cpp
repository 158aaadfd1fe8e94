#include "adapters/fclib/hdf5_file.h"

#include "core/error.h"
#include "core/io/problem_checks.h"

namespace lcpbench {
namespace {

/// An opened dataset, and how many numbers it claims; -1 for none.
struct Dataset {
  explicit Dataset(hid_t opened) : id(opened) {
    const hid_t space = id < 0 ? -1 : H5Dget_space(id);
    if (space >= 0) count = H5Sget_simple_extent_npoints(space);
    if (space >= 0) H5Sclose(space);
  }
  ~Dataset() {
    if (id >= 0) H5Dclose(id);
  }
  Dataset(const Dataset&) = delete;
  Dataset& operator=(const Dataset&) = delete;
  hid_t id;
  hssize_t count = -1;
};

/// Whether HDF5 would read the numbers from elsewhere, by external raw files or a virtual dataset: either can name any
/// file that the user can read.
bool is_stored_elsewhere(hid_t dataset) {
  const hid_t creation = H5Dget_create_plist(dataset);
  const bool elsewhere = H5Pget_external_count(creation) != 0 || H5Pget_layout(creation) == H5D_VIRTUAL;
  H5Pclose(creation);
  return elsewhere;
}

}  // namespace

Hdf5File::Hdf5File(const std::string& file) : name_(file) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // its own messages are pages long
  H5Lunregister(H5L_TYPE_EXTERNAL);             // from now on no link to another file is followed
  file_ = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file_ < 0) throw input_error(name_, "cannot be opened as an HDF5 file");
  hsize_t bytes = 0;
  if (H5Fget_filesize(file_, &bytes) >= 0) bytes_ = static_cast<std::size_t>(bytes);
}

Hdf5File::~Hdf5File() { H5Fclose(file_); }

void Hdf5File::fail(const std::string& path, const std::string& message) const {
  throw input_error(name_, path + message);
}

bool Hdf5File::has(const std::string& path) const {
  // Every group on the way has to be asked for: H5Lexists fails where one is missing.
  for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
    if (H5Lexists(file_, path.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

void Hdf5File::check_count(const std::string& path, std::size_t count) const {
  if (count > kMaxNumbers) {
    fail(path, ": " + std::to_string(count) + " numbers, at most " + std::to_string(kMaxNumbers) + " are read");
  }
  if (count > bytes_) {
    fail(path, ": " + std::to_string(count) + " numbers in a file of " + std::to_string(bytes_) + " bytes");
  }
}

template <class Number>
std::vector<Number> Hdf5File::read(const std::string& path, hid_t type) const {
  if (!has(path)) fail(path, ": missing");
  const Dataset dataset(H5Dopen2(file_, path.c_str(), H5P_DEFAULT));
  if (dataset.id < 0) fail(path, ": is not a dataset of this file");
  if (is_stored_elsewhere(dataset.id)) fail(path, ": its numbers are in another file, which is not read");
  if (dataset.count < 0) fail(path, ": cannot be read");
  check_count(path, static_cast<std::size_t>(dataset.count));
  std::vector<Number> numbers(static_cast<std::size_t>(dataset.count));
  if (!numbers.empty() && H5Dread(dataset.id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) < 0) {
    fail(path, ": cannot be read");
  }
  return numbers;
}

std::vector<int> Hdf5File::integers(const std::string& path) const { return read<int>(path, H5T_NATIVE_INT); }
std::vector<double> Hdf5File::reals(const std::string& path) const { return read<double>(path, H5T_NATIVE_DOUBLE); }

int Hdf5File::integer(const std::string& path) const {
  const std::vector<int> numbers = integers(path);
  if (numbers.size() != 1) fail(path, ": " + std::to_string(numbers.size()) + " numbers, expected 1");
  return numbers.front();
}

}  // namespace lcpbench
