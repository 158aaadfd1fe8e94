#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <hdf5.h>

namespace lcpbench {

/// An HDF5 file, open for reading. No other file is read in its name: links to other files, and datasets whose numbers
/// are in other files, are refused. Errors (InputError) name the file and, once it is open, the dataset. Opening one
/// turns HDF5's messages and external links off for the whole process.
class Hdf5File {
 public:
  explicit Hdf5File(const std::string& file);
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  bool has(const std::string& path) const;
  /// @throws InputError where the count exceeds kMaxNumbers or the bytes of the file, as compressed data may
  void check_count(const std::string& path, std::size_t count) const;
  /// All numbers of a dataset, row by row, converted to the type by HDF5, which cuts off fractions and clamps
  /// what is too large for an int; its shape is not looked at.
  std::vector<int> integers(const std::string& path) const;
  std::vector<double> reals(const std::string& path) const;
  /// Of a dataset of one number.
  int integer(const std::string& path) const;

  /// @param message  stands right behind the path: ": what is wrong"
  [[noreturn]] void fail(const std::string& path, const std::string& message) const;

 private:
  template <class Number>
  std::vector<Number> read(const std::string& path, hid_t type) const;

  std::string name_;
  hid_t file_;
  std::size_t bytes_ = 0;
};

}  // namespace lcpbench
