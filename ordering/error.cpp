#include <mfs/error.hpp>

#include <cstdio>

namespace mfs {
namespace {

/// "values: not finite (row 3, column 5)": the argument, what is wrong, and the place where there is one.
std::string placed(const std::string& subject, const std::string& what, std::int64_t row,
                   std::int64_t column) {
  std::string text = subject.empty() ? what : subject + ": " + what;
  if (row >= 0 && column >= 0) {
    text += " (row " + std::to_string(row) + ", column " + std::to_string(column) + ")";
  } else if (row >= 0) {
    text += " (row " + std::to_string(row) + ")";
  } else if (column >= 0) {
    text += " (column " + std::to_string(column) + ")";
  }
  return text;
}

std::string memory_text(MemorySpace space, std::size_t needed, std::size_t available) {
  std::string text = space == MemorySpace::device ? "out of device memory" : "out of host memory";
  text += ": " + std::to_string(needed) + " bytes needed";
  if (available > 0) text += ", " + std::to_string(available) + " available";
  return text;
}

std::string accuracy_text(double reached, double asked) {
  char text[128];
  std::snprintf(text, sizeof text, "backward error %.3e reached, %.3e asked", reached, asked);
  return text;
}

}  // namespace

void Error::append(const std::string& note) {
  std::runtime_error::operator=(std::runtime_error(what() + note));
}

InvalidInput::InvalidInput(std::string argument, const std::string& what, std::int64_t row,
                           std::int64_t column)
    : Error(placed(argument, what, row, column)),
      argument_(std::move(argument)),
      row_(row),
      column_(column) {}

PatternChanged::PatternChanged(const std::string& what, std::int64_t row)
    : Error(placed("pattern changed", what, row, -1)), row_(row) {}

SingularMatrix::SingularMatrix(Kind kind, std::int64_t row, std::int64_t column, std::int64_t dependent_rows,
                               const std::string& what)
    : Error(placed(kind == Kind::structural ? "structurally singular" : "numerically singular", what, row,
                   column)),
      kind_(kind),
      row_(row),
      column_(column),
      dependent_rows_(dependent_rows) {}

AccuracyNotReached::AccuracyNotReached(double reached, double asked)
    : Error(accuracy_text(reached, asked)), reached_(reached), asked_(asked) {}

OutOfMemory::OutOfMemory(MemorySpace space, std::size_t needed, std::size_t available)
    : Error(memory_text(space, needed, available)), space_(space), needed_(needed), available_(available) {}

BackendError::BackendError(std::string library, int code, const std::string& what)
    : Error(library + (code != 0 ? " failed with code " + std::to_string(code) : "") + ": " + what),
      library_(std::move(library)),
      code_(code) {}

}  // namespace mfs
