// HDF5 behind our own words: datasets of doubles with units, attributes, growing time axes. The only folder
// that includes hdf5.h. Serial HDF5: under MPI rank 0 writes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace granary {

/// A dense array in row-major order with its shape.
struct DataArray {
  std::vector<std::size_t> shape;
  std::vector<double> values;
};

class SealedBytes;

class Hdf5File {
 public:
  static Result<Hdf5File> create(const std::filesystem::path& file);          ///< replaces
  static Result<Hdf5File> open(const std::filesystem::path& file);            ///< read only; a seal is held against it
  static Result<Hdf5File> open_to_append(const std::filesystem::path& file);  ///< read and write
  /// The same with every byte under a checksum: what is in the file is what the last flush() left, whatever ended the
  /// program since, and open_sealed() refuses a damaged file before HDF5 (which may crash on one) sees a byte of it.
  static Result<Hdf5File> create_sealed(const std::filesystem::path& file);
  static Result<Hdf5File> open_sealed(const std::filesystem::path& file);
  Hdf5File(Hdf5File&& other) noexcept;
  Hdf5File& operator=(Hdf5File&& other) noexcept;
  ~Hdf5File();

  /// Writes a whole dataset ("/dem/collision_rate"; groups are made as needed) with its unit ("1/s") and a description.
  Status write(const std::string& name, const DataArray& data, std::string_view unit, std::string_view description);
  Status write_integers(const std::string& name, const std::vector<std::int64_t>& values, std::string_view unit,
                        std::string_view description);
  Status write_texts(const std::string& name, const std::vector<std::string>& values, std::string_view description);

  /// Makes an empty dataset that grows along its first axis; `row_shape` is the shape of one row (empty: a scalar a
  /// row).
  Status create_growing(const std::string& name, const std::vector<std::size_t>& row_shape, std::string_view unit,
                        std::string_view description);
  Status append_row(const std::string& name, const std::vector<double>& row);
  /// Cuts a growing dataset back to its first n rows.
  Status truncate_rows(const std::string& name, std::size_t n_rows);

  /// On the root group for name "/", else on that group (made as needed) or dataset.
  Status attribute(const std::string& name, const std::string& key, std::string_view text);
  Status attribute(const std::string& name, const std::string& key, double value);

  bool has(const std::string& name) const;
  /// Errors of all that read: it is not there, is of another kind, claims sizes beyond all reason, or lies in another
  /// file.
  Result<DataArray> read(const std::string& name) const;
  Result<std::vector<std::size_t>> shape(const std::string& name) const;
  /// Row i of a dataset along its first axis.
  Result<std::vector<double>> read_row(const std::string& name, std::size_t row) const;
  Result<std::vector<std::string>> read_texts(const std::string& name) const;
  Result<std::string> text_attribute(const std::string& name, const std::string& key) const;
  Result<double> number_attribute(const std::string& name, const std::string& key) const;
  /// Names of the groups and datasets directly below a group.
  Result<std::vector<std::string>> children(const std::string& group) const;

  Status flush();
  /// On the disk itself, not only in the kernel's memory. Only for sealed files.
  Status sync();

 private:
  Hdf5File(std::int64_t id, std::filesystem::path file, std::unique_ptr<SealedBytes> sealed = nullptr);
  /// Remembers that a write failed, and says it: `name` could not be written.
  Error failed_to_write(const std::string& name);

  std::unique_ptr<SealedBytes> sealed_;  ///< where HDF5 writes, if the file has a seal; outlives id_
  std::int64_t id_ = -1;
  std::filesystem::path file_;
  bool broken_ = false;  ///< a write failed (a full disk): HDF5 cannot even close such a file
};

}  // namespace granary
