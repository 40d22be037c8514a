// What can go wrong, one class per kind, each with its place. All derive from mfs::Error. After any of them
// the object that threw can be used again: an operation that throws leaves the last completed phase as it
// was, unless its documentation says that the phase is lost.
//
// Rows, columns and entries are 0-based and in the caller's numbering; -1 means "none".
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include <mfs/export.hpp>

namespace mfs {

class MFS_API Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  /// Adds `note` to the text of what(). Throws std::bad_alloc, and the text is then unchanged.
  void append(const std::string& note);
};

/// An argument that cannot be accepted: which one, and which entry of it.
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

/// Phases called out of order (solve before factor, say).
class MFS_API StateError : public Error {
 public:
  using Error::Error;
};

/// The matrix handed to factor or refactor does not have the pattern that was analysed; the first row that
/// differs. The analysis and the last factorization are kept.
class MFS_API PatternChanged : public Error {
 public:
  PatternChanged(const std::string& what, std::int64_t row);
  std::int64_t row() const { return row_; }

 private:
  std::int64_t row_;
};

/// No acceptable solution exists: structurally (no zero-free diagonal can be permuted into place) or
/// numerically. `row` and `column` name one row and column that depend on the others, `dependent_rows` how
/// many were found.
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

/// The factorization is sound but the asked backward error was not reached.
class MFS_API AccuracyNotReached : public Error {
 public:
  AccuracyNotReached(double reached, double asked);
  double reached() const { return reached_; }
  double asked() const { return asked_; }

 private:
  double reached_, asked_;
};

enum class MemorySpace { host, device };

/// Bytes needed by the request that failed and bytes available there (0 when unknown).
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

/// A library or device that MFS stands on failed: its name and its own code.
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
