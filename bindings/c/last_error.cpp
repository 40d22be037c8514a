#include "last_error.hpp"

#include <cstdio>
#include <exception>
#include <new>

#include <mfs/mfs.h>
#include <mfs/error.hpp>

namespace mfs::c {
namespace {

int keep(int status, const char* text, std::int64_t row = -1, std::int64_t column = -1) noexcept {
  LastError& error = last_error();
  error.status = status;
  error.row = row;
  error.column = column;
  error.argument[0] = '\0';
  std::snprintf(error.text, sizeof error.text, "%s", text);
  return status;
}

}  // namespace

LastError& last_error() noexcept {
  thread_local LastError error;
  return error;
}

int keep_current_exception() noexcept {
  try {
    throw;
  } catch (const InvalidInput& e) {
    keep(MFS_INVALID_INPUT, e.what(), e.row(), e.column());
    std::snprintf(last_error().argument, sizeof last_error().argument, "%s", e.argument().c_str());
    return MFS_INVALID_INPUT;
  } catch (const SingularMatrix& e) {
    return keep(MFS_SINGULAR_MATRIX, e.what(), e.row(), e.column());
  } catch (const PatternChanged& e) {
    return keep(MFS_PATTERN_CHANGED, e.what(), e.row());
  } catch (const AccuracyNotReached& e) {
    return keep(MFS_ACCURACY_NOT_REACHED, e.what());
  } catch (const OutOfMemory& e) {
    return keep(MFS_OUT_OF_MEMORY, e.what());
  } catch (const std::bad_alloc&) {
    return keep(MFS_OUT_OF_MEMORY, "out of host memory");
  } catch (const BackendError& e) {
    return keep(MFS_BACKEND_ERROR, e.what());
  } catch (const StateError& e) {
    return keep(MFS_STATE_ERROR, e.what());
  } catch (const std::exception& e) {
    return keep(MFS_INTERNAL_ERROR, e.what());
  } catch (...) {
    return keep(MFS_INTERNAL_ERROR, "unknown exception");
  }
}

}  // namespace mfs::c
