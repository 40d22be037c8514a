// A borrowed sparse matrix in compressed rows, as the caller has it. Offsets and columns are 32-bit or 64-bit
// integers and begin at 0. Rows may be unsorted. Repeated entries are summed, explicit zeros are kept. A view
// copies and checks nothing: analyze, factor and refactor check the matrix that they are passed.
#pragma once

#include <cstdint>
#include <type_traits>

namespace mfs {

/// A borrowed array of integers of either width. It must outlive the view.
class IndexSpan {
 public:
  IndexSpan() = default;
  template <class Integer>
  IndexSpan(const Integer* data) : data_(data), wide_(sizeof(Integer) == 8) {  // NOLINT: implicit by intent
    static_assert(std::is_integral_v<Integer> && (sizeof(Integer) == 4 || sizeof(Integer) == 8),
                  "indices are 32-bit or 64-bit integers");
  }
  std::int64_t operator[](std::int64_t i) const {
    return wide_ ? static_cast<const std::int64_t*>(data_)[i] : static_cast<const std::int32_t*>(data_)[i];
  }
  const void* data() const { return data_; }
  bool wide() const { return wide_; }

 private:
  const void* data_ = nullptr;
  bool wide_ = false;
};

/// A matrix of rows x columns entries; the arrays must outlive the call that the view is passed to.
template <class Scalar>
struct CsrView {
  std::int64_t rows = 0;
  std::int64_t columns = 0;
  IndexSpan row_offsets;           ///< rows + 1
  IndexSpan column_indices;        ///< row_offsets[rows]
  const Scalar* values = nullptr;  ///< row_offsets[rows]; null for a pattern without values
};

}  // namespace mfs
