#include "adapters/fclib/hdf5_file.h"

#include "core/error.h"
#include "core/io/problem_checks.h"

namespace lcpbench {

Hdf5File::Hdf5File(const std::string& file) : name_(file) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // its own messages are pages long
  file_ = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file_ < 0) throw input_error(name_, "cannot be opened as an HDF5 file");
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

template <class Number>
std::vector<Number> Hdf5File::read(const std::string& path, hid_t type) const {
  if (!has(path)) fail(path, ": missing");
  const hid_t dataset = H5Dopen2(file_, path.c_str(), H5P_DEFAULT);
  if (dataset < 0) fail(path, ": is not a dataset");
  const hid_t space = H5Dget_space(dataset);
  const hssize_t size = space < 0 ? -1 : H5Sget_simple_extent_npoints(space);
  std::vector<Number> numbers;
  const bool too_large = size >= 0 && static_cast<std::size_t>(size) > kMaxNumbers;
  bool complete = size >= 0 && !too_large;
  if (complete) {
    numbers.resize(static_cast<std::size_t>(size));
    complete = numbers.empty() || H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) >= 0;
  }
  if (space >= 0) H5Sclose(space);
  H5Dclose(dataset);
  if (too_large) {
    fail(path, ": " + std::to_string(size) + " numbers, at most " + std::to_string(kMaxNumbers) + " are read");
  }
  if (!complete) fail(path, ": cannot be read");
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
