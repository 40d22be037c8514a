// The errors of MFS, one class per kind, all derived from mfs::Error. An object that has thrown can be used
// again: a call that throws leaves the last completed phase as it was, unless its documentation says that the
// phase is lost.
//
// Rows, columns and entries count from 0 in the caller's numbering; -1 means "none".
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include <mfs/export.hpp>

namespace mfs {

/// The base of all errors.
class MFS_API Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  /// Adds `note` to the text of what(). Throws std::bad_alloc, and the text is then unchanged.
  void append(const std::string& note);
};

/// An argument is not acceptable: its name, and the row and column of the entry.
class MFS_API InvalidInput : public Error {
 public:
  InvalidInput(std::string argument, const std::string& what, std::int64_t row = -1,
               std::int64_t column = -1);
  const std::string& argument() const { return argument_; }
  std::int64_t row() const { return row_; }
  std::int64_t column() const { return column_; }

 private:
  std::string argument_;
  std::int64_t row_, column_;
};

/// Phases were called out of order, as solve before factor.
class MFS_API StateError : public Error {
 public:
  using Error::Error;
};

/// The matrix passed to factor or refactor does not have the analysed pattern: the first row that differs.
/// The analysis and the last factorization are kept.
class MFS_API PatternChanged : public Error {
 public:
  PatternChanged(const std::string& what, std::int64_t row);
  std::int64_t row() const { return row_; }

 private:
  std::int64_t row_;
};

/// The matrix is singular: structurally (no permutation gives a diagonal without zeros) or to working
/// precision. `row` and `column` depend on the others; `dependent_rows` is the number of such rows that were
/// found.
class MFS_API SingularMatrix : public Error {
 public:
  enum class Kind { structural, numerical };
  SingularMatrix(Kind kind, std::int64_t row, std::int64_t column, std::int64_t dependent_rows,
                 const std::string& what);
  Kind kind() const { return kind_; }
  std::int64_t row() const { return row_; }
  std::int64_t column() const { return column_; }
  std::int64_t dependent_rows() const { return dependent_rows_; }

 private:
  Kind kind_;
  std::int64_t row_, column_, dependent_rows_;
};

/// A solution missed the tolerance: the componentwise backward error that was reached, and the tolerance.
class MFS_API AccuracyNotReached : public Error {
 public:
  AccuracyNotReached(double reached, double asked);
  double reached() const { return reached_; }
  double asked() const { return asked_; }

 private:
  double reached_, asked_;
};

/// The memory of the host, or of the device of a backend.
enum class MemorySpace { host, device };

/// Memory was refused: the bytes of the request that failed, and the bytes that were free (0 where unknown).
class MFS_API OutOfMemory : public Error {
 public:
  OutOfMemory(MemorySpace space, std::size_t needed, std::size_t available);
  MemorySpace space() const { return space_; }
  std::size_t needed() const { return needed_; }
  std::size_t available() const { return available_; }

 private:
  MemorySpace space_;
  std::size_t needed_, available_;
};

/// A library or device that MFS uses failed: its name, and its own error code.
class MFS_API BackendError : public Error {
 public:
  BackendError(std::string library, int code, const std::string& what);
  const std::string& library() const { return library_; }
  int code() const { return code_; }

 private:
  std::string library_;
  int code_;
};

}  // namespace mfs
