#include "parts/exit_code.hpp"

#include <algorithm>
#include <csignal>
#include <exception>
#include <new>
#include <stdexcept>

#include <mfs/error.hpp>

#include "parts/interrupt.hpp"

namespace mfs::program {
namespace {

// Files are counted from 1 (their lines, and rows and columns in messages that name a line), the library
// counts from 0: say so wherever it names a place.
std::string with_base(const std::string& what, std::int64_t row, std::int64_t column) {
  return row < 0 && column < 0 ? what : what + "; rows and columns count from 0";
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

Failure describe() {
  try {
    throw;
  } catch (const Interrupted& e) {
    return {e.signal() == SIGINT ? ExitCode::interrupted : ExitCode::terminated, e.what()};
  } catch (const InvalidInput& e) {
    return {ExitCode::invalid_input, with_base(e.what(), e.row(), e.column())};
  } catch (const PatternChanged& e) {
    return {ExitCode::invalid_input, with_base(e.what(), e.row(), -1)};
  } catch (const SingularMatrix& e) {
    return {ExitCode::singular, with_base(e.what(), e.row(), e.column())};
  } catch (const OutOfMemory& e) {
    return {ExitCode::out_of_memory, e.what()};
  } catch (const AccuracyNotReached& e) {
    return {ExitCode::accuracy_not_reached, e.what()};
  } catch (const std::bad_alloc&) {
    return {ExitCode::out_of_memory, "out of host memory"};
  } catch (const std::length_error&) {  // a vector longer than any memory
    return {ExitCode::out_of_memory, "out of host memory"};
  } catch (const BackendError& e) {
    return {ExitCode::backend, e.what()};
  } catch (const StateError& e) {
    return {ExitCode::backend, e.what()};
  } catch (const Error& e) {  // of no kind, as of a step that became too small
    return {ExitCode::backend, e.what(), "failed"};
  } catch (const std::exception& e) {
    return {ExitCode::backend, e.what()};
  }
}

}  // namespace

const char* status_word(ExitCode code) {
  switch (code) {
    case ExitCode::solved:
      return "solved";
    case ExitCode::usage:
      return "usage";
    case ExitCode::invalid_input:
      return "invalid_input";
    case ExitCode::singular:
      return "singular";
    case ExitCode::out_of_memory:
      return "out_of_memory";
    case ExitCode::accuracy_not_reached:
      return "accuracy_not_reached";
    case ExitCode::backend:
      return "backend";
    case ExitCode::interrupted:
      return "interrupted";
    case ExitCode::terminated:
      return "terminated";
  }
  return "backend";
}

Failure describe_current_exception() {
  Failure failure = describe();
  failure.message = one_line(failure.message);
  if (failure.status == nullptr) failure.status = status_word(failure.code);
  return failure;
}

}  // namespace mfs::program
