// Puts an HDF5 file into SealedBytes: HDF5 reads and writes through us. Only for the .cpp files of common/results.
#pragma once

#include <hdf5.h>

#include "common/results/sealed_bytes.hpp"

namespace granary {

/// Makes or opens the HDF5 file in `bytes`, which must outlive it. Each H5Fflush, and H5Fclose, commits. The file is a
/// plain HDF5 file with a user block of SealedBytes::kHead bytes, so every HDF5 program reads it. Negative: HDF5
/// refuses.
hid_t create_in(SealedBytes& bytes);
hid_t open_in(SealedBytes& bytes);

}  // namespace granary
